/* Coefficients of the manoeuvres from a set of parameters. */
#include "medium/manoeuvre/manoeuvres.h"

#include "fast/inverter/doubt.h"
#include "math/angle.h"
#include "math/bounds.h"
#include "math/exponential.h"
#include "math/filter.h"

#define SALIENT_SLEW  10e-3f /* [s] to the torque of current_limit, by the rule */
#define SPEED_DAMPING 3.0f   /* [-] four times the square of its damping, by the rule */
#define LOW_CURRENT_LOSS                                                                                     \
    0.1f /* [-] of the low-speed current per hand-over speed: a fifth is left at ten of them */
#define LOW_CURRENT_CUTOFF 20.0f /* [rad/s] */
#define EMF_WRONG          1.3f  /* [-] of psi_f: possible error of the assumed value */
#define EMF_HELD           0.15f /* [-] of what the integral holds: permitted excess of the feed-forward */
#define EMF_LAG            0.4f  /* [-] of the lag of the encoder's speed; the speed control damps the rest */
#define ALIGN_RISE_TIME    75e-3f /* [s] of the current in a light rotor's alignment, a quarter of the turn */
/* [-] of I: largest error of the current while a rotor swings to its aligned position */
#define ALIGN_ERROR      0.25f
#define FADE_TIME        0.1f   /* [s] in which the remaining i_d of a hand-over fades */
#define ALIGN_NATURAL    16.0f  /* [rad] of the pendulum's phase in the turn of an alignment */
#define ALIGN_TIME_MIN   0.3f   /* [s] by the rule */
#define ALIGN_TIME_MAX   2.0f   /* [s] by the rule */
#define SWING_SPEED      0.333f /* [-] of w_n: six times that is 2 w_n */
#define FALLBACK_MARGIN  1.4f   /* [-] over the time in which the current limit lets the speed pass zero */
#define FALLBACK_MIN     20e-3f /* [s] */
#define FALLBACK_MAX     0.1f   /* [s] time for which the model of the loop is valid */
#define CATCH_WEAKENS    0.7f   /* [-] of current_limit */
#define CATCH_REACH_MOST 4.0f   /* [-] above the EMF of every link that the overspeed rule permits */
#define SLOW_ASKED       1.67f  /* [-] of fallback_speed: a smaller reference counts as slow */

static float within(float value, float least, float most)
{
    const float more = value > least ? value : least;
    return more < most ? more : most;
}

/* Share of the EMF at the encoder's speed that is fed forward [-]. It is 1, except for a rotor so light that
 * a current would accelerate it without a torque reference, because of an assumed flux which is too large by
 * EMF_WRONG and the lag of the encoder's speed (docs/theory.md, 15). It does not depend on position_source,
 * because control leaves the encoder's frame some periods after this parameter has changed. */
static float known_emf(const params_t *params, const assumed_t *assumed)
{
    const float flux = (float)params->motor_pole_pairs * assumed->flux_linkage;
    const current_control_params_t control = params_encoder_control(params, assumed);
    const float ki = current_control_integral(&control);
    /* kp and EMF_LAG t, both times encoder_bandwidth */
    const float stiff = control.inductance_q * control.bandwidth * params->encoder_bandwidth;
    const float lags = 2.0f * EMF_LAG + 1.5f * EMF_LAG * DRIVE_PERIOD * params->encoder_bandwidth;
    const float drives = 1.5f * flux * flux;
    const float held = EMF_HELD * EMF_WRONG * EMF_WRONG * ki * assumed->inertia;
    return bounds_less((drives + held) * stiff / (EMF_WRONG * drives * (stiff + lags * ki)), 1.0f);
}

/* Largest growth of a torque per window, as a current of psi_f [A]. */
static float torque_slew(const params_t *params, const assumed_t *assumed)
{
    const float by_rule = params_salient(assumed) ? SALIENT_SLEW : 0.0f;
    const float time = params->torque_slew > 0.0f ? params->torque_slew : by_rule;
    const float most = params_torque_most(params, assumed) /
                       (1.5f * (float)params->motor_pole_pairs * assumed->flux_linkage);
    return time > 0.0f ? most * DRIVE_WINDOW_PERIOD / time : 0.0f;
}

