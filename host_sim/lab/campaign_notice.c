/* Judges the reports of a drive: it reports a fault within the promised time. */
#include <math.h>

#include "host_sim/lab/campaign_parts.h"

#define CARRIES        0.25  /* [-] of rated current: with less current in a phase no report is required */
#define NOTICE_TIMES   3.0   /* [-] part of the promised time in which current is requested */
#define STARVED        10e-3 /* [s] that too low a link may last with a gate on */
#define HEAT_MARGIN    2.0   /* [K] */
#define LATE_MARGIN    1.2   /* [-] periods */
#define SLIP_SEEN      0.3   /* [-] share of the motion that the encoder misses in the fault of the matrix */
#define PHASE_ANGLE    2.0943951023931957 /* [rad] a third of a turn, between two phases */
#define THREE_LEGS     1.3333333333333333 /* [-] of a leg's loss: largest effect of three in a phase */
#define VOLTAGE_LIMITS 0.85   /* [-] of U_dc/sqrt(3), which duty limits and dead time leave (theory, 30) */
#define LOSS_NONE      0.0075 /* [-] of the sensors' range: a larger value is a current for that law */
#define SWITCH_SPEED                                                                                         \
    490.0 /* [rad/s] electrical; at a higher speed half a turn is shorter than twice the 3.2 ms of the law   \
           */

/* The condition under which a fault is visible. */
typedef enum { WHENEVER, WHILE_ON, WHILE_ASKED, WHILE_FED, WHILE_CODED } shows_t;

/* Reports that the matrix promises, for faults of at least this size. */
typedef struct {
    const char *row;
    shows_t shows;
    double within; /* [s] with the bridge on, or while current is requested */
    bool turns;    /* the detection also needs an electrical turn */
} notice_t;

static const notice_t notices[] = {
    {"force_fault", WHILE_ON, 3e-3, false},
    {"plant.sink_temperature", WHENEVER, 0.15, false},
    {"plant.motor_temperature", WHENEVER, 0.15, false},
    {"interrupt_delay", WHILE_ON, 5e-3, false},
    {"stuck_dc_link", WHILE_ON, 5e-3, false},
    {"open_phase_a", WHILE_FED, PROMISED_NOTICE, false},
    {"open_phase_b", WHILE_FED, PROMISED_NOTICE, false},
    {"open_phase_c", WHILE_FED, PROMISED_NOTICE, false},
    {"open_switches", WHILE_FED, PROMISED_NOTICE, false},
    {"stuck_current_a", WHILE_ASKED, PROMISED_NOTICE, true},
    {"stuck_current_b", WHILE_ASKED, PROMISED_NOTICE, true},
    {"encoder_reversed", WHILE_CODED, PROMISED_NOTICE, true},
    {"encoder_slip", WHILE_CODED, PROMISED_NOTICE, true},
    {"encoder_stuck_a", WHILE_CODED, PROMISED_NOTICE, true},
    {"encoder_stuck_b", WHILE_CODED, PROMISED_NOTICE, true},
};

/* True if the fault is large enough for the promise. */
static bool is_large(const campaign_watch_t *watch, const campaign_injected_t *injected)
{
    const char *row = campaign_faults[injected->kind].row;
    if (strcmp(row, "plant.sink_temperature") == 0) {
        return injected->value > campaign_initial(watch->drawn, "sink_temperature_max") + HEAT_MARGIN;
    }
    if (strcmp(row, "plant.motor_temperature") == 0) {
        return injected->value > campaign_initial(watch->drawn, "motor_temperature_max") + HEAT_MARGIN;
    }
    if (strcmp(row, "interrupt_delay") == 0) {
        return injected->value > LATE_MARGIN * RIG_PERIOD_SECONDS;
    }
    if (strcmp(row, "stuck_dc_link") == 0) {
        const double shown = injected->value / CAMPAIGN_CODES * (double)BOARD_DC_AT_3V;
        return shown < 0.98 * campaign_initial(watch->drawn, "dc_undervoltage") ||
               shown > 1.02 * campaign_initial(watch->drawn, "dc_overvoltage");
    }
    return strcmp(row, "encoder_slip") != 0 || injected->value > SLIP_SEEN;
}

/* Keeps the means of the requested current and of the voltage beyond the EMF over a window of the drive, in
 * the frame of the request. A request that alternates within this time does not command a current: in a
 * forced frame the damping responds to the false EMF of an open phase as to an oscillation, and turns the
 * request by up to 4 A in both directions, at 900 Hz. */
