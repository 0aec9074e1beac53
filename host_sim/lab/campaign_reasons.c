/* Judges the reports of a drive: the reason of a latched fault agrees with the true cause. */
#include <math.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"
#include "settings/reasons.h"

#define NEARLY_NONE   0.01                /* [-] of the sensors' range */
#define NAMED_PERIODS (2u * DRIVE_WINDOW) /* [periods] */
#define WITNESS       0.05                /* [s] within which the reported condition was true */
#define LOCK_WITNESS  2.0                 /* [s] within which the third loss of the lock is a fault */
#define MAGNET_LEFT                                                                                          \
    0.5 /* [-] of the configured psi_f: less counts as a missing EMF, R i and dead time considered */
/* [-] of the link: a smaller shown one scales the EMF as a weak magnet does. The voltage of the inductance,
 * which is scaled by the same factor, is as wrong as the EMF, and beside it. */
#define LINK_LEFT 0.5
#define HEAVY_MASS                                                                                           \
    1.0 /* [-] of the motor: an elastic mass whose swing moves the motor against its torque                  \
         */
/* [-] of overspeed_trip: a true overspeed. An encoder whose speed is wrong shows the trip while the rotor is
 * slower; the drive names the encoder only if the EMF turns more slowly than this share of its speed */
#define FAST       0.9
#define FAST_CODED CAMPAIGN_TURNS
#define FLOWS      0.02 /* [A] with a smaller current the offsets can be measured ... */
#define MEASURED   640u /* [periods] ... within this number, settling included */

/* Present faults that a reason may name; several bits. */
enum {
    IN_STUCK = 1,   /* a current sensor shows one value */
    IN_CURRENT = 2, /* a current sensor has another error */
    IN_WIRE = 4,    /* a phase or a switch does not conduct */
    IN_LEG = 8,     /* a leg loses voltage, two wires are changed */
    IN_ENCODER = 16,
    IN_LINK = 32, /* the link or its sensor */
    IN_TIME = 64, /* samples or interrupts */
    IN_SINK = 128,
    IN_WINDING = 256,
    IN_MODULE = 512,
    IN_SHAFT = 1024,
    IN_MEMORY = 2048,  /* anything may be wrong */
    IN_MAGNET = 4096,  /* a magnet so weak that its EMF may count as missing */
    IN_SCALE = 8192,   /* a link that is shown so much too low that the observed EMF may count as missing */
    IN_WIRES = 16384,  /* open wires or switches of two phases, or of one with nearly no requested current */
    IN_OFFSET = 32768, /* an offset has moved by more than nearly no current, and is unknown */
};

static const struct {
    const char *row;
    uint32_t what;
} kinds[] = {
    {"stuck_current_a", IN_STUCK},
    {"stuck_current_b", IN_STUCK},
    {"current_gain_error_a", IN_CURRENT},
    {"current_gain_error_b", IN_CURRENT},
    {"current_offset_a", IN_CURRENT},
    {"current_offset_b", IN_CURRENT},
    {"current_range", IN_CURRENT},
    {"current_noise", IN_CURRENT},
    {"swap_currents", IN_CURRENT},
    {"open_phase_a", IN_WIRE},
    {"open_phase_b", IN_WIRE},
    {"open_phase_c", IN_WIRE},
    {"open_switches", IN_WIRE},
    {"leg_a_drop", IN_LEG},
    {"leg_b_drop", IN_LEG},
    {"leg_c_drop", IN_LEG},
    {"leg_a_resistance", IN_LEG},
    {"leg_b_resistance", IN_LEG},
    {"leg_c_resistance", IN_LEG},
    {"leg_a_delay", IN_LEG},
    {"leg_b_delay", IN_LEG},
    {"leg_c_delay", IN_LEG},
    {"swap_phases", IN_LEG},
    {"shorted_switches", IN_MODULE},
    {"force_fault", IN_MODULE},
    {"plant.encoder_lines", IN_ENCODER},
    {"plant.encoder_offset", IN_ENCODER},
    {"encoder_reversed", IN_ENCODER},
    {"encoder_slip", IN_ENCODER},
    {"encoder_stuck_a", IN_ENCODER},
    {"encoder_stuck_b", IN_ENCODER},
    {"stuck_dc_link", IN_LINK},
    {"dc_gain_error", IN_LINK},
    {"dc_voltage", IN_LINK},
    {"dc_ripple", IN_LINK},
    {"supply_lost", IN_LINK},
    {"dc_returns", IN_LINK},
    {"chopper_driven", IN_LINK},
    {"interrupt_delay", IN_TIME},
    {"interrupt_time", IN_TIME},
    {"background_time", IN_TIME},
    {"section_time", IN_TIME},
    {"missing_samples", IN_TIME},
    {"plant.sink_temperature", IN_SINK},
    {"plant.motor_temperature", IN_WINDING},
    {"brake_torque", IN_SHAFT},
    {"load_torque", IN_SHAFT},
    {"holding_torque", IN_SHAFT},
    {"flip_word", IN_MEMORY},
    {"plant.flux_linkage", IN_MAGNET},
};

