#include "settings/params.h"

#include "math/filter.h"
#include "math/root.h"
#include "settings/rules.h"

/* Speed of the EMF below which the detector is divided by a constant [rad/s] electrical: 2 V of the paper's
 * motor, the remaining dead-time error after compensation. */
#define FLOOR_SPEED 11.0f

static const table_row_t rows[] = {
#define ROW_FLOAT(id, name, unit, initial, min, max, access, text)                                           \
    {id,  SLOT_FLOAT, access,   offsetof(params_t, name), #name, unit, TABLE_TEXT(text), "", initial,        \
     min, max,        {0, 0, 0}},
#define ROW_INT(id, name, unit, initial, min, max, access, text)                                             \
    {id,   SLOT_INT, access, offsetof(params_t, name), #name, unit, TABLE_TEXT(text), "",                    \
     0.0f, 0.0f,     0.0f,   {initial, min, max}},
#define ROW_ENUM(id, name, choices, initial, access, text)                                                   \
    {id,   SLOT_ENUM, access, offsetof(params_t, name), #name, "-", TABLE_TEXT(text), choices,               \
     0.0f, 0.0f,      0.0f,   {initial, 0, 0}},
    DRIVE_PARAMS(ROW_FLOAT, ROW_INT, ROW_ENUM)
#undef ROW_FLOAT
#undef ROW_INT
#undef ROW_ENUM
};

const table_t params_table = {"params", rows, sizeof rows / sizeof rows[0]};

void params_defaults(params_t *params)
{
    table_defaults(&params_table, params);
}

float params_duty_min(const params_t *params)
{
    return (params->dead_time + params->minimum_pulse) / DRIVE_PERIOD;
}

float params_duty_max(const params_t *params)
{
    const float settled = 2.0f * (params->dead_time + BOARD_SECONDS(BOARD_SHUNT_SETTLED_NS)) / DRIVE_PERIOD;
    const float short_of = params_duty_min(params);
    return 1.0f - (BOARD_SAMPLES_AT == BOARD_LOWER_ZERO_VECTOR && settled > short_of ? settled : short_of);
}

#define SATURATION_AT  0.8f  /* [-] of current_limit: i_q at which the constant L_q is that of the table */
#define SATURATION_END 1.25f /* [-] of current_limit: end of the table */

saturation_params_t params_saturation(const params_t *params, const assumed_t *assumed)
{
    if (params->motor_saturation_current == 0.0f) {
        return (saturation_params_t){.current = 0.0f};
    }
    return (saturation_params_t){
        .inductance = assumed->inductance_q,
        .bend = assumed->bend,
        .current = params->motor_saturation_current,
        .current_max = SATURATION_END * params->current_limit,
    };
}

float params_saturation_share(const params_t *params)
{
    const saturation_params_t law = {.current = params->motor_saturation_current};
    return saturation_share(&law, SATURATION_AT * params->current_limit);
}

assumed_t params_configured(const params_t *params)
{
    const float share = params_saturation_share(params);
    return (assumed_t){
        .resistance = params->motor_resistance + params->device_resistance,
        .inductance_d = params->motor_inductance_d,
        .inductance_q = share * params->motor_inductance_q,
        .bend = 1.0f / share - 1.0f,
        .flux_linkage = params->motor_flux_linkage,
        .inertia = params->motor_inertia,
    };
}

#define LOOP_CUTOFF     1.6f   /* [-] over sqrt(p T/J), by the rule: 0.12 rad for a step of T */
#define LOOP_TORQUE     0.5f   /* [-] of the torque at current_limit: the rated one */
#define LOOP_LEAST      50.0f  /* [rad/s] */
#define LOOP_MOST       0.025f /* [rad] per period: a bandwidth of 0.1 per period; noise beyond */
#define LOOP_BANDWIDTHS 4.0f   /* [-] of the loop over the feed-forward, for the least overshoot */
#define LOOP_SLOW       0.6f   /* [-] of the bandwidth by the rule, without its lower limit */

