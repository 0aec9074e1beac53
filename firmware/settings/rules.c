#include "settings/rules.h"

#include <float.h>

#include "estimator/chosen.h"
#include "fast/protect/link_limit.h"
#include "math/frames.h"

/* Two decimal numbers that keep a rule also keep it after rounding to binary. */
#define ROUNDING 1.0000005f

/* The rows on which the speed of the hand-over depends (params_start()). */
#define HANDOVER_LEVERS                                                                                      \
    {PARAM_handover_speed, MORE_HELPS}, {PARAM_dead_time, MORE_HELPS}, {PARAM_dc_overvoltage, MORE_HELPS},   \
        {PARAM_motor_resistance, MORE_HELPS}, {PARAM_device_resistance, MORE_HELPS},                         \
        {PARAM_start_current, MORE_HELPS}, {PARAM_current_limit, MORE_HELPS},                                \
        {PARAM_overspeed_trip, MORE_HELPS}, {PARAM_motor_flux_linkage, LESS_HELPS},                          \
    {                                                                                                        \
        PARAM_motor_pole_pairs, LESS_HELPS                                                                   \
    }

const rule_t rules[RULES] = {
    [RULE_TRIP] = {"overcurrent_trip >= 1.2 current_limit",
                   2,
                   {{PARAM_overcurrent_trip, MORE_HELPS}, {PARAM_current_limit, LESS_HELPS}}},
    [RULE_LINK] = {"dc_undervoltage <= dc_overvoltage - 10 V",
                   2,
                   {{PARAM_dc_undervoltage, LESS_HELPS}, {PARAM_dc_overvoltage, MORE_HELPS}}},
    [RULE_DELAY] = {"turn_off_delay <= dead_time + turn_on_delay, else the legs shoot through",
                    3,
                    {{PARAM_turn_off_delay, LESS_HELPS},
                     {PARAM_dead_time, MORE_HELPS},
                     {PARAM_turn_on_delay, MORE_HELPS}}},
    [RULE_ENCODER] = {"256 motor_pole_pairs <= 4 encoder_lines",
                      2,
                      {{PARAM_motor_pole_pairs, LESS_HELPS}, {PARAM_encoder_lines, MORE_HELPS}}},
    [RULE_TURN] = {"overspeed_trip motor_pole_pairs T_s <= " CHOSEN_TURN_TEXT " rad",
                   2,
                   {{PARAM_overspeed_trip, LESS_HELPS}, {PARAM_motor_pole_pairs, LESS_HELPS}}},
    [RULE_SATURATION] = {"motor_saturation_current = 0, or " CHOSEN_SATURATION_TEXT,
                         2,
                         {{PARAM_motor_saturation_current, MORE_HELPS}, {PARAM_current_limit, LESS_HELPS}}},
    [RULE_WINDING] =
        {"motor_resistance + device_resistance <= motor_inductance_q / (2 T_s), and 100 ohm; with "
         "motor_saturation_current the inductance at 0.8 current_limit counts",
         5,
         {{PARAM_motor_resistance, LESS_HELPS},
          {PARAM_device_resistance, LESS_HELPS},
          {PARAM_motor_inductance_q, MORE_HELPS},
          {PARAM_current_limit, IS_READ},
          {PARAM_motor_saturation_current, IS_READ}}},
    [RULE_FEEDFORWARD] = {"feedforward_cutoff <= 0.95 pll_bandwidth, or both 0: by their rule",
                          2,
                          {{PARAM_feedforward_cutoff, LESS_HELPS}, {PARAM_pll_bandwidth, MORE_HELPS}}},
    [RULE_FORGETTING] = {"torque_feedforward = 0, or feedforward_cutoff >= 0.1 rad/s, or 0 with "
                         "pll_bandwidth 0, else its error does not decay",
                         2,
                         {{PARAM_torque_feedforward, LESS_HELPS}, {PARAM_feedforward_cutoff, MORE_HELPS}}},
    [RULE_TORQUE] = {"torque_feedforward 1.5 motor_pole_pairs^2 motor_flux_linkage / motor_inertia <= 1e7 "
                     "rad/s^2 per A",
                     4,
                     {{PARAM_torque_feedforward, LESS_HELPS},
                      {PARAM_motor_inertia, MORE_HELPS},
                      {PARAM_motor_flux_linkage, LESS_HELPS},
                      {PARAM_motor_pole_pairs, LESS_HELPS}}},
    [RULE_SPEEDS] = {"estimate_speed_min < overspeed_trip",
                     2,
                     {{PARAM_estimate_speed_min, LESS_HELPS}, {PARAM_overspeed_trip, MORE_HELPS}}},
    /* b k_s a_f/2 <= 1.2, b = (1 - exp(-R T_s/L))/R */
    [RULE_RINGING] = {"observer_gain observer_slope (1 - exp(-R T_s / motor_inductance_q)) / (2 R) <= 1.2, R "
                      "= motor_resistance + device_resistance, else the observer oscillates",
                      8,
                      {{PARAM_observer_gain, LESS_HELPS},
                       {PARAM_observer_slope, LESS_HELPS},
                       {PARAM_motor_inductance_q, MORE_HELPS},
                       {PARAM_motor_resistance, MORE_HELPS},
                       {PARAM_device_resistance, MORE_HELPS},
                       {PARAM_current_limit, IS_READ},
                       {PARAM_motor_saturation_current, IS_READ},
                       {PARAM_observer_switching, IS_READ}}},
    [RULE_LOOP] = {"pll_bandwidth, pll_damping and feedforward_cutoff make a stable loop at the PWM "
                   "frequency",
                   3,
                   {{PARAM_pll_bandwidth, LESS_HELPS},
                    {PARAM_pll_damping, LESS_HELPS},
                    {PARAM_feedforward_cutoff, LESS_HELPS}}},
    [RULE_FILTER] = {"observer_emf_cutoff = 0, or not below the gain that pll_bandwidth, pll_damping and "
                     "feedforward_cutoff make, with lag_compensation exact",
                     5,
                     {{PARAM_observer_emf_cutoff, MORE_HELPS},
                      {PARAM_pll_bandwidth, LESS_HELPS},
                      {PARAM_pll_damping, LESS_HELPS},
                      {PARAM_feedforward_cutoff, MORE_HELPS},
                      {PARAM_lag_compensation, IS_READ}}},
    [RULE_REACH] = {"observer_gain >= 1.1 times the largest EMF, motor_flux_linkage motor_pole_pairs "
                    "overspeed_trip, of a salient rotor with the flux that mtpa and "
                    "field_weakening add at current_limit, motor_inductance_q and motor_inductance_d",
                    11,
                    {{PARAM_observer_gain, MORE_HELPS},
                     {PARAM_motor_flux_linkage, LESS_HELPS},
                     {PARAM_overspeed_trip, LESS_HELPS},
                     {PARAM_motor_pole_pairs, LESS_HELPS},
                     {PARAM_current_limit, LESS_HELPS},
                     {PARAM_motor_inductance_q, LESS_HELPS},
                     {PARAM_motor_inductance_d, MORE_HELPS},
                     {PARAM_mtpa, LESS_HELPS},
                     {PARAM_field_weakening, LESS_HELPS},
                     {PARAM_dc_undervoltage, MORE_HELPS},
                     {PARAM_motor_saturation_current, IS_READ}}},
    [RULE_START] = {"start_current <= current_limit",
                    2,
                    {{PARAM_start_current, LESS_HELPS}, {PARAM_current_limit, MORE_HELPS}}},
    [RULE_LOW_SPEED] = {"low_speed_current <= current_limit",
                        2,
                        {{PARAM_low_speed_current, LESS_HELPS}, {PARAM_current_limit, MORE_HELPS}}},
    [RULE_FALLBACK] = {"fallback_speed < handover_speed, for 0 the value of its rule",
                       11,
                       {{PARAM_fallback_speed, LESS_HELPS}, HANDOVER_LEVERS}},
    [RULE_CATCH] = {"start_speed <= handover_speed, for 0 the value of its rule",
                    11,
                    {{PARAM_start_speed, LESS_HELPS}, HANDOVER_LEVERS}},
    [RULE_HANDOVER] = {"handover_speed <= 0.5 overspeed_trip",
                       2,
                       {{PARAM_handover_speed, LESS_HELPS}, {PARAM_overspeed_trip, MORE_HELPS}}},
    [RULE_RAMP] = {"start_ramp motor_inertia <= 0.7 of the torque of a start, 1.5 motor_pole_pairs "
                   "motor_flux_linkage start_current, or current_limit where that is 0",
                   6,
                   {{PARAM_start_ramp, LESS_HELPS},
                    {PARAM_start_current, MORE_HELPS},
                    {PARAM_current_limit, MORE_HELPS},
                    {PARAM_motor_inertia, LESS_HELPS},
                    {PARAM_motor_flux_linkage, MORE_HELPS},
                    {PARAM_motor_pole_pairs, MORE_HELPS}}},
    [RULE_RIDE] = {"ride_through_time = 0, or 1.27 dc_undervoltage <= 0.95 dc_overvoltage, else the link "
                   "limits braking and driving at once",
                   3,
                   {{PARAM_dc_undervoltage, LESS_HELPS},
                    {PARAM_dc_overvoltage, MORE_HELPS},
                    {PARAM_ride_through_time, LESS_HELPS}}},
    [RULE_CHOPPER] = {"chopper_voltage = 0, or chopper_voltage <= 0.95 dc_overvoltage, else the link limits "
                      "braking before the chopper is on",
                      2,
                      {{PARAM_chopper_voltage, LESS_HELPS}, {PARAM_dc_overvoltage, MORE_HELPS}}},
    [RULE_CHOPPER_CURRENT] = {"chopper_voltage = 0, or dc_overvoltage / chopper_resistance <= the largest "
                              "current of the board's chopper",
                              3,
                              {{PARAM_chopper_resistance, MORE_HELPS},
                               {PARAM_dc_overvoltage, LESS_HELPS},
                               {PARAM_chopper_voltage, LESS_HELPS}}},
    [RULE_BRAKE] = {"holding_brake = off, or the board has a brake output and position_source = encoder, "
                    "because no known torque holds the shaft without an encoder",
                    2,
                    {{PARAM_holding_brake, LESS_HELPS}, {PARAM_position_source, LESS_HELPS}}},
    [RULE_OPEN] =
        {"field_weakening = off, or 1.732 motor_flux_linkage motor_pole_pairs overspeed_trip <= the largest "
         "dc_overvoltage of the board, else a rotor at that speed charges the DC link beyond it while the "
         "bridge is off",
         4,
         {{PARAM_overspeed_trip, LESS_HELPS},
          {PARAM_motor_flux_linkage, LESS_HELPS},
          {PARAM_motor_pole_pairs, LESS_HELPS},
          {PARAM_field_weakening, LESS_HELPS}}},
    [RULE_SALIENT] =
        {"motor_inductance_q <= " CHOSEN_SALIENT " motor_inductance_d where position_source or "
         "encoder_fault_reaction is sensorless, because the estimator loses the rotor beyond that; use "
         "an encoder; saturated: at 0.8 current_limit",
         4,
         {{PARAM_motor_inductance_q, LESS_HELPS},
          {PARAM_position_source, LESS_HELPS},
          {PARAM_motor_inductance_d, MORE_HELPS},
          {PARAM_encoder_fault_reaction, IS_READ}}},
};

