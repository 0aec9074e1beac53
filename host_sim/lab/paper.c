#include "host_sim/lab/paper.h"

#include <assert.h>
#include <complex.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/pool.h"
#include "host_sim/rig/rig.h"

#define PI             3.14159265358979323846
#define RPM            (2.0 * PI / 60.0) /* [rad/s] */
#define MRAD           1e-3              /* [rad] */
#define READY_PERIODS  10000u            /* [periods] offsets are measured by then, or never */
#define HOLD_PERIODS   1000u             /* [periods] on the dynamometer: current and estimator settle */
#define FOLLOW_PERIODS 100u              /* [periods] the encoder's speed follows the rotor's */
#define SLICE_PERIODS  10u               /* [periods] grid of the events */
#define TRACE_EVERY    4u                /* [periods] */
#define J              ((double complex)I)
#define PLATEAU_BEGIN  0.75 /* share of a speed change: the transient is over, the limit still holds */
#define PLATEAU_END    0.85
#define LOST_SPEED     0.2 /* [-] mean speed off its reference by more: the loop has lost the rotor */

/* ---- the conditions ---- */

/* The rig: Table I, with the inertia and friction that the paper's accelerations imply (erratum 13). */
static const double pole_pairs = 4.0;
static const double resistance = 0.95;    /* [ohm] */
static const double inductance = 12.5e-3; /* [H] */
static const double flux_linkage = 0.183; /* [Wb] */
static const double inertia = 0.0636;     /* [kg m^2] */
static const double friction = 1.32;      /* [N m] */

#define RATED  5.0   /* [N m] */
#define FOUR_A 3.072 /* [N m] that make i_q 4 A: (4 A 1.5 p psi_f) less the friction */

#define KS        200.0  /* [V] k_s by the rule of erratum 5 */
#define KS_FIG_11 162.0  /* [V] that 0.08 rad at 1500 r/min needs in this timing */
#define OMEGA_S   2500.0 /* [rad/s] of the EMF filter (11); the print has none */

typedef enum { FIG04, FIG05, FIG08, FIG10, FIG11, FIG12, FIG13, FIG14, FIG15, FIG16, FIG17 } figure_t;
typedef enum { SIGN, SIGMOID } switching_t; /* as the choices of observer_switching */
typedef enum { LAG_NONE, LAG_PRINTED, LAG_CORRECTED, LAG_EXACT } lag_t; /* of lag_compensation */
typedef enum { HOLD_1013, STAIRS, COMPENSATE, STEPS, LOAD_500, LOAD_1500, PROFILES } profile_t;
typedef enum { BOTH, REAL, UNCOMPENSATED } flavours_t;

typedef struct {
    figure_t figure;
    const char *name; /* of its traces and for the judgement; unique in the figure */
    profile_t profile;
    flavours_t flavours;
    bool encoder;          /* the estimator runs beside */
    double load;           /* [N m] from the start */
    switching_t switching; /* slope 1/A */
    double gain;           /* k_s [V] */
    double omega_s;        /* [rad/s]; 0: no filter */
    lag_t lag;             /* of COMPENSATE: while it is on */
    double bandwidth;      /* -3 dB [rad/s], damping 1 */
    double omega_c;        /* [rad/s]; 0: conventional */
} run_t;