#define EMF_FOLLOWED 3.0f /* [-] error of psi_f, 0.3, over the permitted share of the current, 0.1 */

#define SALIENT_NATURAL 0.403f /* [-] natural frequency of the loop over its bandwidth, damping 1 */
#define SALIENT_SPEED   0.6f   /* [-] of ki over the product of cutoff and largest speed */
#define SALIENT_LEAST   4.0f   /* [rad/s] */
#define SALIENT_MOST    50.0f  /* [rad/s] */

/* Cutoff of a salient rotor's feed-forward [rad/s], ki/(0.6 omega_max): with it an L_q that is wrong by a
 * fifth leaves the loop stable up to the largest speed (docs/theory.md, 30). */
static float salient_cutoff(float bandwidth, float omega_max)
{
    const float natural = SALIENT_NATURAL * bandwidth;
    const float cutoff = natural * natural / (SALIENT_SPEED * omega_max);
    const float least = cutoff > SALIENT_LEAST ? cutoff : SALIENT_LEAST;
    return least < SALIENT_MOST ? least : SALIENT_MOST;
}

/* Cutoff of the feed-forward for half of this torque at current_limit [N m], at most LOOP_MOST [rad/s]. */
static float loop_cutoff(const params_t *params, const assumed_t *assumed, float torque)
{
    const float half = LOOP_TORQUE * torque;
    const float square =
        LOOP_CUTOFF * LOOP_CUTOFF * (float)params->motor_pole_pairs * half / assumed->inertia;
    const float cutoff = square * inverse_root(square);
    const float most = LOOP_MOST / DRIVE_PERIOD;
    return cutoff < most ? cutoff : most;
}

static float at_least(float cutoff)
{
    return cutoff > LOOP_LEAST ? cutoff : LOOP_LEAST;
}

/* The loop of a salient rotor is designed for its whole torque, reluctance torque included, because a load
 * step, or an angle error in a weakened field, moves the rotor by this torque (docs/theory.md, 30). The speed
 * control is designed for the torque of the magnets. */
loop_params_t params_loop(const params_t *params, const assumed_t *assumed)
{
    const float pole_pairs = (float)params->motor_pole_pairs;
    const float magnets = 1.5f * pole_pairs * assumed->flux_linkage * params->current_limit;
    const bool salient = params_salient(assumed);
    const float by_magnets = loop_cutoff(params, assumed, magnets);
    const float within =
        salient ? loop_cutoff(params, assumed, params_torque_most(params, assumed)) : by_magnets;
    if (params->pll_bandwidth == 0.0f && params->feedforward_cutoff == 0.0f) {
        const float by_rule = at_least(within);
        const float bandwidth = LOOP_BANDWIDTHS * by_rule;
        return (loop_params_t){
            .bandwidth = bandwidth,
            .cutoff = salient ? salient_cutoff(bandwidth, pole_pairs * params->overspeed_trip) : by_rule,
            .speed = LOOP_BANDWIDTHS * at_least(by_magnets) / PARAMS_SPEED_BELOW_LOOP,
            .slow = false};
    }
    return (loop_params_t){.bandwidth = params->pll_bandwidth,
                           .cutoff = params->feedforward_cutoff,
                           .speed = params->pll_bandwidth / PARAMS_SPEED_BELOW_LOOP,
                           .slow = params->pll_bandwidth < LOOP_SLOW * LOOP_BANDWIDTHS * within};
}

/* With the encoder the feed-forward of the EMF is that of the assumed psi_f. The current has the error
 * d omega/dt d psi_f/ki, as soon as the integral follows a changing EMF: with a psi_f that is wrong by 0.3 a
 * tenth of the current that accelerates the rotor (docs/theory.md, 15). */
static current_control_params_t control_in(const params_t *params, const assumed_t *assumed, bool encoder)
{
    const float flux = (float)params->motor_pole_pairs * assumed->flux_linkage;
    return (current_control_params_t){
        .resistance = assumed->resistance,
        .inductance_d = assumed->inductance_d,
        .inductance_q = assumed->inductance_q,
        .bandwidth = params->current_bandwidth,
        .period = DRIVE_PERIOD,
        .held = encoder ? EMF_FOLLOWED * 1.5f * flux * flux / assumed->inertia : 0.0f,
    };
}

