#include "medium/adapt/inductance.h"

#include "math/angle.h"
#include "math/periods.h"
#include "math/winding.h"
#include "medium/adapt/gain.h"
#include "medium/adapt/inductance_dither.h"
#include "medium/adapt/inductance_swing.h"

#define TWELFTH       0.083333333f
#define SLOW_TIMES    UINT32_C(3) /* [-] factor on the misses up to INDUCTANCE_R_SPEED_MAX */
#define TRUST         0.2f      /* [-] change of the confidence by a cycle that agrees with the one before */
#define CONFIDENT     0.5f      /* [-] confidence from which the result of a cycle is used */
#define OPPOSED       0.25f     /* [-] of the remaining swing of i_q that is opposed in each cycle */
#define KEPT          0.984375f /* [-] of the opposing current from one cycle to the next */
#define LARGE         0.125f    /* [-] of the dither: an opposing current that must have reduced the swing */
#define REMAINS       0.125f    /* [-] of the opposing current: twice the swing that its decay leaves */
#define VAIN_CYCLES   16u       /* [-] */
#define WAVE_SQUARE   0.53333333f /* mean of s^2 [-] */
#define SWINGS        2.0f        /* [-] of the mean square of the dither: i_d swings beside it by as much */
#define SHARE_MAX     0.5f        /* [-] */
#define ANSWER_OFF    0.5f        /* [-] of the commanded i_d: largest difference */
#define EMF_MIN       0.5f        /* [-] of psi_f |omega| */
#define SETTLED       0.2f /* [-] of the initial rate: at this rate R has been learnt for long enough */
#define CERTAIN       0.9f /* [-] confidence from which a learnt value is kept at once */
#define ANSWER_LEAST  0.4f /* [-] least G with which the angle shows L_q: t of 0.2 without saturation */
#define ALONG_MAX     3.0f /* [-] */
#define FLUX_LEAST    0.1f /* [-] of psi_f: least psi_t */
#define PLAUSIBLE_MAX 3.0f /* [-] of the parameter: largest L that a noisy cycle can give */

static inductance_wave_t wave_of(const inductance_params_t *params, float frequency)
{
    const float step = (float)params->every * params->period;
    const uint32_t steps = (uint32_t)(1.0f / (frequency * step) + 0.5f);
    const float count = (float)steps;
    const float omega = INDUCTANCE_TWO_PI * frequency;
    const float passed = omega * omega / (omega * omega + INDUCTANCE_CUTOFF * INDUCTANCE_CUTOFF);
    return (inductance_wave_t){
        .steps = steps,
        .step = 2.0f / count,
        .per_sum = 1.0f / (passed * WAVE_SQUARE * count),
    };
}

/* True if L_q is learnt. With a smaller ratio a salient rotor could become a round one; a round rotor has no
 * dither that shows a saturation. */
static bool learns(const inductance_params_t *params)
{
    if (!params->salient) {
        return params->saturation == 0.0f;
    }
    return params->salient_too && params->from >= INDUCTANCE_SALIENT_LEAST * params->inductance_d;
}

inductance_tuning_t inductance_prepare(const inductance_params_t *params)
{
    const float step = (float)params->every * params->period;
    return (inductance_tuning_t){
        .wave = {wave_of(params, INDUCTANCE_FREQUENCY_1), wave_of(params, INDUCTANCE_FREQUENCY_2),
                 wave_of(params, INDUCTANCE_FREQUENCY_3)},
        .rate = learns(params) ? params->rate : 0.0f,
        .from = params->from,
        .inductance_q = params->inductance_q,
        .knee = params->saturation > 0.0f ? 1.0f / (params->saturation * params->saturation) : 0.0f,
        .observed_q = params->observed_q,
        .inductance_d = params->inductance_d,
        .ratio = params->salient ? 0.0f : params->inductance_q / params->inductance_d,
        .resistance = params->resistance,
        .resistance_from = params->resistance_from,
        .flux_linkage = params->flux_linkage,
        .current = inductance_dither(params),
        .slow_most = inductance_slow_most(params),
        .ripple = params->flux_linkage * params->period / params->from,
        .look = periods_of(INDUCTANCE_LOOK, step),
        .rest = periods_of(INDUCTANCE_REST, step),
        .mean_share = lowpass_share(INDUCTANCE_CUTOFF, step),
        .time = step,
        .ahead = (float)params->ahead,
    };
}

