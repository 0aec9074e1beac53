#include "host_sim/plant/interval.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "host_sim/plant/iron.h"
#include "host_sim/plant/magnetics.h"
#include "host_sim/plant/phasor.h"

#define TICK          (1.0 / 150e6)
#define LONGEST_TICKS UINT64_C(15000)
#define LONGEST       100e-6 /* [s] the same */
#define RESYNC_STEPS  64u
#define HALF_SQRT_3   0.86602540378443864676
#define INV_SQRT_3    0.57735026918962576451
#define ROOT_3        1.73205080756887729353

/* Rate of change times step [-]. The rest of the series is then 5e-8 of the current. */
#define LARGEST_ANGLE 0.09
/* Step in time constants of the zone [-]. The error of the Runge-Kutta step is 3e-4 of the transient. */
#define STIFFEST 0.5
/* The same while a rotor whose EMF is near the link voltage or above feeds the link through the diodes: a leg
 * without current floats inside the zone, often for a long time. Its transient has ended when its current
 * changes by less than this share of the zone in a time constant. After a step a third of the change remains,
 * instead of e^-2.
 */
#define RECTIFYING       0.9
#define STIFFEST_SETTLED 2.0
#define SETTLED_ZONE     0.05
/* Repetitions end when a further one would change less than this [A], or after this number. */
#define SETTLED     2e-6
#define MOST_PASSES 6
/* A sub-step ends by this time [s] after a border of the zone, so that the next one begins beyond the border.
 */
#define PAST_BORDER 5e-9

/* The sums of an interval. */
typedef struct {
    double flux_alpha, flux_beta; /* [V s] */
    double charge;                /* [A s] from the link */
    double copper;                /* [J] */
    double loss;                  /* [J] of the legs */
} sums_t;

/* Right-hand side at one instant. */
typedef struct {
    double di_d, di_q;      /* [A/s] */
    double u_alpha, u_beta; /* [V] */
    double link;            /* [A] from the link */
    double copper;          /* [W] */
    double loss;            /* [W] */
} slope_t;

static void to_phases(double cosine, double sine, double i_d, double i_q, double i[3])
{
    double alpha = i_d * cosine - i_q * sine;
    double beta = i_d * sine + i_q * cosine;
    i[0] = alpha;
    i[1] = -0.5 * alpha + HALF_SQRT_3 * beta;
    i[2] = -0.5 * alpha - HALF_SQRT_3 * beta;
}

double interval_pole(const plant_t *plant, const plant_law_t *law, double i, double *share)
{
    double zone = plant->zone;
    if (fabs(i) >= zone) {
        int side = i < 0.0;
        *share = law->s[side];
        return law->s[side] * plant->v_dc + law->d[side] - law->r[side] * i;
    }
    double above = law->s[0] * plant->v_dc + law->d[0] - law->r[0] * zone;
    double below = law->s[1] * plant->v_dc + law->d[1] + law->r[1] * zone;
    double x = i * plant->zone_inverse;
    *share = 0.5 * (law->s[1] + law->s[0]) - 0.5 * x * (law->s[1] - law->s[0]);
    return 0.5 * (below + above) - 0.5 * x * (below - above);
}

/* Decrease of the pole voltage across the zone per ampere [ohm]. */
static double zone_resistance(const plant_t *plant, const plant_law_t *law)
{
    double fall = (law->s[1] - law->s[0]) * plant->v_dc + (law->d[1] - law->d[0]) +
                  (law->r[1] + law->r[0]) * plant->zone;
    return 0.5 * fall * plant->zone_inverse;
}

bool interval_held(const plant_t *plant)
{
    return plant->hold_torque > 0.0 && plant->slip == 0.0;
}

double interval_angle(const plant_t *plant)
{
    return (plant->theta_e + PHASOR_TWO_PI * (double)plant->turns) / plant->p;
}

/* The torque that depends on the angle of an end [N m], `ahead` [rad] of the present angle of the shaft. */
static double angle_load(const plant_t *plant, double ahead)
{
    const plant_params_t *q = &plant->params;
    double theta = interval_angle(plant) - plant->twist + ahead;
    double phase = q->load_sine_cycles * theta;
    double cosine, sine;
    phase -= PHASOR_TWO_PI * floor(phase * (1.0 / PHASOR_TWO_PI) + 0.5);
    phasor_at(phase, &cosine, &sine);
    return q->load_sine * sine + q->load_spring * theta;
}

/* The table at an end's speed [N m], against its motion. */
static double table_load(const plant_t *plant, double omega)
{
    double x = fabs(omega) * plant->table_inverse;
    x = x < 7.0 ? x : 7.0;
    size_t n = x < 6.0 ? (size_t)x : 6u;
    double against = plant->table[n] + (x - (double)n) * (plant->table[n + 1u] - plant->table[n]);
    return omega < 0.0 ? -against : against;
}

/* Load torque by the square of a shaft end's speed or by the table, and by its angle [N m]. */
static __attribute__((noinline)) double work_load(const plant_t *plant, double omega, double ahead)
{
    return plant->params.load_quadratic * omega * fabs(omega) + table_load(plant, omega) +
           angle_load(plant, ahead);
}

/* interval_resistance() with the shaft turned by `ahead` [rad]. */
static inline double resistance_at(const plant_t *plant, double omega_m, double ahead)
{
    double x = omega_m * plant->width_inverse;
    double smooth = x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x * (1.5 - 0.5 * x * x);
    double sign = plant->hold_torque > 0.0 ? plant->slip : smooth;
    double against =
        plant->dry_torque * sign + plant->params.friction_viscous * omega_m + plant->active_torque;
    return plant->works && plant->load_inverse == 0.0 ? against + work_load(plant, omega_m, ahead) : against;
}

double interval_resistance(const plant_t *plant, double omega_m)
{
    return resistance_at(plant, omega_m, 0.0);
}

/* Load at the far end of an elastic shaft [N m], positive against positive rotation; that end turned by
 * `ahead` [rad]. */
static double far_resistance(const plant_t *plant, double omega_load, double ahead)
{
    double x = omega_load * plant->load_width_inverse;
    double smooth = x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x * (1.5 - 0.5 * x * x);
    double against = plant->load_torque * smooth + plant->load_active;
    return plant->works ? against + work_load(plant, omega_load, ahead) : against;
}

double interval_load(const plant_t *plant)
{
    bool fixed = plant->params.shaft_locked != 0.0 || interval_held(plant);
    double near = fixed ? plant->torque - plant->shaft_torque : interval_resistance(plant, plant->omega_m);
    return plant->load_inverse > 0.0 ? near + far_resistance(plant, plant->omega_load, 0.0) : near;
}