current_control_params_t params_encoder_control(const params_t *params, const assumed_t *assumed)
{
    return control_in(params, assumed, true);
}

current_control_params_t params_current_control(const params_t *params, const assumed_t *assumed)
{
    return control_in(params, assumed, params->position_source == (int32_t)POSITION_ENCODER);
}

/* L_q at this i_q minus L_d [H]: apparent, and incremental. */
typedef struct {
    float apparent, incremental;
} apart_t;

static apart_t apart_at(const params_t *params, const assumed_t *assumed, float i_q)
{
    const saturation_params_t saturation = params_saturation(params, assumed);
    const float apparent = assumed->inductance_q * saturation_share(&saturation, i_q);
    float incremental = apparent;
    if (saturation.current > 0.0f) {
        const float x = i_q / saturation.current;
        incremental = apparent / (1.0f + x * x);
    }
    return (apart_t){apparent - assumed->inductance_d, incremental - assumed->inductance_d};
}

float params_inductance_least(const params_t *params, const assumed_t *assumed)
{
    if (params->motor_saturation_current == 0.0f) {
        return bounds_less(assumed->inductance_d, assumed->inductance_q);
    }
    const float incremental = apart_at(params, assumed, params->current_limit).incremental;
    return assumed->inductance_d + bounds_less(incremental, 0.0f);
}

#define MTPA_HALVINGS 20 /* of the current limit */

/* i_d of most torque per ampere with a current of this length [A], where the q axis saturates: between zero
 * and -`current` the sign of D_i i_d^2 - psi_f i_d - D_a i_q^2 changes there, D_a and D_i of the apparent and
 * the incremental L_q (docs/theory.md, 30). */
static float most_per_ampere(const params_t *params, const assumed_t *assumed, float current)
{
    float low = -current;
    float high = 0.0f;
    for (int n = 0; n < MTPA_HALVINGS; n++) {
        const float i_d = 0.5f * (low + high);
        const float square = current * current - i_d * i_d;
        const apart_t apart = apart_at(params, assumed, root_or_none(square));
        const bool beyond =
            apart.incremental * i_d * i_d - assumed->flux_linkage * i_d - apart.apparent * square > 0.0f;
        low = beyond ? i_d : low;
        high = beyond ? high : i_d;
    }
    return 0.5f * (low + high);
}

float params_mtpa(const params_t *params, const assumed_t *assumed)
{
    const float psi_f = assumed->flux_linkage;
    const float taken = (assumed->inductance_q - assumed->inductance_d) * params->current_limit;
    if (!params_salient(assumed) || params->mtpa == (int32_t)MTPA_OFF) {
        return 0.0f;
    }
    if (assumed->bend > 0.0f) {
        return most_per_ampere(params, assumed, params->current_limit);
    }
    const float square = psi_f * psi_f + 8.0f * taken * taken;
    return -2.0f * taken * params->current_limit / (psi_f + square * inverse_root(square));
}

float params_torque_most(const params_t *params, const assumed_t *assumed)
{
    const float i_d = params_mtpa(params, assumed);
    const float square = params->current_limit * params->current_limit - i_d * i_d;
    const float root = root_or_none(square);
    const float saliency = params_salient(assumed) ? apart_at(params, assumed, root).apparent : 0.0f;
    return 1.5f * (float)params->motor_pole_pairs * (assumed->flux_linkage - saliency * i_d) * square *
           inverse_root(square);
}

#define FUNDAMENTAL 1.27323954f /* 4/pi: of a square wave */
#define WITHIN_MADE 0.98f       /* [-] of the inverter's largest voltage that field weakening may use */

/* Share of the link that field_weakening uses in every direction [-]: voltage_use, or the share that duties
 * and dead time leave to the inverter, if that is smaller; with over-modulation, of its fundamental. */