/* A set of the estimator that keeps all of its rules. Each of its values keeps them for any values of the
 * others. */
static estimator_params_t harmless(void)
{
    return (estimator_params_t){
        .smo = {.resistance = 1.0f,
                .inductance = 1.0f,
                .gain = 1e4f,
                .slope = 1e-3f,
                .period = DRIVE_PERIOD,
                .switching = SMO_SIGN},
        .lag = LAG_NONE,
        .pll = {.kp = 100.0f,
                .ki = 2500.0f,
                .feedforward_cutoff = 1.0f,
                .amplitude_floor = 1.0f,
                .period = DRIVE_PERIOD},
        .flux_linkage = 1e-4f,
    };
}

/* The values other than the gain that RULE_REACH reads. */
static void take_reach(estimator_params_t *alone, const estimator_params_t *all)
{
    alone->flux_linkage = all->flux_linkage;
    alone->flux_most = all->flux_most;
    alone->validity.speed_max = all->validity.speed_max;
}

/* Evaluates the estimator's own rules, one at a time: the set has the values of the rows that the rule reads,
 * and harmless values otherwise. */
static bool estimator_takes(rule_number_t rule, const params_t *params)
{
    params_error_t ignored;
    estimator_params_t all;
    estimator_params_t alone = harmless();
    smo_params_t *observer = &alone.smo;
    const assumed_t assumed = params_configured(params);
    params_estimator(params, &assumed, &all);
    const smo_params_t *of_all = &all.smo;
    switch ((int32_t)rule) {
    case RULE_WINDING:
        observer->resistance = of_all->resistance;
        observer->inductance = of_all->inductance;
        break;
    case RULE_RINGING:
        *observer = *of_all;
        observer->emf_cutoff = 0.0f;
        break;
    case RULE_TORQUE:
        alone.torque_feedforward = all.torque_feedforward;
        break;
    case RULE_SPEEDS:
        alone.validity.speed_min = all.validity.speed_min;
        alone.validity.speed_max = all.validity.speed_max;
        break;
    case RULE_FILTER:
        alone.lag = all.lag;
        observer->emf_cutoff = of_all->emf_cutoff;
        alone.pll = all.pll;
        break;
    case RULE_LOOP:
        alone.pll = all.pll;
        break;
    case RULE_REACH:
        observer->gain = of_all->gain;
        take_reach(&alone, &all);
        break;
    default:
        break;
    }
    return estimator_params_check(&alone, &ignored);
}