/* cos and sin of six times the angle. */
static void sixfold(double cosine, double sine, double *cos_6, double *sin_6)
{
    double c2 = cosine * cosine - sine * sine;
    double s2 = 2.0 * cosine * sine;
    double c4 = c2 * c2 - s2 * s2;
    double s4 = 2.0 * c2 * s2;
    *cos_6 = c4 * c2 - s4 * s2;
    *sin_6 = s4 * c2 + c4 * s2;
}

/* EMF per electrical speed in the rotor frame [Wb]. */
static void emf_shape(const plant_t *plant, double cosine, double sine, double *d, double *q)
{
    *d = 0.0;
    *q = plant->params.flux_linkage;
    if (plant->harmonics) {
        double c6, s6;
        sixfold(cosine, sine, &c6, &s6);
        *d = -plant->emf_d6 * s6;
        *q += plant->emf_q6 * c6;
    }
}

/* `omega_m`: at the present currents [rad/s]. */
static double torque_of(const plant_t *plant, double omega_m)
{
    double d, q;
    emf_shape(plant, plant->cos_e, plant->sin_e, &d, &q);
    if (plant->saturates != 0.0) {
        const iron_t iron = iron_at(plant, plant->p * omega_m, plant->i_d, plant->i_q);
        d += -iron.field.flux_q;
        q += iron.field.flux_d;
        return 1.5 * plant->p * (d * iron.i_d + q * iron.i_q);
    }
    return 1.5 * plant->p * (d * plant->i_d + q * plant->i_q + plant->saliency * plant->i_d * plant->i_q);
}

/* EMF in the stationary frame without current in the phases [V]. */
static void emf_of(const plant_t *plant, double omega_e, double cosine, double sine, double *alpha,
                   double *beta)
{
    double d, q;
    emf_shape(plant, cosine, sine, &d, &q);
    if (plant->params.iron_loss_resistance > 0.0) {
        const iron_t iron = iron_at(plant, omega_e, 0.0, 0.0);
        d += -iron.field.flux_q;
        q += iron.field.flux_d;
    }
    *alpha = omega_e * (d * cosine - q * sine);
    *beta = omega_e * (d * sine + q * cosine);
}

double interval_magnetic(const plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    if (plant->saturates != 0.0) {
        const iron_t iron = iron_at(plant, plant->p * plant->omega_m, plant->i_d, plant->i_q);
        return magnetics_energy(plant, iron.i_d, iron.i_q);
    }
    return 0.75 * (q->inductance_d * plant->i_d * plant->i_d + q->inductance_q * plant->i_q * plant->i_q);
}

/* No current flows for any state of the legs: the bridge is idle, or two wires are broken. */
static bool currentless(const plant_t *plant)
{
    return plant->idle || (plant->open & (plant->open - 1u)) != 0u;
}

double interval_line_emf(const plant_t *plant)
{
    double alpha, beta;
    emf_of(plant, plant->p * plant->omega_m, plant->cos_e, plant->sin_e, &alpha, &beta);
    double ab = fabs(1.5 * alpha - HALF_SQRT_3 * beta);
    double bc = fabs(2.0 * HALF_SQRT_3 * beta);
    double ca = fabs(1.5 * alpha + HALF_SQRT_3 * beta);
    double most = ab > bc ? ab : bc;
    return ca > most ? ca : most;
}

/* One wire broken: the currents of the others are opposite, so the vector lies on a line fixed in the
 * stationary frame. Its direction in the rotor frame. */
static void open_line(const plant_t *plant, double cosine, double sine, double *d, double *q)
{
    static const double line[3][2] = {{0.0, 1.0}, {-HALF_SQRT_3, -0.5}, {HALF_SQRT_3, -0.5}};
    const double *m = line[plant->open == 1u ? 0 : plant->open == 2u ? 1 : 2];
    *d = m[0] * cosine + m[1] * sine;
    *q = -m[0] * sine + m[1] * cosine;
}

void interval_refresh(plant_t *plant)
{
    double *i = plant->i;
    double alpha = i[0];
    double beta = (i[1] - i[2]) * INV_SQRT_3;
    plant->i_d = alpha * plant->cos_e + beta * plant->sin_e;
    plant->i_q = beta * plant->cos_e - alpha * plant->sin_e;
    uint32_t open = plant->open;
    if (open == 1u || open == 2u || open == 4u) {
        double d, q;
        open_line(plant, plant->cos_e, plant->sin_e, &d, &q);
        double y = plant->i_d * d + plant->i_q * q;
        plant->i_d = y * d;
        plant->i_q = y * q;
        to_phases(plant->cos_e, plant->sin_e, plant->i_d, plant->i_q, i);
        for (int leg = 0; leg < 3; leg++) {
            if (open >> leg & 1u) {
                i[leg] = 0.0;
            }
        }
    } else if (open != 0u || plant->idle) {
        plant->i_d = 0.0;
        plant->i_q = 0.0;
        i[0] = 0.0;
        i[1] = 0.0;
        i[2] = 0.0;
    }
    plant->torque = torque_of(plant, plant->omega_m);
}

/* Torque that an elastic shaft takes from the motor [N m]; 0 for a rigid shaft. */
static double twisted(const plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    return plant->load_inverse > 0.0
               ? q->shaft_stiffness * plant->twist + q->shaft_damping * (plant->omega_m - plant->omega_load)
               : 0.0;
}

/* Torque that drives the shaft independent of its motion [N m]. */
static double driving(const plant_t *plant)
{
    double drive = plant->torque - plant->active_torque - plant->shaft_torque;
    return plant->works && plant->load_inverse == 0.0 ? drive - angle_load(plant, 0.0) : drive;
}

/* Sets the state of the shaft for the present speed and torque: the direction of dry friction, whether it
 * holds, and the extrapolation of the speed. */
static void shaft_restart(plant_t *plant)
{
    plant->shaft_torque = twisted(plant);
    double drive = driving(plant);
    double way = plant->omega_m != 0.0 ? plant->omega_m : fabs(drive) > plant->hold_torque ? drive : 0.0;
    plant->slip = plant->hold_torque == 0.0 || way == 0.0 ? 0.0 : way > 0.0 ? 1.0 : -1.0;
    bool fixed = plant->params.shaft_locked != 0.0 || interval_held(plant);
    double against = interval_resistance(plant, plant->omega_m);
    plant->acceleration =
        fixed ? 0.0 : plant->inertia_inverse * (plant->torque - against - plant->shaft_torque);
    plant->omega_ahead = plant->omega_m;
}

void interval_restart(plant_t *plant)
{
    interval_refresh(plant);
    shaft_restart(plant);
}

/* The same as current_slope where an axis saturates or the iron has a loss, by the incremental inductances at
 * these currents; `drive` is the voltage less the EMF of the magnets. */
