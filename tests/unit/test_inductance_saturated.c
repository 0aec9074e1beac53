/* The learnt factor of the curve psi_q = L_0 i_q/sqrt(1 + (i_q/I_s)^2) of a salient rotor, with an EMF from
 * the fluxes of the rotor and of the observer, and with a current control that follows like a low-pass. */
#include "medium/adapt/inductance.h"
#include "tests/unit/compare.h"

#define PERIOD 1e-4
#define EVERY  4u
#define PSI_F  0.444
#define L_D    24e-3
#define L_0    142e-3
#define I_S    9.1
#define LIMIT  15.0

/* The state of a run in the frame of the drive, which leads the rotor by `ahead`. */
typedef struct {
    double omega;     /* [rad/s] */
    double bandwidth; /* of the tracking loop [rad/s] */
    double i_d, i_q;  /* [A] */
    double at_d;      /* [A] i_d without the dither */
    double at_q;      /* [A] i_q without the dither */
    double ahead;     /* [rad] */
    double rotor;     /* [rad] */
    double cross;     /* flux along q per ampere of i_d [H], which the drive does not know */
    double shaken;    /* speed of the loop per ampere of the dither [rad/s/A] */
} turning_t;

static inductance_t x;

static double share(double i_q)
{
    return 1.0 / hypot(1.0, i_q / I_S);
}

/* The observer's constant L_q is that of the assumed curve at 0.8 of the limit. */
static double observed(void)
{
    return (double)x.learnt.value * share(0.8 * LIMIT);
}

static inductance_tuning_t assumed(double from)
{
    const inductance_params_t params = {
        .inductance_d = (float)L_D,
        .inductance_q = x.learnt.value,
        .observed_q = (float)observed(),
        .saturation = (float)I_S,
        .from = (float)from,
        .resistance = 0.63f,
        .resistance_from = 0.63f,
        .flux_linkage = (float)PSI_F,
        .current_max = (float)LIMIT,
        .rate = 3.0f,
        .period = (float)PERIOD,
        .every = EVERY,
        .salient = true,
        .salient_too = true,
    };
    return inductance_prepare(&params);
}

/* The flux of the rotor in the frame of the drive minus L_q i of the observer [Wb]. */
static dq_t beyond(const turning_t *at, double ahead)
{
    const double i_d = at->i_d * cos(ahead) - at->i_q * sin(ahead);
    const double i_q = at->i_q * cos(ahead) + at->i_d * sin(ahead);
    const double flux_d = PSI_F + L_D * i_d + at->cross * (i_q - at->at_q);
    const double flux_q = L_0 * share(i_q) * i_q + at->cross * (i_d - at->at_d);
    return (dq_t){(float)(flux_d * cos(ahead) + flux_q * sin(ahead) - observed() * at->i_d),
                  (float)(flux_q * cos(ahead) - flux_d * sin(ahead) - observed() * at->i_q)};
}

/* A period: the loop turns to the EMF without the known flux of i_q. Returns the EMF [V]. */
static dq_t turn(turning_t *at)
{
    const dq_t flux = beyond(at, at->ahead);
    const double known = ((double)x.learnt.value * share(at->i_q) - observed()) * at->i_q;
    const double shaken = at->shaken * (at->i_d - at->at_d);
    const double turns = at->bandwidth * ((double)flux.q - known) / (double)flux.d + shaken;
    const double step = 1e-3;
    const dq_t next = beyond(at, at->ahead + step);
    at->ahead += PERIOD * turns;
    at->rotor = remainder(at->rotor + PERIOD * at->omega, 2.0 * PI);
    const double speed = at->omega + turns;
    return (dq_t){(float)((double)(next.d - flux.d) / step * turns - speed * (double)flux.q),
                  (float)((double)(next.q - flux.q) / step * turns + speed * (double)flux.d)};
}

