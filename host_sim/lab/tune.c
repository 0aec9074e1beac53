#include "host_sim/lab/tune.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/board_facts.h"
#include "host_sim/lab/scenario_parts.h"

#define PI     3.14159265358979323846
#define RPM    (PI / 30.0)
#define SQRT_3 1.7320508075688772
#define T_S    RIG_PERIOD_SECONDS

/* Shares; where docs/theory.md has the rule, its section. */
#define CURRENT_RESERVE  2.0   /* 23: a start leaves 0.7 of its torque for the load */
#define RESISTIVE_MOST   0.5   /* R I at current_limit, of the voltage that the link gives */
#define CURRENT_LEAST    1.3   /* of the rated current, for any R I */
#define SALIENT_MOST     0.8   /* 30: of psi_f, largest (L_q - L_d) I in a start */
#define TRIP_SHARE       1.5   /* the board's own: 15 A over 10 A */
#define TRIP_LEAST       1.2   /* the firmware's rule */
#define LINK_OVER        1.286 /* the board's own: 400 V over 311 V */
#define LINK_UNDER       0.643 /* 200 V */
#define LINK_ROOM        1.15  /* of the largest trip over the link, at least */
#define SPEED_RESERVE    1.4   /* tests and defaults: 220 rad/s over 157 */
#define SPEED_LEAST_TRIP 1.055 /* overspeed_trip over the top speed, at least 1/0.95 */
#define OPEN_SHARE       0.999 /* of the largest link voltage of the board: EMF with the bridge off */
#define TURN_GOOD        0.35  /* [rad] a period at the top speed: faster, a wrong L may remain unlearnt */
#define CATCH_PERIODS    (BOARD_GATE_CHARGE_US > 0 ? 3.0 : 2.2) /* 23: of a short circuit, at most */
#define CATCH_RESERVE    1.05                                   /* of overcurrent_trip over this current */
#define GAIN_RULE        1.25 /* 3: over the largest EMF at overspeed_trip, the firmware's rule */
#define WITHIN_MADE      0.98 /* theory, 30: share of the voltage that remains after duties and dead time */
#define VOLTAGE_USE      0.93 /* the row's own, of U_dc/sqrt3 */
#define LINK_LEAST                                                                                           \
    1.27 /* theory, 29: multiple of dc_undervoltage, at which the drive begins to hold the link */
#define SLOPE_RULE   1.6  /* 3: the firmware's rule */
#define CUTOFF_RULE  1.6  /* 7: 0.12 rad for a load step of the rated torque */
#define CUTOFF_LEAST 50.0 /* [rad/s] 7 */
#define CUTOFF_MOST                                                                                          \
    (0.025 / T_S)                     /* limits the bandwidth to 0.1 per period; above this the noise is     \
                                       * too large */
#define BANDWIDTHS        4.0         /* 7: of the loop over the feed-forward, least overshoot */
#define LOOP_KI           2698.0      /* [1/s^2] 7: of a bandwidth of 200 rad/s */
#define RAMP_SHARE        0.5         /* [rad] a/k_i that an inertia which is not known at all would cost */
#define CURRENT_BANDWIDTH (0.1 / T_S) /* 15: K = 0.1 */
#define LOW_CURRENT       0.2         /* 23: of current_limit */
#define LOW_RIPPLE        0.6         /* 23: of the ripple of the current */
#define LOW_MOST          0.5         /* 23: of current_limit */
#define SPEED_LEAST       0.02        /* 11: of the top speed, 3 rad/s over 157 */
#define VOLTAGE_ROOM      0.9         /* of the voltage that the duty limits permit, for the control */
#define ANSWER            14.0        /* 23: pll_bandwidth over the bandwidth of the speed control */
#define LOAD_DIP          0.03        /* of the speed, while a load comes */
#define LOAD_TIME         0.05        /* [s] of it at least */
#define RIPPLE_MOST       0.25  /* of the rated current: above this a leg's sign at its edges is uncertain */
#define RIPPLE_JUDGED     0.1   /* of the range: above this the winding's law is no check of the sensors */
#define HANDOVER_EMF      1.15  /* 23: the drive's own rule, over dead time and R I ... */
#define HANDOVER_SHARE    0.3   /* ... and no more than this of overspeed_trip */
#define FALLBACK_SHARE    0.4   /* 23: of the hand-over speed, below which the forced frame is used again */
#define WINDING_LEAST     2.0   /* [periods] of L_q/R, the firmware's rule */
#define COARSE            0.2   /* 3: L_q i/T of a step of the converter, of the EMF at overspeed_trip */
#define SATURATED_MOST    2.5   /* 30: current_limit over the saturation current, the drive's limit */
#define SATURATED_AT      0.8   /* 30: of current_limit, at which the drive takes its constant L_q */
#define SALIENT_FROM      1.1   /* 30: L_q/L_d from which on a rotor counts as salient, the firmware's rule */
#define SALIENT_NATURAL   0.403 /* 30: natural frequency of the loop over its bandwidth */
#define SALIENT_SPEED     0.6   /* 30: of ki over the product of cutoff and largest speed */
#define ENCODER           0.0   /* position_source */
#define SENSORLESS        1.0   /* the same */
#define DEVICE_RESISTANCE ((BOARD_IGBT_SLOPE_UOHM + BOARD_DIODE_SLOPE_UOHM) / 2e6) /* [ohm] of a leg */
#define DERIVED_SPEED     0.9 /* of the speed that the link permits, if no rated speed is given */