/* L begins again with its parameter. */
static void begin_again(inductance_t *x)
{
    x->learnt = (learnt_value_t){x->tuning.from, x->tuning.from};
    x->look.kept = x->tuning.from;
    x->rate = x->tuning.rate;
    x->confidence = 0.0f;
}

static void start(inductance_t *x)
{
    x->look = (inductance_look_t){.looked = 0u};
    begin_again(x);
    x->resistance = (learnt_value_t){x->tuning.resistance_from, x->tuning.resistance_from};
    x->resistance_rate = x->tuning.rate;
    x->swing.from = 0u;
    x->swing.vain = 0u;
    inductance_rest(x);
}

void inductance_init(inductance_t *x, const inductance_tuning_t *tuning)
{
    x->tuning = *tuning;
    start(x);
}

void inductance_take(inductance_t *x, const inductance_tuning_t *tuning)
{
    const bool other_rate = tuning->rate != x->tuning.rate;
    x->tuning = *tuning;
    if (tuning->from != x->learnt.from || tuning->resistance_from != x->resistance.from ||
        tuning->rate == 0.0f) {
        start(x);
    } else if (other_rate) {
        x->rate = tuning->rate;
        x->resistance_rate = tuning->rate;
        x->look.rests = 0u;
    }
}

/* True if the response to the dither is beyond the errors of the voltage. */
static bool shows(const inductance_t *x, float speed, float i_q)
{
    return speed * x->tuning.from * x->tuning.current >= INDUCTANCE_EMF &&
           !inductance_hides(&x->tuning, speed, i_q);
}

/* True if i_q [A] makes enough torque that L affects the result. */
static bool loaded(const inductance_t *x, float i_q)
{
    return !bounds_within(i_q, INDUCTANCE_TORQUE * x->tuning.current);
}

/* True if R still has to be learnt at this speed [rad/s]. */
static bool looks_for_resistance(const inductance_t *x, float speed)
{
    return x->tuning.ratio != 0.0f && speed < INDUCTANCE_R_SPEED_MAX &&
           x->resistance_rate > SETTLED * x->tuning.rate;
}

/* Ends an interval. Values that it has learnt before its cycles contradicted each other are not used: few
 * results of a light rotor agree by chance. */
static void settle(inductance_t *x, bool failed)
{
    if (x->confidence > (failed ? CERTAIN : CONFIDENT)) {
        x->look.kept = x->learnt.value;
    } else if (failed) {
        x->learnt.value = x->look.kept;
    }
}

/* Counts a cycle that has ended, with or without a result that L or R has used. Once the learning interval
 * has enough results, or too many cycles without one, the dither pauses. */
static void look(inductance_t *x, bool said, bool learnt, float speed)
{
    const inductance_tuning_t *tuning = &x->tuning;
    inductance_look_t *at = &x->look;
    const uint32_t steps = tuning->wave[x->which].steps;
    at->looked += said ? steps : 0u;
    at->missed = !learnt ? at->missed + steps : at->missed > steps ? at->missed - steps : 0u;
    /* at low speed the dead time is learnt first, and a light rotor swings near the dither's frequency */
    const bool slow = speed < INDUCTANCE_R_SPEED_MAX;
    const bool failed = at->missed >= (slow ? SLOW_TIMES : UINT32_C(1)) * INDUCTANCE_MISSED * tuning->look;
    if (failed || (at->looked >= tuning->look && x->rate <= INDUCTANCE_LOOKED * tuning->rate &&
                   !looks_for_resistance(x, speed))) {
        settle(x, failed);
        at->looked = 0u;
        at->missed = 0u;
        at->failed = failed ? UINT32_C(1) : UINT32_C(0);
        at->rests = tuning->rest;
        at->looked_at = x->mean.q;
    }
}

