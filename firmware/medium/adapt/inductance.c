#include "medium/adapt/inductance.h"

#include "math/angle.h"
#include "math/periods.h"
#include "medium/adapt/gain.h"

#define TWO_PI        6.2831853f
#define TRUST         0.2f /* [-] change of the confidence by a cycle that agrees with the one before */
#define CONFIDENT     0.5f /* [-] confidence from which the result of a cycle is used */
#define WAVE_SQUARE   0.53333333f                             /* mean of s^2 [-] */
#define SHARE_MAX     0.5f                                    /* [-] */
#define TORQUE_MIN    (INDUCTANCE_TORQUE / INDUCTANCE_DITHER) /* [-] of the dither: least i_q */
#define ANSWER_MIN    0.5f                                    /* [-] of the commanded i_d */
#define ANSWER_MAX    1.5f                                    /* [-] of the commanded i_d */
#define EMF_MIN       0.5f                                    /* [-] of psi_f |omega| */
#define SETTLED       0.2f /* [-] of the initial rate: at this rate R has been learnt for long enough */
#define PLAUSIBLE_MAX 3.0f /* [-] of the parameter: largest L that a noisy cycle can give */
#define CONDITION     0.5f /* [-] least area of U and V over that without a swing of i_q */

static inductance_wave_t wave_of(const inductance_params_t *params, float frequency)
{
    const float step = (float)params->every * params->period;
    const uint32_t steps = (uint32_t)(1.0f / (frequency * step) + 0.5f);
    const float count = (float)steps;
    const float omega = TWO_PI * frequency;
    const float passed = omega * omega / (omega * omega + INDUCTANCE_CUTOFF * INDUCTANCE_CUTOFF);
    return (inductance_wave_t){
        .steps = steps,
        .step = 2.0f / count,
        .omega = TWO_PI / (count * step),
        .turn_share = count * step / TWO_PI,
        .per_sum = 1.0f / (passed * WAVE_SQUARE * count),
    };
}

inductance_tuning_t inductance_prepare(const inductance_params_t *params)
{
    const float step = (float)params->every * params->period;
    return (inductance_tuning_t){
        .wave = {wave_of(params, INDUCTANCE_FREQUENCY_1), wave_of(params, INDUCTANCE_FREQUENCY_2),
                 wave_of(params, INDUCTANCE_FREQUENCY_3)},
        .rate = params->inductance_q > INDUCTANCE_SALIENT_MAX * params->inductance_d ? 0.0f : params->rate,
        .from = params->from,
        .inductance_q = params->inductance_q,
        .saliency = params->inductance_d - params->inductance_q,
        .ratio = params->inductance_q / params->inductance_d,
        .resistance = params->resistance,
        .resistance_from = params->resistance_from,
        .flux_linkage = params->flux_linkage,
        .current = INDUCTANCE_DITHER * params->current_max,
        .moved = INDUCTANCE_MOVED * params->current_max,
        .look = periods_of(INDUCTANCE_LOOK, step),
        .rest = periods_of(INDUCTANCE_REST, step),
        .mean_share = lowpass_share(INDUCTANCE_CUTOFF, step),
        .time = step,
        .ahead = (float)params->ahead,
    };
}