static __attribute__((noinline)) void bent_slope(const plant_t *plant, double omega_e, double cosine,
                                                 double sine, double i_d, double i_q, double drive_d,
                                                 double drive_q, double *di_d, double *di_q)
{
    const double resistance = plant->params.resistance;
    const iron_t iron = iron_at(plant, omega_e, i_d, i_q);
    const magnetics_t field = iron.field;
    if (plant->open == 0u) {
        const double rate_d = drive_d - resistance * i_d + omega_e * field.flux_q;
        const double rate_q = drive_q - resistance * i_q - omega_e * field.flux_d;
        const double per = 1.0 / (field.slope_d * field.slope_q - field.cross_d * field.cross_q);
        *di_d = per * (field.slope_q * rate_d - field.cross_d * rate_q) - iron.g * rate_q;
        *di_q = per * (field.slope_d * rate_q - field.cross_q * rate_d) + iron.g * rate_d;
        if (iron.g != 0.0) {
            const double dg = plant->p * plant->acceleration / plant->params.iron_loss_resistance;
            *di_d -= dg * field.flux_q;
            *di_q += dg * (plant->params.flux_linkage + field.flux_d);
        }
        return;
    }
    /* The flux along the line m: d(m psi)/dt = m (u - e) - R y, with the currents y m and m turning back. */
    double m_d, m_q;
    open_line(plant, cosine, sine, &m_d, &m_q);
    double y = i_d * m_d + i_q * m_q;
    double turn_d = omega_e * m_q;
    double turn_q = -omega_e * m_d;
    double l_d = field.slope_d * m_d + field.cross_q * m_q; /* of the flux along m, by i_d and by i_q */
    double l_q = field.slope_q * m_q + field.cross_d * m_d;
    double l_m = l_d * m_d + l_q * m_q;
    double moved = y * (l_d * turn_d + l_q * turn_q) + field.flux_d * turn_d + field.flux_q * turn_q;
    double dy = (drive_d * m_d + drive_q * m_q - resistance * y - moved) / l_m;
    *di_d = dy * m_d + y * turn_d;
    *di_q = dy * m_q + y * turn_q;
}

/* Derivative of the currents at (i_d, i_q) under a voltage, with the rotor at (cosine, sine). */
static void current_slope(const plant_t *plant, double omega_e, double cosine, double sine, double i_d,
                          double i_q, double u_d, double u_q, double *di_d, double *di_q)
{
    const plant_params_t *params = &plant->params;
    double e_d, e_q;
    emf_shape(plant, cosine, sine, &e_d, &e_q);
    e_d *= omega_e;
    e_q *= omega_e;
    if (plant->saturates != 0.0) {
        bent_slope(plant, omega_e, cosine, sine, i_d, i_q, u_d - e_d, u_q - e_q, di_d, di_q);
        return;
    }
    if (plant->open == 0u) {
        *di_d = (u_d - params->resistance * i_d + omega_e * params->inductance_q * i_q - e_d) * plant->k_d;
        *di_q = (u_q - params->resistance * i_q - omega_e * params->inductance_d * i_d - e_q) * plant->k_q;
        return;
    }
    /* d(L_m y)/dt = (u - e) m - R y along the line m, L_m = L_d m_d^2 + L_q m_q^2; m turns back in the rotor
     * frame. */
    double m_d, m_q;
    open_line(plant, cosine, sine, &m_d, &m_q);
    double y = i_d * m_d + i_q * m_q;
    double l_m = params->inductance_d * m_d * m_d + params->inductance_q * m_q * m_q;
    double dl_m = 2.0 * omega_e * m_d * m_q * plant->saliency;
    double dy = ((u_d - e_d) * m_d + (u_q - e_q) * m_q - (params->resistance + dl_m) * y) / l_m;
    *di_d = dy * m_d + y * omega_e * m_q;
    *di_q = dy * m_q - y * omega_e * m_d;
}

/* A leg's law as straight lines at the present link: interval_pole() with all parts that do not depend on a
 * current computed once, for the many currents of a divided interval. */
typedef struct {
    double at[2], r[2];  /* [V], [ohm] outside the zone: v = at - r i */
    double middle, fall; /* [V] at no current; across the zone */
    double s[2];         /* [-] shares outside the zone */
} line_t;

static void make_lines(const plant_t *plant, line_t lines[3])
{
    for (int leg = 0; leg < 3; leg++) {
        const plant_law_t *law = &plant->law[leg][plant->kind[leg]];
        line_t *line = &lines[leg];
        for (int side = 0; side < 2; side++) {
            line->at[side] = law->s[side] * plant->v_dc + law->d[side];
            line->r[side] = law->r[side];
            line->s[side] = law->s[side];
        }
        const double above = line->at[0] - law->r[0] * plant->zone;
        const double below = line->at[1] + law->r[1] * plant->zone;
        line->middle = 0.5 * (below + above);
        line->fall = below - above;
    }
}

/* Charge and losses of the legs with pole voltages v at currents i. */
static void leg_powers(const plant_t *plant, const line_t lines[3], const double i[3], const double v[3],
                       slope_t *out)
{
    out->link = 0.0;
    out->loss = 0.0;
    for (int leg = 0; leg < 3; leg++) {
        const double *s = lines[leg].s;
        double x = i[leg] * plant->zone_inverse;
        double share =
            fabs(i[leg]) >= plant->zone ? s[i[leg] < 0.0] : 0.5 * (s[1] + s[0]) - 0.5 * x * (s[1] - s[0]);
        if (!(plant->open >> leg & 1u)) {
            out->link += share * i[leg];
            out->loss += (share * plant->v_dc - v[leg]) * i[leg];
        }
    }
}

/* The broken phase's terminal follows its EMF; only the voltage along the line reaches the motor. */
static __attribute__((noinline)) void open_voltage(const plant_t *plant, double cosine, double sine,
                                                   slope_t *out)
{
    double m_d, m_q;
    open_line(plant, cosine, sine, &m_d, &m_q);
    double u_d = out->u_alpha * cosine + out->u_beta * sine;
    double u_q = out->u_beta * cosine - out->u_alpha * sine;
    double u = u_d * m_d + u_q * m_q;
    u_d = u * m_d;
    u_q = u * m_q;
    out->u_alpha = u_d * cosine - u_q * sine;
    out->u_beta = u_d * sine + u_q * cosine;
}

/* Derivative of the currents at (i_d, i_q) with the rotor at (cosine, sine). Powers only if metering is on.
 */