/* Runs this number of seconds from a learnt L_0 of `from`, with a new assumption every 10 ms. */
static void run(turning_t at, double from, double seconds)
{
    x.learnt = (learnt_value_t){(float)from, (float)from};
    const inductance_tuning_t first = assumed(from);
    inductance_init(&x, &first);
    at.i_d = at.at_d;
    at.i_q = at.at_q;
    inductance_input_t means = {.sound = true};
    for (int n = 1; n <= (int)(seconds / PERIOD + 0.5); n++) {
        const dq_t emf = turn(&at);
        means.emf.d += emf.d / (float)EVERY;
        means.emf.q += emf.q / (float)EVERY;
        means.current.d += (float)at.i_d / (float)EVERY;
        means.current.q += (float)at.i_q / (float)EVERY;
        if (n % (int)EVERY == 0) {
            means.omega_smooth = (float)(at.omega + at.shaken * (at.i_d - at.at_d));
            means.theta = (float)remainder(at.rotor + at.ahead, 2.0 * PI);
            means.flux = (float)(PSI_F - (observed() - L_D) * at.i_d);
            means.voltage_known = true;
            inductance_step(&x, &means);
            means = (inductance_input_t){.sound = true};
        }
        at.i_d += 0.1 * (at.at_d + (double)x.dither.d - at.i_d);
        at.i_q += 0.1 * (at.at_q + (double)x.dither.q - at.i_q);
        if (n % 100 == 0) {
            const inductance_tuning_t tuning = assumed(from);
            inductance_take(&x, &tuning);
        }
    }
}

/* i_d and i_q of most torque per ampere with 3, 6 and 12.4 A, driving and braking. */
static const double currents[][2] = {{-1.37, 2.67}, {-3.46, 4.9}, {-8.7, 8.83}, {-3.46, -4.9}, {-8.7, -8.83}};

static void test_the_curve_of_a_rotor_that_saturates_goes_to_the_truth(void)
{
    static const double cases[][3] = {{0.9, 63.0, 100.0}, {1.1, 126.0, 100.0}, {0.8, 126.0, 50.0}};
    for (size_t m = 0; m < sizeof currents / sizeof currents[0]; m++) {
        for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
            memset(&x, 0, sizeof x);
            const turning_t at = {.omega = cases[n][1],
                                  .bandwidth = cases[n][2],
                                  .at_d = currents[m][0],
                                  .at_q = currents[m][1]};
            run(at, cases[n][0] * L_0, 8.0);
            check_line(fabs((double)x.learnt.value / L_0 - 1.0), 0.01, "A13 learnt curve");
        }
    }
}

/* A loop whose smooth speed the dither shakes by 1.5 rad/s, as its feed-forward does while braking, turns by
 * some milliradians. The law contains its motion. */
static void test_a_loop_that_the_dither_shakes_leaves_the_curve_right(void)
{
    for (size_t m = 0; m < sizeof currents / sizeof currents[0]; m++) {
        for (double shaken = -2.0; shaken < 3.0; shaken += 4.0) {
            memset(&x, 0, sizeof x);
            const turning_t at = {.omega = 126.0,
                                  .bandwidth = 100.0,
                                  .at_d = currents[m][0],
                                  .at_q = currents[m][1],
                                  .shaken = shaken};
            run(at, 0.9 * L_0, 8.0);
            check_line(fabs((double)x.learnt.value / L_0 - 1.0), 0.01, "A13 learnt curve, shaken");
        }
    }
}

/* A flux of i_d along q, which the drive does not know, adds `cross` per ampere of i_d to the answer of the
 * angle. The learnt curve is then larger by cross/(G L_0), to first order. With t of the line of constant
 * torque, G L_0 is L_i t + L_a i_q (D_i + t i_d dL_i/di_q)/psi_t. */
static void test_a_flux_of_i_d_along_q_moves_the_curve_as_the_algebra_tells(void)
{
    const double i_d = -3.46, i_q = 4.9, cross = -0.5e-3;
    const double apparent = L_0 * share(i_q), incremental = apparent * share(i_q) * share(i_q);
    const double slope = -3.0 * incremental * i_q / (I_S * I_S + i_q * i_q);
    const double psi_t = PSI_F - (incremental - L_D) * i_d;
    const double t = (apparent - L_D) * i_q / psi_t;
    const double answer = incremental * t + apparent * i_q * (incremental - L_D + slope * t * i_d) / psi_t;
    const turning_t at = {.omega = 126.0, .bandwidth = 100.0, .at_d = i_d, .at_q = i_q, .cross = cross};
    memset(&x, 0, sizeof x);
    run(at, L_0, 8.0);
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * fabs(cross) / answer, cross / answer, (double)x.learnt.value / L_0 - 1.0);
}