/* Another condition under which a reason is true: the cause was present shortly before. */
typedef enum { BY_FAULT, BY_SPEED, BY_CURRENT, BY_HIGH_LINK, BY_LOW_LINK, BY_ANGLE, BY_FRAME } witness_t;

/* Reasons that name a cause; the other reasons name an action that failed. */
static const struct {
    int32_t reason;
    uint32_t what;
    witness_t witness;
} truths[] = {
    {REASON_MODULE_FAULT, IN_MODULE, BY_CURRENT},
    {REASON_OVERCURRENT, IN_STUCK | IN_CURRENT, BY_CURRENT},
    {REASON_DC_OVERVOLTAGE, IN_LINK, BY_HIGH_LINK},
    {REASON_DC_UNDERVOLTAGE, IN_LINK, BY_LOW_LINK},
    {REASON_SINK_HOT, IN_SINK, BY_FAULT},
    {REASON_MOTOR_HOT, IN_WINDING, BY_FAULT},
    /* after missed interrupts the motion of several periods counts as one */
    {REASON_OVERSPEED, IN_TIME, BY_SPEED},
    {REASON_LATE, IN_TIME, BY_FAULT},
    /* a current beyond the range of the sensors drives one of them to its limit */
    {REASON_BAD_SAMPLE, IN_STUCK | IN_CURRENT, BY_CURRENT},
    {REASON_ENCODER_PHASE, IN_ENCODER | IN_TIME, BY_FAULT},
    {REASON_ENCODER_JUMP, IN_ENCODER | IN_TIME, BY_FAULT},
    {REASON_ENCODER_DIRECTION, IN_ENCODER | IN_CURRENT | IN_LEG | IN_WIRES, BY_FAULT},
    /* less than a quarter of the expected EMF is that of an encoder that turns without the rotor; the
     * observed voltages have the scale of the shown link; those that are missing in two phases lie beside the
     * axes of all three, as the error of a wrong encoder does; without a requested current in its phase only
     * the EMF shows an open wire, whose direction a wrong psi_f changes */
    {REASON_ENCODER_MISMATCH, IN_ENCODER | IN_STUCK | IN_CURRENT | IN_LEG | IN_MAGNET | IN_SCALE | IN_WIRES,
     BY_FAULT},
    /* with less than half of psi_f, a load of half the rated torque exceeds that of the motor */
    {REASON_RUNAWAY, IN_ENCODER | IN_LEG | IN_SHAFT | IN_MAGNET, BY_FAULT},
    /* The voltage that a leg loses does not change the current, either. In a frame that does not follow the
     * rotor the EMF may hold a current against the control for a moment. */
    {REASON_CURRENT_STUCK, IN_STUCK | IN_LEG, BY_FRAME},
    /* in a period without an interrupt the current changes, too */
    {REASON_CURRENT_GAIN, IN_STUCK | IN_CURRENT | IN_LEG | IN_TIME, BY_FAULT},
    /* a frame that does not follow the rotor causes currents like those of a broken wire, in one of twenty
     * runs; a sensor with a shifted zero shows no current although its phase carries one, and a dead time
     * of the wrong sign changes the EMF by less than a wrong psi_f does */
    {REASON_PHASE_LOSS, IN_WIRE | IN_LEG | IN_ENCODER | IN_LINK | IN_CURRENT | IN_OFFSET, BY_FRAME},
    {REASON_BACKGROUND_STALLED, IN_TIME, BY_FAULT},
    {REASON_PROGRAM_CORRUPT, 0u, BY_FAULT},
    {REASON_PARAMS_CORRUPT, 0u, BY_FAULT},
    {REASON_STACK_LOW, 0u, BY_FAULT},
    {REASON_LOCK_LOST, 0u, BY_ANGLE},
};