/* Share of the torque that a start may use for the ramp; the rest is for the load and for swings. */
#define RAMP_SHARE 0.7f

/* The rules of the speeds and of the ramp (RULE_RAMP), with the values that a start uses. */
static bool start_takes(rule_number_t rule, const params_t *params)
{
    const assumed_t assumed = params_configured(params);
    const start_params_t start = params_start(params, &assumed);
    const float per_ampere = 1.5f * (float)params->motor_pole_pairs * assumed.flux_linkage;
    if (rule == RULE_FALLBACK) {
        return start.fallback_speed < start.handover_speed;
    }
    if (rule == RULE_CATCH) {
        return params->start_speed <= start.handover_speed;
    }
    return params->start_ramp * assumed.inertia <= RAMP_SHARE * per_ampere * start.current;
}

static bool saturation_takes(const params_t *params)
{
    return params->motor_saturation_current == 0.0f ||
           params->motor_saturation_current * ROUNDING >= CHOSEN_SATURATION_LEAST * params->current_limit;
}

/* RULE_SALIENT: after a fault of the encoder the estimator may have to control the motor. */
static bool salient_takes(const params_t *params)
{
    const bool estimated = params->position_source == (int32_t)POSITION_SENSORLESS ||
                           params->encoder_fault_reaction == (int32_t)ENCODER_FAULT_SENSORLESS;
    const assumed_t assumed = params_configured(params);
    return !estimated || assumed.inductance_q <= CHOSEN_SALIENT_MAX * assumed.inductance_d * ROUNDING;
}