static inline void slope_at(const plant_t *plant, const line_t lines[3], double omega_e, double cosine,
                            double sine, double i_d, double i_q, slope_t *out)
{
    double i[3], v[3];
    to_phases(cosine, sine, i_d, i_q, i);
    for (int leg = 0; leg < 3; leg++) {
        const line_t *line = &lines[leg];
        int side = i[leg] < 0.0;
        double outside = line->at[side] - line->r[side] * i[leg];
        double inside = line->middle - 0.5 * (i[leg] * plant->zone_inverse) * line->fall;
        v[leg] = fabs(i[leg]) >= plant->zone ? outside : inside;
    }
    out->u_alpha = (2.0 * v[0] - v[1] - v[2]) * (1.0 / 3.0);
    out->u_beta = (v[1] - v[2]) * INV_SQRT_3;
    double u_d = out->u_alpha * cosine + out->u_beta * sine;
    double u_q = out->u_beta * cosine - out->u_alpha * sine;
    current_slope(plant, omega_e, cosine, sine, i_d, i_q, u_d, u_q, &out->di_d, &out->di_q);
    if (plant->open != 0u) {
        open_voltage(plant, cosine, sine, out);
    }
    if (plant->extras) {
        leg_powers(plant, lines, i, v, out);
    }
    const double resistance = plant->params.resistance;
    out->copper = 1.5 * resistance * (i_d * i_d + i_q * i_q);
    if (plant->extras && plant->params.iron_loss_resistance > 0.0) {
        const iron_t iron = iron_at(plant, omega_e, i_d, i_q);
        out->copper +=
            1.5 * ((u_d - resistance * i_d) * (i_d - iron.i_d) + (u_q - resistance * i_q) * (i_q - iron.i_q));
    }
}

void interval_phase_slopes(const plant_t *plant, double h, double begin[3], double end[3], double by_alpha[3],
                           double by_beta[3])
{
    double omega_e = plant->p * (plant->omega_ahead + 0.5 * h * plant->acceleration);
    double i_d = plant->i_d;
    double i_q = plant->i_q;
    double c = plant->cos_e;
    double s = plant->sin_e;
    double d[3], q[3];
    current_slope(plant, omega_e, c, s, i_d, i_q, 0.0, 0.0, &d[0], &q[0]);
    to_phases(c, s, d[0] - omega_e * i_q, q[0] + omega_e * i_d, begin);
    phasor_turn(&c, &s, 0.5 * omega_e * h);
    current_slope(plant, omega_e, c, s, i_d, i_q, 0.0, 0.0, &d[0], &q[0]);
    current_slope(plant, omega_e, c, s, i_d, i_q, c, -s, &d[1], &q[1]);
    current_slope(plant, omega_e, c, s, i_d, i_q, s, c, &d[2], &q[2]);
    to_phases(c, s, d[1] - d[0], q[1] - q[0], by_alpha);
    to_phases(c, s, d[2] - d[0], q[2] - q[0], by_beta);
    phasor_turn(&c, &s, 0.5 * omega_e * h);
    current_slope(plant, omega_e, c, s, i_d, i_q, 0.0, 0.0, &d[0], &q[0]);
    to_phases(c, s, d[0] - omega_e * i_q, q[0] + omega_e * i_d, end);
}

void interval_voltage(const plant_t *plant, double *u_alpha, double *u_beta)
{
    double omega_e = plant->p * plant->omega_m;
    if (currentless(plant)) {
        emf_of(plant, omega_e, plant->cos_e, plant->sin_e, u_alpha, u_beta);
        return;
    }
    slope_t slope;
    line_t lines[3];
    make_lines(plant, lines);
    slope_at(plant, lines, omega_e, plant->cos_e, plant->sin_e, plant->i_d, plant->i_q, &slope);
    *u_alpha = slope.u_alpha;
    *u_beta = slope.u_beta;
}

/* Longest sub-step from here: stiffness of the legs inside the zone, and the next border that a current
 * meets. */
static double soft_step(const plant_t *plant, const slope_t *slope, double omega_e, double cosine,
                        double sine, double i_d, double i_q, double h, bool rectifies)
{
    double i[3], di[3];
    to_phases(cosine, sine, i_d, i_q, i);
    to_phases(cosine, sine, slope->di_d - omega_e * i_q, slope->di_q + omega_e * i_d, di);
    double stiffest = 0.0;
    double fastest = 0.0; /* [A/s] inside the zone */
    double zone = plant->zone;
    for (int leg = 0; leg < 3; leg++) {
        if (plant->open >> leg & 1u) {
            continue;
        }
        double border;
        if (fabs(i[leg]) < zone) {
            const plant_law_t *law = &plant->law[leg][plant->kind[leg]];
            double fall = zone_resistance(plant, law);
            stiffest = fall > stiffest ? fall : stiffest;
            fastest = fmax(fastest, fabs(di[leg]));
            border = di[leg] > 0.0 ? zone - i[leg] : i[leg] + zone;
        } else if (i[leg] * di[leg] < 0.0) {
            border = fabs(i[leg]) - zone;
        } else {
            continue;
        }
        double rate = fabs(di[leg]);
        if (border + PAST_BORDER * rate < h * rate) {
            h = border / rate + PAST_BORDER;
        }
    }
    double rate = stiffest * plant->k_max;
    double longest = rectifies && fastest < SETTLED_ZONE * zone * rate ? STIFFEST_SETTLED : STIFFEST;
    return rate * h > longest ? longest / rate : h;
}

/* The whole interval in sub-steps. cosine and sine are those of its start. */
static void soft_interval(plant_t *plant, double h, double omega_e, sums_t *sums)
{
    double cosine = plant->cos_e;
    double sine = plant->sin_e;
    double i_d = plant->i_d;
    double i_q = plant->i_q;
    slope_t k1, k2, k3, k4;
    line_t lines[3];
    make_lines(plant, lines);
    const bool rectifies = (plant->kind[0] | plant->kind[1] | plant->kind[2]) == PLANT_LAW_OFF &&
                           fabs(omega_e) * plant->emf_bound * ROOT_3 > RECTIFYING * plant->v_dc;
    while (h > 0.0) {
        slope_at(plant, lines, omega_e, cosine, sine, i_d, i_q, &k1);
        double step = soft_step(plant, &k1, omega_e, cosine, sine, i_d, i_q, h, rectifies);
        double half = 0.5 * step;
        phasor_turn(&cosine, &sine, omega_e * half);
        slope_at(plant, lines, omega_e, cosine, sine, i_d + half * k1.di_d, i_q + half * k1.di_q, &k2);
        slope_at(plant, lines, omega_e, cosine, sine, i_d + half * k2.di_d, i_q + half * k2.di_q, &k3);
        phasor_turn(&cosine, &sine, omega_e * half);
        slope_at(plant, lines, omega_e, cosine, sine, i_d + step * k3.di_d, i_q + step * k3.di_q, &k4);
        double sixth = step * (1.0 / 6.0);
        i_d += sixth * (k1.di_d + 2.0 * (k2.di_d + k3.di_d) + k4.di_d);
        i_q += sixth * (k1.di_q + 2.0 * (k2.di_q + k3.di_q) + k4.di_q);
        sums->flux_alpha += sixth * (k1.u_alpha + 2.0 * (k2.u_alpha + k3.u_alpha) + k4.u_alpha);
        sums->flux_beta += sixth * (k1.u_beta + 2.0 * (k2.u_beta + k3.u_beta) + k4.u_beta);
        if (plant->extras) {
            sums->charge += sixth * (k1.link + 2.0 * (k2.link + k3.link) + k4.link);
            sums->copper += sixth * (k1.copper + 2.0 * (k2.copper + k3.copper) + k4.copper);
            sums->loss += sixth * (k1.loss + 2.0 * (k2.loss + k3.loss) + k4.loss);
        }
        h -= step;
    }
    plant->i_d = i_d;
    plant->i_q = i_q;
}

