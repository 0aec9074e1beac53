/* Judges a run from the signals of every period and from every edge of the gates. */
#include <math.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"

#define SIGMAS 3.0 /* [-] theta_sigma that the true error exceeds in at most a hundredth of the periods */

#define CURRENT_SAMPLES 3u /* two periods from the first to the last */

/* Time after the end of a fault in which its consequences are accepted [s]. */
#define AFTERWARDS 0.1

/* Time in which the drive detects a current sensor whose value does not change [s] (docs/theory.md, 27). */
#define DETECTED_STILL 1.2e-3

static const char *const judged[CAMPAIGN_JUDGED_ROWS] = {
#define NAME(name) #name,
    CAMPAIGN_JUDGED(NAME)
#undef NAME
};

uint32_t campaign_watched(uint32_t ids[CAMPAIGN_WATCHED_MAX], uint32_t *floats)
{
    const table_t *signals = NULL;
    uint32_t count = 0;
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        signals = strcmp(rig_table(t)->name, "signals") == 0 ? rig_table(t) : signals;
    }
    for (uint32_t n = 0; n < signals->count && count < CAMPAIGN_WATCHED_MAX - CAMPAIGN_JUDGED_ROWS; n++) {
        if (signals->rows[n].kind == SLOT_FLOAT) {
            ids[count++] = signals->rows[n].id;
        }
    }
    *floats = count + CAMPAIGN_FLOATS_JUDGED;
    for (uint32_t n = 0; n < CAMPAIGN_JUDGED_ROWS; n++) {
        ids[count++] = rig_row_by_name(judged[n])->id;
    }
    return count;
}

static uint32_t choice(const char *row, const char *name)
{
    return (uint32_t)table_choice(rig_row_by_name(row), name);
}

/* The time from which the consequences of a fault must have ended. */
static uint32_t ends(const campaign_injected_t *injected, const campaign_fault_t *fault)
{
    double lasts = injected->lasts;
    if (strcmp(fault->row, "missing_samples") == 0) {
        lasts = injected->value * RIG_PERIOD_SECONDS;
    } else if (lasts == 0.0 || (fault->excuse & CAMPAIGN_STAYS) != 0u) {
        return UINT32_MAX;
    }
    return campaign_periods(injected->time + lasts + AFTERWARDS);
}

/* Offset of the current sensor b, or of sensor a, at this time [A]. The drift has opposite signs in both, and
 * c has no offset. */
static double offset_of_sensor(const campaign_case_t *drawn, bool b, double time)
{
    const double drift = campaign_drift(drawn, time);
    return b ? CAMPAIGN_VALUE(drawn, offset_b) - drift : CAMPAIGN_VALUE(drawn, offset_a) + drift;
}

/* Largest difference of the offsets of two sensors whose signals are exchanged at this time [A]; `pair` as in
 * plant.swap_currents. */
static double offset_between(const campaign_case_t *drawn, double pair, double time)
{
    const double a = offset_of_sensor(drawn, false, time);
    const double b = offset_of_sensor(drawn, true, time);
    return pair == 3.0 ? fabs(a - b) : fabs(pair == 2.0 ? a : b);
}

/* Error that the fault adds to the measured currents [A]: the step of an offset, or the offset of the sensor
 * with which a sensor is exchanged. */
static double offset_of(const campaign_case_t *drawn, const campaign_motor_t *motor,
                        const campaign_injected_t *injected)
{
    const char *const row = campaign_faults[injected->kind].row;
    if (strcmp(row, "swap_currents") == 0) {
        return offset_between(drawn, injected->value, injected->time);
    }
    const bool b = strcmp(row, "current_offset_b") == 0;
    return b || strcmp(row, "current_offset_a") == 0
               ? fabs(injected->value * motor->current - offset_of_sensor(drawn, b, injected->time))
               : 0.0;
}