static run_tuning_t prepare_run(const params_t *params, const assumed_t *assumed, float handover_speed)
{
    const float fast = params_loop(params, assumed).speed;
    const float per_ampere = params_acceleration(params, assumed);
    const float kp = params->speed_kp > 0.0f ? params->speed_kp : fast / per_ampere;
    const speed_control_params_t speed = {
        .kp = kp,
        .ki = params->speed_ki > 0.0f ? params->speed_ki : kp * kp * per_ampere / SPEED_DAMPING,
        .weight = params->speed_setpoint_weight,
        .current_limit = params->current_limit,
        .period = DRIVE_WINDOW_PERIOD,
    };
    const weakening_params_t weakening = params_weakening(params, assumed);
    const saturation_params_t saturation = params_saturation(params, assumed);
    return (run_tuning_t){
        .speed = speed_control_prepare(&speed),
        .ramp = params->speed_ramp * DRIVE_WINDOW_PERIOD,
        .stop_ramp = params->quick_stop_ramp * DRIVE_WINDOW_PERIOD,
        .low_current = params->low_speed_current,
        .low_inverse = LOW_CURRENT_LOSS / handover_speed,
        .low_share = lowpass_share(LOW_CURRENT_CUTOFF, DRIVE_WINDOW_PERIOD),
        .fade = exponential(-DRIVE_WINDOW_PERIOD / FADE_TIME),
        .saliency = params_salient(assumed)
                        ? (assumed->inductance_q - assumed->inductance_d) / assumed->flux_linkage
                        : 0.0f,
        .saturation = saturation_prepare(&saturation),
        .mtpa = params->mtpa == (int32_t)MTPA_ON,
        .per_torque = 1.0f / (1.5f * (float)params->motor_pole_pairs * assumed->flux_linkage),
        .slew = torque_slew(params, assumed),
        .weakening = weakening_prepare(&weakening),
    };
}

static forced_params_t forced_of(const params_t *params, const assumed_t *assumed,
                                 const start_params_t *start)
{
    return (forced_params_t){
        .resistance = assumed->resistance,
        .inductance = assumed->inductance_q,
        .saliency = params_salient(assumed) ? assumed->inductance_q - assumed->inductance_d : 0.0f,
        .inductance_least = params_inductance_least(params, assumed),
        .flux_linkage = assumed->flux_linkage,
        .pole_pairs = (float)params->motor_pole_pairs,
        .inertia = assumed->inertia,
        .dead_voltage = start->dead_voltage,
        .current = start->current,
        .current_max = params->current_limit,
        .damping = params->start_damping,
        .period = DRIVE_PERIOD,
    };
}

/* Longest EMF with which the voltage of the inverter can control the current of a caught rotor, over
 * U_dc/sqrt3 [-]: that of the speed at which the voltage that weakens the field needs CATCH_WEAKENS of
 * current_limit along -d; without weakening 1. The rest of the current is for the first periods of a catch
 * (docs/theory.md, 23). */
static float catch_reach(const params_t *params, const assumed_t *assumed)
{
    const weakening_params_t weakening = params_weakening(params, assumed);
    const float weakened = CATCH_WEAKENS * weakening.current_max * weakening.inductance_d;
    const float left = within(1.0f - weakened / weakening.flux_linkage, 1.0f / CATCH_REACH_MOST, 1.0f);
    return within(weakening.use / (FRAMES_ONE_OVER_SQRT_3 * left), 1.0f, CATCH_REACH_MOST);
}

reference_tuning_t reference_prepare(const params_t *params, const assumed_t *assumed)
{
    const start_params_t start = params_start(params, assumed);
    const forced_params_t forced = forced_of(params, assumed, &start);
    const catch_params_t catching = {assumed->flux_linkage,
                                     (float)params->motor_pole_pairs * start.catch_speed,
                                     params->doubtful_current,
                                     params->low_speed_current,
                                     params_salient(assumed),
                                     catch_reach(params, assumed),
                                     DRIVE_PERIOD};
    return (reference_tuning_t){
        .forced = forced_prepare(&forced),
        .catching = catch_prepare(&catching),
        .flux_linkage = known_emf(params, assumed) * assumed->flux_linkage,
        .saliency = assumed->inductance_q - assumed->inductance_d,
        .pole_pairs_inverse = 1.0f / (float)params->motor_pole_pairs,
        .periods = (float)DRIVE_WINDOW,
        .per_period = 1.0f / (float)DRIVE_WINDOW,
    };
}