static uint32_t what_of(const campaign_injected_t *injected)
{
    const char *row = campaign_faults[injected->kind].row;
    for (size_t n = 0; n < sizeof kinds / sizeof kinds[0]; n++) {
        if (strcmp(kinds[n].row, row) == 0) {
            return kinds[n].what;
        }
    }
    return 0u;
}

/* The faults that are present in this period. */
static uint32_t present(const campaign_watch_t *watch, uint32_t period)
{
    uint32_t what = 0u;
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        what |= campaign_is_there(watch, n, period) ? what_of(&watch->drawn->faults[n]) : 0u;
    }
    return what;
}

/* The least true current that may be measured as an overcurrent [A]: the gains of the sensors may be wrong,
 * and the computed phase has the noise of two sensors, of which three standard deviations count. */
static double measured_over(const campaign_case_t *drawn)
{
    const double trip = campaign_trip(drawn);
    return fmin(0.9 * trip, 0.99 * trip - 3.0 * sqrt(2.0) * CAMPAIGN_VALUE(drawn, current_noise));
}

void campaign_truth_begin(campaign_watch_t *watch)
{
    const double sensed = fabs(CAMPAIGN_VALUE(watch->drawn, dc_gain)) + 0.02;
    const double noise = 4.0 * CAMPAIGN_VALUE(watch->drawn, dc_noise);
    const double low = campaign_initial(watch->drawn, "dc_undervoltage");
    uint32_t opens[CAMPAIGN_FAULTS_MAX];
    bool weak = false;
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const campaign_injected_t *injected = &watch->drawn->faults[n];
        weak = weak || (what_of(injected) == IN_MAGNET &&
                        injected->value < MAGNET_LEFT * CAMPAIGN_VALUE(watch->drawn, flux_configured));
        opens[n] = what_of(injected) == IN_WIRE ? UINT32_C(1) << campaign_open_phase(injected) : 0u;
    }
    watch->truth = (campaign_truth_t){
        .fast = FAST * watch->overspeed,
        .fast_coded = FAST_CODED * watch->overspeed,
        .none = NEARLY_NONE * (double)BOARD_CURRENT_RANGE,
        .over = measured_over(watch->drawn),
        .high = campaign_initial(watch->drawn, "dc_overvoltage") * (1.0 - sensed) - noise,
        .low = low * (1.0 + sensed) + noise,
        .under = low * (1.0 - sensed) - noise,
        .weak = weak,
        .heavy = CAMPAIGN_VALUE(watch->drawn, second_mass) > HEAVY_MASS,
    };
    memcpy(watch->truth.opens, opens, sizeof opens);
}

/* ---- a true reason ---- */

static bool lately(uint32_t at, uint32_t period, double seconds)
{
    return at != 0u && period - at <= campaign_periods(seconds);
}

static bool witnessed(const campaign_truth_t *truth, witness_t witness, uint32_t period)
{
    switch (witness) {
    case BY_SPEED:
        return lately(truth->fast_at, period, WITNESS);
    case BY_CURRENT:
        return lately(truth->over_at, period, WITNESS);
    case BY_HIGH_LINK:
        return lately(truth->high_at, period, WITNESS);
    case BY_LOW_LINK:
        return lately(truth->low_at, period, WITNESS);
    case BY_ANGLE:
        return lately(truth->wrong_at, period, LOCK_WITNESS);
    case BY_FRAME:
        return lately(truth->wrong_at, period, WITNESS);
    case BY_FAULT:
        break;
    }
    return false;
}