static void keep_request(campaign_watch_t *watch, const uint32_t *rows)
{
    campaign_notices_t *kept = &watch->notices;
    const double share = 1.0 / DRIVE_WINDOW;
    const double frame = campaign_number(rows, CAMPAIGN_AT_frame_theta_e);
    const double theta = campaign_number(rows, CAMPAIGN_AT_true_theta_e);
    const double emf =
        watch->motor.flux_linkage * watch->motor.pole_pairs * campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const double more = (CAMPAIGN_VALUE(watch->drawn, flux_configured) - 1.0) * emf;
    const double alpha = campaign_number(rows, CAMPAIGN_AT_u_alpha) + emf * sin(theta);
    const double beta = campaign_number(rows, CAMPAIGN_AT_u_beta) - emf * cos(theta);
    kept->i_d += (campaign_number(rows, CAMPAIGN_AT_i_d_ref) - kept->i_d) * share;
    kept->i_q += (campaign_number(rows, CAMPAIGN_AT_i_q_ref) - kept->i_q) * share;
    kept->u_d += (alpha * cos(frame) + beta * sin(frame) - kept->u_d) * share;
    kept->u_q += (beta * cos(frame) - alpha * sin(frame) - kept->u_q) * share;
    kept->more_d += (more * sin(theta - frame) - kept->more_d) * share;
    kept->more_q += (-more * cos(theta - frame) - kept->more_q) * share;
}

/* [V] Voltage beyond the EMF with which a sound phase may carry no current: that of the dead time and the
 * drops, if the compensation has the wrong sign in all three legs. */
static double held_by(const campaign_watch_t *watch, const uint32_t *rows)
{
    const double lost = campaign_initial(watch->drawn, "dead_time") / RIG_PERIOD_SECONDS *
                        campaign_number(rows, CAMPAIGN_AT_true_u_dc);
    const double drop = fmax(rig_initial_named("igbt_voltage"), rig_initial_named("diode_voltage"));
    return THREE_LEGS * (lost + CAMPAIGN_VALUE(watch->drawn, drops) * drop);
}

/* True while the link limits the voltage: then it cannot drive every requested current, also in a sound
 * phase. */
static bool is_at_its_limit(const uint32_t *rows)
{
    const double made =
        hypot(campaign_number(rows, CAMPAIGN_AT_u_alpha), campaign_number(rows, CAMPAIGN_AT_u_beta));
    return made > VOLTAGE_LIMITS / sqrt(3.0) * campaign_number(rows, CAMPAIGN_AT_true_u_dc);
}

uint32_t campaign_open_phase(const campaign_injected_t *injected)
{
    const char *row = campaign_faults[injected->kind].row;
    return strcmp(row, "open_switches") == 0 ? (uint32_t)(injected->value / 2.0)
                                             : (uint32_t)(row[strlen(row) - 1u] - 'a');
}

/* [A] Commanded current of the phase that a broken wire or switch interrupts, while the voltage must drive
 * it, both beyond the true EMF and beyond that of the configured psi_f, which the drive knows: its magnitude;
 * for a switch only if the switch conducts this direction. */
static double fed_by(const campaign_watch_t *watch, const campaign_injected_t *injected, const uint32_t *rows)
{
    const campaign_notices_t *kept = &watch->notices;
    const char *row = campaign_faults[injected->kind].row;
    const bool wire = strcmp(row, "open_switches") != 0;
    const double lower = wire ? 0.0 : fmod(injected->value, 2.0);
    const double angle =
        campaign_number(rows, CAMPAIGN_AT_frame_theta_e) - PHASE_ANGLE * campaign_open_phase(injected);
    const double current = kept->i_d * cos(angle) - kept->i_q * sin(angle);
    const double sign = current < 0.0 ? -1.0 : 1.0;
    const double voltage = sign * (kept->u_d * cos(angle) - kept->u_q * sin(angle));
    const double more = sign * (kept->more_d * cos(angle) - kept->more_q * sin(angle));
    const bool driven = voltage + fmin(more, 0.0) > held_by(watch, rows) && !is_at_its_limit(rows);
    const double fed = wire ? fabs(current) : lower != 0.0 ? -current : current;
    return driven ? fed : 0.0;
}

/* [A] Standard deviation of the mean of a window of the third phase's current, which is the sum of two
 * samples, by the noise of an injected fault. */
static double noise_of_mean(const campaign_motor_t *motor, const campaign_injected_t *injected)
{
    const bool noise = strcmp(campaign_faults[injected->kind].row, "current_noise") == 0;
    return noise ? injected->value * motor->current * sqrt(2.0 / DRIVE_WINDOW) : 0.0;
}

/* True if other faults shift the zero of the sensors by so much that the law takes a phase without current
 * for one with current: by half of its limit, of which leakage, the noise of a sound sensor and the offset
 * itself may take the other half. */