/* [A] Error of the offset that a stuck sensor has while no current flows, when the drive measures it. */
static double offset_of_stuck(const campaign_case_t *drawn, const campaign_injected_t *injected)
{
    const char *const row = campaign_faults[injected->kind].row;
    const bool b = strcmp(row, "stuck_current_b") == 0;
    const double volts = 3.0 * injected->value / CAMPAIGN_CODES - rig_initial_named("plant.current_zero");
    const double shown = volts / 1.5 * rig_initial_named("plant.current_range");
    return b || strcmp(row, "stuck_current_a") == 0 ? fabs(shown - offset_of_sensor(drawn, b, injected->time))
                                                    : 0.0;
}

/* [A] Largest current that a wrong sensor excuses: the promise, or, if L is small, what half of the largest
 * voltage of a phase, 2/3 U_dc, drives until the drive has detected a value that does not change. A q axis
 * that saturates below its trip has no inductance left that limits the current. */
static double ceiling_of(const campaign_case_t *drawn, const campaign_motor_t *motor, bool still)
{
    if (motor->saturation != 0.0 && motor->saturation < motor->trip) {
        return (double)INFINITY;
    }
    const double driven = DETECTED_STILL * CAMPAIGN_VALUE(drawn, dc_voltage) / (3.0 * motor->inductance_d);
    return still ? fmax(PROMISED_CURRENT, driven) : PROMISED_CURRENT;
}

/* [V] Length of the voltage vector that the fault of one leg takes at rated current: 2/3 of the leg's loss.
 */
static double leg_loss(const campaign_case_t *drawn, const campaign_motor_t *motor,
                       const campaign_injected_t *injected)
{
    const char *const row = campaign_faults[injected->kind].row;
    if (strncmp(row, "leg_", 4) != 0) {
        return 0.0;
    }
    const double per = strstr(row, "_resistance") != NULL ? motor->current
                       : strstr(row, "_delay") != NULL
                           ? CAMPAIGN_VALUE(drawn, dc_voltage) / RIG_PERIOD_SECONDS
                           : 1.0;
    return 2.0 / 3.0 * fabs(injected->value) * per;
}

static campaign_excused_t excuse_of(const campaign_case_t *drawn, const campaign_motor_t *motor,
                                    const campaign_injected_t *injected)
{
    const campaign_fault_t *fault = &campaign_faults[injected->kind];
    const bool until_told = (fault->excuse & CAMPAIGN_UNTIL_TOLD) != 0u;
    const bool while_slow = (fault->excuse & CAMPAIGN_WHILE_SLOW) != 0u;
    const bool uncoded = (fault->excuse & CAMPAIGN_UNCODED) != 0u;
    const bool limited = until_told || (fault->excuse & CAMPAIGN_TO_CEILING) != 0u;
    const double lost = leg_loss(drawn, motor, injected);
    const bool unfed = (fault->excuse & CAMPAIGN_UNFED) != 0u;
    const bool for_angle = while_slow || uncoded || unfed;
    return (campaign_excused_t){
        .bits = for_angle ? fault->excused & ~CAMPAIGN_BIT(ANGLE) : fault->excused,
        .begins = campaign_periods(injected->time),
        .ends = ends(injected, fault),
        .ceiling = limited ? ceiling_of(drawn, motor, until_told) : (double)INFINITY,
        .blind = while_slow
                     ? fmax(campaign_blind_speed(drawn), lost / (motor->flux_linkage * motor->pole_pairs))
                     : 0.0,
        .uncoded = uncoded,
        .unfed = unfed,
        .told = until_told ? campaign_periods(injected->time + PROMISED_NOTICE) : UINT32_MAX,
        .turned = until_told ? 0.0 : CAMPAIGN_TURN,
        .notice = until_told ? campaign_periods(PROMISED_NOTICE) : 0u,
        .offset = offset_of(drawn, motor, injected),
    };
}

/* The largest change of an offset that the drive may not know [A]: by a drift, or by a stuck sensor. A larger
 * one than it accepts refuses the start. */