/* The rules of brake and chopper. */
static bool outputs_take(rule_number_t rule, const params_t *params)
{
    if (rule == RULE_BRAKE) {
        return params->holding_brake == (int32_t)BRAKE_NONE ||
               (params->position_source == (int32_t)POSITION_ENCODER && DRIVE_HAS_BRAKE);
    }
    if (params->chopper_voltage == 0.0f) {
        return true;
    }
    if (rule == RULE_CHOPPER) {
        return params->chopper_voltage <= (LINK_FULL - LINK_OVER_BAND) * params->dc_overvoltage * ROUNDING;
    }
    return params->dc_overvoltage <= DRIVE_CHOPPER_CURRENT * params->chopper_resistance * ROUNDING;
}

/* True if the board's link withstands the EMF of a rotor at its trip speed,
 * rectified while the bridge is off. */
static bool open_bridge_takes(const params_t *params)
{
    return FRAMES_SQRT_3 * params->motor_flux_linkage * (float)params->motor_pole_pairs *
               params->overspeed_trip <=
           BOARD_VOLTS(BOARD_OVERVOLTAGE_MAX_MV) * ROUNDING;
}

/* True if the limits of braking and driving by the link are apart. */
static bool ride_takes(const params_t *params)
{
    return (LINK_HOLD + LINK_HOLD_BAND) * params->dc_undervoltage <=
           (LINK_FULL - LINK_OVER_BAND) * params->dc_overvoltage * ROUNDING;
}