/* Antiderivative over the current of a leg's pole voltage [V A]. */
static double pole_integral(const plant_t *plant, const plant_law_t *law, double i)
{
    double zone = plant->zone;
    double above = law->s[0] * plant->v_dc + law->d[0];
    double below = law->s[1] * plant->v_dc + law->d[1];
    double at_zone = above - law->r[0] * zone;
    double at_minus_zone = below + law->r[1] * zone;
    double middle = 0.5 * (at_zone + at_minus_zone);
    double fall = 0.25 * (at_minus_zone - at_zone) * plant->zone_inverse;
    if (i > zone) {
        return (middle - fall * zone) * zone + (i - zone) * (above - 0.5 * law->r[0] * (i + zone));
    }
    if (i < -zone) {
        return -(middle + fall * zone) * zone + (i + zone) * (below - 0.5 * law->r[1] * (i - zone));
    }
    return (middle - fall * i) * i;
}

double interval_pole_mean(const plant_t *plant, const plant_law_t *law, double x, double y)
{
    double share;
    if (fabs(y - x) < 1e-7) {
        return interval_pole(plant, law, 0.5 * (x + y), &share);
    }
    return (pole_integral(plant, law, y) - pole_integral(plant, law, x)) / (y - x);
}

/* Inputs of the Taylor series of the currents besides the voltage. */
typedef struct {
    double h, h_2, h_3, h_4;         /* [s^n] h^n/n! */
    double omega_e;                  /* [rad/s] */
    double cosine, sine;             /* [-] of the angle at the start */
    double cosine_end, sine_end;     /* [-] of the angle at the end */
    double free_d, free_q;           /* [A/s] derivative without voltage */
    double turn_d, turn_q, square_e; /* omega_e L_q/L_d, omega_e L_d/L_q [rad/s], omega_e^2 [rad^2/s^2] */
} series_t;

static inline void series_begin(const plant_t *plant, double h, double omega_e, double cos_1, double sin_1,
                                series_t *series)
{
    series->h = h;
    series->h_2 = h * h * 0.5;
    series->h_3 = h * series->h_2 * (1.0 / 3.0);
    series->h_4 = series->h_2 * series->h_2 * (1.0 / 6.0);
    series->omega_e = omega_e;
    series->cosine = plant->cos_e;
    series->sine = plant->sin_e;
    series->cosine_end = cos_1;
    series->sine_end = sin_1;
    series->turn_d = omega_e * plant->cross_d;
    series->turn_q = omega_e * plant->cross_q;
    series->square_e = omega_e * omega_e;
    series->free_d = series->turn_d * plant->i_q - plant->decay_d * plant->i_d;
    series->free_q = -series->turn_q * plant->i_d - plant->decay_q * plant->i_q - omega_e * plant->emf_q;
    if (plant->harmonics) {
        /* Held at the mean over the interval: value in the middle times sin(x)/x of half the sixfold angle.
         */
        double x = 3.0 * omega_e * h;
        double mean = 1.0 - x * x * (1.0 / 6.0 - x * x * (1.0 / 120.0));
        double c = plant->cos_e;
        double s = plant->sin_e;
        double c6, s6;
        phasor_turn(&c, &s, 0.5 * omega_e * h);
        sixfold(c, s, &c6, &s6);
        series->free_d += omega_e * plant->k_d * plant->emf_d6 * s6 * mean;
        series->free_q -= omega_e * plant->k_q * plant->emf_q6 * c6 * mean;
    }
}

/* Currents after the interval under a constant voltage. The voltage turns back in the rotor frame: dU_d/dt =
 * w_d U_q and dU_q/dt = -w_q U_d for U_d = u_d/L_d, U_q = u_q/L_q. */
static inline void series_end(const plant_t *plant, const series_t *series, double u_alpha, double u_beta,
                              double *i_d, double *i_q)
{
    double w_d = series->turn_d;
    double w_q = series->turn_q;
    double decay_d = plant->decay_d;
    double decay_q = plant->decay_q;
    double u_d = (u_alpha * series->cosine + u_beta * series->sine) * plant->k_d;
    double u_q = (u_beta * series->cosine - u_alpha * series->sine) * plant->k_q;
    double d1 = u_d + series->free_d;
    double q1 = u_q + series->free_q;
    double d2 = w_d * (u_q + q1) - decay_d * d1;
    double q2 = -w_q * (u_d + d1) - decay_q * q1;
    double d3 = w_d * q2 - decay_d * d2 - series->square_e * u_d;
    double q3 = -w_q * d2 - decay_q * q2 - series->square_e * u_q;
    double d4 = w_d * (q3 - series->square_e * u_q) - decay_d * d3;
    double q4 = w_q * (series->square_e * u_d - d3) - decay_q * q3;
    *i_d = ((plant->i_d + series->h * d1) + series->h_2 * d2) + (series->h_3 * d3 + series->h_4 * d4);
    *i_q = ((plant->i_q + series->h * q1) + series->h_2 * q2) + (series->h_3 * q3 + series->h_4 * q4);
}

static inline double least(double x, double y)
{
    return x < y ? x : y;
}

/* Charge, copper heat and losses of an interval with pole voltages v (r_mean i added) and shares s. The
 * currents are assumed to change linearly from i to j. The difference of the power from the link and the
 * power into the motor is lost. */
static void add_up(const plant_t *plant, double h, const double j[3], const double v[3], const double s[3],
                   sums_t *sums)
{
    sums->charge = 0.0;
    sums->copper = 0.0;
    sums->loss = 0.0;
    for (int leg = 0; leg < 3; leg++) {
        double x = plant->i[leg];
        double y = j[leg];
        double mean = 0.5 * (x + y);
        double square = (x * x + x * y + y * y) * (1.0 / 3.0);
        sums->charge += h * s[leg] * mean;
        sums->copper += h * plant->params.resistance * square;
        sums->loss += h * ((s[leg] * plant->v_dc - v[leg]) * mean + plant->r_mean * square);
    }
}

/* For a leg whose current touches the zone, or whose resistance differs from the others: the voltage is the
 * mean over the change of the current, found by repetition from the initial values in v and j. false if a leg
 * is too stiff for that. */