static double largest_drift(const campaign_case_t *drawn)
{
    double drift = 0.0;
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        drift = fmax(drift, offset_of_stuck(drawn, &drawn->faults[n]));
    }
    drift = fmin(drift, 2.0 * campaign_initial(drawn, "current_offset_max"));
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        if (drawn->events[n].kind == CAMPAIGN_V_DRIFT) {
            drift = fmax(drift, fabs(drawn->events[n].value));
        }
    }
    return drift;
}

void campaign_watch_begin(campaign_watch_t *watch, const campaign_case_t *drawn, campaign_result_t *result,
                          const volatile sig_atomic_t *asked)
{
    *watch = (campaign_watch_t){
        .drawn = drawn,
        .result = result,
        .asked = asked,
        .motor = campaign_motor(drawn),
        .trip = campaign_invariants[CAMPAIGN_I_CURRENT].limit * campaign_trip(drawn),
        .overspeed = campaign_overspeed(drawn),
        .slow = campaign_fallback_speed(drawn),
        .passage = campaign_passage_seconds(drawn),
        .ready = choice("state", "ready"),
        .enabled = choice("state", "operation_enabled"),
        .stops = choice("state", "quick_stop"),
        .fault = choice("state", "fault"),
        .run = choice("manoeuvre", "run"),
    };
    watch->per_omega = watch->motor.pole_pairs * RIG_PERIOD_SECONDS;
    watch->drift = largest_drift(drawn);
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        watch->excused[n] = excuse_of(drawn, &watch->motor, &drawn->faults[n]);
    }
    campaign_duty_begin(watch);
    campaign_truth_begin(watch);
}

bool campaign_is_there(const campaign_watch_t *watch, uint32_t fault, uint32_t period)
{
    const campaign_excused_t *excuse = &watch->excused[fault];
    return watch->drawn->faults[fault].kind != 0u && period >= excuse->begins && period <= excuse->ends;
}

double campaign_offset(const campaign_watch_t *watch, uint32_t period)
{
    double offset = 0.0;
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        offset += campaign_is_there(watch, n, period) ? watch->excused[n].offset : 0.0;
    }
    return offset;
}

static bool is_excused(const campaign_watch_t *watch, uint32_t bit, uint32_t period)
{
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const campaign_excused_t *excuse = &watch->excused[n];
        if ((excuse->bits & bit) != 0u && campaign_is_there(watch, n, period) &&
            (period <= excuse->told || excuse->turned < CAMPAIGN_TURN)) {
            return true;
        }
    }
    return false;
}

static void violated(campaign_watch_t *watch, campaign_invariant_t invariant, uint32_t period, uint32_t since,
                     uint32_t row)
{
    campaign_result_t *result = watch->result;
    const uint32_t bit = UINT32_C(1) << (uint32_t)invariant;
    if (is_excused(watch, bit, period)) {
        result->excused |= bit;
    } else if (result->end != CAMPAIGN_VIOLATED) {
        result->end = CAMPAIGN_VIOLATED;
        result->invariant = invariant;
        result->period = period;
        result->from = period + 1u - since;
        result->row = row;
        watch->stop = 1;
    }
}

void campaign_violated(campaign_watch_t *watch, campaign_invariant_t invariant, uint32_t period,
                       uint32_t since, const char *row)
{
    violated(watch, invariant, period, since, rig_row_by_name(row)->id);
}

/* Infinite or not a number: all bits of the exponent. */
#define EXPONENT UINT32_C(0x7f800000)

/* One loop without a branch, so that it is fast. */
static bool all_finite(const uint32_t *slots, uint32_t count)
{
    uint32_t bad = 0;
    for (uint32_t n = 0; n < count; n++) {
        bad |= (uint32_t)((slots[n] & EXPONENT) == EXPONENT);
    }
    return bad == 0u;
}

static void judge_numbers(campaign_watch_t *watch, uint32_t period, const uint32_t *slots)
{
    uint32_t ids[CAMPAIGN_WATCHED_MAX];
    uint32_t floats;
    (void)campaign_watched(ids, &floats);
    for (uint32_t n = 0; n < floats; n++) {
        if ((slots[n] & EXPONENT) == EXPONENT) {
            violated(watch, CAMPAIGN_I_NUMBER, period, 1u, ids[n]);
        }
    }
}