static float voltage_used(const params_t *params)
{
    const float effective = params->dead_time + params->turn_on_delay - params->turn_off_delay;
    const float lost = params->compensation_gain * effective / DRIVE_PERIOD;
    const float range = params_duty_max(params) - params_duty_min(params);
    const bool over = params->over_modulation == (int32_t)OVER_MODULATION_ON;
    const float most = over ? 0.5f * FUNDAMENTAL : FRAMES_ONE_OVER_SQRT_3;
    const float made = WITHIN_MADE * (most * range - FUNDAMENTAL * lost);
    const float wished = FRAMES_ONE_OVER_SQRT_3 * params->voltage_use;
    return wished < made ? wished : made;
}

weakening_params_t params_weakening(const params_t *params, const assumed_t *assumed)
{
    const bool salient = params_salient(assumed);
    const float mean = 0.5f * (assumed->inductance_d + assumed->inductance_q);
    return (weakening_params_t){
        .flux_linkage = assumed->flux_linkage,
        .inductance_d = salient ? assumed->inductance_d : mean,
        .inductance_q = salient ? assumed->inductance_q : mean,
        .resistance = assumed->resistance,
        .current_max = params->current_limit,
        .i_d_mtpa = params_mtpa(params, assumed),
        .use = params->field_weakening == (int32_t)WEAKENING_ON ? voltage_used(params) : 0.0f,
        .period = DRIVE_WINDOW_PERIOD,
    };
}

float params_flux_most(const params_t *params, const assumed_t *assumed)
{
    const float psi_f = assumed->flux_linkage;
    const float saliency = assumed->inductance_q - assumed->inductance_d;
    if (!params_salient(assumed)) {
        return psi_f;
    }
    const weakening_params_t weakening = params_weakening(params, assumed);
    const weakening_tuning_t tuning = weakening_prepare(&weakening);
    weakening_t most;
    weakening_init(&most, &tuning);
    weakening_look(&most, PARAMS_LINK_LEAST * params->dc_undervoltage,
                   (float)params->motor_pole_pairs * params->overspeed_trip, (dq_t){0.0f, 0.0f});
    return psi_f - saliency * (most.looks != 0u ? most.i_d_limit : weakening.i_d_mtpa);
}

#define OBSERVER_REACH  1.25f /* [-] of k_s over the largest EMF at overspeed_trip, by the rule */
#define OBSERVER_SLOPE  1.6f  /* [-] of a_f k_s T_s/L, by the rule: an error decays in two periods */
#define OBSERVER_ERRORS 4.0f  /* [-] of a_f times the largest current error, by the rule: 96 % of k_s */

/* The value of a rule, limited to the values that the observer accepts: at most the largest of its row. */
static float by_rule(float value, float least, param_t param)
{
    const float most = table_max(&params_table.rows[param]);
    const float upper = value < most ? value : most;
    return upper > least ? upper : least;
}

observer_rows_t params_observer(const params_t *params, const assumed_t *assumed)
{
    const assumed_t configured = params_configured(params);
    const float omega_most = (float)params->motor_pole_pairs * params->overspeed_trip;
    observer_rows_t in_force = {
        .gain = params->observer_gain,
        /* a configured slope is scaled with L: the gain of the observer's loop is kept */
        .slope = params->observer_slope * (assumed->inductance_q / configured.inductance_q),
        .current_max = params->estimate_current_max,
    };
    if (in_force.gain == 0.0f) {
        in_force.gain = by_rule(OBSERVER_REACH * params_flux_most(params, assumed) * omega_most,
                                PARAMS_OBSERVER_GAIN_LEAST, PARAM_observer_gain);
    }
    if (in_force.slope == 0.0f) {
        in_force.slope = by_rule(OBSERVER_SLOPE * assumed->inductance_q / (in_force.gain * DRIVE_PERIOD),
                                 PARAMS_OBSERVER_SLOPE_LEAST, PARAM_observer_slope);
    }
    if (in_force.current_max == 0.0f) {
        in_force.current_max = by_rule(OBSERVER_ERRORS / in_force.slope, 0.0f, PARAM_estimate_current_max);
    }
    return in_force;
}