static bool bend(const plant_t *plant, const series_t *series, double v[3], double s[3], double j[3],
                 double *i_d, double *i_q)
{
    double follow[3];
    bool touched[3], in_zone[3];
    double contraction = 1e-6;
    for (int leg = 0; leg < 3; leg++) {
        double x = plant->i[leg];
        double y = j[leg];
        const plant_law_t *law = &plant->law[leg][plant->kind[leg]];
        in_zone[leg] = fabs(x) < plant->zone || fabs(y) < plant->zone || x * y < 0.0;
        touched[leg] = in_zone[leg] || plant->uneven;
        follow[leg] = 0.0;
        if (touched[leg]) {
            /* The effect of a leg on its own mean current determines how far the new mean voltage is
             * followed. */
            double fall = in_zone[leg] ? zone_resistance(plant, law) : law->r[0];
            double stiff = fall * series->h * plant->k_max;
            if (stiff > STIFFEST) {
                return false;
            }
            follow[leg] = 1.0 / (1.0 + stiff * (1.0 / 3.0));
            contraction = stiff > contraction ? stiff : contraction;
        }
    }
    double settled = SETTLED / contraction;
    for (int pass = 0; pass < MOST_PASSES; pass++) {
        double before[3] = {j[0], j[1], j[2]};
        for (int leg = 0; leg < 3; leg++) {
            if (touched[leg]) {
                const plant_law_t *law = &plant->law[leg][plant->kind[leg]];
                double middle = 0.5 * (plant->i[leg] + j[leg]);
                double mean = interval_pole(plant, law, middle, &s[leg]);
                if (in_zone[leg]) { /* otherwise the law is one straight line, whose mean is the value in its
                                       middle */
                    mean = interval_pole_mean(plant, law, plant->i[leg], j[leg]);
                }
                mean += plant->r_mean * middle;
                v[leg] += follow[leg] * (mean - v[leg]);
            }
        }
        double u_alpha = (2.0 * v[0] - v[1] - v[2]) * (1.0 / 3.0);
        double u_beta = (v[1] - v[2]) * INV_SQRT_3;
        series_end(plant, series, u_alpha, u_beta, i_d, i_q);
        to_phases(series->cosine_end, series->sine_end, *i_d, *i_q, j);
        if (fabs(j[0] - before[0]) + fabs(j[1] - before[1]) + fabs(j[2] - before[2]) < settled) {
            break;
        }
    }
    return true;
}

/* The interval under constant voltages. false, and nothing is changed: this method is not valid here. */
static inline bool series_interval(plant_t *plant, double h, double omega_e, double cos_1, double sin_1,
                                   sums_t *sums)
{
    const double *i = plant->i;
    double zone = plant->zone;
    series_t series;
    series_begin(plant, h, omega_e, cos_1, sin_1, &series);
    const plant_law_t *a = &plant->law[0][plant->kind[0]];
    const plant_law_t *b = &plant->law[1][plant->kind[1]];
    const plant_law_t *c = &plant->law[2][plant->kind[2]];
    size_t side_a = i[0] < 0.0;
    size_t side_b = i[1] < 0.0;
    size_t side_c = i[2] < 0.0;
    double r_mean = plant->r_mean;
    double v[3], s[3], j[3], i_d, i_q;
    v[0] = a->s[side_a] * plant->v_dc + a->d[side_a] - (a->r[side_a] - r_mean) * i[0];
    v[1] = b->s[side_b] * plant->v_dc + b->d[side_b] - (b->r[side_b] - r_mean) * i[1];
    v[2] = c->s[side_c] * plant->v_dc + c->d[side_c] - (c->r[side_c] - r_mean) * i[2];
    series_end(plant, &series, (2.0 * v[0] - v[1] - v[2]) * (1.0 / 3.0), (v[1] - v[2]) * INV_SQRT_3, &i_d,
               &i_q);
    to_phases(cos_1, sin_1, i_d, i_q, j);
    /* Both ends are outside the zone and on the same side; the signs of the products show the sides. In
     * averaged mode the law is one straight line without a zone. */
    bool away = plant->kind[0] >= PLANT_LAW_AVERAGED ||
                (!plant->uneven && least(least(fabs(i[0]), fabs(i[1])), fabs(i[2])) >= zone &&
                 least(least(fabs(j[0]), fabs(j[1])), fabs(j[2])) >= zone &&
                 least(least(i[0] * j[0], i[1] * j[1]), i[2] * j[2]) > 0.0);
    if (!away || plant->extras) {
        s[0] = a->s[side_a];
        s[1] = b->s[side_b];
        s[2] = c->s[side_c];
        if (!away && !bend(plant, &series, v, s, j, &i_d, &i_q)) {
            return false;
        }
        if (plant->extras) {
            add_up(plant, h, j, v, s, sums);
        }
    }
    double u_alpha = (2.0 * v[0] - v[1] - v[2]) * (1.0 / 3.0);
    double u_beta = (v[1] - v[2]) * INV_SQRT_3;
    sums->flux_alpha = h * (u_alpha - 0.5 * r_mean * (i[0] + j[0]));
    sums->flux_beta = h * (u_beta - 0.5 * r_mean * ((i[1] + j[1]) - (i[2] + j[2])) * INV_SQRT_3);
    plant->i_d = i_d;
    plant->i_q = i_q;
    plant->i[0] = j[0];
    plant->i[1] = j[1];
    plant->i[2] = j[2];
    return true;
}

/* First-order lag of a sensor whose input changes linearly from i_0 to i_1. */
static double lagged(double y, double i_0, double i_1, double x)
{
    double behind = (i_1 - i_0) / x;
    return i_1 - behind + (y - i_0 + behind) * phasor_decay(x);
}

double interval_source(const plant_t *plant, double ahead)
{
    const plant_params_t *q = &plant->params;
    if (q->dc_ripple == 0.0) {
        return q->dc_voltage;
    }
    double t = (double)(int64_t)(plant->tick - plant->ripple_since) * TICK + ahead;
    double turns = t * q->dc_ripple_frequency * (1.0 / PHASOR_TWO_PI);
    double cosine, sine;
    phasor_at((turns - floor(turns)) * PHASOR_TWO_PI, &cosine, &sine);
    return q->dc_voltage + q->dc_ripple * sine;
}

/* Voltage of a soft link after `charge` has left it. The source only supplies current unless it is a battery,
 * and the chopper only draws current. Implicit, so that any time constant is safe. The diodes prevent a
 * change of its direction. */
static void link_step(plant_t *plant, double h, double charge)
{
    const plant_params_t *q = &plant->params;
    double v = plant->v_dc - charge * plant->link_rate;
    double source = interval_source(plant, h);
    double given = v < source || q->dc_returns != 0.0 ? h * plant->source_rate : 0.0;
    bool driven = q->chopper_driven != 0.0;
    bool chops = plant->chopper_rate > 0.0 && (driven ? plant->chops != 0u : v > q->chopper_voltage);
    if (given > 0.0 || chops) {
        v = (v + given * source) / (1.0 + given + (chops ? h * plant->chopper_rate : 0.0));
        v = chops && !driven && v < q->chopper_voltage ? q->chopper_voltage : v;
    }
    plant->supplied += given > 0.0 ? given * (source - v) / plant->link_rate : 0.0;
    plant->v_dc = v > 0.0 ? v : 0.0;
}