/* A wrong sensor excuses nothing beyond the promised limits. */
static void judge_ceiling(campaign_watch_t *watch, uint32_t phase, double amount)
{
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        campaign_excused_t *excuse = &watch->excused[n];
        excuse->far[phase] = amount > excuse->ceiling ? excuse->far[phase] + 1u : 0u;
        if (excuse->far[phase] >= CURRENT_SAMPLES) {
            excuse->bits &= ~CAMPAIGN_BIT(CURRENT);
        }
    }
}

/* With all gates off, software can do no more: a rotor whose EMF exceeds the link voltage feeds the link
 * through the diodes. The same holds in the first periods of a catch, in which the drive has not yet measured
 * the speed: the drive does not cause a speed beyond overspeed_trip then. The current of such a rotor brakes
 * it, and continues below this speed. The trip has the error of the measured currents: that of an offset that
 * has changed, until it can be measured. It cannot be measured with the bridge on, or while the rotor feeds
 * the link. */
static void judge_currents(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    static const char *const names[3] = {"true_i_a", "true_i_b", "true_i_c"};
    const double limit =
        watch->trip + (watch->truth.fed ? watch->drift : 0.0) + campaign_offset(watch, period);
    const double largest = fmax(fabs(campaign_number(rows, CAMPAIGN_AT_true_i_a)),
                                fmax(fabs(campaign_number(rows, CAMPAIGN_AT_true_i_b)),
                                     fabs(campaign_number(rows, CAMPAIGN_AT_true_i_c))));
    const bool begins = fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m)) > watch->overspeed;
    watch->fast = rows[CAMPAIGN_AT_manoeuvre] != watch->run && (begins || (watch->fast && largest > limit));
    for (uint32_t phase = 0; phase < 3u; phase++) {
        const double amount = fabs(campaign_number(rows, CAMPAIGN_AT_true_i_a + phase));
        const bool over = amount > limit;
        const bool acts = watch->gates_seen && !watch->fast;
        watch->over[phase] = over && acts ? watch->over[phase] + 1u : 0u;
        judge_ceiling(watch, phase, over && acts ? amount : 0.0);
        watch->over_off[phase] = over && !acts ? watch->over_off[phase] + 1u : 0u;
        if (watch->over_off[phase] >= CURRENT_SAMPLES) {
            watch->result->excused |= CAMPAIGN_BIT(CURRENT);
        }
        if (watch->over[phase] >= CURRENT_SAMPLES) {
            violated(watch, CAMPAIGN_I_CURRENT, period, watch->over[phase],
                     rig_row_by_name(names[phase])->id);
        }
    }
}

/* The speed whose EMF, in a frame with the right angle, would be as large as the one that a wrong angle shows
 * now. A salient rotor has the EMF omega (psi_f - (L_q - L_d) i_d), and at a wrong angle the whole current
 * may be i_d. While nearly no current flows, or less than the error of the measured one, which is 2/sqrt(3)
 * times the offset of a sensor, the dead time's voltage has any sign, and twice the EMF is needed. */
static double shown_speed(const campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    const campaign_motor_t *motor = &watch->motor;
    const double speed = fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    double squares = 0.0;
    for (uint32_t phase = 0; phase < 3u; phase++) {
        const double current = campaign_number(rows, CAMPAIGN_AT_true_i_a + phase);
        squares += current * current;
    }
    const double amplitude = sqrt(squares / 1.5);
    const double against = (motor->inductance_q - motor->inductance_d) * amplitude / motor->flux_linkage;
    const double unsure = fmax(watch->truth.none, 2.0 / sqrt(3.0) * campaign_offset(watch, period));
    const double signs = amplitude < unsure ? 0.5 : 1.0;
    return signs * speed * fmax(1.0 - fmax(against, 0.0), 0.0);
}