void params_estimator(const params_t *params, const assumed_t *assumed, estimator_params_t *estimator)
{
    const observer_rows_t observer = params_observer(params, assumed);
    const float pole_pairs = (float)params->motor_pole_pairs;
    const float psi_f = assumed->flux_linkage;
    *estimator = (estimator_params_t){
        .smo =
            {
                .resistance = assumed->resistance,
                .inductance = assumed->inductance_q,
                .gain = observer.gain,
                .slope = observer.slope,
                .emf_cutoff = params->observer_emf_cutoff,
                .period = DRIVE_PERIOD,
                .switching = (smo_switching_t)params->observer_switching,
            },
        .lag = (lag_mode_t)params->lag_compensation,
        .pll = {.amplitude_floor = psi_f * FLOOR_SPEED},
        .flux_linkage = psi_f,
        .saliency = assumed->inductance_q - assumed->inductance_d,
        .flux_most = params_flux_most(params, assumed),
        .flux_adaptation = params->flux_adaptation,
        .saturation = params_saturation(params, assumed),
        .torque_feedforward =
            params->torque_feedforward * 1.5f * pole_pairs * pole_pairs * psi_f / assumed->inertia,
        .validity =
            {
                .amplitude_min = params->estimate_amplitude_min,
                .amplitude_max =
                    params->estimate_amplitude_max > 1.0f ? params->estimate_amplitude_max : 0.0f,
                .amplitude_time = params->estimate_time,
                .detector_max = params->estimate_detector_max,
                .detector_time = params->estimate_time,
                .current_max = observer.current_max,
                .current_time = params->estimate_time,
                .speed_min = pole_pairs * params->estimate_speed_min,
                .speed_max = pole_pairs * params->overspeed_trip,
                .speed_time = params->estimate_time,
            },
    };
    const loop_params_t loop = params_loop(params, assumed);
    (void)pll_design(&estimator->pll, loop.bandwidth, params->pll_damping, loop.cutoff, DRIVE_PERIOD);
}

#define START_SALIENT      0.8f  /* [-] of psi_f/(L_q - L_d), by the rule */
#define START_ACCELERATION 0.15f /* [-] of the acceleration by the start's current, by the rule */
#define START_TIME         0.3f  /* [s] least time from standstill to hand-over, by the rule */
#define HANDOVER_EMF       1.15f /* [-] over the voltage of dead time and resistance, by the rule */
/* [-] configured EMF over the standard deviation of its noise, by the rule: with a psi_f that is configured
 * 30 % too large the EMF is 6.3 times its noise. The mean square of the detector is then 0.025, half of the
 * largest one at a hand-over. */
#define HANDOVER_NOISE     8.2f
#define ROOT_2             1.41421356f
#define HANDOVER_SPEED_MAX 0.3f /* [-] of overspeed_trip, by the rule */
#define FALLBACK_SHARE     0.4f /* [-] of the hand-over's speed, by the rule */
/* [rad/s] electrical, of the slowest rotor that is caught, by the rule: while a catch measures, it turns by
 * 0.16 rad. Errors of the voltage turn the EMF of a slower one by more, so that its direction is unknown. */
#define CATCH_SPEED 10.0f
#define CATCH_SHARE 0.5f /* [-] of the hand-over's speed, for the slowest rotor that is caught */

/* The largest current of a start [A]. Above psi_f/D a salient rotor no longer rests on the current's axis,
 * and on that axis it has no EMF. */
static float start_most(const params_t *params, const assumed_t *assumed)
{
    const float saliency = (1.0f + assumed->bend) * assumed->inductance_q - assumed->inductance_d;
    const float most = START_SALIENT * assumed->flux_linkage;
    const bool less = params_salient(assumed) && most < saliency * params->current_limit;
    return less ? most / saliency : params->current_limit;
}