/* L_q/L_d without an encoder (30, 6), and the turn in a period at overspeed_trip [rad], up to which this
 * firmware's estimator holds: on all boards a turning rotor is caught up to 0.85 rad. */
#ifdef LAGLESS_ESTIMATOR_FIXED
#define ESTIMATED_MOST 1.2
#define TURN_MOST      0.63
#else
#define ESTIMATED_MOST 4.0
#define TURN_MOST      0.85
#endif

static void warn(tune_t *tune, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void warn(tune_t *tune, const char *format, ...)
{
    if (tune->warning_count == TUNE_WARNINGS) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(tune->warnings[tune->warning_count++], TUNE_TEXT_SIZE, format, arguments);
    va_end(arguments);
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

static double larger(double a, double b)
{
    return a > b ? a : b;
}

/* Six digits, as it will be printed: the same bits whether the row is written out or not. More digits if with
 * six the value would leave the range of the row. */
static double printed(const table_row_t *row, double value)
{
    double read = value;
    for (int digits = 6; digits <= 17; digits++) {
        char text[32];
        snprintf(text, sizeof text, "%.*g", digits, value);
        read = strtod(text, NULL);
        if (rig_accepts(row, read)) {
            break;
        }
    }
    return read;
}

static double four_digits(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.4g", value);
    return strtod(text, NULL);
}

static void add(tune_t *tune, const char *name, double value, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
static void add(tune_t *tune, const char *name, double value, const char *format, ...)
{
    tune_row_t *row = &tune->rows[tune->count++];
    char qualified[64];
    scenario_error_t ignored;
    snprintf(qualified, sizeof qualified, "%s%s", strchr(name, '.') != NULL ? "" : "params.", name);
    row->row = scenario_row(qualified, &ignored);
    row->value = printed(row->row, value);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(row->reason, TUNE_REASON_SIZE, format, arguments);
    va_end(arguments);
}

static double most(const char *name)
{
    return rig_max(rig_row_by_name(name));
}

static double least(const char *name)
{
    return rig_min(rig_row_by_name(name));
}

double tune_load_time(double torque, double speed, double inertia, double bandwidth)
{
    const double w = bandwidth / ANSWER;
    const double time = torque / (LOAD_DIP * speed * inertia * w * w);
    return time > LOAD_TIME ? time : LOAD_TIME;
}

/* ---- the limits of the motor by the board ---- */

typedef struct {
    double p, r, l_d, psi, kt, inertia;
    double l_q;                         /* [H] with saturation that at 0.8 of the current limit */
    double l_0;                         /* [H] without current */
    double saturation;                  /* [A] of the q axis; 0: none */
    double rated_current, rated_torque; /* [A] peak, [N m] */
    double limit, trip, start;          /* [A] */
    bool resistive;           /* the limit is the current at which R takes its largest share of the voltage */
    bool caught;              /* the trip is larger for the current of a catch */
    bool by_module;           /* the current of the start is limited by the current of a leg of the module */
    double link, over, under; /* [V] */
    double voltage;           /* [V] of a phase, that remains after duties, dead time and drops */
    double drop;              /* [V] part of the voltage that does not depend on the link */
    double reach;             /* [rad/s] mechanical, largest speed under load */
    double speed;             /* [rad/s] mechanical, top */
    double free;              /* [rad/s] mechanical, largest speed without load */
    double overspeed;         /* [rad/s] mechanical */
    double handover;          /* [rad/s] mechanical, by the drive's rule without its limit */
    double ripple;            /* [A] peak to peak, at most */
} given_t;

/* Speed at which (omega L_q i)^2 + (omega psi + R i)^2 is the voltage's square [rad/s] mechanical; 0: none.
 */
static double reach(const given_t *g, double i)
{
    const double a = g->l_q * i * g->l_q * i + g->psi * g->psi;
    const double r = g->r + DEVICE_RESISTANCE;
    const double b = g->psi * r * i;
    const double c = r * i * r * i - g->voltage * g->voltage;
    return c >= 0.0 || g->voltage <= 0.0 ? 0.0 : (sqrt(b * b - a * c) - b) / (a * g->p);
}

static void take_link(const motor_t *motor, tune_t *tune, given_t *g)
{
    const double nominal = BOARD_DC_NOMINAL_MV / 1e3;
    const double top = most("dc_overvoltage");
    g->link = motor->has[MOTOR_LINK] ? motor->value[MOTOR_LINK] : nominal;
    if (g->link * LINK_ROOM > top) {
        const double lower = floor(top / LINK_ROOM);
        warn(tune, "link_voltage %.4g V is too high: the board's trip ends at %.4g V; %.4g V is used instead",
             g->link, top, lower);
        g->link = lower;
    }
    if (g->link * LINK_OVER < least("dc_overvoltage")) {
        const double higher = ceil(least("dc_overvoltage") / LINK_OVER);
        warn(tune,
             "link_voltage %.4g V is too low for the board, which begins at %.4g V; this value is used "
             "instead",
             g->link, higher);
        g->link = higher;
    }
    g->over = smaller(four_digits(LINK_OVER * g->link), top);
    g->under = larger(four_digits(LINK_UNDER * g->link), least("dc_undervoltage"));
    const double duty_least = (BOARD_DEAD_TIME_NS + BOARD_MINIMUM_PULSE_NS) / 1e9 / T_S;
    const double lost = (BOARD_DEAD_TIME_NS + BOARD_TURN_ON_DELAY_NS - BOARD_TURN_OFF_DELAY_NS) / 1e9 / T_S;
    g->drop = 4.0 / PI * (BOARD_IGBT_DROP_MV + BOARD_DIODE_DROP_MV) / 2e3;
    g->voltage =
        VOLTAGE_ROOM * g->link / SQRT_3 * (1.0 - 2.0 * duty_least) - 4.0 / PI * lost * g->link - g->drop;
    g->ripple = g->link * T_S / (6.0 * smaller(g->l_d, g->l_q));
}

/* L_q at this i_q [H]. */
static double apparent(const given_t *g, double i_q)
{
    return g->saturation > 0.0 ? g->l_0 / hypot(1.0, i_q / g->saturation) : g->l_0;
}

static void take_current(tune_t *tune, given_t *g)
{
    const double top = smaller(most("current_limit"), most("overcurrent_trip") / TRIP_LEAST);
    g->limit = smaller(CURRENT_RESERVE * g->rated_current, floor(10.0 * top) / 10.0);
    const double resistive = larger(RESISTIVE_MOST * g->voltage / g->r, CURRENT_LEAST * g->rated_current);
    g->resistive = resistive < g->limit;
    g->limit = smaller(g->limit, resistive);
    const double most_saturated = SATURATED_MOST * g->saturation;
    if (g->saturation > 0.0 && g->limit > most_saturated) {
        warn(
            tune,
            "current_limit is %.4g A in place of %.4g A: the drive accepts at most %.3g times the saturation "
            "current of %.4g A (theory, 30)",
            most_saturated, g->limit, SATURATED_MOST, g->saturation);
        g->limit = most_saturated;
    }
    g->limit = larger(four_digits(g->limit), least("current_limit"));
    const double salient = g->l_0 > g->l_d ? SALIENT_MOST * g->psi / (g->l_0 - g->l_d) : g->limit;
    g->l_q = apparent(g, SATURATED_AT * g->limit);
    const double module = BOARD_MODULE_CONTINUOUS_MA / 1e3;
    const double stands = module > 0.0 ? module : g->limit;
    g->by_module = stands < g->limit && stands < salient;
    g->start = smaller(smaller(g->limit, stands), larger(four_digits(salient), 0.1));
    tune->current = smaller(g->rated_current, 0.8 * g->limit);
    tune->torque_top = smaller(g->rated_torque, g->kt * tune->current);
    g->trip = smaller(four_digits(larger(TRIP_SHARE * g->limit, TRIP_LEAST * g->limit + g->ripple)),
                      most("overcurrent_trip"));
    g->trip = larger(g->trip, least("overcurrent_trip"));
    if (g->rated_current > 0.8 * g->limit) {
        warn(tune,
             "rated current %.4g A peak exceeds 0.8 of the current limit %.4g A that a range of +-%.4g A "
             "allows: "
             "the load is limited to %.4g N m of %.4g N m",
             g->rated_current, g->limit, (double)BOARD_CURRENT_RANGE, tune->torque_top, g->rated_torque);
    }
}

/* Largest current of the shorted winding at no load, psi_f/L [A]. */
static double short_circuit(const given_t *g)
{
    return g->psi / smaller(g->l_d, g->l_q);
}

/* Largest current of a catch at this speed [A]: that of a winding which is shorted while the rotor turns by
 * CATCH_PERIODS periods. */
static double catch_current(const given_t *g, double speed)
{
    const double turned = smaller(CATCH_PERIODS * g->p * speed * T_S, PI);
    return 2.0 * short_circuit(g) * sin(0.5 * turned);
}

/* The speed at which a catch has this current [rad/s] mechanical. */
static double catch_speed(const given_t *g, double current)
{
    const double most = 2.0 * short_circuit(g);
    return current < most ? 2.0 * asin(current / most) / (CATCH_PERIODS * g->p * T_S) : HUGE_VAL;
}

/* overcurrent_trip allows for the current with which a rotor is caught at overspeed_trip, if the board does.
 */
static void take_catch(tune_t *tune, given_t *g)
{
    const double top = most("overcurrent_trip");
    const double needed = CATCH_RESERVE * catch_current(g, g->overspeed);
    g->caught = needed > g->trip;
    g->trip = g->caught ? smaller(four_digits(needed), top) : g->trip;
    if (needed > top) {
        warn(
            tune,
            "a rotor that turns faster than %.0f r/min when it is switched on, or that is lost at such a "
            "speed, "
            "may end in overcurrent: to catch it takes up to %.4g A at overspeed_trip, psi_f/L being %.4g A, "
            "and "
            "the board's overcurrent_trip ends at %.4g A",
            catch_speed(g, top / CATCH_RESERVE) / RPM, needed / CATCH_RESERVE, short_circuit(g), top);
    }
}

static void take_speed(const motor_t *motor, tune_t *tune, given_t *g)
{
    const double cap = 0.999 * TURN_MOST / (SPEED_LEAST_TRIP * g->p * T_S);
    g->reach = reach(g, tune->current);
    g->speed = DERIVED_SPEED * g->reach;
    if (motor->has[MOTOR_SPEED]) {
        g->speed = motor->value[MOTOR_SPEED];
    } else {
        warn(
            tune,
            "rated_speed is not given: 0.9 of the speed that %.4g V reach under load, %.0f r/min, is assumed",
            g->link, g->speed / RPM);
    }
    if (g->speed > g->reach) {
        const double needed =
            hypot(g->psi * g->p * g->speed + g->r * tune->current, g->p * g->speed * g->l_q * tune->current);
        warn(tune,
             "at %.0f r/min the EMF is %.4g V peak of a phase, with R I and omega L I %.4g V; a link of %.4g "
             "V "
             "gives %.4g V: top speed %.0f r/min; a link of %.0f V is enough",
             g->speed / RPM, g->psi * g->p * g->speed, needed, g->link, g->voltage, g->reach / RPM,
             ceil(g->link * (needed + g->drop) / (g->voltage + g->drop)));
        g->speed = g->reach;
    }
    if (g->speed > cap) {
        warn(tune,
             "at %.0f r/min the rotor turns by %.2g rad electrical in a period of %.4g us; the limit is %.2g "
             "rad at overspeed_trip, so the top speed is %.0f r/min",
             g->speed / RPM, g->speed * g->p * T_S, 1e6 * T_S, TURN_MOST, cap / RPM);
        g->speed = cap;
    }
    const double open = OPEN_SHARE * BOARD_OVERVOLTAGE_MAX_MV / 1e3 / (SQRT_3 * g->psi * g->p);
    if (SPEED_LEAST_TRIP * g->speed > open) {
        warn(tune,
             "at %.0f r/min the EMF between two phases is %.4g V; with the bridge off it would charge the "
             "board's link, which may have at most %.4g V, so the top speed is %.0f r/min",
             g->speed / RPM, SQRT_3 * g->psi * g->p * g->speed, BOARD_OVERVOLTAGE_MAX_MV / 1e3,
             open / SPEED_LEAST_TRIP / RPM);
        g->speed = open / SPEED_LEAST_TRIP;
    }
    g->speed = four_digits(g->speed);
    g->free = smaller(
        larger(motor->has[MOTOR_SPEED] ? motor->value[MOTOR_SPEED] : g->voltage / (g->psi * g->p), g->speed),
        larger(g->voltage / (g->psi * g->p), g->speed));
    g->overspeed = smaller(SPEED_RESERVE * g->speed, SPEED_LEAST_TRIP * cap);
    if (motor->has[MOTOR_SPEED_MAX]) {
        g->overspeed =
            smaller(g->overspeed, larger(motor->value[MOTOR_SPEED_MAX], SPEED_LEAST_TRIP * g->speed));
    }
    g->free = smaller(g->free, cap);
    g->overspeed = smaller(g->overspeed, open);
    take_catch(tune, g);
    g->overspeed = smaller(four_digits(g->overspeed), most("overspeed_trip"));
    const double dead = BOARD_DEAD_TIME_NS / 1e9 / T_S * g->over;
    g->handover = HANDOVER_EMF * larger(dead, (g->r + DEVICE_RESISTANCE) * g->start) / (g->psi * g->p);
    tune->handover = smaller(g->handover, HANDOVER_SHARE * g->overspeed);
    tune->speed_top = g->speed;
}

/* ---- warnings ---- */

/* Current of a step of the converter [A]. */
static double current_step(void)
{
    return fabs((double)BOARD_CURRENT_PER_CODE);
}

/* Voltage that such a step makes of the current between two samples [V]. */
static double step_voltage(const given_t *g)
{
    return g->l_0 * current_step() / T_S;
}

static void judge_winding(tune_t *tune, const given_t *g)
{
    const double tau = g->l_q / g->r;
    if (g->ripple > RIPPLE_MOST * g->rated_current) {
        char l[UNITS_TEXT_SIZE];
        warn(tune,
             "%s at %.4g kHz and a link of %.4g V: the current ripple is %.3g A peak to peak, which is "
             "large for a rated current of %.4g A and a sensor range of +-%.4g A",
             units_text(l, smaller(g->l_d, g->l_q), "H"), 1e-3 / T_S, g->link, g->ripple, g->rated_current,
             (double)BOARD_CURRENT_RANGE);
    }
    if (g->ripple > RIPPLE_JUDGED * (double)BOARD_CURRENT_RANGE) {
        warn(tune,
             "a ripple of %.3g A would trip the check of the current sensors' gain: current_judged is set to "
             "0",
             g->ripple);
    }
    const double code = step_voltage(g);
    const double emf = g->psi * g->p * g->overspeed;
    if (code > COARSE * emf) {
        warn(tune,
             "one step of the board's current sensors, %.3g A, is equivalent to L_q i/T = %.3g V in a "
             "period; compared with the EMF at overspeed_trip, %.3g V, this makes the estimated speed too "
             "coarse to run without an encoder; use a board with a smaller range or a higher link voltage",
             current_step(), code, emf);
    }
    if (g->speed * g->p * T_S > TURN_GOOD) {
        warn(tune,
             "at %.0f r/min the rotor turns by %.2g rad electrical in a period: above %.2g rad L may "
             "remain unlearnt, and an L that is wrong by a tenth shifts the angle by up to %.2g rad; measure "
             "L (`lagless "
             "commission`)",
             g->speed / RPM, g->speed * g->p * T_S, TURN_GOOD,
             asin(smaller(0.1 * g->l_q * tune->current / g->psi, 1.0)));
    }
    if (g->limit + 0.5 * g->ripple > g->trip) {
        warn(tune,
             "current_limit, %.4g A, plus half of the current ripple, %.3g A, exceeds overcurrent_trip, %.4g "
             "A",
             g->limit, g->ripple, g->trip);
    }
    if (tau >= WINDING_LEAST * T_S && tau < 5.0 * T_S) {
        warn(tune,
             "L/R is %.3g ms, %.3g periods of the control: below 5 periods the current control is coarse, "
             "and below 2 periods the drive refuses to run",
             1e3 * tau, tau / T_S);
    }
    if (tune->needs_encoder) {
        warn(tune,
             "L_q is %.3g L_d: without an encoder the drive accepts %.2g L_d at most, so position_source is "
             "set to encoder",
             g->l_q / g->l_d, ESTIMATED_MOST);
    }
}

static void judge_sensing(tune_t *tune, const given_t *g)
{
    const double code = fabs((double)BOARD_CURRENT_PER_CODE);
    if (code > 0.004 * g->rated_current) {
        warn(tune,
             "the ADC resolves only %.3g mA, %.2g %% of the rated current: a board with a range of +-%.3g A "
             "is sufficient",
             1e3 * code, 100.0 * code / g->rated_current, 1.2 * TRIP_SHARE * g->limit);
    }
    const double dead = BOARD_DEAD_TIME_NS / 1e9 / T_S * g->over;
    const double resistive = (g->r + DEVICE_RESISTANCE) * g->start;
    const double needed = g->handover;
    if (needed > HANDOVER_SHARE * g->speed) {
        warn(tune,
             "dead time (%.3g V) and R I of the start (%.3g V) are as large as the EMF at %.0f r/min, %.0f "
             "%% of the top speed: the drive uses a forced frame up to %.0f r/min while accelerating "
             "(handover_speed), and below %.0f r/min while decelerating (fallback_speed)",
             dead, resistive, needed / RPM, 100.0 * needed / g->speed, tune->handover / RPM,
             FALLBACK_SHARE * tune->handover / RPM);
    }
    if (g->voltage < 4.0 * g->r * g->limit) {
        warn(tune, "R I at current_limit needs %.3g V of the %.3g V that the link can apply to a phase",
             g->r * g->limit, g->voltage);
    }
}

/* ---- the rows ---- */

static void add_motor(const motor_t *motor, tune_t *tune, const given_t *g)
{
    add(tune, "motor_pole_pairs", g->p, "of the motor");
    add(tune, "motor_resistance", g->r, "[ohm] of a phase");
    add(tune, "motor_inductance_d", g->l_d, "[H]");
    add(tune, "motor_inductance_q", g->l_0, g->saturation > 0.0 ? "[H] without current" : "[H]");
    if (g->saturation > 0.0) {
        add(tune, "motor_saturation_current", g->saturation,
            "[A] L_q is %.4g mH at 0.8 of current_limit (theory, 30)", 1e3 * g->l_q);
    }
    add(tune, "motor_flux_linkage", g->psi, "[Wb] psi_f, peak: K_t = 1.5 p psi_f = %.4g N m/A", g->kt);
    add(tune, "motor_inertia", g->inertia, "[kg m^2] rotor%s%s; the drive learns it from steps of the speed",
        motor->value[MOTOR_LOAD_INERTIA] > 0.0 ? " and load" : "",
        motor->has[MOTOR_INERTIA] ? "" : ", assumed");
}

static void add_limits(const motor_t *motor, tune_t *tune, const given_t *g)
{
    add(tune, "current_limit", g->limit, "[A] %s: a start needs a reserve (theory, 23)",
        g->resistive ? "R I half of the link's voltage, at least 1.3 of the rated current"
                     : "twice the rated current, limited by the board");
    add(tune, "start_current", g->start < g->limit ? g->start : 0.0, "%s",
        g->by_module ? "[A] continuous current of a leg of the board's module, while the rotor is aligned"
        : g->start < g->limit
            ? "[A] 0.8 psi_f/(L_q - L_d): with more a salient rotor may not align (theory, 30)"
            : "current_limit (theory, 23)");
    add(tune, "overcurrent_trip", g->trip,
        g->caught ? "[A] 1.05 of the current with which a rotor is caught at overspeed_trip (theory, 23)"
                  : "[A] 1.5 current_limit, at least 1.2 current_limit plus the ripple");
    add(tune, "motor_current_continuous", g->rated_current, "[A] rated, length of the vector");
    if (motor->has[MOTOR_WARMING]) {
        add(tune, "motor_time_constant", motor->value[MOTOR_WARMING], "[s] of the winding");
    }
    const double low = larger(LOW_CURRENT * g->limit, LOW_RIPPLE * g->ripple);
    add(tune, "low_speed_current", four_digits(smaller(low, LOW_MOST * g->limit)),
        "[A] a fifth of current_limit, at least 0.6 of the ripple, at most half of the limit (theory, 23)");
    add(tune, "overspeed_trip", g->overspeed,
        "[rad/s] 1.4 of the top speed, %.0f r/min; %.2g rad a period at most", g->speed / RPM, TURN_MOST);
    if (g->ripple > RIPPLE_JUDGED * (double)BOARD_CURRENT_RANGE) {
        add(tune, "current_judged", 0.0, "the ripple of %.3g A would trip the check of the gain", g->ripple);
    }
    add(tune, "dc_overvoltage", g->over, "[V] 1.286 of the link's %.4g V", g->link);
    add(tune, "dc_undervoltage", g->under, "[V] 0.643 of the link's %.4g V", g->link);
    if (motor->has[MOTOR_TEMPERATURE]) {
        add(tune, "motor_temperature_max",
            smaller(motor->value[MOTOR_TEMPERATURE], most("motor_temperature_max")),
            "[degC] the winding's, or the sensor's end");
    }
}

/* Share of the link that the drive uses of the field's voltage (theory, 30). */
static double voltage_used(void)
{
    const double duty_least = (BOARD_DEAD_TIME_NS + BOARD_MINIMUM_PULSE_NS) / 1e9 / T_S;
    const double lost = (BOARD_DEAD_TIME_NS + BOARD_TURN_ON_DELAY_NS - BOARD_TURN_OFF_DELAY_NS) / 1e9 / T_S;
    return smaller(VOLTAGE_USE / SQRT_3, WITHIN_MADE * ((1.0 - 2.0 * duty_least) / SQRT_3 - 4.0 / PI * lost));
}

/* The torque divided by 1.5 p [Wb A] at this i_d [A], with the i_q that remains of this current. */
static double torque_at(const given_t *g, double i_d, double current)
{
    const double i_q = sqrt(current * current - i_d * i_d);
    return (g->psi + (g->l_d - apparent(g, i_q)) * i_d) * i_q;
}

/* i_d of most torque per ampere at this current [A]. With saturation, interval halving finds it, because
 * the torque has one maximum. */
static double most_per_ampere(const given_t *g, double current)
{
    if (g->saturation > 0.0 && g->l_q > SALIENT_FROM * g->l_d) {
        double low = -current;
        double high = 0.0;
        while (high - low > 1e-6 * current) {
            const double step = (high - low) / 3.0;
            if (torque_at(g, low + step, current) > torque_at(g, high - step, current)) {
                high -= step;
            } else {
                low += step;
            }
        }
        return 0.5 * (low + high);
    }
    const double taken = g->l_q > SALIENT_FROM * g->l_d ? (g->l_q - g->l_d) * current : 0.0;
    return -2.0 * taken * current / (g->psi + hypot(g->psi, sqrt(8.0) * taken));
}

/* Speed from which on this current at most torque per ampere needs more than that voltage [rad/s] mechanical.
 */
static double corner(const given_t *g, double current)
{
    const double i_d = most_per_ampere(g, current);
    const double i_q = sqrt(current * current - i_d * i_d);
    const double r = g->r + DEVICE_RESISTANCE;
    const double d = g->psi + g->l_d * i_d;
    const double q = apparent(g, i_q) * i_q;
    const double a = d * d + q * q;
    const double b = r * (i_q * d - i_d * q);
    const double c = r * current * r * current - voltage_used() * g->link * voltage_used() * g->link;
    return c < 0.0 ? (sqrt(b * b - a * c) - b) / (a * g->p) : 0.0;
}

static void add_reference(tune_t *tune, const given_t *g)
{
    const double i_d = most_per_ampere(g, g->limit);
    const double i_q = sqrt(g->limit * g->limit - i_d * i_d);
    if (i_d < 0.0) {
        add(tune, "mtpa", 1.0, "at current_limit %.3g A of i_d and %.3g A of i_q: %.3g N m (theory, 30)", i_d,
            i_q, 1.5 * g->p * torque_at(g, i_d, g->limit));
    }
    add(tune, "field_weakening", 1.0,
        "begins at %.0f r/min with current_limit, %.0f with %.3g A, %.0f without load; above %.0f the EMF "
        "alone exceeds the board's link (theory, 30)",
        corner(g, g->limit) / RPM, corner(g, tune->current) / RPM, tune->current,
        voltage_used() * g->link / (g->psi * g->p) / RPM,
        BOARD_OVERVOLTAGE_MAX_MV / 1e3 / (SQRT_3 * g->psi * g->p) / RPM);
}

/* psi_a [Wb] of the i_d that overspeed_trip takes with the least link which the drive does not hold by
 * itself, where circle and voltage meet or the voltage has its most torque (theory, 30); with less speed that
 * of current_limit. */
static double weakened(const given_t *g)
{
    const double d = g->l_q - g->l_d;
    const double voltage = voltage_used() * LINK_LEAST * g->under;
    const double flux = voltage / (g->p * g->overspeed);
    const double q = g->l_q * g->limit;
    const double c = g->psi * g->psi + q * q - flux * flux;
    const double across = (g->l_q * g->l_q - g->l_d * g->l_d) * c + g->l_d * g->psi * g->l_d * g->psi;
    const double meet = -c / (g->l_d * g->psi + sqrt(larger(across, 0.0)));
    const double most =
        -2.0 * d * flux * flux / (g->l_q * g->psi + hypot(g->l_q * g->psi, sqrt(8.0) * d * flux));
    return g->psi - d * larger(larger(meet, (most - g->psi) / g->l_d), -g->limit);
}

static void add_estimator(tune_t *tune, const given_t *g)
{
    const bool salient = g->l_q > SALIENT_FROM * g->l_d;
    const double flux = g->psi - (salient ? (g->l_q - g->l_d) * most_per_ampere(g, g->limit) : 0.0);
    const double weak = salient ? weakened(g) : 0.0;
    const double gain = GAIN_RULE * larger(flux, weak) * g->p * g->overspeed;
    const double slope = SLOPE_RULE * g->l_q / (gain * T_S);
    add(tune, "observer_gain", 0.0, "by rule, %.4g V: 1.25 times the EMF at overspeed_trip%s (theory, 3%s)",
        gain,
        weak > flux ? " with the i_d that weakens the field"
        : salient   ? " with i_d at current_limit"
                    : "",
        salient ? ", 30" : "");
    add(tune, "observer_slope", 0.0, "by rule, %.4g 1/A: 1.6 L_q/(k_s T_s) (theory, 3)", slope);
    add(tune, "estimate_current_max", 0.0, "by rule, %.4g A: 4/a_f of the observer (theory, 3)", 4.0 / slope);
    add(tune, "estimate_speed_min", four_digits(SPEED_LEAST * g->speed), "[rad/s] 2 %% of the top speed");

    const double wanted = CUTOFF_RULE * sqrt(g->p * g->rated_torque / g->inertia);
    const double cutoff = floor(smaller(larger(wanted, CUTOFF_LEAST), CUTOFF_MOST));
    const double bandwidth = BANDWIDTHS * cutoff;
    if (salient) {
        const double natural = SALIENT_NATURAL * bandwidth;
        const double by_speed = natural * natural / (SALIENT_SPEED * g->p * g->overspeed);
        add(tune, "feedforward_cutoff", four_digits(smaller(larger(by_speed, 4.0), 50.0)),
            "[rad/s] ki/(0.6 p overspeed_trip), from 4 to 50 (theory, 30)");
        add(tune, "pll_bandwidth", bandwidth, "[rad/s] 6.4 sqrt(p T/J), from 200 to %.3g (theory, 7)",
            BANDWIDTHS * CUTOFF_MOST);
    } else {
        add(tune, "feedforward_cutoff", cutoff, "[rad/s] 1.6 sqrt(p T/J) = %.3g, from 50 to %.3g (theory, 7)",
            wanted, CUTOFF_MOST);
        add(tune, "pll_bandwidth", bandwidth, "[rad/s] 4 feedforward_cutoff: least overshoot (theory, 7)");
    }
    add(tune, "torque_feedforward", 1.0, "K i_q with motor_inertia (theory, 9)");
    const double stop = g->speed * g->inertia / g->rated_torque;
    tune->response = ANSWER / bandwidth;
    if (stop < tune->response) {
        warn(tune,
             "a step of the rated torque stops an inertia of %.3g kg m^2 within %.3g ms, before the speed "
             "control reacts (%.3g ms): give the inertia of the load (load_inertia), or let the load rise "
             "over %.3g s",
             g->inertia, 1e3 * stop, 1e3 * tune->response,
             tune_load_time(g->rated_torque, g->speed, g->inertia, bandwidth));
    }

    const double able = g->kt * g->limit / g->inertia;
    const double followed = RAMP_SHARE * LOOP_KI * (bandwidth / 200.0) * (bandwidth / 200.0) / g->p;
    const double ramp = able > followed ? four_digits(followed) : 0.0;
    add(tune, "speed_ramp", ramp,
        ramp > 0.0 ? "[rad/s^2] the motor could reach %.3g, but without a known J the angle error would be "
                     "half a radian (theory, 9)"
                   : "no ramp: the loop follows the %.3g rad/s^2 of the current limit",
        able);
    add(tune, "quick_stop_ramp", ramp, "[rad/s^2] as speed_ramp");
}

static void add_control(const motor_t *motor, tune_t *tune, const given_t *g)
{
    add(tune, "current_bandwidth", smaller(CURRENT_BANDWIDTH, most("current_bandwidth")),
        "[rad/s] 0.1 a period (theory, 15)");
    add(tune, "speed_kp", 0.0, "by rule from the learnt inertia, bandwidth pll_bandwidth/14 (theory, 23)");
    add(tune, "speed_ki", 0.0, "by rule from the learnt inertia, damping 0.87");
    const double lines = motor->has[MOTOR_LINES] ? motor->value[MOTOR_LINES] : 2500.0;
    if (256.0 * g->p > 4.0 * lines) {
        warn(tune, "an encoder of %.0f lines is too coarse for %.0f pole pairs: at least %.0f", lines, g->p,
             64.0 * g->p);
    }
    add(tune, "encoder_lines", larger(lines, 64.0 * g->p), "%s",
        motor->has[MOTOR_LINES] ? "of the motor's encoder" : "no encoder given: the default");
}

static void add_plant(const motor_t *motor, tune_t *tune, const given_t *g)
{
    add(tune, "plant.pole_pairs", g->p, "this and the following rows: the motor");
    add(tune, "plant.resistance", g->r, "[ohm]");
    add(tune, "plant.inductance_d", g->l_d, "[H]");
    add(tune, "plant.inductance_q", g->l_0, "[H]");
    if (g->saturation > 0.0) {
        add(tune, "plant.saturation_q", g->saturation, "[A]");
    }
    add(tune, "plant.flux_linkage", g->psi, "[Wb]");
    add(tune, "plant.inertia", motor->value[MOTOR_INERTIA], "[kg m^2]%s",
        motor->has[MOTOR_INERTIA] ? "" : " assumed");
    add(tune, "plant.load_inertia", motor->value[MOTOR_LOAD_INERTIA], "[kg m^2]");
    const bool known = motor->has[MOTOR_COULOMB] || motor->has[MOTOR_VISCOUS];
    add(tune, "plant.friction_coulomb", motor->value[MOTOR_COULOMB], "[N m]%s",
        known ? "" : " a hundredth of the rated torque, assumed");
    add(tune, "plant.friction_viscous", motor->value[MOTOR_VISCOUS], "[N m s/rad]");
    add(tune, "plant.dc_voltage", g->link, "[V]");
    add(tune, "plant.encoder_lines",
        larger(motor->has[MOTOR_LINES] ? motor->value[MOTOR_LINES] : 2500.0, 64.0 * g->p), "as above");
}

/* The firmware's own judgement. */
static bool accepted(const tune_t *tune, scenario_error_t *error)
{
    rig_t *rig = rig_create(0);
    if (rig == NULL) {
        return scenario_no_memory(error);
    }
    bool good = true;
    for (uint32_t n = 0; n < tune->count && good; n++) {
        good = rig_set(rig, tune->rows[n].row->id, tune->rows[n].value);
    }
    good = good && rig_apply(rig);
    if (!good) {
        (void)scenario_fail(error, (scenario_place_t){0u, 0u}, "motor",
                            "the drive on this board cannot run this motor: %.500s", rig_error(rig));
    }
    rig_free(rig);
    return good;
}

bool tune_motor(const motor_t *motor, tune_t *tune, scenario_error_t *error)
{
    const double *value = motor->value;
    given_t g = {
        .p = value[MOTOR_POLE_PAIRS],
        .r = value[MOTOR_RESISTANCE],
        .l_d = value[MOTOR_INDUCTANCE_D],
        .l_q = value[MOTOR_INDUCTANCE_Q],
        .l_0 = value[MOTOR_INDUCTANCE_Q],
        .saturation = value[MOTOR_SATURATION],
        .psi = value[MOTOR_FLUX],
        .kt = motor_torque_constant(motor),
        .inertia = motor_inertia(motor),
        .rated_current = value[MOTOR_CURRENT],
        .rated_torque = value[MOTOR_TORQUE],
    };
    *tune = (tune_t){.count = 0u};
    for (uint32_t n = 0; n < motor->note_count; n++) {
        warn(tune, "%s", motor->notes[n]);
    }
    take_link(motor, tune, &g);
    take_current(tune, &g);
    take_speed(motor, tune, &g);
    if (g.speed < 1.0) {
        return scenario_fail(
            error, (scenario_place_t){0u, 0u}, "motor",
            "a link of %.4g V is too low: R I at %.4g A is %.4g V of a phase; accepted: a higher "
            "link_voltage, or a smaller rated current",
            g.link, tune->current, g.r * tune->current);
    }
    tune->link = g.link;
    if (g.l_q < WINDING_LEAST * T_S * g.r) {
        char l[UNITS_TEXT_SIZE];
        char least[UNITS_TEXT_SIZE];
        return scenario_fail(
            error, (scenario_place_t){0u, 0u}, "motor",
            "L/R of %s and %.4g ohm is %.3g ms, %.3g periods of the control of %.4g us: the drive "
            "on this board needs 2 periods, %s at least; a board with a faster carrier can run it",
            units_text(l, g.l_q, "H"), g.r, 1e3 * g.l_q / g.r, g.l_q / g.r / T_S, 1e6 * T_S,
            units_text(least, WINDING_LEAST * T_S * g.r, "H"));
    }
    tune->needs_encoder = g.l_q > ESTIMATED_MOST * g.l_d;
    judge_winding(tune, &g);
    judge_sensing(tune, &g);
    add_motor(motor, tune, &g);
    add_limits(motor, tune, &g);
    add_control(motor, tune, &g);
    add_reference(tune, &g);
    add_estimator(tune, &g);
    if (tune->needs_encoder) {
        add(tune, "position_source", ENCODER, "L_q is %.3g L_d: without an encoder at most %.2g (theory, 30)",
            g.l_q / g.l_d, ESTIMATED_MOST);
    } else {
        add(tune, "position_source", SENSORLESS, "without an encoder");
    }
    add_plant(motor, tune, &g);
    return accepted(tune, error);
}