/* After a time without current the bridge is idle, until a gate turns on or the EMF is high enough. */
static void settle(plant_t *plant, uint64_t ticks)
{
    for (int leg = 0; leg < 3; leg++) {
        bool quiet = (plant->open >> leg & 1u) ||
                     (plant->kind[leg] == PLANT_LAW_OFF && fabs(plant->i[leg]) < plant->zone);
        if (!quiet) {
            plant->calm_ticks = 0;
            return;
        }
    }
    plant->calm_ticks += ticks;
    if (plant->calm_ticks >= PLANT_IDLE_TICKS &&
        interval_line_emf(plant) < plant->v_dc + 2.0 * plant->params.diode_voltage) {
        if (plant->metering) {
            plant->energy_inverter += interval_magnetic(plant);
        }
        plant->idle = 1;
        plant->calm_ticks = 0;
        interval_refresh(plant);
    }
}

void interval_count_turns(plant_t *plant)
{
    /* Whole mechanical turns are counted separately, so that the fraction keeps its digits in long runs. */
    int64_t pairs = (int64_t)plant->p;
    double counts = 4.0 * plant->params.encoder_lines * (1.0 - plant->params.encoder_slip);
    double whole = (double)(plant->turns / pairs) * counts;
    plant->count_whole = (int64_t)floor(whole);
    plant->count_rest =
        ((double)(plant->turns % pairs) / plant->p + plant->params.encoder_offset * (1.0 / PHASOR_TWO_PI)) *
            counts +
        (whole - floor(whole));
}

/* Both ends of an elastic shaft under constant torques, `net` on the motor: the series of the exponential of
 * d twist/dt = nu, d nu/dt = a - sum (k twist + c nu), nu the difference of the speeds and sum that of 1/J at
 * the ends that are free to turn, to the sixth order (its
 * angle is below LARGEST_ANGLE: the rest is 1e-11). Kept out of the step of a rigid
 * shaft, which it would make slower. */
static __attribute__((noinline)) void twist_step(plant_t *plant, double h, double net, bool fixed)
{
    const plant_params_t *q = &plant->params;
    double near = fixed ? 0.0 : plant->inertia_inverse;
    double far = plant->load_inverse;
    double sum = near + far;
    /* The angle of the motor's end is already the new one, while the twist is that of the begin. The angle
     * of the far end is therefore also that of the begin, plus the angle by which the motor has turned. */
    double back = -h * plant->omega_m;
    double against = far_resistance(plant, plant->omega_load, back);
    double omega_felt = plant->omega_load + 0.5 * h * far * (plant->shaft_torque - against);
    against = far_resistance(plant, omega_felt, back + 0.5 * h * plant->omega_load);
    double a = near * net + far * against;
    double twist = plant->twist;
    double nu = plant->omega_m - plant->omega_load;
    double dx = h * nu;
    double dv = h * (a - sum * (q->shaft_stiffness * twist + q->shaft_damping * nu));
    double more_x = 0.0;
    double more_v = 0.0;
    static const double inverse[] = {1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0, 1.0 / 6.0, 1.0 / 7.0};
    double stiffness = h * sum * q->shaft_stiffness;
    double damping = h * sum * q->shaft_damping;
    for (size_t n = 0; n < sizeof inverse / sizeof inverse[0]; n++) {
        more_x += dx;
        more_v += dv;
        double next = h * dv * inverse[n];
        dv = -(stiffness * dx + damping * dv) * inverse[n];
        dx = next;
    }
    double impulse = (h * a - more_v) / sum; /* [N m s] that went through the shaft */
    plant->omega_m += near * (h * net - impulse);
    plant->omega_load += far * (impulse - h * against);
    plant->twist += more_x;
    plant->shaft_torque = twisted(plant);
    plant->omega_ahead = plant->omega_m;
    plant->acceleration = near * (net - plant->shaft_torque);
    if (plant->metering) {
        /* The part of the driving power that is not stored is dissipated by the damping. */
        double stored = 0.5 / sum * more_v * (2.0 * nu + more_v) +
                        0.5 * q->shaft_stiffness * more_x * (2.0 * twist + more_x);
        double dynamometer = fixed ? (h * net - impulse) * plant->omega_m : 0.0;
        plant->energy_mechanical += h * omega_felt * against + a / sum * more_x - stored + dynamometer;
    }
}

/* Basis of the length of an interval if an axis saturates: the smallest incremental inductance at the
 * present currents, and the time in which the link voltage changes a current so much that this inductance
 * changes. */
static __attribute__((noinline)) void bent_rate(plant_t *plant)
{
    const plant_params_t *q = &plant->params;
    const magnetics_t field = magnetics_at(plant, plant->i_d, plant->i_q);
    plant->k_max = 1.0 / (field.slope_d < field.slope_q ? field.slope_d : field.slope_q);
    double least_square = 1e12;
    if (plant->map != 0u) { /* the smaller eigenvalue is at least the determinant over the trace */
        const double determinant = field.slope_d * field.slope_q - field.cross_d * field.cross_q;
        const double step = flux_map_step(flux_map_of(plant->map));
        plant->k_max = (field.slope_d + field.slope_q) / determinant;
        least_square = step * step;
    }
    if (plant->map == 0u && q->saturation_d > 0.0) {
        least_square = q->saturation_d * q->saturation_d + plant->i_d * plant->i_d;
    }
    if (plant->map == 0u && q->saturation_q > 0.0) {
        least_square = least(least_square, q->saturation_q * q->saturation_q + plant->i_q * plant->i_q);
    }
    plant->rate = plant->ohms * plant->k_max +
                  plant->p * (q->flux_linkage + fabs(field.flux_d) + fabs(field.flux_q)) *
                      sqrt(1.5 * plant->k_max * plant->inertia_inverse) +
                  plant->rate_other + plant->v_dc * plant->k_max / sqrt(least_square);
}

/* An interval in which the state of the shaft does not change: held, or with friction against one
 * direction. */