/* True if a present fault hides a wrong angle. */
static bool hides_angle(const campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    const double speed = shown_speed(watch, period, rows);
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const campaign_excused_t *excuse = &watch->excused[n];
        const bool uncoded = excuse->uncoded && !campaign_is_coded(watch->drawn, RIG_PERIOD_SECONDS * period);
        const bool unfed = excuse->unfed && campaign_asked(rows) < campaign_wire_current;
        if (campaign_is_there(watch, n, period) && (speed < excuse->blind || uncoded || unfed)) {
            return true;
        }
    }
    return false;
}

/* The speed that the request leads to [rad/s]. A requested current leads to the hand-over speed at least, in
 * its direction. */
static double wanted(const campaign_watch_t *watch, const uint32_t *rows)
{
    if (rows[CAMPAIGN_AT_mode] == 0u) {
        return campaign_number(rows, CAMPAIGN_AT_omega_m_ref);
    }
    return copysign(campaign_handover_speed(watch->drawn), campaign_number(rows, CAMPAIGN_AT_i_q_request));
}

/* True if the drive may wait for the EMF of a shaft that is to pass zero speed, and has waited no longer than
 * this takes: below fallback_speed no EMF shows the angle, and before the passage the EMF is judged from the
 * hand-over speed on. A reference below fallback_speed is not waited for. */
static bool may_wait(const campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    const double time = watch->wrong * RIG_PERIOD_SECONDS;
    const double reference = wanted(watch, rows);
    const double speed = campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const bool before = speed * reference < 0.0;
    return time <= watch->passage &&
           fabs(speed) < (before ? campaign_handover_speed(watch->drawn) : watch->slow) &&
           fabs(reference) >= watch->slow && !campaign_is_coded(watch->drawn, RIG_PERIOD_SECONDS * period);
}

/* theta_sigma beside the true error, in a run without an injected fault, while the drive runs on the
 * estimate. */
static void compare_sigma(campaign_watch_t *watch, uint32_t period, const uint32_t *rows, double error)
{
    campaign_result_t *result = watch->result;
    const double sigma = campaign_number(rows, CAMPAIGN_AT_theta_sigma);
    if (watch->drawn->faults[0].kind != 0u || campaign_is_coded(watch->drawn, RIG_PERIOD_SECONDS * period)) {
        return;
    }
    result->tracked++;
    result->inside += error <= SIGMAS * sigma ? 1u : 0u;
    watch->error_square += error * error;
    watch->sigma += sigma;
    const double mean =
        sqrt(watch->error_square * result->tracked); /* rms error, times the number of periods */
    result->share = mean > 0.0 ? (uint32_t)fmin(CAMPAIGN_PER_MILLE * watch->sigma / mean,
                                                CAMPAIGN_PER_MILLE * CAMPAIGN_PER_MILLE)
                               : 0u;
}

static void judge_angle(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    const bool runs = rows[CAMPAIGN_AT_state] == watch->enabled && rows[CAMPAIGN_AT_manoeuvre] == watch->run;
    const double error = fabs(campaign_number(rows, CAMPAIGN_AT_theta_err));
    const bool wrong = runs && !(error <= campaign_invariants[CAMPAIGN_I_ANGLE].limit); /* NaN is wrong */
    const bool excused = wrong && hides_angle(watch, period, rows);
    if (runs) {
        compare_sigma(watch, period, rows, error);
    }
    watch->result->excused |= excused ? CAMPAIGN_BIT(ANGLE) : 0u;
    watch->wrong = !wrong ? 0u : excused ? watch->wrong : watch->wrong + 1u;
    if (watch->wrong * RIG_PERIOD_SECONDS > CAMPAIGN_ANGLE_SECONDS && !may_wait(watch, period, rows)) {
        violated(watch, CAMPAIGN_I_ANGLE, period, watch->wrong, rig_row_by_name("theta_err")->id);
    }
}

/* True if a bit of the drive's memory has been flipped. */
static bool is_flipped(const campaign_watch_t *watch, uint32_t period)
{
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const campaign_fault_t *fault = &campaign_faults[watch->drawn->faults[n].kind];
        if (fault->scale == CAMPAIGN_OF_STATE && campaign_is_there(watch, n, period)) {
            return true;
        }
    }
    return false;
}