/* True if the dither pauses at this i_q [A]. */
static bool rests(inductance_t *x, float i_q)
{
    if (x->look.rests == 0u) {
        return false;
    }
    x->look.rests = bounds_within(i_q - x->look.looked_at, INDUCTANCE_MOVED * x->tuning.current)
                        ? x->look.rests - 1u
                        : 0u;
    x->follows = 0u;
    x->dither = (dq_t){0.0f, 0.0f};
    return x->look.rests != 0u;
}

/* psi_q of the assumed curve over i_q, relative to that without current [-]. */
static float share_at(const inductance_tuning_t *tuning, float i_q)
{
    return tuning->knee != 0.0f ? winding_saturation(tuning->knee * i_q * i_q) : 1.0f;
}

/* The part of psi_q at this i_q [A] that the observer's constant L_q does not have [Wb]. */
static float flux_beyond(const inductance_tuning_t *tuning, float i_q)
{
    return tuning->knee != 0.0f ? (share_at(tuning, i_q) * tuning->inductance_q - tuning->observed_q) * i_q
                                : 0.0f;
}

/* Change of the flux along q per ampere of i_d at constant torque and this current, per error of L_q [-]. */
static float answer_at(const inductance_t *x, dq_t current)
{
    const inductance_tuning_t *tuning = &x->tuning;
    const float share = share_at(tuning, current.q);
    const float square = share * share;
    const float incremental = square * share * tuning->inductance_q;
    const float slope = -3.0f * incremental * square * tuning->knee * current.q; /* of the incremental one */
    const float less = incremental - tuning->inductance_d + slope * x->along * current.d;
    return share * (square * x->along + current.q * less / x->flux);
}

/* The line of constant torque at this current; false: a salient rotor has too little of i_q to show L_q. With
 * D_a and D_i of the apparent and the incremental L_q, T/(1.5 p) = psi_f i_q + L_d i_d i_q - psi_q i_d is
 * constant along di_q = t di_d, t = D_a i_q/psi_t, psi_t = psi_f - D_i i_d. */
static bool turns_with(inductance_t *x, const inductance_input_t *input)
{
    const inductance_tuning_t *tuning = &x->tuning;
    if (tuning->ratio != 0.0f) {
        x->along = 0.0f;
        return true;
    }
    const float i_q = input->current.q;
    const float share = share_at(tuning, i_q);
    const float apparent = share * tuning->inductance_q;
    /* psi_a contains the observer's L_q */
    const float flux = input->flux - (share * share * apparent - tuning->observed_q) * input->current.d;
    const float least = FLUX_LEAST * tuning->flux_linkage;
    x->flux = flux > least ? flux : least;
    x->along = bounds_clamp((apparent - tuning->inductance_d) * i_q / x->flux, ALONG_MAX);
    return !bounds_within(answer_at(x, input->current), ANSWER_LEAST);
}

/* The loop's angle counts from a rotation at this speed [rad/s] from now on. Where the swing is eliminated,
 * the high-pass changes at once by its answer to the difference of the rotations, which otherwise would
 * settle in the cycle. */
static void turn_at(inductance_t *x, float omega)
{
    const float share = x->tuning.mean_share;
    if (inductance_eliminated(x, omega, x->which) != 0.0f) {
        x->turned -= x->tuning.time * (1.0f - share) / share * (omega - x->omega);
    }
    x->omega = omega;
    if (x->tuning.ratio != 0.0f) {
        x->flux = x->emf_mean.q / omega;
    }
}