static bool hides_zero(const campaign_watch_t *watch, uint32_t period)
{
    double shift = campaign_offset(watch, period);
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const double noise = noise_of_mean(&watch->motor, &watch->drawn->faults[n]);
        shift += campaign_is_there(watch, n, period) ? noise : 0.0;
    }
    return shift > 0.5 * LOSS_NONE * (double)BOARD_CURRENT_RANGE;
}

static bool shows(const campaign_watch_t *watch, shows_t how, uint32_t n, uint32_t period,
                  const uint32_t *rows)
{
    const campaign_injected_t *injected = &watch->drawn->faults[n];
    const bool wire = strcmp(campaign_faults[injected->kind].row, "open_switches") != 0;
    const double asked = how == WHILE_FED ? fed_by(watch, injected, rows) : campaign_asked(rows);
    const bool carries = rows[CAMPAIGN_AT_state] >= watch->enabled && watch->gates_seen &&
                         asked > fmax(CARRIES * watch->motor.current, campaign_wire_current);
    const double speed = fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    switch (how) {
    case WHENEVER:
        return rows[CAMPAIGN_AT_state] != 0u; /* not before the offsets are measured */
    case WHILE_ON:
        return watch->gates_seen;
    case WHILE_ASKED:
        return carries;
    case WHILE_FED:
        return carries && (wire || watch->motor.pole_pairs * speed < SWITCH_SPEED) &&
               !hides_zero(watch, period);
    case WHILE_CODED:
        return carries && campaign_is_coded(watch->drawn, RIG_PERIOD_SECONDS * period) &&
               speed > 2.0 * campaign_blind_speed(watch->drawn);
    }
    return false;
}

/* A current has to be requested in each phase. Therefore these times count only while a current is requested,
 * and are three times the promise of the matrix for a whole turn. */
static void judge_notice(campaign_watch_t *watch, uint32_t n, const notice_t *notice, uint32_t period,
                         const uint32_t *rows)
{
    campaign_notices_t *kept = &watch->notices;
    const campaign_injected_t *injected = &watch->drawn->faults[n];
    const bool gone = injected->lasts > 0.0 && period * RIG_PERIOD_SECONDS > injected->time + injected->lasts;
    const bool reported = rows[CAMPAIGN_AT_state] == watch->fault || rows[CAMPAIGN_AT_state] == watch->stops;
    if (!campaign_is_there(watch, n, period) || gone || reported) {
        kept->asked[n] = 0u;
        kept->turned[n] = 0.0;
        return;
    }
    if (shows(watch, notice->shows, n, period, rows)) {
        kept->asked[n]++;
        kept->seen[n] = true;
        kept->turned[n] += watch->per_omega * fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    }
    const double times = notice->turns || notice->shows == WHILE_FED ? NOTICE_TIMES : 1.0;
    if (kept->asked[n] * RIG_PERIOD_SECONDS > times * notice->within &&
        (!notice->turns || kept->turned[n] > NOTICE_TIMES * CAMPAIGN_TURN)) {
        campaign_violated(watch, CAMPAIGN_I_NOTICE, period, kept->asked[n], "fault_reason");
    }
}

static void judge_notices(campaign_watch_t *watch, uint32_t n, uint32_t period, const uint32_t *rows)
{
    const campaign_injected_t *injected = &watch->drawn->faults[n];
    const char *row = campaign_faults[injected->kind].row;
    if (injected->kind == 0u || !is_large(watch, injected)) {
        return;
    }
    for (size_t k = 0; k < sizeof notices / sizeof notices[0]; k++) {
        if (strcmp(notices[k].row, row) == 0) {
            judge_notice(watch, n, &notices[k], period, rows);
        }
    }
}

/* True if the sensor of the link does not show the true voltage. */
static bool hides_link(const campaign_watch_t *watch, uint32_t period)
{
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const char *row = campaign_faults[watch->drawn->faults[n].kind].row;
        if (campaign_is_there(watch, n, period) &&
            (strcmp(row, "stuck_dc_link") == 0 || strcmp(row, "dc_gain_error") == 0)) {
            return true;
        }
    }
    return false;
}

/* For every fault: while a gate is on, too low a link voltage is reported, unless its sensor does not show
 * it. */
static void judge_starved(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_notices_t *kept = &watch->notices;
    const bool low = watch->gates_seen && campaign_number(rows, CAMPAIGN_AT_true_u_dc) < watch->truth.under;
    kept->starved = low && !hides_link(watch, period) ? kept->starved + 1u : 0u;
    if (kept->starved * RIG_PERIOD_SECONDS > STARVED) {
        campaign_violated(watch, CAMPAIGN_I_NOTICE, period, kept->starved, "true_u_dc");
    }
}

void campaign_judge_notices(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    if (watch->drawn->around != NULL) {
        return;
    }
    judge_starved(watch, period, rows);
    keep_request(watch, rows);
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        judge_notices(watch, n, period, rows);
    }
}