/* Standard deviation of the observed EMF by the noise of the current sensors [V]. The observer makes
 * L (n(k) - n(k-1))/T of the noise n; of its variance the low-pass with the share a leaves a^2/(1 - a/2). */
static float emf_noise(const params_t *params, const assumed_t *assumed)
{
    if (assumed->noise == 0.0f) {
        return 0.0f;
    }
    const float cutoff = params->observer_emf_cutoff;
    const float share = cutoff > 0.0f ? lowpass_share(cutoff, DRIVE_PERIOD) : 1.0f;
    const float left = 1.0f - 0.5f * share;
    return share * inverse_root(left) * assumed->inductance_q / DRIVE_PERIOD * assumed->noise;
}

/* Both voltages of the rule, times T. A share a is at most omega_s T and 1, and (1 - a/2)^(1/2) at least
 * 2^(-1/2). */
float params_noise(const params_t *params, const assumed_t *assumed, float noise)
{
    const float turn = params->observer_emf_cutoff * DRIVE_PERIOD;
    const float share = turn > 0.0f && turn < 1.0f ? turn : 1.0f;
    const float emf = ROOT_2 * share * assumed->inductance_q * noise;
    const float lost = params->dead_time * params->dc_overvoltage;
    return HANDOVER_NOISE * emf > HANDOVER_EMF * lost ? noise : 0.0f;
}

start_params_t params_start(const params_t *params, const assumed_t *assumed)
{
    const float emf_per_speed = assumed->flux_linkage * (float)params->motor_pole_pairs;
    const float most = start_most(params, assumed);
    start_params_t start = {
        .current = params->start_current > 0.0f ? params->start_current : most,
        .current_most = most,
        .ramp = params->start_ramp,
        .stop_ramp = params->start_ramp,
        .handover_speed = params->handover_speed,
        .visible_speed = params->handover_speed,
        .fallback_speed = params->fallback_speed,
        .dead_voltage = params->dead_time / DRIVE_PERIOD * params->dc_overvoltage,
    };
    if (start.handover_speed == 0.0f) {
        const float resistive = assumed->resistance * start.current;
        const float mistaken = HANDOVER_EMF * bounds_more(start.dead_voltage, resistive);
        const float noisy = HANDOVER_NOISE * emf_noise(params, assumed);
        const float fastest = HANDOVER_SPEED_MAX * params->overspeed_trip;
        start.visible_speed = bounds_less(mistaken / emf_per_speed, fastest);
        start.handover_speed =
            noisy > mistaken ? bounds_less(noisy / emf_per_speed, fastest) : start.visible_speed;
    }
    if (start.fallback_speed == 0.0f) {
        start.fallback_speed = FALLBACK_SHARE * start.handover_speed;
    }
    start.catch_speed = params->start_speed;
    if (start.catch_speed == 0.0f) {
        start.catch_speed = CATCH_SHARE * start.handover_speed;
        const float pole_pairs = (float)params->motor_pole_pairs;
        if (pole_pairs * start.catch_speed < CATCH_SPEED) {
            start.catch_speed = bounds_less(CATCH_SPEED / pole_pairs, start.handover_speed);
        }
    }
    if (start.ramp == 0.0f) {
        const float able = START_ACCELERATION * 1.5f * emf_per_speed * start.current / assumed->inertia;
        const float fastest = start.handover_speed / START_TIME;
        start.ramp = able < fastest ? able : fastest;
        start.stop_ramp = able;
    }
    return start;
}

params_in_force_t params_in_force(const params_t *params, const assumed_t *assumed)
{
    const observer_rows_t observer = params_observer(params, assumed);
    const loop_params_t loop = params_loop(params, assumed);
    return (params_in_force_t){
        .observer_gain = observer.gain,
        .observer_slope = observer.slope,
        .pll_bandwidth = loop.bandwidth,
        .feedforward_cutoff = loop.cutoff,
        .handover_speed = params_start(params, assumed).handover_speed,
    };
}