/* Begins a cycle. false: the conditions for a result are not met. */
static bool begin(inductance_t *x, const inductance_input_t *input)
{
    const float speed = bounds_magnitude(input->omega_smooth);
    const bool along = turns_with(x, input);
    const bool torque = along && loaded(x, input->current.q);
    const uint32_t which = inductance_frequency(speed, torque, x->swing.from);
    if (speed < INDUCTANCE_SPEED_MIN || which == INDUCTANCE_FREQUENCIES ||
        !((torque && shows(x, speed, input->current.q)) || looks_for_resistance(x, speed))) {
        inductance_rest(x);
        return false;
    }
    if ((x->look.failed != 0u || !looks_for_resistance(x, speed)) && rests(x, input->current.q)) {
        return false;
    }
    if (x->follows == 0u) {
        x->swing.i_d = 0.0f;
        x->emf_mean.q = input->emf.q;
        x->emf_mean.d = input->emf.d + input->omega_smooth * flux_beyond(&x->tuning, input->current.q);
        x->turned = 0.0f;
        x->theta = input->theta;
        x->omega = input->omega_smooth;
        x->mean = input->current;
    }
    x->follows = 0u;
    x->which = which;
    x->left = x->tuning.wave[x->which].steps;
    x->marks = input->voltage_known ? INDUCTANCE_SOUND | INDUCTANCE_KNOWN : INDUCTANCE_SOUND;
    x->t = -1.0f;
    x->current = inductance_amplitude(&x->tuning, speed, x->mean.q);
    turn_at(x, input->omega_smooth);
    x->sum = (inductance_sums_t){.detector = 0.0f};
    x->swing.s = 0.0f;
    x->swing.c = 0.0f;
    return true;
}

/* True if the rotor turned and the loop followed it in the cycle that ends now. */
static bool is_locked(const inductance_t *x, const inductance_wave_t *wave, float speed)
{
    const bool turns = speed > INDUCTANCE_SPEED_MIN &&
                       bounds_magnitude(x->emf_mean.q) > EMF_MIN * x->tuning.flux_linkage * speed;
    return turns && x->sum.detector < INDUCTANCE_DETECTOR_MAX * (float)wave->steps;
}

/* L_q from the cycle that ends now [H], whose dL of a round rotor is `beyond` [H]; 0: it is not plausible. */
static float said_by(const inductance_t *x, float omega, float beyond)
{
    const inductance_tuning_t *tuning = &x->tuning;
    const float miss =
        tuning->ratio != 0.0f
            ? tuning->ratio * (beyond - (tuning->inductance_d - tuning->inductance_q))
            : -inductance_per_ampere(&x->sum, x->sum.drop, x->sum.drop_c) / (omega * answer_at(x, x->mean));
    const float said = tuning->inductance_q + miss;
    return said > 0.0f && said < PLAUSIBLE_MAX * tuning->from ? said : 0.0f;
}

/* True if this result [H] of a cycle may be used. */
static bool is_trusted(inductance_t *x, float said)
{
    const bool agrees = bounds_within(said - x->said, INDUCTANCE_AGREES * x->learnt.value);
    x->confidence = lowpass_step(x->confidence, TRUST, agrees ? 1.0f : 0.0f);
    return agrees && x->confidence > CONFIDENT;
}

/* True if the opposing current is large, but has not reduced the swing to what its decay leaves. */
static bool is_in_vain(const inductance_swing_t *swing, float current, float s, float c)
{
    const float against = swing->against_s * swing->against_s + swing->against_c * swing->against_c;
    return against > LARGE * LARGE * current * current && s * s + c * c > REMAINS * REMAINS * against;
}

/* The next cycle opposes the swing of i_q that this one has measured, unless its L is not plausible. A share
 * of the opposing current decays: where the frequency of the dither is a resonance of the shaft, the speed
 * control turns the answer to it by a quarter of a cycle and more, and the opposing current would grow. If it
 * grows nevertheless, or if the rotor swings although i_q does not, the next cycle has another frequency.
 * What the swing has taught is discarded, unless the law has eliminated it. */
static void oppose(inductance_t *x, const inductance_wave_t *wave, bool plausible, bool shaken)
{
    inductance_swing_t *swing = &x->swing;
    const float s = wave->per_sum * swing->s;
    const float c = wave->per_sum * swing->c;
    swing->vain = shaken || is_in_vain(swing, x->current, s, c) ? swing->vain + 1u : swing->vain >> 1;
    if (swing->vain >= VAIN_CYCLES && x->which + 1u < INDUCTANCE_FREQUENCIES) {
        swing->from = x->which + 1u;
        swing->vain = 0u;
        swing->against_s = 0.0f;
        swing->against_c = 0.0f;
        if (inductance_eliminated(x, x->omega, x->which) == 0.0f) {
            begin_again(x);
        }
        return;
    }
    if (!plausible) {
        return;
    }
    swing->against_s = bounds_clamp(KEPT * swing->against_s - OPPOSED * s, x->current);
    swing->against_c = bounds_clamp(KEPT * swing->against_c - OPPOSED * c, x->current);
}