/* The interrupt of the period that latches a fault opens the bridge itself. A flipped bit may set the state
 * fault or a reason. The bridge then opens with the next setpoint, as after `enable` = off. */
static void judge_gates(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    const bool latched = rows[CAMPAIGN_AT_state] == watch->fault;
    const bool at_once = rows[CAMPAIGN_AT_fault_reason] != 0u && !is_flipped(watch, period);
    const campaign_invariant_t as = at_once ? CAMPAIGN_I_GATES : CAMPAIGN_I_OFF;
    if (latched && watch->gates_seen && (double)watch->latched >= campaign_invariants[as].limit) {
        violated(watch, CAMPAIGN_I_GATES, period, 1u, rig_row_by_name("state")->id);
    }
    watch->latched = latched ? watch->latched + 1u : 0u;
}

/* A chip that the watchdog has reset still shows the previous values. Its pins float, so the gates are off.
 */
static void judge_reset(campaign_watch_t *watch, uint32_t period)
{
    if (watch->gates_seen) {
        violated(watch, CAMPAIGN_I_GATES, period, 1u, rig_row_by_name("state")->id);
    }
    watch->gates_seen = watch->gates != 0u;
}

/* A stuck sensor is reported within this time, or within a third of a turn. It is not judged with the bridge
 * off, or if it is stuck at zero while zero is the correct value. */
static void judge_notice(campaign_watch_t *watch, campaign_excused_t *excuse, uint32_t period,
                         const uint32_t *rows)
{
    if (excuse->notice == 0u) {
        return;
    }
    if (!watch->gates_seen && excuse->told < period + excuse->notice) {
        excuse->told = period + excuse->notice;
        excuse->turned = 0.0;
    } else if (period + excuse->notice >= excuse->told) {
        excuse->turned += watch->per_omega * fabs(campaign_number(rows, CAMPAIGN_AT_true_omega_m));
    }
}

void campaign_watch_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    campaign_watch_t *watch = context;
    const uint32_t *rows = slots + (count - CAMPAIGN_JUDGED_ROWS);
    if (watch->reset) {
        judge_reset(watch, period);
        return;
    }
    if (!all_finite(slots, count - CAMPAIGN_JUDGED_ROWS + CAMPAIGN_FLOATS_JUDGED)) {
        judge_numbers(watch, period, slots);
    }
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        judge_notice(watch, &watch->excused[n], period, rows);
    }
    judge_currents(watch, period, rows);
    judge_angle(watch, period, rows);
    judge_gates(watch, period, rows);
    campaign_judge_duty(watch, period, rows);
    campaign_judge_reasons(watch, period, rows);
    campaign_judge_notices(watch, period, rows);
    campaign_keep_angle(watch, rows);
    const double shorts = campaign_number(rows, CAMPAIGN_AT_shoot_throughs);
    if (shorts > watch->shorts) { /* this count includes those that were excused */
        violated(watch, CAMPAIGN_I_LEGS, period, 1u, rig_row_by_name("shoot_throughs")->id);
    }
    watch->shorts = shorts;
    if (campaign_number(rows, CAMPAIGN_AT_chip_reports) > 0.0) {
        violated(watch, CAMPAIGN_I_CHIP, period, 1u, rig_row_by_name("chip_reports")->id);
        watch->reset = is_excused(watch, CAMPAIGN_BIT(CHIP), period);
    }
    if ((rows[CAMPAIGN_AT_sample_flags] & CAMPAIGN_LATE_FLAG) != 0u) {
        violated(watch, CAMPAIGN_I_LATE, period, 1u, rig_row_by_name("sample_flags")->id);
    }
    watch->gates_seen = watch->gates != 0u;
    if (watch->asked != NULL && *watch->asked != 0) {
        watch->stop = 1;
    }
}

void campaign_watch_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    campaign_watch_t *watch = context;
    (void)tick;
    if (what == (uint32_t)RIG_EDGE_GATES) {
        watch->gates = value;
        watch->gates_seen = watch->gates_seen || value != 0u;
    }
}