static uint64_t smooth_step(plant_t *plant, uint64_t ticks)
{
    if (plant->saturates != 0.0) {
        bent_rate(plant);
    }
    double rate = fabs(plant->p * plant->omega_m) + plant->rate;
    if (plant->works) {
        double inverse = plant->load_inverse > 0.0 ? plant->load_inverse : plant->inertia_inverse;
        rate += 2.0 * plant->params.load_quadratic * fabs(plant->omega_m) * inverse;
    }
    uint64_t limit = LONGEST_TICKS;
    if (rate * LONGEST > LARGEST_ANGLE) {
        limit = 1u + (uint64_t)(LARGEST_ANGLE / (rate * TICK));
    }
    if (ticks > limit) {
        /* The remaining time is cut into equal parts: a period is halved, not cut into a long and a very
         * short part. */
        uint64_t parts = (ticks + limit - 1u) / limit;
        ticks = parts < 8u ? (ticks + parts - 1u) / parts : limit;
    }
    double h = (double)ticks * TICK;

    if (plant->ripples) {
        plant->v_dc = interval_source(plant, 0.5 * h); /* as the mean of the interval */
    }

    /* Extrapolates from the torque before the last one, so that the computation of the currents does not
     * depend on the last result of the shaft. */
    double omega_mid = plant->omega_ahead + 0.5 * h * plant->acceleration;
    double omega_e = plant->p * omega_mid;
    double delta = omega_e * h;
    double cos_1 = plant->cos_e;
    double sin_1 = plant->sin_e;
    phasor_turn(&cos_1, &sin_1, delta);

    sums_t sums;
    double i_a = plant->i[0];
    double i_b = plant->i[1];
    double i_c = plant->i[2];
    double torque_0 = plant->torque;
    bool phases_known = true;
    if (plant->idle | plant->open || plant->saturates != 0.0 ||
        !series_interval(plant, h, omega_e, cos_1, sin_1, &sums)) {
        memset(&sums, 0, sizeof sums);
        if (currentless(plant)) {
            double alpha_0, beta_0, alpha_1, beta_1;
            emf_of(plant, omega_e, plant->cos_e, plant->sin_e, &alpha_0, &beta_0);
            emf_of(plant, omega_e, cos_1, sin_1, &alpha_1, &beta_1);
            sums.flux_alpha = 0.5 * h * (alpha_0 + alpha_1);
            sums.flux_beta = 0.5 * h * (beta_0 + beta_1);
        } else {
            soft_interval(plant, h, omega_e, &sums);
            phases_known = false;
        }
    }
    plant->cos_e = cos_1;
    plant->sin_e = sin_1;
    double theta = plant->theta_e + delta;
    if (theta >= PHASOR_PI) {
        theta -= PHASOR_TWO_PI;
        plant->turns++;
        interval_count_turns(plant);
    } else if (theta < -PHASOR_PI) {
        theta += PHASOR_TWO_PI;
        plant->turns--;
        interval_count_turns(plant);
    }
    plant->theta_e = theta;
    if (++plant->steps >= RESYNC_STEPS) {
        plant->steps = 0;
        phasor_at(theta, &plant->cos_e, &plant->sin_e);
    }
    if (!phases_known) {
        to_phases(plant->cos_e, plant->sin_e, plant->i_d, plant->i_q, plant->i);
    }
    if (plant->open) {
        interval_refresh(plant);
    } else {
        plant->torque = torque_of(plant, plant->omega_ahead + h * plant->acceleration);
    }

    double torque = 0.5 * (torque_0 + plant->torque);
    bool locked = plant->params.shaft_locked != 0.0;
    bool elastic = plant->load_inverse > 0.0;
    double omega = plant->omega_m;
    double omega_felt = omega + 0.5 * h * plant->acceleration;
    double against = resistance_at(plant, omega_felt, -0.5 * h * omega_mid);
    plant->omega_ahead = omega + h * plant->acceleration;
    if (elastic) {
        bool fixed = locked || interval_held(plant);
        twist_step(plant, h, fixed ? torque : torque - against, fixed);
    } else if (!locked && !interval_held(plant)) {
        plant->acceleration = plant->inertia_inverse * (torque - against);
        plant->omega_m = omega + h * plant->acceleration;
    }
    plant->flux_alpha += sums.flux_alpha;
    plant->flux_beta += sums.flux_beta;
    if (plant->extras) {
        if (plant->metering) {
            plant->energy_dc += plant->v_dc * sums.charge;
            plant->energy_copper += sums.copper;
            plant->energy_inverter += sums.loss;
            plant->energy_mechanical += h * omega_felt *
                                        (!locked   ? against
                                         : elastic ? 0.0
                                                   : torque); /* twist_step computes the other values */
        }
        if (plant->link_rate > 0.0) {
            link_step(plant, h, sums.charge);
        } else if (plant->ripples) {
            plant->v_dc = interval_source(plant, h);
        }
        if (plant->params.current_bandwidth > 0.0) {
            double x = plant->params.current_bandwidth * h;
            plant->sensed[0] = lagged(plant->sensed[0], i_a, plant->i[0], x);
            plant->sensed[1] = lagged(plant->sensed[1], i_b, plant->i[1], x);
            plant->sensed[2] = lagged(plant->sensed[2], i_c, plant->i[2], x);
        }
    }
    if (plant->idle) {
        plant->idle = interval_line_emf(plant) < plant->v_dc + 2.0 * plant->params.diode_voltage;
    } else if ((plant->kind[0] | plant->kind[1] | plant->kind[2]) == PLANT_LAW_OFF || plant->open != 0u) {
        settle(plant, ticks);
    }
    return ticks;
}

/* The shaft at the begin of an interval. */
typedef struct {
    bool held;
    double drive, omega_m, slip;
} shaft_t;

/* The time in an interval at which the shaft came to rest or broke loose, as a share of the interval, 0..1,
 * with torque and speed as straight lines; above 1: neither occurred. */
static double event_share(const shaft_t *before, const plant_t *after)
{
    if (before->held) {
        double from = before->drive;
        double to = driving(after);
        double edge = to > 0.0 ? after->hold_torque : -after->hold_torque;
        return fabs(to) > after->hold_torque ? (edge - from) / (to - from) : 2.0;
    }
    if (after->omega_m * before->slip > 0.0) {
        return 2.0;
    }
    double change = before->omega_m - after->omega_m;
    return change != 0.0 ? before->omega_m / change : 1.0;
}

/* All members that a step may change follow the coefficients in the struct. */
#define STATE_AT   offsetof(plant_t, i)
#define STATE_SIZE (sizeof(plant_t) - STATE_AT)

uint64_t interval_step(plant_t *plant, uint64_t ticks)
{
    if (plant->hold_torque == 0.0 || plant->params.shaft_locked != 0.0) {
        return smooth_step(plant, ticks);
    }
    /* The interval is repeated with a shorter length until the event is in its last tick. */
    unsigned char state[STATE_SIZE];
    memcpy(state, (const unsigned char *)plant + STATE_AT, STATE_SIZE);
    const shaft_t before = {interval_held(plant), driving(plant), plant->omega_m, plant->slip};
    uint64_t taken = smooth_step(plant, ticks);
    for (double share = event_share(&before, plant); share <= 1.0; share = event_share(&before, plant)) {
        uint64_t until = (uint64_t)ceil(share * (double)taken);
        if (until >= taken || taken == 1u) {
            plant->omega_m = 0.0;
            shaft_restart(plant);
            return taken;
        }
        memcpy((unsigned char *)plant + STATE_AT, state, STATE_SIZE);
        taken = smooth_step(plant, until > 0u ? until : 1u);
    }
    return taken;
}