bool rules_hold(rule_number_t rule, const params_t *params)
{
    switch (rule) {
    case RULE_TRIP:
        return params->overcurrent_trip * ROUNDING >= 1.2f * params->current_limit;
    case RULE_LINK:
        return params->dc_undervoltage + 10.0f <= params->dc_overvoltage * ROUNDING;
    case RULE_DELAY:
        return params->turn_off_delay <= (params->dead_time + params->turn_on_delay) * ROUNDING;
    case RULE_ENCODER:
        /* A step of the angle above 25 mrad makes the current noisy. */
        return 256 * params->motor_pole_pairs <= 4 * params->encoder_lines;
    case RULE_TURN:
        return params->overspeed_trip * (float)params->motor_pole_pairs * DRIVE_PERIOD <=
               CHOSEN_TURN_MAX * ROUNDING;
    case RULE_FEEDFORWARD:
        return params->feedforward_cutoff <= 0.95f * params->pll_bandwidth * ROUNDING;
    case RULE_FORGETTING:
        return params->torque_feedforward == 0.0f || params->feedforward_cutoff >= 0.1f ||
               (params->pll_bandwidth == 0.0f && params->feedforward_cutoff == 0.0f);
    case RULE_SPEEDS:
        return params->estimate_speed_min < params->overspeed_trip && estimator_takes(rule, params);
    case RULE_RINGING:
        return !estimator_takes(RULE_WINDING, params) || estimator_takes(rule, params);
    case RULE_LOOP:
        return params->feedforward_cutoff > 0.95f * params->pll_bandwidth * ROUNDING ||
               estimator_takes(rule, params);
    case RULE_FILTER:
        return !estimator_takes(RULE_LOOP, params) || estimator_takes(rule, params);
    case RULE_WINDING:
    case RULE_TORQUE:
    case RULE_REACH:
        return estimator_takes(rule, params);
    case RULE_START:
        return params->start_current <= params->current_limit;
    case RULE_LOW_SPEED:
        return params->low_speed_current <= params->current_limit;
    case RULE_HANDOVER:
        return params->handover_speed <= 0.5f * params->overspeed_trip;
    case RULE_FALLBACK:
    case RULE_CATCH:
    case RULE_RAMP:
        return start_takes(rule, params);
    case RULE_RIDE:
        return params->ride_through_time == 0.0f || ride_takes(params);
    case RULE_CHOPPER:
    case RULE_CHOPPER_CURRENT:
    case RULE_BRAKE:
        return outputs_take(rule, params);
    case RULE_OPEN:
        return params->field_weakening == (int32_t)WEAKENING_OFF || open_bridge_takes(params);
    case RULE_SATURATION:
        return saturation_takes(params);
    case RULE_SALIENT:
        return salient_takes(params);
    case RULES:
        break;
    }
    return true;
}

float rules_least_above_zero(param_t param)
{
    if (param == PARAM_observer_gain) {
        return PARAMS_OBSERVER_GAIN_LEAST;
    }
    if (param == PARAM_observer_slope) {
        return PARAMS_OBSERVER_SLOPE_LEAST;
    }
    const bool apart = param == PARAM_observer_emf_cutoff || param == PARAM_start_current ||
                       param == PARAM_handover_speed || param == PARAM_motor_saturation_current;
    return apart ? FLT_MIN : 0.0f;
}

lever_sense_t rules_sense(rule_number_t rule, param_t param)
{
    for (int32_t n = 0; n < rules[rule].count; n++) {
        if (rules[rule].levers[n].row == param) {
            return rules[rule].levers[n].sense;
        }
    }
    return IS_READ;
}