/* A loop without load and with 5 N m. */
#define LOOP(figure, flavours, b, wc)                                                                        \
    {figure, "b" #b "_wc" #wc "_nl", STEPS, flavours, false, 0.0, SIGMOID, KS, OMEGA_S, LAG_EXACT, b, wc},   \
    {                                                                                                        \
        figure, "b" #b "_wc" #wc "_rated", STEPS, flavours, false, RATED, SIGMOID, KS, OMEGA_S, LAG_EXACT,   \
            b, wc                                                                                            \
    }
#define LOOP_AT(figure, flavours, b, wc, at, load)                                                           \
    {                                                                                                        \
        figure, "b" #b "_wc" #wc "_" at, STEPS, flavours, false, load, SIGMOID, KS, OMEGA_S, LAG_EXACT, b,   \
            wc                                                                                               \
    }
#define LOAD(profile, at, b, wc)                                                                             \
    {                                                                                                        \
        FIG17, "b" #b "_wc" #wc "_" at, profile, BOTH, false, 0.0, SIGMOID, KS, OMEGA_S, LAG_EXACT, b, wc    \
    }

/* clang-format off */
static const run_t runs[] = {
    {FIG05, "sign",    HOLD_1013, BOTH, true, 0.0, SIGN,    KS, 0.0, LAG_EXACT, 100.0, 0.0},
    {FIG05, "sigmoid", HOLD_1013, BOTH, true, 0.0, SIGMOID, KS, 0.0, LAG_EXACT, 100.0, 0.0},

    {FIG10, "sign",    STAIRS, BOTH, true, 0.0, SIGN,    KS, OMEGA_S, LAG_EXACT, 100.0, 0.0},
    {FIG10, "sigmoid", STAIRS, BOTH, true, 0.0, SIGMOID, KS, OMEGA_S, LAG_EXACT, 100.0, 0.0},

    {FIG11, "ks162", STAIRS, BOTH, false, 0.0, SIGMOID, KS_FIG_11, 0.0, LAG_NONE, 100.0, 0.0},
    {FIG11, "ks200", STAIRS, BOTH, false, 0.0, SIGMOID, KS,        0.0, LAG_NONE, 100.0, 0.0},

    {FIG12, "exact",   COMPENSATE, BOTH, false, FOUR_A, SIGMOID, KS_FIG_11, 0.0, LAG_EXACT,   100.0, 0.0},
    {FIG12, "printed", COMPENSATE, BOTH, false, FOUR_A, SIGMOID, KS_FIG_11, 0.0, LAG_PRINTED, 100.0, 0.0},

    LOOP(FIG13, BOTH, 100, 0),

    LOOP_AT(FIG14, BOTH, 100,  0, "nl", 0.0), LOOP_AT(FIG14, BOTH, 200,  0, "nl", 0.0),
    LOOP_AT(FIG14, BOTH, 100, 12, "nl", 0.0), LOOP_AT(FIG14, BOTH, 200, 25, "nl", 0.0),
    LOOP_AT(FIG14, BOTH, 100, 25, "nl", 0.0), LOOP_AT(FIG14, BOTH, 200, 50, "nl", 0.0),
    LOOP_AT(FIG14, BOTH, 100, 40, "nl", 0.0), LOOP_AT(FIG14, BOTH, 200, 81, "nl", 0.0),

    LOOP_AT(FIG15, BOTH, 100,  0, "rated", RATED), LOOP_AT(FIG15, BOTH, 200,  0, "rated", RATED),
    LOOP_AT(FIG15, BOTH, 100, 12, "rated", RATED), LOOP_AT(FIG15, BOTH, 200, 25, "rated", RATED),
    LOOP_AT(FIG15, BOTH, 100, 25, "rated", RATED), LOOP_AT(FIG15, BOTH, 200, 50, "rated", RATED),
    LOOP_AT(FIG15, BOTH, 100, 40, "rated", RATED), LOOP_AT(FIG15, BOTH, 200, 81, "rated", RATED),
    LOOP_AT(FIG15, UNCOMPENSATED, 200,  0, "uncompensated", RATED),
    LOOP_AT(FIG15, UNCOMPENSATED, 200, 25, "uncompensated", RATED),
    LOOP_AT(FIG15, UNCOMPENSATED, 100,  0, "uncompensated", RATED),

    LOOP(FIG16, BOTH, 100,  0), LOOP(FIG16, BOTH, 200,  0),
    LOOP(FIG16, BOTH, 100,  8), LOOP(FIG16, BOTH, 200, 16),
    LOOP(FIG16, BOTH, 100, 16), LOOP(FIG16, BOTH, 200, 33),
    LOOP(FIG16, BOTH, 100, 25), LOOP(FIG16, BOTH, 200, 50),
    LOOP(FIG16, BOTH, 100, 40), LOOP(FIG16, BOTH, 200, 81),
    LOOP(FIG16, BOTH, 100, 60), LOOP(FIG16, BOTH, 200, 121),

    LOAD(LOAD_500,  "500",  100, 0), LOAD(LOAD_500,  "500",  100, 25), LOAD(LOAD_500,  "500",  200, 50),
    LOAD(LOAD_1500, "1500", 100, 0), LOAD(LOAD_1500, "1500", 100, 25), LOAD(LOAD_1500, "1500", 200, 50),
};
/* clang-format on */
#define RUNS (sizeof runs / sizeof runs[0])

/* The sweeps of fig14 to fig16, in the order of omega_c. */
static const char *const sweep_14[2][4] = {{"b100_wc0", "b100_wc12", "b100_wc25", "b100_wc40"},
                                           {"b200_wc0", "b200_wc25", "b200_wc50", "b200_wc81"}};
#define SWEEP_16 6
static const char *const sweep_16[2][SWEEP_16] = {
    {"b100_wc0", "b100_wc8", "b100_wc16", "b100_wc25", "b100_wc40", "b100_wc60"},
    {"b200_wc0", "b200_wc16", "b200_wc33", "b200_wc50", "b200_wc81", "b200_wc121"}};
static const char *const loads_16[2] = {"nl", "rated"};

const paper_figure_t paper_figures[PAPER_FIGURES] = {
    [FIG04] = {"fig04", "sign and sigmoid, and their equivalent gains, over the input"},
    [FIG05] = {"fig05", "equivalent gains on the sliding surface"},
    [FIG08] = {"fig08", "Bode plots of the loop filters at equal closed-loop bandwidth"},
    [FIG10] = {"fig10", "sign SMO over speed"},
    [FIG11] = {"fig11", "sigmoid SMO over speed, not compensated"},
    [FIG12] = {"fig12", "phase self-compensation on at 1.25 s, off at 3.75 s"},
    [FIG13] = {"fig13", "conventional PLL through speed steps"},
    [FIG14] = {"fig14", "feed-forward PLL through speed steps, no load"},
    [FIG15] = {"fig15", "feed-forward PLL through speed steps, rated load; loss of lock"},
    [FIG16] = {"fig16", "deviations and overshoots over bandwidth, omega_c and load"},
    [FIG17] = {"fig17", "rated load step at 500 and 1500 r/min"},
};

/* ---- what happens during a run ---- */

typedef enum { SPEED, COMPENSATION, LOAD_TORQUE } event_kind_t;

typedef struct {
    double time; /* [s] */
    event_kind_t kind;
    double value; /* [r/min], 1 on, [N m] */
} event_t;

/* A window's numbers are taken from begin to end. */
typedef struct {
    double begin, end; /* [s] */
    double from, to;   /* [r/min]; equal: a steady speed */
} window_t;

#define EVENTS_MAX  4
#define WINDOWS_MAX 5

typedef struct {
    double rpm;    /* at the start */
    double length; /* [s] */
    event_t events[EVENTS_MAX];
    size_t event_count;
    window_t windows[WINDOWS_MAX];
    size_t window_count;
} course_t;

/* Names of the windows. */
enum { AT_100 = 0, AT_500 = 1, AT_1000 = 2, AT_1500 = 3 };     /* STAIRS */
enum { BEFORE = 0, ON = 1, AFTER = 2 };                        /* COMPENSATE */
enum { SLOW = 0, UP = 1, FAST = 2, DOWN = 3, MIDDLE = 4 };     /* STEPS */
enum { UNLOADED = 0, LOADING = 1, LOADED = 2, UNLOADING = 3 }; /* LOAD_500, LOAD_1500 */

#define LOAD_COURSE(rpm)                                                                                     \
    {                                                                                                        \
        rpm, 6.0, {{1.0, LOAD_TORQUE, RATED}, {4.0, LOAD_TORQUE, 0.0}}, 2,                                   \
            {{0.0, 1.0, rpm, rpm}, {1.0, 3.0, rpm, rpm}, {3.0, 4.0, rpm, rpm}, {4.0, 6.0, rpm, rpm}}, 4      \
    }

/* At 10 A the rotor takes 1.0 s from 100 to 1500 r/min, 2.0 s with 5 N m; the speed control settles with a
 * time constant of 0.2 s. */
static const course_t courses[PROFILES] = {
    [HOLD_1013] = {1013.0, 1.0, {{0}}, 0, {{0.5, 1.0, 1013.0, 1013.0}}, 1},
    [STAIRS] = {100.0,
                11.0,
                {{2.0, SPEED, 500.0}, {5.0, SPEED, 1000.0}, {8.0, SPEED, 1500.0}},
                3,
                {{1.0, 2.0, 100.0, 100.0},
                 {4.5, 5.0, 500.0, 500.0},
                 {7.5, 8.0, 1000.0, 1000.0},
                 {10.5, 11.0, 1500.0, 1500.0}},
                4},
    [COMPENSATE] = {1500.0,
                    5.0,
                    {{1.25, COMPENSATION, 1.0}, {3.75, COMPENSATION, 0.0}},
                    2,
                    {{0.5, 1.25, 1500.0, 1500.0}, {3.0, 3.75, 1500.0, 1500.0}, {4.5, 5.0, 1500.0, 1500.0}},
                    3},
    [STEPS] = {100.0,
               11.0,
               {{2.0, SPEED, 1500.0}, {8.0, SPEED, 1000.0}},
               2,
               {{0.0, 2.0, 100.0, 100.0},
                {2.0, 6.0, 100.0, 1500.0},
                {6.5, 8.0, 1500.0, 1500.0},
                {8.0, 10.5, 1500.0, 1000.0},
                {10.5, 11.0, 1000.0, 1000.0}},
               5},
    [LOAD_500] = LOAD_COURSE(500.0),
    [LOAD_1500] = LOAD_COURSE(1500.0),
};

/* ---- theory ---- */

/* |Phi_1(j omega)| of (22). */
static double closed_loop(double kp, double ki, double wc, double omega)
{
    const double complex s = J * omega;
    return cabs(((kp + wc) * s * s + (ki + kp * wc) * s + ki * wc) / ((s + wc) * (s * s + kp * s + ki)));
}

bool paper_loop(double bandwidth, double omega_c, double *kp, double *ki)
{
    double low = 1e-3 * bandwidth;
    double high = bandwidth;
    if (closed_loop(2.0 * low, low * low, omega_c, bandwidth) > sqrt(0.5)) {
        return false;
    }
    for (int n = 0; n < 60; n++) { /* the gain at `bandwidth` rises with the natural frequency */
        const double wn = 0.5 * (low + high);
        if (closed_loop(2.0 * wn, wn * wn, omega_c, bandwidth) < sqrt(0.5)) {
            low = wn;
        } else {
            high = wn;
        }
    }
    *kp = 2.0 * high;
    *ki = high * high;
    return true;
}

/* Describing function of tanh(slope x/2) for a sine of this amplitude: the trapezoidal rule over a whole
 * period converges faster than any power. */
static double describing_gain(double slope, double amplitude)
{
    const int points = 64;
    double sum = 0.0;
    for (int n = 0; n < points; n++) {
        const double sine = sin(2.0 * PI * (n + 0.5) / points);
        sum += tanh(0.5 * slope * amplitude * sine) * sine;
    }
    return 2.0 * sum / (points * amplitude);
}

/* v/e of the sampled observer, exact zero-order hold, for g = k_s k_f (physics.md, section 2). */
static double complex sampled_response(double g, double omega_e)
{
    const double lambda = resistance / inductance;
    const double a = exp(-lambda * RIG_PERIOD_SECONDS);
    const double b = (1.0 - a) / resistance;
    const double complex z = cexp(J * omega_e * RIG_PERIOD_SECONDS);
    return b * g / (z - (a - b * g)) * lambda * (z - a) / ((1.0 - a) * (lambda + J * omega_e));
}

/* The k_f that belongs to the amplitude of the current error that it makes. */
static double settled_gain(double gain, double slope, double omega_e)
{
    const double emf = flux_linkage * fabs(omega_e);
    double k_f = 0.5 * slope;
    for (int n = 0; n < 100 && emf > 0.0; n++) {
        const double amplitude = emf * cabs(sampled_response(gain * k_f, omega_e)) / (gain * k_f);
        k_f += 0.5 * (describing_gain(slope, amplitude) - k_f);
    }
    return k_f;
}

double paper_lag_sampled(double gain, double slope, double omega_e)
{
    return carg(sampled_response(gain * settled_gain(gain, slope, omega_e), omega_e));
}

double paper_lag_printed(double gain, double slope, double omega_e)
{
    const double g = gain * settled_gain(gain, slope, omega_e);
    return -atan(omega_e * inductance / (g * resistance + resistance));
}

static double sigmoid(double x)
{
    return tanh(0.5 * x);
}

/* f(x)/x, eq. (12). */
static double equivalent_gain(switching_t switching, double x)
{
    if (switching == SIGN) {
        return 1.0 / fmax(fabs(x), 1e-6);
    }
    return fabs(x) < 1e-6 ? 0.5 : sigmoid(x) / x;
}

/* ---- one run ---- */

/* Columns of a trace. */
enum {
    C_SPEED_REF,
    C_SPEED,
    C_SPEED_HAT,
    C_THETA,
    C_THETA_HAT,
    C_ERROR,
    C_THEORY,
    C_I_Q,
    C_I_D,
    C_K_F,
    COLUMNS
};
static const char *const column_names[COLUMNS] = {
    [C_SPEED_REF] = "speed_ref[r/min]",
    [C_SPEED] = "speed[r/min]",
    [C_SPEED_HAT] = "speed_hat[r/min]",
    [C_THETA] = "theta[rad]",
    [C_THETA_HAT] = "theta_hat[rad]",
    [C_ERROR] = "theta_err[mrad]",
    [C_THEORY] = "theory_err[mrad]",
    [C_I_Q] = "i_q[A]",
    [C_I_D] = "true_i_d[A]",
    [C_K_F] = "k_f_alpha[1/A]",
};
#define BIT(column) (1u << (column))
#define MOTION      (BIT(C_SPEED_REF) | BIT(C_SPEED) | BIT(C_SPEED_HAT) | BIT(C_ERROR))

/* What a figure shows of each run; 0: no trace over time. */
static const unsigned shown[PAPER_FIGURES] = {
    [FIG05] = BIT(C_K_F),
    [FIG10] = MOTION | BIT(C_THETA) | BIT(C_THETA_HAT),
    [FIG11] = MOTION | BIT(C_THETA) | BIT(C_THETA_HAT) | BIT(C_THEORY),
    [FIG12] = BIT(C_SPEED) | BIT(C_ERROR) | BIT(C_I_Q) | BIT(C_I_D),
    [FIG13] = MOTION | BIT(C_THEORY),
    [FIG14] = MOTION,
    [FIG15] = MOTION,
    [FIG17] = MOTION | BIT(C_I_Q),
};

/* A window's numbers. Angles [mrad], speeds [r/min]. */
typedef struct {
    double count;
    double mean, sd;             /* of the angle's error */
    double peak;                 /* its largest magnitude */
    double speed;                /* mean of the true one */
    double speed_sd, speed_peak; /* of the estimated speed less the true one */
    double i_q, i_d;             /* means: as the drive sees it, and the true one [A] */
    double k_mean, k_sd, k_max;  /* equivalent gain of the alpha axis, sample by sample [1/A] */
    double plateau;              /* mean error between PLATEAU_BEGIN and PLATEAU_END; NAN: none */
    double acceleration;         /* mean there [rad/s^2], electrical */
} numbers_t;

typedef struct {
    double squares, speed_mean, speed_squares, k_squares; /* Welford's recurrences */
    double plateau_count, plateau_sum, acceleration_sum;
    bool plateau_over;
} sums_t;

typedef struct {
    const run_t *run;
    bool real;
    int32_t fault; /* [-] the drive's reason; 0: none */
    bool lost;     /* [-] fault, or a steady window's mean speed is off by LOST_SPEED */
    numbers_t numbers[WINDOWS_MAX];
    float *trace; /* COLUMNS per row; NULL: not recorded */
    size_t rows, rows_max;
} result_t;

typedef struct {
    result_t *result;
    const course_t *course;
    sums_t sums[WINDOWS_MAX];
    double load;    /* [N m] */
    double ki;      /* of the conventional loop [rad/s^2] */
    uint32_t count; /* [periods] so far */
} watch_t;

enum { T_REF, T_SPEED, T_HAT, T_THETA, T_THETA_HAT, T_ERROR, T_I_Q, T_I_D, T_TORQUE, T_I_ERR, TAPPED };
static const char *const tapped[TAPPED] = {[T_REF] = "omega_m_ref",
                                           [T_SPEED] = "true_omega_m",
                                           [T_HAT] = "omega_hat",
                                           [T_THETA] = "true_theta_e",
                                           [T_THETA_HAT] = "theta_hat",
                                           [T_ERROR] = "theta_hat_err",
                                           [T_I_Q] = "i_q",
                                           [T_I_D] = "true_i_d",
                                           [T_TORQUE] = "true_torque",
                                           [T_I_ERR] = "i_err_alpha"};

static void recur(double count, double value, double *mean, double *squares)
{
    const double step = value - *mean;
    *mean += step / count;
    *squares += step * (value - *mean);
}

typedef struct {
    double error, speed, speed_err, i_q, i_d, k_f, acceleration;
} moment_t;

static void take_window(const window_t *window, const moment_t *now, numbers_t *n, sums_t *s)
{
    n->count += 1.0;
    recur(n->count, now->error, &n->mean, &s->squares);
    recur(n->count, now->speed_err, &s->speed_mean, &s->speed_squares);
    recur(n->count, now->k_f, &n->k_mean, &s->k_squares);
    n->speed += (now->speed - n->speed) / n->count;
    n->i_q += (now->i_q - n->i_q) / n->count;
    n->i_d += (now->i_d - n->i_d) / n->count;
    n->peak = fmax(n->peak, fabs(now->error));
    n->speed_peak = fmax(n->speed_peak, fabs(now->speed_err));
    n->k_max = fmax(n->k_max, now->k_f);
    if (window->from != window->to) {
        const double share = (now->speed - window->from) / (window->to - window->from);
        s->plateau_over = s->plateau_over || share >= PLATEAU_END;
        if (share > PLATEAU_BEGIN && !s->plateau_over) {
            s->plateau_count += 1.0;
            s->plateau_sum += now->error;
            s->acceleration_sum += now->acceleration;
        }
    }
}

/* What theory says of the error at this moment [mrad]. */
static double theory(const watch_t *w, const moment_t *now)
{
    const run_t *run = w->result->run;
    if (run->figure == FIG11) {
        return paper_lag_sampled(run->gain, 1.0, pole_pairs * now->speed * RPM) / MRAD;
    }
    /* (20), with the detector's sine. */
    return run->omega_c > 0.0 ? 0.0 : -asin(fmax(-1.0, fmin(1.0, now->acceleration / w->ki))) / MRAD;
}

static void watch(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    watch_t *w = context;
    result_t *result = w->result;
    float value[TAPPED];
    (void)period;
    memcpy(value, slots, count * sizeof value[0]);

    const double time = w->count * RIG_PERIOD_SECONDS;
    const double speed = (double)value[T_SPEED];
    const moment_t now = {
        .error = (double)value[T_ERROR] / MRAD,
        .speed = speed / RPM,
        .speed_err = ((double)value[T_HAT] / pole_pairs - speed) / RPM,
        .i_q = (double)value[T_I_Q],
        .i_d = (double)value[T_I_D],
        .k_f = equivalent_gain(result->run->switching, (double)value[T_I_ERR]),
        .acceleration = pole_pairs * ((double)value[T_TORQUE] - w->load - friction) / inertia,
    };
    for (size_t n = 0; n < w->course->window_count; n++) {
        const window_t *window = &w->course->windows[n];
        if (time >= window->begin && time < window->end) {
            take_window(window, &now, &result->numbers[n], &w->sums[n]);
        }
    }
    if (result->trace != NULL && w->count % TRACE_EVERY == 0u && result->rows < result->rows_max) {
        float *row = &result->trace[COLUMNS * result->rows++];
        row[C_SPEED_REF] = (float)((double)value[T_REF] / RPM);
        row[C_SPEED] = (float)now.speed;
        row[C_SPEED_HAT] = (float)((double)value[T_HAT] / pole_pairs / RPM);
        row[C_THETA] = value[T_THETA];
        row[C_THETA_HAT] = value[T_THETA_HAT];
        row[C_ERROR] = (float)now.error;
        row[C_THEORY] = (shown[result->run->figure] & BIT(C_THEORY)) != 0u ? (float)theory(w, &now) : 0.0f;
        row[C_I_Q] = value[T_I_Q];
        row[C_I_D] = value[T_I_D];
        row[C_K_F] = (float)now.k_f;
    }
    w->count++;
}

/* A row of a table and its value. */
typedef struct {
    const char *row;
    double value;
} setting_t;

static bool put(rig_t *rig, const setting_t *settings, size_t count)
{
    for (size_t n = 0; n < count; n++) {
        if (!rig_put(rig, settings[n].row, settings[n].value)) {
            return false;
        }
    }
    return true;
}
#define PUT(rig, settings) put(rig, settings, sizeof settings / sizeof settings[0])

/* Inverter and sensors without error: what the dead band delays one edge by, the turn-off delays the other.
 */
static const setting_t ideal_settings[] = {
    {"plant.turn_on_delay", 0.0},  {"plant.turn_off_delay", 2.5e-6},
    {"plant.igbt_voltage", 0.0},   {"plant.igbt_resistance", 0.0},
    {"plant.diode_voltage", 0.0},  {"plant.diode_resistance", 0.0},
    {"plant.current_zone", 0.0},   {"plant.current_noise", 0.0},
    {"params.turn_on_delay", 0.0}, {"params.turn_off_delay", 2.5e-6},
    {"params.device_drop", 0.0},   {"params.device_resistance", 0.0},
    {"params.current_zone", 1e-3}, {"rig.sensors", 1.0},
};
/* What calibration left of the sensors' errors. */
static const setting_t real_settings[] = {
    {"plant.current_offset_a", 0.03},
    {"plant.current_gain_error_a", 0.002},
};
/* Of fig16 besides, as in the reference study: a machine whose EMF is no pure sine. */
static const setting_t harmonic_settings[] = {
    {"plant.emf_5th", 0.01},
    {"plant.emf_7th", 0.005},
};
/* 3.6 us of each edge are lost and the drive knows nothing of it: it believes that the transistors switch off
 * as late as the dead band lets the others switch on. Chosen to show the effect: from 3.5 us on the
 * conventional loop of 200 rad/s is lost here (at 3.25 us in the reference study), and the feed-forward loop
 * is not. */
static const setting_t uncompensated_settings[] = {
    {"params.dead_time", 3.8e-6},      {"params.turn_off_delay", 4.49e-6}, {"params.device_drop", 0.0},
    {"params.device_resistance", 0.0}, {"params.compensation_gain", 0.0},  {"params.doubtful_current", 0.0},
};
/* The rig, and the signs of a lost estimate, which the paper does not have. */
static const setting_t common_settings[] = {
    {"plant.inertia", 0.0636},
    {"plant.friction_coulomb", 1.32},
    {"params.speed_kp", 0.5},
    {"params.speed_ki", 2.5},
    {"params.current_limit", 10.0},
    {"params.current_bandwidth", 1000.0},
    {"params.overspeed_trip", 200.0}, /* [rad/s]; the smallest k_s covers the EMF up to here */
    {"params.observer_slope", 1.0},
    {"params.pll_damping", 1.0},
    {"params.torque_feedforward", 0.0},
    {"params.flux_adaptation", 0.0},
    {"params.estimate_amplitude_min", 0.0},
    {"params.estimate_amplitude_max", 1.0},
    {"params.estimate_detector_max", 0.0},
    {"params.estimate_current_max", 0.0},
    {"params.estimate_speed_min", 0.0},
    {"params.start_speed", 0.0},
    {"rig.fidelity", 1.0},
};

static bool configure(rig_t *rig, const result_t *result)
{
    const run_t *run = result->run;
    const setting_t own[] = {
        {"params.observer_switching", run->switching},
        {"params.observer_gain", run->gain},
        {"params.observer_emf_cutoff", run->omega_s},
        {"params.lag_compensation", run->profile == COMPENSATE ? LAG_NONE : run->lag},
        {"params.pll_bandwidth", run->bandwidth},
        {"params.feedforward_cutoff", run->omega_c},
        {"params.position_source", run->encoder ? 0.0 : 1.0},
    };
    return PUT(rig, common_settings) && (result->real || PUT(rig, ideal_settings)) &&
           (run->flavours != UNCOMPENSATED || PUT(rig, uncompensated_settings)) && PUT(rig, own) &&
           rig_apply(rig);
}

/* The current [A] that holds the load and the friction. */
static double holding_current(double load)
{
    return (load + friction) / (1.5 * pole_pairs * flux_linkage);
}

/* A dynamometer turns the rotor until the estimator has settled and the drive gives the torque that is asked
 * for; then the speed control takes over: a load that fell on the rotor all at once would stop it at 100
 * r/min. */
static bool begin(rig_t *rig, const result_t *result)
{
    const run_t *run = result->run;
    const double omega_m = courses[run->profile].rpm * RPM;
    const table_row_t *mode = rig_row_by_name("mode");
    if ((result->real && !PUT(rig, real_settings)) ||
        (result->real && run->figure == FIG16 && !PUT(rig, harmonic_settings)) ||
        !rig_put(rig, "plant.shaft_locked_speed", omega_m) || !rig_put(rig, "plant.shaft_locked", 1.0) ||
        !rig_put(rig, "plant.load_torque", run->load)) {
        return false;
    }
    rig_set_motion(rig, 0.0, omega_m);
    rig_run(rig, FOLLOW_PERIODS);
    if (!rig_put(rig, "mode", table_choice(mode, "current")) ||
        !rig_put(rig, "i_q_request", holding_current(run->load)) || !rig_put(rig, "enable", 1.0)) {
        return false;
    }
    rig_run(rig, HOLD_PERIODS);
    if (!rig_put(rig, "speed_request", omega_m) || !rig_put(rig, "mode", table_choice(mode, "speed")) ||
        !rig_put(rig, "plant.shaft_locked", 0.0)) {
        return false;
    }
    /* With real sensors the drive trims the offset away while turning. */
    rig_run(rig, (uint32_t)((result->real ? 3.0 : 0.5) / RIG_PERIOD_SECONDS));
    return true;
}

static bool act(rig_t *rig, const run_t *run, const event_t *event, watch_t *w)
{
    switch (event->kind) {
    case SPEED:
        return rig_put(rig, "speed_request", event->value * RPM);
    case COMPENSATION:
        return rig_put(rig, "params.lag_compensation", event->value > 0.0 ? run->lag : LAG_NONE) &&
               rig_apply(rig);
    case LOAD_TORQUE:
        w->load = event->value;
        return rig_put(rig, "plant.load_torque", event->value);
    }
    return false;
}

/* Sums into numbers; and whether the rotor was where it should be. */
static void conclude(watch_t *w)
{
    result_t *result = w->result;
    result->lost = result->fault != 0;
    for (size_t n = 0; n < w->course->window_count; n++) {
        const window_t *window = &w->course->windows[n];
        const sums_t *s = &w->sums[n];
        numbers_t *to = &result->numbers[n];
        to->sd = sqrt(s->squares / to->count);
        to->speed_sd = sqrt(s->speed_squares / to->count);
        to->k_sd = sqrt(s->k_squares / to->count);
        to->plateau = s->plateau_count > 0.0 ? s->plateau_sum / s->plateau_count : (double)NAN;
        to->acceleration = s->plateau_count > 0.0 ? s->acceleration_sum / s->plateau_count : (double)NAN;
        if (window->from == window->to && fabs(to->speed - window->to) > LOST_SPEED * window->to) {
            result->lost = true;
        }
    }
}

static bool measure_on(rig_t *rig, result_t *result)
{
    const run_t *run = result->run;
    const course_t *course = &courses[run->profile];
    watch_t w = {.result = result, .course = course, .load = run->load};
    uint32_t ids[TAPPED];
    double kp = 0.0;
    for (uint32_t n = 0; n < TAPPED; n++) {
        ids[n] = rig_row_by_name(tapped[n])->id;
    }
    const table_row_t *state = rig_row_by_name("state");
    if (!paper_loop(run->bandwidth, run->omega_c, &kp, &w.ki) || !configure(rig, result) ||
        !rig_stop_when(rig, state->id, RIG_EQUAL, table_choice(state, "ready"))) {
        return false;
    }
    rig_run(rig, READY_PERIODS);
    if (!rig_stop_when(rig, state->id, RIG_NEVER, 0.0) || !begin(rig, result) ||
        !rig_tap(rig, ids, TAPPED, 1u, watch, &w)) {
        return false;
    }
    const uint32_t slices = (uint32_t)(course->length / (SLICE_PERIODS * RIG_PERIOD_SECONDS) + 0.5);
    size_t next = 0;
    for (uint32_t slice = 0; slice < slices; slice++) {
        const double time = (slice + 0.5) * SLICE_PERIODS * RIG_PERIOD_SECONDS;
        while (next < course->event_count && course->events[next].time <= time) {
            if (!act(rig, run, &course->events[next++], &w)) {
                return false;
            }
        }
        rig_run(rig, SLICE_PERIODS);
    }
    result->fault = (int32_t)rig_value(rig, "fault_reason");
    conclude(&w);
    return true;
}

static bool measure(result_t *result, uint64_t seed, paper_error_t *why)
{
    const run_t *run = result->run;
    if (shown[run->figure] != 0u) {
        result->rows_max = (size_t)(courses[run->profile].length / (RIG_PERIOD_SECONDS * TRACE_EVERY) + 0.5);
        result->trace = calloc(result->rows_max * COLUMNS, sizeof result->trace[0]);
    }
    rig_t *rig = rig_create(seed);
    if (rig == NULL || (shown[run->figure] != 0u && result->trace == NULL)) {
        rig_free(rig);
        snprintf(why->text, sizeof why->text, "no memory");
        return false;
    }
    const bool measured = measure_on(rig, result);
    if (!measured) {
        snprintf(why->text, sizeof why->text, "%s, %s: %s", paper_figures[run->figure].id, run->name,
                 rig_error(rig));
    }
    rig_free(rig);
    return measured;
}

/* ---- all runs ---- */

struct paper {
    bool wanted[PAPER_FIGURES];
    result_t *results;
    size_t result_count;
    paper_row_t rows[PAPER_ROWS_MAX];
    size_t row_count;
};

typedef struct {
    paper_t *paper;
    uint64_t seed;
    atomic_size_t next; /* run that nobody has taken yet */
    pthread_mutex_t lock;
    size_t done;        /* behind the lock */
    bool failed;        /* likewise */
    paper_error_t *why; /* likewise, of the first failure */
    paper_progress_t progress;
    void *context;
} work_t;

static void *work_off(void *argument)
{
    work_t *work = argument;
    const size_t count = work->paper->result_count;
    for (size_t n = atomic_fetch_add(&work->next, 1u); n < count; n = atomic_fetch_add(&work->next, 1u)) {
        paper_error_t why;
        const bool measured = measure(&work->paper->results[n], work->seed, &why);
        pthread_mutex_lock(&work->lock);
        work->done++;
        if (measured && work->progress != NULL && !work->failed) {
            work->progress(work->context, work->done, count);
        }
        if (!measured && !work->failed) {
            *work->why = why;
            work->failed = true;
            atomic_store(&work->next, count); /* nobody need go on */
        }
        pthread_mutex_unlock(&work->lock);
    }
    return NULL;
}

static bool run_all(paper_t *paper, uint64_t seed, unsigned threads, paper_progress_t progress, void *context,
                    paper_error_t *why)
{
    work_t work = {.paper = paper, .seed = seed, .why = why, .progress = progress, .context = context};
    atomic_init(&work.next, 0u);
    pthread_mutex_init(&work.lock, NULL);

    pool_run(threads, work_off, &work);
    pthread_mutex_destroy(&work.lock);
    return !work.failed;
}

static size_t lay_out(const bool wanted[PAPER_FIGURES], result_t *results)
{
    size_t count = 0;
    for (size_t n = 0; n < RUNS; n++) {
        for (int real = runs[n].flavours == BOTH ? 0 : 1; real <= 1; real++) {
            if (wanted[runs[n].figure]) {
                if (results != NULL) {
                    results[count] = (result_t){.run = &runs[n], .real = real != 0};
                }
                count++;
            }
        }
    }
    return count;
}

size_t paper_figure(const char *id)
{
    size_t n = 0;
    while (n < PAPER_FIGURES && strcmp(paper_figures[n].id, id) != 0) {
        n++;
    }
    return n;
}

/* ---- judgement ---- */

paper_verdict_t paper_judge(const paper_row_t *row)
{
    if (row->stopped || isnan(row->ours)) {
        return PAPER_NOT_REPRODUCED;
    }
    const bool same = fabs(row->ours - row->expected) <= row->tolerance;
    if (same && !isnan(row->paper)) {
        return PAPER_REPRODUCED;
    }
    return same || row->kind ? PAPER_IN_KIND : PAPER_NOT_REPRODUCED;
}

const char *paper_verdict_name(paper_verdict_t verdict)
{
    static const char *const names[] = {
        [PAPER_REPRODUCED] = "reproduced",
        [PAPER_IN_KIND] = "reproduced in kind",
        [PAPER_NOT_REPRODUCED] = "not reproduced",
    };
    return names[verdict];
}

static void describe(char *to, size_t size, const run_t *run, bool real)
{
    static const char *const switchings[] = {"sign", "sigmoid 1/A per axis"};
    static const char *const lags[] = {"none", "(14) as printed", "(14) corrected", "exact"};
    static const char *const starts[PROFILES] = {
        [HOLD_1013] = "1013 r/min",          [STAIRS] = "100-500-1000-1500 r/min",
        [COMPENSATE] = "1500 r/min",         [STEPS] = "100-1500-1000 r/min",
        [LOAD_500] = "500 r/min, 0-5-0 N m", [LOAD_1500] = "1500 r/min, 0-5-0 N m"};
    const char *harmonics = real && run->figure == FIG16 ? ", EMF with 1 % 5th and 0.5 % 7th" : "";
    const char *flavour = !real ? "ideal inverter and sensors"
                          : run->flavours == UNCOMPENSATED
                              ? "3.6 us dead time in effect, not compensated, 12-bit "
                                "ADC, noise 10 mA, offset 30 mA, gain error 0.2 %"
                              : "2.5 us dead time, compensated, 12-bit ADC, noise 10 "
                                "mA, offset 30 mA, gain error 0.2 %";
    snprintf(to, size,
             "%s%s; %s, load %g N m, friction %g N m, J %g kg m^2; %s; %s, k_s %g V, omega_s %g rad/s, lag "
             "compensation %s; PLL %g rad/s, damping 1, omega_c %g rad/s; speed PI 0.5, 2.5, 10 A",
             flavour, harmonics, starts[run->profile], run->load, friction, inertia,
             run->encoder ? "estimator beside the encoder" : "sensorless", switchings[run->switching],
             run->gain, run->omega_s, lags[run->lag], run->bandwidth, run->omega_c);
}

static const result_t *find(const paper_t *paper, figure_t figure, const char *name, bool real)
{
    for (size_t n = 0; n < paper->result_count; n++) {
        const result_t *result = &paper->results[n];
        if (result->run->figure == figure && result->real == real && strcmp(result->run->name, name) == 0) {
            return result;
        }
    }
    assert(false);
    return NULL;
}

/* What the row says beside its number. */
typedef struct {
    figure_t figure;
    const char *id; /* after the figure's */
    const char *claim;
    const char *unit;
    double paper; /* NAN: none; then `theory` is what ours is judged against */
    double theory;
    double tolerance;
    const char *because; /* if ours is not the paper's */
} claim_t;

/* Judged against the paper's number. */
static claim_t claim_of(figure_t figure, const char *id, const char *claim, const char *unit, double number,
                        double tolerance, const char *because)
{
    return (claim_t){figure, id, claim, unit, number, (double)NAN, tolerance, because};
}

/* The print has no number: judged against what theory says. */
static claim_t claim_of_theory(figure_t figure, const char *id, const char *claim, const char *unit,
                               double theory_number, double tolerance, const char *because)
{
    return (claim_t){figure, id, claim, unit, (double)NAN, theory_number, tolerance, because};
}

static paper_row_t *add(paper_t *paper, const claim_t *claim, const char *flavour, double ours, bool kind)
{
    assert(paper->row_count < PAPER_ROWS_MAX);
    paper_row_t *row = &paper->rows[paper->row_count++];
    *row = (paper_row_t){
        .figure = claim->figure,
        .flavour = flavour,
        .paper = claim->paper,
        .expected = isnan(claim->paper) ? claim->theory : claim->paper,
        .ours = ours,
        .unit = claim->unit,
        .tolerance = claim->tolerance,
        .kind = kind,
    };
    snprintf(row->id, sizeof row->id, "%s.%s.%s", paper_figures[claim->figure].id, claim->id, flavour);
    snprintf(row->claim, sizeof row->claim, "%s", claim->claim);
    return row;
}

static void conclude_row(paper_row_t *row, const claim_t *claim)
{
    row->verdict = paper_judge(row);
    if (row->stopped) {
        snprintf(row->because, sizeof row->because, "because the drive stopped or lost the rotor");
    } else if (isnan(row->ours)) {
        snprintf(row->because, sizeof row->because, "because there is nothing to measure");
    } else if (row->verdict == PAPER_NOT_REPRODUCED && isinf(row->expected)) {
        snprintf(row->because, sizeof row->because, "because the claim does not hold of it");
    } else if (row->verdict == PAPER_NOT_REPRODUCED && isnan(row->paper)) {
        snprintf(row->because, sizeof row->because, "because theory says %.4g within %.2g", row->expected,
                 row->tolerance);
    } else if (row->verdict != PAPER_REPRODUCED) {
        snprintf(row->because, sizeof row->because, "because %s", claim->because);
    }
}

/* A number of one run; kind: the claim holds. */
static void row_of(paper_t *paper, const claim_t *claim, const result_t *result, double ours, bool kind)
{
    paper_row_t *row = add(paper, claim, result->real ? "real" : "ideal", ours, kind);
    row->stopped = result->lost;
    describe(row->condition, sizeof row->condition, result->run, result->real);
    conclude_row(row, claim);
}

static void row_of_formula(paper_t *paper, const claim_t *claim, double ours, bool kind,
                           const char *condition)
{
    paper_row_t *row = add(paper, claim, "formula", ours, kind);
    snprintf(row->condition, sizeof row->condition, "%s", condition);
    conclude_row(row, claim);
}

/* A number of several runs, one of which stands for the conditions. */
static void row_of_several(paper_t *paper, const claim_t *claim, const result_t *one, bool stopped,
                           double ours, bool kind, const char *condition)
{
    paper_row_t *row = add(paper, claim, one->real ? "real" : "ideal", ours, kind);
    row->stopped = stopped;
    char text[sizeof row->condition];
    describe(text, sizeof text, one->run, one->real);
    snprintf(row->condition, sizeof row->condition, "%s; %.280s", condition, text);
    conclude_row(row, claim);
}

/* ---- fig04 and fig08: formulas ---- */

static void judge_fig04(paper_t *paper)
{
    double largest = 0.0;
    double sign = 0.0;
    for (int n = -1000; n <= 1000; n++) {
        const double x = 0.01 * n;
        largest = fmax(largest, equivalent_gain(SIGMOID, x));
        if (n != 0) {
            sign = fmax(sign, equivalent_gain(SIGN, x));
        }
    }
    const claim_t bound = claim_of(FIG04, "sigmoid", "k_f of the sigmoid is at most 1/2", "1/A", 0.5, 1e-4,
                                   "the largest is another");
    const claim_t unbound =
        claim_of_theory(FIG04, "sign", "k_f of the sign has no bound: its value at 10 mA", "1/A", 100.0, 1e-6,
                        "the print shows a curve without a number; 1/|x| gives this");
    row_of_formula(paper, &bound, largest, largest <= 0.5,
                   "eq. (12), slope 1/A, |x| up to 10 A in steps of 10 mA");
    row_of_formula(paper, &unbound, sign, sign > 10.0 * largest, "eq. (12), |x| from 10 mA to 10 A");
}

#define BODE_POINTS  251
#define BODE_CUTOFFS 4
static const double bode_bandwidths[2] = {100.0, 200.0};
static const double bode_cutoffs[2][BODE_CUTOFFS] = {{0.0, 12.0, 25.0, 40.0}, {0.0, 25.0, 50.0, 81.0}};

static double bode_frequency(int n)
{
    return 0.1 * pow(10.0, n / 50.0);
}

/* k_p + k_i/s at s = j omega. */
static double complex loop_filter(double bandwidth, double omega_c, double omega)
{
    double kp = 0.0;
    double ki = 0.0;
    const bool exists = paper_loop(bandwidth, omega_c, &kp, &ki);
    assert(exists);
    (void)exists;
    return kp + ki / (J * omega);
}

static void judge_fig08(paper_t *paper)
{
    for (int b = 0; b < 2; b++) {
        double least = INFINITY;
        double at_25_or_50 = 0.0;
        int not_lower = 0;
        for (int c = 1; c < BODE_CUTOFFS; c++) {
            for (int n = 0; n < BODE_POINTS; n++) {
                const double omega = bode_frequency(n);
                const double gain = cabs(loop_filter(bode_bandwidths[b], bode_cutoffs[b][c], omega));
                const double before = cabs(loop_filter(bode_bandwidths[b], bode_cutoffs[b][c - 1], omega));
                const double conventional = cabs(loop_filter(bode_bandwidths[b], 0.0, omega));
                not_lower += gain >= before;
                if (c == 2) {
                    least = fmin(least, 20.0 * log10(conventional / gain));
                }
            }
        }
        at_25_or_50 = least;
        const claim_t monotone =
            claim_of(FIG08, b == 0 ? "b100_falling" : "b200_falling",
                     b == 0 ? "100 rad/s: frequencies at which more omega_c does not lower the loop filter"
                            : "200 rad/s: frequencies at which more omega_c does not lower the loop filter",
                     "-", 0.0, 0.0, "it is not lower there");
        /* Where k_p rules, 20 log of the ratio of k_p: 40.3/25.9 in physics.md, section 3, at 25.2 rad/s. */
        const claim_t lower = claim_of_theory(
            FIG08, b == 0 ? "b100_lower" : "b200_lower",
            b == 0 ? "100 rad/s: omega_c 25 rad/s lowers the loop filter everywhere, at least by"
                   : "200 rad/s: omega_c 50 rad/s lowers the loop filter everywhere, at least by",
            "dB", 3.84, 0.05,
            "the print has no number; k_p, k_i retuned for equal bandwidth, damping 1 (erratum 11)");
        const char *condition = "k_p + k_i/s, -3 dB bandwidth of (22) kept, damping 1, 0.1 to 10^4 rad/s";
        row_of_formula(paper, &monotone, not_lower, false, condition);
        row_of_formula(paper, &lower, at_25_or_50, least > 0.0, condition);
    }
}

/* ---- measured figures ---- */

static void judge_fig05(paper_t *paper, bool real)
{
    const result_t *sign = find(paper, FIG05, "sign", real);
    const result_t *smooth = find(paper, FIG05, "sigmoid", real);
    const numbers_t *a = &sign->numbers[0];
    const numbers_t *b = &smooth->numbers[0];
    const char *none = "the print has no number";
    const double spread_a = a->k_sd / a->k_mean;
    const double spread_b = b->k_sd / b->k_mean;
    /* k_f below 0.5 by what the EMF of 78 V takes: tanh(x/2)/x with |x| up to 0.8 A. */
    const claim_t bound = claim_of(FIG05, "sigmoid", "sigmoid: k_f below 0.5; its mean", "1/A", 0.5, 0.03,
                                   "the mean is another");
    const claim_t constant = claim_of_theory(
        FIG05, "sigmoid_spread", "sigmoid: k_f nearly constant; its SD over its mean", "-", 0.0, 0.05, none);
    const claim_t huge = claim_of_theory(FIG05, "sign", "sign: k_f huge; its largest over the sigmoid's", "-",
                                         INFINITY, 0.0, none);
    const claim_t irregular = claim_of_theory(
        FIG05, "sign_spread", "sign: k_f irregular; its SD over its mean", "-", INFINITY, 0.0, none);
    row_of(paper, &bound, smooth, b->k_mean, b->k_max < 0.5 + 1e-6);
    row_of(paper, &constant, smooth, spread_b, false);
    row_of(paper, &huge, sign, a->k_max / b->k_max, a->k_max > 10.0 * b->k_max);
    row_of(paper, &irregular, sign, spread_a, spread_a > 10.0 * spread_b);
}

static void judge_fig10(paper_t *paper, bool real)
{
    const result_t *sign = find(paper, FIG10, "sign", real);
    const result_t *smooth = find(paper, FIG10, "sigmoid", real);
    const numbers_t *a = &sign->numbers[AT_1500];
    const numbers_t *b = &smooth->numbers[AT_1500];
    /* A switch that acts once per sample can be late or early by half of it: omega_e T_s/2 = 31 mrad. */
    const claim_t mean = claim_of(FIG10, "mean", "sign: mean deviation at 1500 r/min negligible", "mrad", 0.0,
                                  8.0, "it is there, and below half a sample (31 mrad)");
    const claim_t ripple = claim_of_theory(
        FIG10, "ripple", "sign: harmonic error at 1500 r/min, SD over that of the sigmoid", "-", 20.0, 0.0,
        "the print has no number; large is taken as five times the sigmoid's");
    row_of(paper, &mean, sign, a->mean, fabs(a->mean) < 31.4);
    row_of(paper, &ripple, sign, a->sd / b->sd, a->sd > 5.0 * b->sd);
}

static void judge_fig11(paper_t *paper, bool real)
{
    static const double speeds[] = {100.0, 500.0, 1000.0, 1500.0};
    const result_t *fitted = find(paper, FIG11, "ks162", real);
    const result_t *rule = find(paper, FIG11, "ks200", real);
    double worst = 0.0;
    bool grows = true;
    for (int n = 0; n < 4; n++) {
        const double expected = paper_lag_sampled(KS, 1.0, pole_pairs * speeds[n] * RPM) / MRAD;
        const double off = rule->numbers[n].mean - expected;
        worst = fabs(off) > fabs(worst) ? off : worst;
        grows = grows && (n == 0 || rule->numbers[n].mean < rule->numbers[n - 1].mean);
    }
    const double printed = paper_lag_printed(KS, 1.0, pole_pairs * 1500.0 * RPM) / MRAD;
    const claim_t size = claim_of(FIG11, "ks162", "deviation at 1500 r/min, k_s 162 V", "mrad", -80.0, 3.0,
                                  "the number is another");
    const claim_t size_rule =
        claim_of(FIG11, "ks200", "deviation at 1500 r/min, k_s 200 V", "mrad", -80.0, 3.0,
                 "k_s is not in the print; with voltage and sample in time this one leaves -54");
    const claim_t exact =
        claim_of(FIG11, "theory", "k_s 200 V: largest distance from theory of the sampled observer", "mrad",
                 0.0, real ? 4.0 : 1.0, "the distance is larger");
    const claim_t print =
        claim_of(FIG11, "printed", "k_s 200 V: distance from (14) as printed, 1500 r/min", "mrad", 0.0, 3.0,
                 "the sampled observer lags half a period less than (14), 31 mrad (errata 1, 2)");
    row_of(paper, &size, fitted, fitted->numbers[AT_1500].mean, false);
    row_of(paper, &size_rule, rule, rule->numbers[AT_1500].mean, grows);
    row_of(paper, &exact, rule, worst, false);
    row_of(paper, &print, rule, rule->numbers[AT_1500].mean - printed, false);
}

static void judge_fig12(paper_t *paper, bool real)
{
    const result_t *exact = find(paper, FIG12, "exact", real);
    const result_t *printed = find(paper, FIG12, "printed", real);
    const numbers_t *n = exact->numbers;
    const double off = 0.5 * (n[BEFORE].mean + n[AFTER].mean);
    const double i_q = 0.5 * (n[BEFORE].i_q + n[AFTER].i_q) - n[ON].i_q;
    const double i_d = 0.5 * (n[BEFORE].i_d + n[AFTER].i_d) - n[ON].i_d;
    const claim_t without =
        claim_of(FIG12, "off", "deviation without compensation", "mrad", -80.0, 4.0, "the number is another");
    const claim_t with = claim_of(FIG12, "exact", "deviation with exact compensation", "mrad", 0.0,
                                  real ? 4.0 : 1.0, "more is left");
    const claim_t as_printed = claim_of(FIG12, "printed", "deviation with (14) as printed", "mrad", 0.0, 4.0,
                                        "(14) counts half a period too much (erratum 2)");
    /* 1 - cos of the change of angle, times 4 A */
    const claim_t falls =
        claim_of(FIG12, "i_q", "i_q falls as compensation is switched on", "A", 0.32, 0.05,
                 "an error of 0.08 rad changes i_q by 0.3 %: the 0.32 A are on the other axis (erratum 12)");
    const claim_t wrong_axis =
        claim_of(FIG12, "i_d", "current on the wrong axis that goes with the deviation", "A", 0.32, 0.02,
                 "i sin(deviation) gives another number");
    row_of(paper, &without, exact, off, false);
    row_of(paper, &with, exact, n[ON].mean, fabs(n[ON].mean) < 0.1 * fabs(off));
    row_of(paper, &as_printed, printed, printed->numbers[ON].mean, false);
    row_of(paper, &falls, exact, i_q, false);
    row_of(paper, &wrong_axis, exact, fabs(i_d), false);
}

static void judge_fig13(paper_t *paper, bool real)
{
    const result_t *nl = find(paper, FIG13, "b100_wc0_nl", real);
    const result_t *rated = find(paper, FIG13, "b100_wc0_rated", real);
    double kp = 0.0;
    double ki = 0.0;
    (void)paper_loop(100.0, 0.0, &kp, &ki);
    const double predicted = -asin(fmin(1.0, nl->numbers[UP].acceleration / ki)) / MRAD;
    double steady = 0.0;
    for (int n = 0; n < 2; n++) {
        const numbers_t *numbers = n == 0 ? nl->numbers : rated->numbers;
        steady = fmax(steady, fmax(fabs(numbers[FAST].mean), fabs(numbers[MIDDLE].mean)));
    }
    const double up = fabs(nl->numbers[UP].plateau);
    const double down = nl->numbers[DOWN].peak;
    const double down_rated = rated->numbers[DOWN].peak;
    const claim_t constant = claim_of(FIG13, "steady", "no error at constant speed", "mrad", 0.0,
                                      real ? 4.0 : 0.5, "some is left");
    const claim_t accelerating = claim_of(FIG13, "accelerating", "error while accelerating, no load", "mrad",
                                          355.0, 10.0, "the number is another");
    const claim_t decelerating = claim_of(FIG13, "decelerating", "error while decelerating, no load", "mrad",
                                          449.0, 15.0, "the number is another");
    const claim_t loaded = claim_of(FIG13, "decelerating_rated", "error while decelerating, rated load",
                                    "mrad", 623.0, 20.0, "the number is another");
    const claim_t theory_claim = claim_of(FIG13, "theory", "error while accelerating over asin(a/k_i)", "-",
                                          1.0, 0.02, "the ratio is another");
    const bool ordered = up < down && down < down_rated;
    row_of(paper, &constant, nl, steady, false);
    row_of(paper, &accelerating, nl, up, ordered);
    row_of(paper, &decelerating, nl, down, ordered);
    row_of(paper, &loaded, rated, down_rated, ordered);
    row_of(paper, &theory_claim, nl, nl->numbers[UP].plateau / predicted, false);
}

/* The largest error while accelerating of the feed-forward loops of a sweep, by magnitude. */
static const result_t *worst_of_sweep(const paper_t *paper, figure_t figure, int b, const char *load,
                                      bool real, bool *stopped)
{
    const result_t *worst = NULL;
    *stopped = false;
    for (int c = 1; c < 4; c++) {
        char name[40];
        snprintf(name, sizeof name, "%s_%s", sweep_14[b][c], load);
        const result_t *result = find(paper, figure, name, real);
        *stopped = *stopped || result->lost;
        if (worst == NULL || fabs(result->numbers[UP].plateau) > fabs(worst->numbers[UP].plateau)) {
            worst = result;
        }
    }
    return worst;
}

static void judge_sweep(paper_t *paper, figure_t figure, const char *load, bool real)
{
    for (int b = 0; b < 2; b++) {
        char name[40];
        char condition[80];
        bool stopped = false;
        snprintf(name, sizeof name, "%s_%s", sweep_14[b][0], load);
        const result_t *conventional = find(paper, figure, name, real);
        const result_t *worst = worst_of_sweep(paper, figure, b, load, real, &stopped);
        double kp = 0.0;
        double ki = 0.0;
        (void)paper_loop(conventional->run->bandwidth, 0.0, &kp, &ki);
        const claim_t none =
            claim_of(figure, b == 0 ? "b100_feedforward" : "b200_feedforward",
                     b == 0 ? "100 rad/s: largest error while accelerating over omega_c"
                            : "200 rad/s: largest error while accelerating over omega_c",
                     "mrad", 0.0, real ? 6.0 : 3.0,
                     "a slow pole (small omega_c or k_i) has not settled in the time of the acceleration");
        const claim_t late = claim_of_theory(
            figure, b == 0 ? "b100_conventional" : "b200_conventional",
            b == 0 ? "100 rad/s: the conventional PLL's error" : "200 rad/s: the conventional PLL's error",
            "mrad", -asin(conventional->numbers[UP].acceleration / ki) / MRAD,
            0.03 * 355.0 / (b == 0 ? 1.0 : 4.0), "the print has no number here; this is a/k_i");
        snprintf(condition, sizeof condition, "worst of omega_c %s rad/s",
                 b == 0 ? "12, 25, 40" : "25, 50, 81");
        const double error = worst->numbers[UP].plateau;
        row_of_several(paper, &none, worst, stopped, error,
                       fabs(error) < 0.1 * fabs(conventional->numbers[UP].plateau), condition);
        row_of(paper, &late, conventional, conventional->numbers[UP].plateau, false);
    }
}

/* Which loops lose the rotor: 1, and the row is not about a number that a stopped drive would spoil. */
static void judge_loss(paper_t *paper, const claim_t *claim, const result_t *result)
{
    paper_row_t *row = add(paper, claim, result->real ? "real" : "ideal", result->lost ? 1.0 : 0.0, false);
    describe(row->condition, sizeof row->condition, result->run, result->real);
    conclude_row(row, claim);
}

static void judge_fig15(paper_t *paper, bool real)
{
    judge_sweep(paper, FIG15, "rated", real);
    const claim_t compensated = claim_of(
        FIG15, "compensated", "200 rad/s, conventional, inverter compensated: loses the rotor (1)", "-", 1.0,
        0.0, "it holds: no k_i of this size loses the rotor if the dead time is compensated");
    judge_loss(paper, &compensated, find(paper, FIG15, "b200_wc0_rated", real));
    if (!real) { /* has no dead time */
        return;
    }
    const claim_t conventional =
        claim_of(FIG15, "conventional", "200 rad/s, conventional, not compensated: loses the rotor (1)", "-",
                 1.0, 0.0, "it holds");
    const claim_t feedforward =
        claim_of(FIG15, "feedforward", "200 rad/s, omega_c 25, not compensated: loses the rotor (1)", "-",
                 0.0, 0.0, "it is lost too");
    const claim_t moderate =
        claim_of(FIG15, "moderate", "100 rad/s, conventional, not compensated: loses the rotor (1)", "-", 0.0,
                 0.0, "it is lost too: not the k_i is the cause");
    judge_loss(paper, &conventional, find(paper, FIG15, "b200_wc0_uncompensated", true));
    judge_loss(paper, &feedforward, find(paper, FIG15, "b200_wc25_uncompensated", true));
    judge_loss(paper, &moderate, find(paper, FIG15, "b100_wc0_uncompensated", true));
}

static const result_t *of_16(const paper_t *paper, int b, int c, int load, bool real)
{
    char name[40];
    snprintf(name, sizeof name, "%s_%s", sweep_16[b][c], loads_16[load]);
    return find(paper, FIG16, name, real);
}

static double speed_sd(const result_t *result, int window)
{
    return result->numbers[window].speed_sd;
}

/* omega_c of the least overshoot, between the grid's points by a parabola through the three about the
 * lowest; NAN: it is at the grid's end. */
static double best_cutoff(const paper_t *paper, int b, int load, int window, bool speed, bool real)
{
    double x[SWEEP_16];
    double y[SWEEP_16];
    int low = 0;
    for (int c = 0; c < SWEEP_16; c++) {
        const result_t *result = of_16(paper, b, c, load, real);
        x[c] = result->run->omega_c;
        y[c] = speed ? result->numbers[window].speed_peak : result->numbers[window].peak;
        low = y[c] < y[low] ? c : low;
    }
    if (low == 0 || low == SWEEP_16 - 1) {
        return (double)NAN;
    }
    const double slope_left = (y[low] - y[low - 1]) / (x[low] - x[low - 1]);
    const double slope_right = (y[low + 1] - y[low]) / (x[low + 1] - x[low]);
    const double curvature = (slope_right - slope_left) / (x[low + 1] - x[low - 1]);
    return 0.5 * (x[low - 1] + x[low]) - 0.5 * slope_left / curvature;
}

static void judge_fig16(paper_t *paper, bool real)
{
    bool stopped = false;
    int speed_rises = 0;
    int position_falls = 0;
    int speed_falls = 0;
    for (int b = 0; b < 2; b++) {
        for (int load = 0; load < 2; load++) {
            for (int c = 0; c < SWEEP_16; c++) {
                const result_t *result = of_16(paper, b, c, load, real);
                stopped = stopped || result->lost;
                for (int at = 0; at < 2; at++) {
                    const int window = at == 0 ? SLOW : FAST;
                    if (c > 0) {
                        speed_rises +=
                            speed_sd(result, window) >= speed_sd(of_16(paper, b, c - 1, load, real), window);
                    }
                    if (b == 1) {
                        const result_t *slower = of_16(paper, 0, c, load, real);
                        position_falls += result->numbers[window].sd <= slower->numbers[window].sd;
                        speed_falls += speed_sd(result, window) <= speed_sd(slower, window);
                    }
                }
            }
        }
    }
    const result_t *one = of_16(paper, 0, 0, 0, real);
    const char *condition = "bandwidths 100 and 200 rad/s x six omega_c x no load and 5 N m";
    if (real) { /* an ideal drive has no deviation to speak of */
        const claim_t falling =
            claim_of(FIG16, "speed_sd", "neighbours of 40 whose speed SD does not fall as omega_c rises", "-",
                     0.0, 0.0, "some do not fall");
        const claim_t rising = claim_of(
            FIG16, "position_sd_bandwidth", "pairs of 24 whose position SD does not grow with bandwidth", "-",
            0.0, 0.0, "at 1500 r/min and large omega_c the slower loop, of small k_i, has more of it");
        const claim_t rising_speed =
            claim_of(FIG16, "speed_sd_bandwidth", "pairs of 24 whose speed SD does not grow with bandwidth",
                     "-", 0.0, 0.0, "some do not grow");
        row_of_several(paper, &falling, one, stopped, speed_rises, speed_rises <= 4, condition);
        row_of_several(paper, &rising, one, stopped, position_falls, position_falls <= 6, condition);
        row_of_several(paper, &rising_speed, one, stopped, speed_falls, speed_falls <= 2, condition);
    }
    static const struct {
        int window;
        const char *word;
    } changes[2] = {{UP, "accelerating"}, {DOWN, "decelerating"}};
    for (int b = 0; b < 2; b++) {
        for (int load = 0; load < 2; load++) {
            for (int n = 0; n < 2; n++) {
                char id[40];
                char text[120];
                char where[80];
                snprintf(id, sizeof id, "b%d_%s_%s", b == 0 ? 100 : 200, loads_16[load], changes[n].word);
                snprintf(text, sizeof text, "%d rad/s, %s: omega_c of the least position overshoot, %s",
                         b == 0 ? 100 : 200, load == 0 ? "no load" : "5 N m", changes[n].word);
                snprintf(where, sizeof where, "six omega_c from 0 to %d rad/s", b == 0 ? 60 : 121);
                const double centre = b == 0 ? 25.0 : 50.0;
                const claim_t minimum = claim_of_theory(
                    FIG16, id, text, "rad/s", centre, 0.32 * centre,
                    "the print names an inflection and no number; damping 1 gives 0.62 of the "
                    "conventional loop's natural frequency");
                const double best = best_cutoff(paper, b, load, changes[n].window, false, real);
                row_of_several(paper, &minimum, of_16(paper, b, 3, load, real), stopped, best, false, where);
            }
        }
    }
}

static void judge_fig17(paper_t *paper, bool real)
{
    static const struct {
        const char *name, *id, *claim;
        double theory, tolerance;
    } loops[] = {
        {"b100_wc0_500", "b100_wc0_500", "conventional, 100 rad/s, 500 r/min: peak at the load step", 115.0,
         6.0},
        {"b100_wc25_500", "b100_wc25_500", "omega_c 25, 100 rad/s, 500 r/min: peak at the load step", 98.0,
         7.0},
        {"b200_wc50_500", "b200_wc50_500", "omega_c 50, 200 rad/s, 500 r/min: peak at the load step", 28.0,
         4.0},
        {"b100_wc0_1500", "b100_wc0_1500", "conventional, 100 rad/s, 1500 r/min: peak at the load step",
         115.0, 6.0},
        {"b100_wc25_1500", "b100_wc25_1500", "omega_c 25, 100 rad/s, 1500 r/min: peak at the load step", 98.0,
         7.0},
        {"b200_wc50_1500", "b200_wc50_1500", "omega_c 50, 200 rad/s, 1500 r/min: peak at the load step", 28.0,
         4.0},
    };
    double steady = 0.0;
    bool stopped = false;
    for (size_t n = 0; n < sizeof loops / sizeof loops[0]; n++) {
        const result_t *result = find(paper, FIG17, loops[n].name, real);
        const double peak = fmax(result->numbers[LOADING].peak, result->numbers[UNLOADING].peak);
        const claim_t claim = claim_of_theory(
            FIG17, loops[n].id, loops[n].claim, "mrad", loops[n].theory,
            loops[n].tolerance + (real ? 3.0 : 0.0),
            "the print shows a trace without a number; hardly affected is taken as below 150 mrad");
        row_of(paper, &claim, result, peak, peak < 150.0);
        steady = fmax(steady, fabs(result->numbers[LOADED].mean));
        stopped = stopped || result->lost;
    }
    const claim_t claim = claim_of(FIG17, "steady", "the load leaves no steady error: the largest", "mrad",
                                   0.0, real ? 1.5 : 0.5, "some is left");
    row_of_several(paper, &claim, find(paper, FIG17, "b100_wc25_1500", real), stopped, steady, false,
                   "worst of six");
}

static void judge(paper_t *paper)
{
    static void (*const measured[PAPER_FIGURES])(paper_t *, bool) = {
        [FIG05] = judge_fig05, [FIG10] = judge_fig10, [FIG11] = judge_fig11, [FIG12] = judge_fig12,
        [FIG13] = judge_fig13, [FIG15] = judge_fig15, [FIG16] = judge_fig16, [FIG17] = judge_fig17};
    for (figure_t figure = FIG04; figure <= FIG17; figure++) {
        if (!paper->wanted[figure]) {
            continue;
        }
        if (figure == FIG04) {
            judge_fig04(paper);
        } else if (figure == FIG08) {
            judge_fig08(paper);
        } else if (figure == FIG14) {
            judge_sweep(paper, FIG14, "nl", true);
            judge_sweep(paper, FIG14, "nl", false);
        } else {
            measured[figure](paper, true);
            measured[figure](paper, false);
        }
    }
}

paper_t *paper_run(const bool wanted[PAPER_FIGURES], uint64_t seed, unsigned threads,
                   paper_progress_t progress, void *context, paper_error_t *why)
{
    paper_t *paper = calloc(1, sizeof *paper);
    const size_t count = lay_out(wanted, NULL);
    result_t *results = calloc(count + 1u, sizeof *results);
    if (paper == NULL || results == NULL) {
        free(paper);
        free(results);
        snprintf(why->text, sizeof why->text, "no memory");
        return NULL;
    }
    memcpy(paper->wanted, wanted, sizeof paper->wanted);
    paper->results = results;
    paper->result_count = lay_out(wanted, results);
    if (!run_all(paper, seed, threads, progress, context, why)) {
        paper_free(paper);
        return NULL;
    }
    judge(paper);
    return paper;
}

void paper_free(paper_t *paper)
{
    if (paper != NULL) {
        for (size_t n = 0; n < paper->result_count; n++) {
            free(paper->results[n].trace);
        }
        free(paper->results);
        free(paper);
    }
}

size_t paper_row_count(const paper_t *paper)
{
    return paper->row_count;
}

const paper_row_t *paper_row(const paper_t *paper, size_t n)
{
    assert(n < paper->row_count);
    return &paper->rows[n];
}

const paper_row_t *paper_row_by_id(const paper_t *paper, const char *id)
{
    for (size_t n = 0; n < paper->row_count; n++) {
        if (strcmp(paper->rows[n].id, id) == 0) {
            return &paper->rows[n];
        }
    }
    return NULL;
}

/* ---- CSV ---- */

static void write_fig04(FILE *file)
{
    fprintf(file, "x[A],sign[-],sigmoid[-],k_f_sign[1/A],k_f_sigmoid[1/A]\n");
    for (int n = -1000; n <= 1000; n++) {
        const double x = 0.01 * n;
        fprintf(file, "%.2f,%d,%.6g,", x, (n > 0) - (n < 0), sigmoid(x));
        if (n != 0) { /* where the sign's has no value */
            fprintf(file, "%.6g", equivalent_gain(SIGN, x));
        }
        fprintf(file, ",%.6g\n", equivalent_gain(SIGMOID, x));
    }
}

static void write_fig08(FILE *file)
{
    fprintf(file, "omega[rad/s]");
    for (int b = 0; b < 2; b++) {
        for (int c = 0; c < BODE_CUTOFFS; c++) {
            fprintf(file, ",b%g_wc%g_gain[dB],b%g_wc%g_phase[deg]", bode_bandwidths[b], bode_cutoffs[b][c],
                    bode_bandwidths[b], bode_cutoffs[b][c]);
        }
    }
    fprintf(file, "\n");
    for (int n = 0; n < BODE_POINTS; n++) {
        const double omega = bode_frequency(n);
        fprintf(file, "%.6g", omega);
        for (int b = 0; b < 2; b++) {
            for (int c = 0; c < BODE_CUTOFFS; c++) {
                const double complex response = loop_filter(bode_bandwidths[b], bode_cutoffs[b][c], omega);
                fprintf(file, ",%.6g,%.6g", 20.0 * log10(cabs(response)), carg(response) * 180.0 / PI);
            }
        }
        fprintf(file, "\n");
    }
}

static void write_fig16(const paper_t *paper, FILE *file)
{
    fprintf(file, "real[-],bandwidth[rad/s],omega_c[rad/s],load[N "
                  "m],locked[-],sd_100[mrad],sd_1500[mrad],speed_sd_100[r/min],"
                  "speed_sd_1500[r/min],overshoot_accelerating[mrad],overshoot_decelerating[mrad],"
                  "speed_overshoot_accelerating[r/min],speed_overshoot_decelerating[r/"
                  "min],steady_accelerating[mrad]\n");
    for (size_t n = 0; n < paper->result_count; n++) {
        const result_t *result = &paper->results[n];
        if (result->run->figure == FIG16) {
            const numbers_t *to = result->numbers;
            fprintf(file, "%d,%g,%g,%g,%d,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g,%.5g\n", result->real,
                    result->run->bandwidth, result->run->omega_c, result->run->load, !result->lost,
                    to[SLOW].sd, to[FAST].sd, to[SLOW].speed_sd, to[FAST].speed_sd, to[UP].peak,
                    to[DOWN].peak, to[UP].speed_peak, to[DOWN].speed_peak, to[UP].plateau);
        }
    }
}

static bool of_figure(const result_t *result, size_t figure)
{
    return (size_t)result->run->figure == figure;
}

static void write_traces(const paper_t *paper, size_t figure, FILE *file)
{
    size_t rows = 0;
    fprintf(file, "time[s]");
    for (size_t n = 0; n < paper->result_count; n++) {
        const result_t *result = &paper->results[n];
        if (of_figure(result, figure)) {
            rows = result->rows > rows ? result->rows : rows;
            for (unsigned c = 0; c < COLUMNS; c++) {
                if ((shown[figure] & BIT(c)) != 0u) {
                    fprintf(file, ",%s_%s_%s", result->run->name, result->real ? "real" : "ideal",
                            column_names[c]);
                }
            }
        }
    }
    fprintf(file, "\n");
    for (size_t row = 0; row < rows; row++) {
        fprintf(file, "%.4f", (double)row * (TRACE_EVERY * RIG_PERIOD_SECONDS));
        for (size_t n = 0; n < paper->result_count; n++) {
            const result_t *result = &paper->results[n];
            for (unsigned c = 0; c < COLUMNS && of_figure(result, figure); c++) {
                if ((shown[figure] & BIT(c)) == 0u) {
                    continue;
                }
                fputc(',', file);
                if (row < result->rows) {
                    fprintf(file, "%.5g", (double)result->trace[COLUMNS * row + c]);
                }
            }
        }
        fprintf(file, "\n");
    }
}

void paper_write_csv(const paper_t *paper, size_t figure, FILE *file)
{
    assert(figure < PAPER_FIGURES);
    if (!paper->wanted[figure]) {
        return;
    }
    if (figure == FIG04) {
        write_fig04(file);
    } else if (figure == FIG08) {
        write_fig08(file);
    } else if (figure == FIG16) {
        write_fig16(paper, file);
    } else {
        write_traces(paper, figure, file);
    }
}