/* True if a wire or switch is open and has not carried a requested current that would show it. */
static bool is_unseen(const campaign_watch_t *watch, uint32_t period)
{
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        if (campaign_is_there(watch, n, period) && !watch->notices.seen[n] && watch->truth.opens[n] != 0u) {
            return true;
        }
    }
    return false;
}

/* True if a reason that has been shown since this period is true. */
static bool is_true(const campaign_watch_t *watch, int32_t reason, uint32_t since, uint32_t period)
{
    uint32_t what =
        present(watch, since) | (watch->truth.fed ? IN_CURRENT : 0u) | (watch->truth.heavy ? IN_SHAFT : 0u);
    what |= lately(watch->truth.scaled_at, period, WITNESS) ? IN_SCALE : 0u;
    what |= lately(watch->truth.apart_at, period, WITNESS) || is_unseen(watch, since) ? IN_WIRES : 0u;
    what |= watch->truth.step > watch->truth.none ? IN_OFFSET : 0u;
    what |= watch->truth.stopping;
    what &= watch->truth.weak ? ~UINT32_C(0) : ~(uint32_t)IN_MAGNET;
    for (size_t n = 0; n < sizeof truths / sizeof truths[0]; n++) {
        if (truths[n].reason == reason) {
            return (what & (truths[n].what | IN_MEMORY)) != 0u ||
                   witnessed(&watch->truth, truths[n].witness, period);
        }
    }
    return true;
}

/* [A] By which the offsets of the sensors a and b move in this period, in opposite directions. */
static double drifts(const campaign_case_t *drawn, uint32_t period)
{
    double before = 0.0;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        const bool moves = drawn->events[n].kind == CAMPAIGN_V_DRIFT;
        if (moves && campaign_periods(drawn->events[n].time) == period) {
            return fabs(drawn->events[n].value - before);
        }
        before = moves ? drawn->events[n].value : before;
    }
    return 0.0;
}

/* True if a current sensor is wrong while its offset is measured. */
static bool errs_at_rest(const campaign_watch_t *watch, uint32_t period)
{
    return !watch->gates_seen && (present(watch, period) & (IN_STUCK | IN_CURRENT)) != 0u;
}

/* Offsets are measured while no current flows. A rotor whose EMF exceeds the link voltage drives a current
 * through the diodes. Changes during this time are unknown at the next start, and so are values measured
 * with a faulty sensor. A step of a sensor's offset is a wrong value until the sensor has been measured
 * without current for long enough. Until then the sensors show the current plus the step of their offsets. */
static void watch_offsets(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_truth_t *truth = &watch->truth;
    double largest = 0.0;
    for (uint32_t phase = 0; phase < 3u; phase++) {
        largest = fmax(largest, fabs(campaign_number(rows, CAMPAIGN_AT_true_i_a + phase)));
    }
    const bool errs = errs_at_rest(watch, period);
    const double step = drifts(watch->drawn, period);
    const bool moves = errs || step > 0.0;
    truth->quiet = !watch->gates_seen && largest < FLOWS && !moves ? truth->quiet + 1u : 0u;
    truth->drifted = truth->quiet < MEASURED && (truth->drifted || moves);
    truth->step = truth->drifted ? fmax(truth->step, step) : 0.0;
    truth->fed = truth->drifted && (truth->fed || errs || (!watch->gates_seen && largest >= FLOWS));
}

/* True if the sensor of the link [V] is stuck at so small a value that at rated current the error of the
 * voltage exceeds that of an EMF with half of its length. */
static bool scales_voltages(const campaign_watch_t *watch, uint32_t period, double link)
{
    const campaign_motor_t *motor = &watch->motor;
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        const campaign_injected_t *injected = &watch->drawn->faults[n];
        if (strcmp(campaign_faults[injected->kind].row, "stuck_dc_link") == 0 &&
            campaign_is_there(watch, n, period)) {
            const double shown = injected->value / CAMPAIGN_CODES * (double)BOARD_DC_AT_3V;
            const double error = hypot(1.0, motor->inductance_q * motor->current / motor->flux_linkage);
            return (link - shown) * error > (1.0 - LINK_LEFT) * link;
        }
    }
    return false;
}