/* Moves a learnt value towards the result of a cycle with this duration [s] by its rate, and reduces the
 * rate. The value stays between half and twice the parameter from which it started. */
static void learn(const inductance_tuning_t *tuning, float time, float said, learnt_value_t *learnt,
                  float *rate)
{
    const float share = *rate * time;
    const float next = lowpass_step(learnt->value, share < SHARE_MAX ? share : SHARE_MAX, said);
    const float least = (tuning->ratio == 0.0f ? INDUCTANCE_SALIENT_MIN : INDUCTANCE_MIN) * learnt->from;
    const float most = INDUCTANCE_MAX * learnt->from;
    learnt->value = next < most ? (next > least ? next : least) : most;
    *rate = gain_step(*rate, tuning->rate, time);
}

/* R from the component of e_d that is in step with i_d in this cycle [ohm]. */
static float resistance_said(const inductance_t *x)
{
    const float beyond = inductance_per_ampere(&x->sum, x->sum.drop, x->sum.drop_c);
    return x->tuning.resistance + bounds_clamp(beyond, x->resistance.from);
}

/* How steady the speed was in a cycle. All laws accept STEADY; RIPPLED is accepted for a light rotor only. */
typedef enum { UNSTEADY, RIPPLED, STEADY } steadiness_t;

static steadiness_t steadiness(const inductance_t *x, float omega)
{
    const float drift = bounds_magnitude(omega - x->omega);
    const float speed = bounds_magnitude(omega);
    if (drift <= INDUCTANCE_R_SPEED_DRIFT * speed) {
        return STEADY;
    }
    return drift <= INDUCTANCE_SPEED_DRIFT * speed && (x->marks & INDUCTANCE_KNOWN) != 0u &&
                   loaded(x, x->mean.q)
               ? RIPPLED
               : UNSTEADY;
}

static void end(inductance_t *x, float omega_smooth)
{
    const inductance_wave_t *wave = &x->tuning.wave[x->which];
    const float told = x->current;
    const float answer = wave->per_sum * x->sum.answer;
    const steadiness_t steady = steadiness(x, omega_smooth);
    x->follows = (x->marks & INDUCTANCE_SOUND) != 0u && bounds_within(answer - told, ANSWER_OFF * told);
    const bool swings = x->sum.square > SWINGS * WAVE_SQUARE * (float)wave->steps * told * told;
    const bool valid = steady != UNSTEADY && !swings && x->follows != 0u &&
                       is_locked(x, wave, bounds_magnitude(omega_smooth));
    const float beyond = x->tuning.ratio != 0.0f ? inductance_beside(x, omega_smooth) : 0.0f;
    const float said = valid ? said_by(x, omega_smooth, beyond) : 0.0f;
    bool learnt = false;
    if (valid) {
        oppose(x, wave, said > 0.0f, inductance_is_shaken(x, omega_smooth, beyond));
    }
    if (said > 0.0f) {
        const inductance_tuning_t *tuning = &x->tuning;
        const float time = (float)wave->steps * tuning->time;
        if (tuning->ratio != 0.0f && steady == STEADY && (x->marks & INDUCTANCE_KNOWN) != 0u &&
            bounds_within(x->omega, INDUCTANCE_R_SPEED_MAX)) {
            learn(tuning, time, resistance_said(x), &x->resistance, &x->resistance_rate);
            learnt = true;
        }
        if (is_trusted(x, said) && loaded(x, x->mean.q) &&
            shows(x, bounds_magnitude(omega_smooth), x->mean.q)) {
            learn(tuning, time, said, &x->learnt, &x->rate);
            learnt = true;
            x->look.kept = x->confidence > CERTAIN ? x->learnt.value : x->look.kept;
        }
    }
    x->said = said;
    look(x, said > 0.0f, learnt, bounds_magnitude(omega_smooth));
}