/* Coefficients of the modules of the manoeuvres. */
static void prepare_rooms(manoeuvres_tuning_t *tuning, const params_t *params, const assumed_t *assumed,
                          const start_params_t *start)
{
    const float psi_f = assumed->flux_linkage;
    const float pole_pairs = (float)params->motor_pole_pairs;
    const handover_params_t handover = {start->current, params_salient(assumed), DRIVE_WINDOW_PERIOD};
    const lock_params_t lock = {psi_f, pole_pairs * start->fallback_speed,
                                SLOW_ASKED * pole_pairs * start->fallback_speed, DRIVE_WINDOW_PERIOD};
    tuning->handover = handover_prepare(&handover);
    tuning->lock = lock_prepare(&lock);
    tuning->proof = proof_prepare(DRIVE_WINDOW_PERIOD);
    tuning->run = prepare_run(params, assumed, pole_pairs * start->handover_speed);
}

/* Rise of the current per window in an alignment [A]. A rotor that the full current finds at its unstable
 * equilibrium swings in with up to 2 w_n. The part of its EMF that is not fed forward, 2 w_n psi_f (1 -
 * share), makes an error of this voltage over L_d bandwidth. If the error is large, the current rises slowly:
 * the rotor is released at the least current that overcomes its friction (docs/theory.md, 23). */
static float align_rise(const params_t *params, const forced_params_t *forced, float natural)
{
    const float volts = 2.0f * natural * forced->flux_linkage * (1.0f - forced_emf_share(forced));
    const float holds = (forced->inductance - forced->saliency) * params->current_bandwidth;
    const bool light = volts > ALIGN_ERROR * holds * forced->current;
    return forced->current * (light ? DRIVE_WINDOW_PERIOD / ALIGN_RISE_TIME : MANOEUVRE_RISE);
}

manoeuvres_tuning_t manoeuvres_prepare(const params_t *params, const assumed_t *assumed)
{
    const start_params_t start = params_start(params, assumed);
    const float pole_pairs = (float)params->motor_pole_pairs;
    const forced_params_t forced = forced_of(params, assumed, &start);
    const float natural = forced_natural(&forced);
    const float align = params->start_align_time > 0.0f
                            ? params->start_align_time
                            : within(ALIGN_NATURAL / natural, ALIGN_TIME_MIN, ALIGN_TIME_MAX);
    const float slowly = 2.0f * ANGLE_PI / align;
    const float fallback_speed = pole_pairs * start.fallback_speed;
    const float torque = 1.5f * pole_pairs * assumed->flux_linkage * params->current_limit;
    const float passing = FALLBACK_MARGIN * 2.0f * start.fallback_speed * assumed->inertia / torque;
    const bool gentler = params->speed_ramp > 0.0f && params->speed_ramp < start.ramp;
    const bool limited = params->quick_stop_ramp > 0.0f && params->quick_stop_ramp < start.stop_ramp;

    manoeuvres_tuning_t tuning;
    tuning.limits = (manoeuvres_limits_t){
        .sensorless = params->position_source == (int32_t)POSITION_SENSORLESS,
        .pole_pairs = pole_pairs,
        .pole_pairs_inverse = 1.0f / pole_pairs,
        .handover_speed = pole_pairs * start.handover_speed,
        .fallback_speed = fallback_speed,
        .flux_linkage = assumed->flux_linkage,
        .ramp = pole_pairs * (gentler ? params->speed_ramp : start.ramp) * DRIVE_WINDOW_PERIOD,
        .stop_ramp = pole_pairs * (limited ? params->quick_stop_ramp : start.stop_ramp) * DRIVE_WINDOW_PERIOD,
        .ease_share = lowpass_share(FORCED_EASE_CUTOFF, DRIVE_WINDOW_PERIOD),
        .current_start = start.current,
        .current_inverse = 1.0f / start.current,
        .align_rise = align_rise(params, &forced, natural),
        .current_retry = start.current_most,
        .current_caught =
            catch_current_along(params->doubtful_current, params->low_speed_current, params_salient(assumed)),
        .doubtful = params->doubtful_current < DOUBT_SHARE * start.current ? params->doubtful_current : 0.0f,
        .align_speed = slowly < fallback_speed ? slowly : fallback_speed,
        .swing_square = SWING_SPEED * SWING_SPEED * natural * natural / start.current,
        .align_windows = DRIVE_WINDOWS(align),
        .fallback_periods = DRIVE_PERIODS(within(passing, FALLBACK_MIN, FALLBACK_MAX)),
        .start_tries = (uint32_t)params->start_tries,
        .smooth = params->speed_feedback == (int32_t)SPEED_SMOOTH,
        .slow_loop =
            params->position_source == (int32_t)POSITION_SENSORLESS && params_loop(params, assumed).slow,
        .judging = params->lock_judged == (int32_t)LOCK_JUDGED,
        .encoder_fault = params->encoder_fault_reaction,
    };
    prepare_rooms(&tuning, params, assumed, &start);
    return tuning;
}