static void start(inductance_t *x)
{
    x->learnt = (learnt_value_t){x->tuning.from, x->tuning.from};
    x->resistance = (learnt_value_t){x->tuning.resistance_from, x->tuning.resistance_from};
    x->rate = x->tuning.rate;
    x->resistance_rate = x->tuning.rate;
    x->look.looked = 0u;
    x->look.rests = 0u;
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

/* True if i_q [A] makes enough torque that L affects the result. */
static bool loaded(const inductance_t *x, float i_q)
{
    return !bounds_within(i_q, TORQUE_MIN * x->tuning.current);
}

/* True if the electrical frequency is so near that motion and L can hardly be told apart. All in [rad/s]. */
static bool is_near_first(float frequency, float omega)
{
    return bounds_within(frequency - INDUCTANCE_FIRST_SHARE * omega, INDUCTANCE_FIRST_REACH * frequency);
}

/* True if a multiple of the electrical frequency is too near, `reach` for the sixth. All in [rad/s]. */
static bool is_disturbed(float frequency, float omega, float reach)
{
    return is_near_first(frequency, omega) ||
           bounds_within(frequency - 2.0f * omega, TWO_PI * INDUCTANCE_NEAR) ||
           bounds_within(frequency - 6.0f * omega, reach);
}

/* The frequency at this speed [rad/s]: the first one that is not near one, two or six times the electrical
 * one, and without torque not near five or seven times either. Near one times it, the third is the next. */
static uint32_t frequency_at(float omega, bool torque)
{
    static const float frequencies[] = {TWO_PI * INDUCTANCE_FREQUENCY_1, TWO_PI * INDUCTANCE_FREQUENCY_2,
                                        TWO_PI * INDUCTANCE_FREQUENCY_3};
    const float reach = torque ? TWO_PI * INDUCTANCE_NEAR_SIXTH : TWO_PI * INDUCTANCE_NEAR + omega;
    if (!is_disturbed(frequencies[0], omega, reach)) {
        return 0u;
    }
    const uint32_t next = is_near_first(frequencies[0], omega) ? 2u : 1u;
    return is_disturbed(frequencies[next], omega, reach) ? 3u - next : next;
}

/* True if R still has to be learnt at this speed [rad/s]. */
static bool looks_for_resistance(const inductance_t *x, float speed)
{
    return speed < INDUCTANCE_R_SPEED_MAX && x->resistance_rate > SETTLED * x->tuning.rate;
}

/* A cycle has ended, with or without a result. Once the learning interval has
 * enough results, the dither pauses. */
static void look(inductance_t *x, bool said, float speed)
{
    const inductance_tuning_t *tuning = &x->tuning;
    x->look.looked += said ? tuning->wave[x->which].steps : 0u;
    if (x->look.looked >= tuning->look && x->rate <= INDUCTANCE_LOOKED * tuning->rate &&
        !looks_for_resistance(x, speed)) {
        x->look.looked = 0u;
        x->look.rests = tuning->rest;
        x->look.looked_at = x->mean.q;
    }
}

/* True if the dither pauses at this i_q [A]. */
static bool rests(inductance_t *x, float i_q)
{
    if (x->look.rests == 0u) {
        return false;
    }
    x->look.rests = bounds_within(i_q - x->look.looked_at, x->tuning.moved) ? x->look.rests - 1u : 0u;
    x->follows = 0u;
    x->dither = 0.0f;
    return x->look.rests != 0u;
}

/* Begins a cycle. false: the conditions for a result are not met. */
static bool begin(inductance_t *x, const inductance_input_t *input)
{
    const float speed = bounds_magnitude(input->omega_smooth);
    const bool torque = loaded(x, input->current.q);
    if (speed < INDUCTANCE_SPEED_MIN || !(torque || looks_for_resistance(x, speed))) {
        inductance_rest(x);
        return false;
    }
    if (!looks_for_resistance(x, speed) && rests(x, input->current.q)) {
        return false;
    }
    if (x->follows == 0u) {
        x->emf_mean = input->emf.q;
        x->emf_d_mean = input->emf.d;
        x->turned = 0.0f;
        x->theta = input->theta;
        x->mean = input->current;
    }
    x->follows = 0u;
    x->which = frequency_at(speed, torque);
    x->left = x->tuning.wave[x->which].steps;
    x->sound = 1u;
    x->voltage_known = input->voltage_known ? 1u : 0u;
    x->t = -1.0f;
    x->omega = input->omega_smooth;
    x->emf_from = x->emf_mean;
    x->sum = (inductance_sums_t){0};
    return true;
}

/* True if the rotor turned and the loop followed it in the cycle that ends now. */
static bool is_locked(const inductance_t *x, const inductance_wave_t *wave, float speed)
{
    const bool turns = speed > INDUCTANCE_SPEED_MIN &&
                       bounds_magnitude(x->emf_mean) > EMF_MIN * x->tuning.flux_linkage * speed;
    return turns && x->sum.detector < INDUCTANCE_DETECTOR_MAX * (float)wave->steps;
}

/* The errors of L_d against the assumed L_q [H] and of R [ohm] that a cycle shows. */
typedef struct {
    float inductance, resistance;
} inductance_errors_t;

/* Im(conj(a) b): the area between both, in the product of their units. */
static float beside(inductance_phasor_t a, inductance_phasor_t b)
{
    return a.s * b.c - a.c * b.s;
}

/* a - j share b, share being omega/W [-]: what is left if b is the speed that belongs to the angle a. */
static inductance_phasor_t less_motion(inductance_phasor_t a, float share, inductance_phasor_t b)
{
    return (inductance_phasor_t){a.s + share * b.c, a.c - share * b.s};
}

/* The solution of Z = dR U + dL_d V (inductance.h). If i_q swings so that U lies along V, its swing is left
 * out: U = I_d. */
static inductance_errors_t errors_of(const inductance_t *x, const inductance_wave_t *wave, float omega)
{
    const float share = omega * wave->turn_share;
    const float turn = wave->omega - omega * share;
    const inductance_phasor_t i_d = x->sum.i_d;
    const inductance_phasor_t z = less_motion(x->sum.across, share, x->sum.emf);
    const inductance_phasor_t v = {-turn * i_d.c, turn * i_d.s};
    inductance_phasor_t u = less_motion(i_d, share, x->sum.i_q);
    float area = beside(u, v);
    const float square = beside(i_d, v);
    if (!(area * square > CONDITION * square * square)) {
        u = i_d;
        area = square;
    }
    const float per_area = 1.0f / area;
    return (inductance_errors_t){per_area * beside(u, z), -per_area * beside(v, z)};
}

/* L_q from this error [H]; 0: it is not plausible. */
static float said_by(const inductance_tuning_t *tuning, float error)
{
    const float said = tuning->inductance_q + tuning->ratio * (error - tuning->saliency);
    return said > 0.0f && said < PLAUSIBLE_MAX * tuning->from ? said : 0.0f;
}

/* True if this result [H] of a cycle may be used. */
static bool is_trusted(inductance_t *x, float said)
{
    const bool agrees = bounds_within(said - x->said, INDUCTANCE_AGREES * x->learnt.value);
    x->confidence = lowpass_step(x->confidence, TRUST, agrees ? 1.0f : 0.0f);
    x->said = said;
    return agrees && x->confidence > CONFIDENT;
}

/* A value follows the result of a cycle of this time [s] by its rate, which falls; it stays between half and
 * twice the parameter from which it started. */
static void learn(const inductance_tuning_t *tuning, float time, float said, learnt_value_t *learnt,
                  float *rate)
{
    const float share = *rate * time;
    const float next = lowpass_step(learnt->value, share < SHARE_MAX ? share : SHARE_MAX, said);
    const float least = INDUCTANCE_MIN * learnt->from;
    const float most = INDUCTANCE_MAX * learnt->from;
    learnt->value = next < most ? (next > least ? next : least) : most;
    *rate = gain_step(*rate, tuning->rate, time);
}

/* R from this error [ohm]. */
static float resistance_said(const inductance_t *x, float error)
{
    return x->tuning.resistance + bounds_clamp(error, x->resistance.from);
}

/* How steady the speed was in a cycle: RIPPLED is accepted for a light rotor, STEADY by all laws. */
typedef enum { UNSTEADY, RIPPLED, STEADY } steadiness_t;

static steadiness_t steadiness(const inductance_t *x, float omega)
{
    const float drift = bounds_magnitude(omega - x->omega);
    const float speed = bounds_magnitude(omega);
    if (drift <= INDUCTANCE_R_SPEED_DRIFT * speed) {
        return STEADY;
    }
    return drift <= INDUCTANCE_SPEED_DRIFT * speed && x->voltage_known != 0u && loaded(x, x->mean.q)
               ? RIPPLED
               : UNSTEADY;
}

static void end(inductance_t *x, float omega_smooth)
{
    const inductance_tuning_t *tuning = &x->tuning;
    const inductance_wave_t *wave = &tuning->wave[x->which];
    const float told = tuning->current;
    const float answer = wave->per_sum * x->sum.i_d.s;
    const float speed = bounds_magnitude(omega_smooth);
    const steadiness_t steady = steadiness(x, omega_smooth);
    x->follows = x->sound != 0u && answer > ANSWER_MIN * told && answer < ANSWER_MAX * told;
    float said = 0.0f;
    if (steady != UNSTEADY && x->follows != 0u && is_locked(x, wave, speed)) {
        const float time = (float)wave->steps * tuning->time;
        const inductance_errors_t errors = errors_of(x, wave, omega_smooth);
        said = said_by(tuning, errors.inductance);
        if (said > 0.0f && steady == STEADY && x->voltage_known != 0u &&
            bounds_within(x->omega, INDUCTANCE_R_SPEED_MAX)) {
            learn(tuning, time, resistance_said(x, errors.resistance), &x->resistance, &x->resistance_rate);
        }
        if (said > 0.0f && is_trusted(x, said) && loaded(x, x->mean.q)) {
            learn(tuning, time, said, &x->learnt, &x->rate);
        }
    }
    look(x, said > 0.0f, speed);
}

/* The wave of the dither at t, -1..1. */
static float wave_at(float t)
{
    return 4.0f * t * (1.0f - bounds_magnitude(t));
}

/* The position in the wave that lies `by` later. */
static float later(float t, float by)
{
    const float next = t + by;
    return next < 1.0f ? next : next - 2.0f;
}

static void add(inductance_phasor_t *sum, float value, float s, float c)
{
    sum->s += value * s;
    sum->c += value * c;
}

void inductance_step(inductance_t *x, const inductance_input_t *input)
{
    const float share = x->tuning.mean_share;
    if (x->left == 0u && !begin(x, input)) {
        return;
    }
    x->emf_mean = lowpass_step(x->emf_mean, share, input->emf.q);
    x->mean.d = lowpass_step(x->mean.d, share, input->current.d);
    x->mean.q = lowpass_step(x->mean.q, share, input->current.q);
    x->emf_d_mean = lowpass_step(x->emf_d_mean, share, input->emf.d);
    const float s = wave_at(x->t);
    const float c = wave_at(later(x->t, 0.5f));
    x->dither = x->tuning.current * wave_at(later(x->t, x->tuning.ahead * x->tuning.wave[x->which].step));
    const float moved = angle_wrap(input->theta - x->theta) - x->tuning.time * x->omega;
    x->theta = input->theta;
    x->turned = (1.0f - share) * (x->turned + moved);
    add(&x->sum.across, input->emf.d - x->emf_d_mean - x->emf_from * x->turned, s, c);
    add(&x->sum.emf, input->emf.q - x->emf_mean, s, c);
    add(&x->sum.i_d, input->current.d - x->mean.d, s, c);
    add(&x->sum.i_q, input->current.q - x->mean.q, s, c);
    x->sum.detector += bounds_magnitude(input->detector);
    if (!input->sound) {
        x->sound = 0u;
    }
    x->t += x->tuning.wave[x->which].step;
    x->left--;
    if (x->left == 0u) {
        end(x, input->omega_smooth);
    }
}