/* True if two phases are open. */
static bool opens_two(const campaign_watch_t *watch, uint32_t period)
{
    uint32_t phases = 0u;
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        phases |= campaign_is_there(watch, n, period) ? watch->truth.opens[n] : 0u;
    }
    return (phases & (phases - 1u)) != 0u;
}

/* A fault whose reaction is a stop, and which comes during a stop that was requested, is latched at the end
 * of this stop. Its cause may be gone by then. */
static void watch_stop(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    if (rows[CAMPAIGN_AT_state] == watch->stops) {
        watch->truth.stopping |= present(watch, period);
    } else if (rows[CAMPAIGN_AT_state] != watch->fault) {
        watch->truth.stopping = 0u;
    }
}

/* The speed of the tracking loop has an error equal to the change of the speed within its lag, because the
 * loop needs this time to learn a load torque. */
static void bear_witness(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_truth_t *truth = &watch->truth;
    const double link = campaign_number(rows, CAMPAIGN_AT_true_u_dc);
    const double wrong = campaign_invariants[CAMPAIGN_I_ANGLE].limit;
    const double speed = campaign_number(rows, CAMPAIGN_AT_true_omega_m);
    const double lag = watch->duty.coded ? 0.0 : watch->duty.lag;
    truth->speed += (speed - truth->speed) * RIG_PERIOD_SECONDS / (lag + RIG_PERIOD_SECONDS);
    const double followed = fabs(2.0 * speed - truth->speed);
    const bool coded = followed > truth->fast_coded &&
                       campaign_is_coded(watch->drawn, RIG_PERIOD_SECONDS * period) &&
                       (present(watch, period) & IN_ENCODER) != 0u;
    truth->fast_at = followed > truth->fast || coded ? period : truth->fast_at;
    for (uint32_t phase = 0; phase < 3u; phase++) {
        truth->over_at = fabs(campaign_number(rows, CAMPAIGN_AT_true_i_a + phase)) + truth->step > truth->over
                             ? period
                             : truth->over_at;
    }
    truth->high_at = link > truth->high ? period : truth->high_at;
    truth->low_at = link < truth->low ? period : truth->low_at;
    truth->apart_at = opens_two(watch, period) ? period : truth->apart_at;
    truth->scaled_at = scales_voltages(watch, period, link) ? period : truth->scaled_at;
    truth->wrong_at = fabs(campaign_number(rows, CAMPAIGN_AT_theta_err)) > wrong ? period : truth->wrong_at;
}

/* The reason that the drive shows. While the drive stops the motor because of a fault, its refusal of
 * `enable` names the fault; the fault is latched when the shaft is at standstill. The cause may be gone by
 * then. */
static int32_t shown_reason(const campaign_watch_t *watch, const uint32_t *rows)
{
    const int32_t latched = (int32_t)rows[CAMPAIGN_AT_fault_reason];
    if (latched != 0 || rows[CAMPAIGN_AT_state] != watch->stops) {
        return latched;
    }
    for (size_t n = 0; n < sizeof truths / sizeof truths[0]; n++) {
        if (truths[n].reason == (int32_t)rows[CAMPAIGN_AT_refusal]) {
            return truths[n].reason;
        }
    }
    return watch->truth.shown;
}

/* A reason counts if it remains for two windows, because the reason of one period may be replaced by that
 * of the whole window. */
static void judge_reason(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    campaign_truth_t *truth = &watch->truth;
    const int32_t reason = shown_reason(watch, rows);
    if (reason != truth->shown) {
        truth->shown = reason;
        truth->shown_at = period;
    }
    if (reason == truth->reason || period - truth->shown_at < NAMED_PERIODS) {
        return;
    }
    if (reason != 0 && !is_true(watch, reason, truth->shown_at, period)) {
        campaign_violated(watch, CAMPAIGN_I_REASON_TRUE, period, period - truth->shown_at, "fault_reason");
    }
    truth->reason = reason;
}

void campaign_judge_reasons(campaign_watch_t *watch, uint32_t period, const uint32_t *rows)
{
    if (watch->drawn->around != NULL) {
        return;
    }
    bear_witness(watch, period, rows);
    watch_stop(watch, period, rows);
    watch_offsets(watch, period, rows);
    judge_reason(watch, period, rows);
}