/* Takes the EMF along d [V] into its low-pass; the rest of it [V]. */
static float beyond_mean(inductance_t *x, float e_d)
{
    x->emf_mean.d = lowpass_step(x->emf_mean.d, x->tuning.mean_share, e_d);
    return e_d - x->emf_mean.d;
}

/* The high-passed voltage along d of a salient rotor [V], without that of the flux that the observer's L_q
 * does not have, and without (L_q - L_d) i_q d(turned)/dt: its flux changes because the current turns with
 * the loop, by which x->turned was `before` at the last step. The speed is that of the rotor, constant in a
 * cycle: the smooth speed of the loop moves with the dither while the drive brakes (docs/theory.md, 24). */
static float salient_drop(inductance_t *x, const inductance_input_t *input, float before)
{
    const inductance_tuning_t *tuning = &x->tuning;
    const float known = x->omega * flux_beyond(tuning, input->current.q);
    const float moved = (tuning->observed_q - tuning->inductance_d) * x->mean.q;
    return beyond_mean(x, input->emf.d + known) - moved * (x->turned - before) / tuning->time;
}

/* The part of the mean of i_q [A] that comes from a change of i_d from one step to the next [A]. The mean is
 * that of a vector that turns by omega T in the step. While i_d rises, the vectors at the end of the step are
 * longer, and they point ahead of the middle. The integral of omega t di_d/dt t over the step is omega T/12
 * of the change. */
static float turned_part(const inductance_t *x, float change)
{
    return TWELFTH * x->tuning.time * x->omega * change;
}

void inductance_step(inductance_t *x, const inductance_input_t *input)
{
    const float share = x->tuning.mean_share;
    if (x->left == 0u && !begin(x, input)) {
        return;
    }
    x->emf_mean.q = lowpass_step(x->emf_mean.q, share, input->emf.q);
    x->mean.d = lowpass_step(x->mean.d, share, input->current.d);
    x->mean.q = lowpass_step(x->mean.q, share, input->current.q);
    const float step = x->tuning.wave[x->which].step;
    const float s = inductance_wave_at(x->t);
    const float c = inductance_wave_at(inductance_later(x->t, 0.5f));
    const float t = inductance_later(x->t, x->tuning.ahead * step);
    const float given = inductance_wave_at(t);
    const float d = x->current * given;
    x->dither = (dq_t){d, x->along * d + x->swing.against_s * given +
                              x->swing.against_c * inductance_wave_at(inductance_later(t, 0.5f))};
    const float i_d = input->current.d - x->mean.d;
    const float i_q = input->current.q - x->mean.q - x->along * i_d - turned_part(x, i_d - x->swing.i_d);
    x->swing.i_d = i_d;
    const float e_q = input->emf.q - x->emf_mean.q;
    x->sum.emf += e_q * s;
    x->sum.emf_c += e_q * c;
    x->sum.answer += i_d * s;
    x->sum.answer_c += i_d * c;
    x->sum.square += i_d * i_d;
    x->swing.s += i_q * s;
    x->swing.c += i_q * c;
    const float moved = angle_wrap(input->theta - x->theta) - x->tuning.time * x->omega;
    x->theta = input->theta;
    const float before = x->turned;
    x->turned = (1.0f - share) * (x->turned + moved);
    const float e_d = x->along == 0.0f ? beyond_mean(x, input->emf.d) : salient_drop(x, input, before);
    const float drop = e_d - 0.5f * x->flux * x->omega * (before + x->turned);
    x->sum.drop += drop * s;
    x->sum.drop_c += drop * c;
    x->sum.detector += bounds_magnitude(input->detector);
    if (!input->sound) {
        x->marks &= ~INDUCTANCE_SOUND;
    }
    x->t += step;
    x->left--;
    if (x->left == 0u) {
        end(x, input->omega_smooth);
    }
}
