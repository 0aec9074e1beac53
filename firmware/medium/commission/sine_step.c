#include "medium/commission/sine_step.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/periods.h"
#include "math/root.h"
#include "math/trig.h"

#define BLOCK       0.1f /* [s] of a mean, and of a run at least */
#define BLOCKS_MOST 4.0f /* of a run with a small current [-] */
#define SCATTER                                                                                              \
    1.3e-3f /* standard error of the sine's amplitude by the noise of a sensor, relative: the gains of the   \
               sensors have up to 1.1 % of the 1.5 % that L_d may be wrong; three standard errors are the    \
               rest [-] */
#define BLOCKS_FINE 10.0f /* the same of the two runs that are compared ... */
#define SCATTER_FINE                                                                                         \
    3.2e-4f /* ... for the saturation: BENT and RESULT standard errors of both together are then below       \
               3/4 WRONG (MORE^2 - AMPLITUDE^2), so that a linear axis can be called linear */
#define SETTLE        0.08f  /* [s] before a run */
#define FREQUENCY     500.0f /* [Hz] */
#define FREQUENCY_LOW 250.0f /* [Hz] across, at least, where the link does not drive a large L at 500 Hz */
#define LOWER         0.7f   /* second frequency across, over the first [-] */
#define VOLTAGE_LEAST 3.0f   /* [V] below it the frequency is doubled */
#define VOLTAGE_MOST  0.2f   /* of the DC link [-] */
#define AMPLITUDE     0.2f   /* of the current, over the standing one [-] */
#define MORE          0.45f  /* of the current, for the saturation, at most ... */
#define MORE_LEAST    0.3f   /* ... and at least, else it is not measured [-] */
#define REACHED       0.9f   /* of that, which the link has to drive [-] */
#define MORE_VOLTAGE  0.4f   /* of the DC link, across [-] */
#define WAY                                                                                                  \
    (2.0f / 3.0f) /* way of the standing current in a run: two steps of a converter, three of which are      \
                     noise_max [-] */
#define CLEAR        1.2f    /* zones that a phase keeps from zero current [-] */
#define BENT         2.5e-3f /* least relative change of L that counts as saturation ... */
#define BENT_SCATTER 3.0f    /* ... and standard errors of it [-] */
#define RESULT       2.5f    /* standard errors of the change that count as its error [-] */
#define FRICTION                                                                                             \
    0.5f /* error of the change of L by the motion, relative: friction makes it depend on the amplitude */
#define WRONG 0.03f /* error of L_q at the rated current from which on I_s is not known, relative [-] */
#define PROBE 0.35f /* of the voltage, while L is a guess [-] */
#define GAIN_APART                                                                                           \
    0.02f /* (g_a - g_b)/sqrt(3) of wrong sensors: gains of up to 1.1 % have 0.0127, and three standard      \
             errors SCATTER by the noise 0.004 [-] */
#define GAIN_ASIDE    2.0f /* answer of a rotor aside, not shaken, beyond that of a shaken one, relative [-] */
#define CROSS_MOST    0.15f /* current across the sine over that along it, for an aligned rotor [-] */
#define LESS          0.6f  /* of the current, after an unstable alignment [-] */
#define LOWERED_MOST  2u
#define SALIENCY_MOST 10.0f
#define THREE_EIGHTHS 0.375f
#define THE_NEXT      0.234375f   /* 15/64 */
#define ACROSS        0.05f       /* current across over that along of a rotor at rest [-] */
#define SIXTH_TURN    1.04719755f /* [rad] */

/* The runs: direction of the sine, standing current, frequency. The first run of each axis determines the
 * voltage for the next ones. */
typedef struct {
    bool across;     /* true: across the standing current */
    bool probe;      /* true: L is not measured yet */
    float bias;      /* [-] of the standing current */
    float frequency; /* [-] of FREQUENCY */
} sine_run_t;
static const sine_run_t runs[] = {
    {false, true, 1.0f, 1.0f}, {false, false, 1.0f, 1.0f}, {false, false, 0.6f, 1.0f},
    {true, true, 1.0f, 1.0f},  {true, false, 1.0f, 1.0f},  {true, false, 1.0f, LOWER},
    {true, false, 1.0f, 1.0f},
};
#define RUN_D_MOST  1u
#define RUN_D       2u
#define RUN_Q       4u
#define RUN_Q_LOWER 5u
#define RUN_Q_MORE  6u /* a larger amplitude, for the saturation */

void sine_step_begin(sine_step_t *step)
{
    *step = (sine_step_t){.phase = (int32_t)SINE_BEGIN};
}

float sine_solve(sine_sum_t voltage, sine_sum_t current, rotation_t turn, const commission_tuning_t *tuning)
{
    const sine_sum_t before = {turn.cos * current.re + turn.sin * current.im,
                               turn.cos * current.im - turn.sin * current.re};
    const float det = before.re * voltage.im - before.im * voltage.re;
    if (!(bounds_magnitude(det) > 0.0f)) {
        return 0.0f;
    }
    const float a = (current.re * voltage.im - current.im * voltage.re) / det;
    const float b = (before.re * current.im - before.im * current.re) / det;
    const float root = root_or_none(a);
    if (!(b > 0.0f && root > 0.0f)) {
        return 0.0f;
    }
    /* r = R T/L = -ln a = 2 artanh y; what the series leave out is below 1e-4 for L/R of two periods */
    const float y = (1.0f - a) / (1.0f + a);
    const float r = y * (2.0f + y * y * (2.0f / 3.0f + y * y * 0.4f));
    return (tuning->period + tuning->edge_delay * r) / b * root * (1.0f + r * r * (1.0f / 32.0f));
}

/* 1/(L_q I_s)^2 [1/Wb^2] from L and the amplitude of the flux of two runs, the second with more flux. Not
 * positive: no saturation. */
static float saturation_from(float l_less, float flux_less, float l_more, float flux_more)
{
    const float less = flux_less * flux_less;
    const float more = flux_more * flux_more;
    float s = 0.0f;
    for (uint32_t n = 0u; n < 6u; n++) {
        const float of_less = 1.0f + s * less * (THREE_EIGHTHS + THE_NEXT * s * less);
        s = (l_less / l_more * of_less - 1.0f) / (more * (THREE_EIGHTHS + THE_NEXT * s * more));
    }
    return s;
}

/* The standing current of the present window [A]. It moves by two steps of the converter in a run, which is
 * one step of the phases b and c. A sine of A steps about the current c (in steps) is read with the relative
 * error 2 J_1(2 pi A)/(pi A) cos(2 pi c), 1.4 % for 6 steps without noise. Its mean over a whole step of c is
 * zero, and so is that of all other terms, which contain cos(2 pi n c) and sin(2 pi n c). */
static float standing_now(const sine_step_t *step, const commission_tuning_t *tuning)
{
    const float from = (float)periods_of(SETTLE, tuning->window);
    const float share = ((float)step->windows - from) / (float)step->length;
    return runs[step->run].bias * step->current + WAY * tuning->noise_max * (share - 0.5f);
}

/* Amplitude of a run, divided by its standing current [-]; 0: the run is left out. The phases b and c carry
 * half of the standing current and sqrt(3)/2 of the amplitude; neither the ripple nor the zone may bring them
 * to zero. */
static float amplitude_of(const sine_step_t *step, const commission_tuning_t *tuning,
                          const commission_results_t *results, float u_dc)
{
    if (step->run != RUN_Q_MORE) {
        return AMPLITUDE;
    }
    const float inductance = bounds_less(step->guess_d, step->guess_q);
    const float ripple = u_dc * tuning->period / (24.0f * inductance);
    const float moves = 0.25f * WAY * tuning->noise_max; /* standing_now() */
    const float clear = 0.5f - (CLEAR * results->current_zone + ripple + moves) / step->current;
    const float most = bounds_less(2.0f * FRAMES_ONE_OVER_SQRT_3 * clear, MORE);
    return most >= MORE_LEAST ? most : 0.0f;
}

/* Noise of a sensor [A]; the largest one that is permitted if the step `board` has not been run. */
static float noise_of(const commission_tuning_t *tuning, const commission_results_t *results)
{
    return results->noise > 0.0f ? results->noise : tuning->noise_max;
}

/* Windows of a run: as many as the mean over the noise needs, sqrt(2/N) noise/amplitude. */
static uint32_t length_of(uint32_t run, float amplitude, const commission_tuning_t *tuning,
                          const commission_results_t *results)
{
    const bool fine = run == RUN_Q || run == RUN_Q_MORE;
    const float error = noise_of(tuning, results) / ((fine ? SCATTER_FINE : SCATTER) * amplitude);
    const float blocks = 2.0f * error * error * tuning->period * (1.0f / BLOCK);
    const float most = fine ? BLOCKS_FINE : BLOCKS_MOST;
    return periods_of(BLOCK * bounds_less(bounds_more(blocks, 1.0f), most), tuning->window);
}

/* [Hz] of a sine that reaches the amplitude for the saturation with this voltage; `flux`: L_q times the
 * standing current [Wb]. */
static float frequency_across(float flux, float voltage)
{
    return bounds_more(bounds_less(voltage / (ANGLE_TWO_PI * MORE * flux), FREQUENCY), FREQUENCY_LOW);
}

/* Orders a run: a whole number of periods of the sine. */
static void prepare(sine_step_t *step, const commission_tuning_t *tuning, const commission_input_t *input,
                    const commission_results_t *results, excite_order_t *order)
{
    const sine_run_t *run = &runs[step->run];
    const float bias = run->bias * step->current;
    const float share = amplitude_of(step, tuning, results, input->u_dc);
    const float most = (run->across ? MORE_VOLTAGE : VOLTAGE_MOST) * input->u_dc;
    const bool same = step->run == RUN_Q_MORE; /* frequency and motion of the rotor as in RUN_Q */
    const float inductance = same ? step->value[RUN_Q] : run->across ? step->guess_q : step->guess_d;
    step->length =
        run->probe ? periods_of(BLOCK, tuning->window) : length_of(step->run, share * bias, tuning, results);
    const float block = (float)step->length * tuning->window;
    float frequency = same          ? step->turn_q / (ANGLE_TWO_PI * tuning->period)
                      : run->across ? run->frequency * frequency_across(bias * inductance, most)
                                    : run->frequency * FREQUENCY;
    float voltage = 0.0f;
    for (uint32_t n = 0u; n < 2u && voltage < VOLTAGE_LEAST; n++) {
        const float reactance = ANGLE_TWO_PI * frequency * inductance;
        voltage =
            share * bias * root_or_none(results->resistance * results->resistance + reactance * reactance);
        frequency *= voltage < VOLTAGE_LEAST && n == 0u && !same ? 2.0f : 1.0f;
    }
    const float cycles = (float)(uint32_t)(frequency * block + 0.5f);
    order->turn = ANGLE_TWO_PI * cycles * tuning->period / block;
    step->turn_q = step->run == RUN_Q ? order->turn : step->turn_q;
    step->turn_lower = step->run == RUN_Q_LOWER ? order->turn : step->turn_lower;
    order->voltage = bounds_less((run->probe ? PROBE : 1.0f) * voltage, most);
    order->sine_across = run->across ? 1u : 0u;
    step->windows = 0u;
    order->current = standing_now(step, tuning);
    step->voltage = (sine_sum_t){0.0f, 0.0f};
    step->along = (sine_sum_t){0.0f, 0.0f};
    step->across = (sine_sum_t){0.0f, 0.0f};
}

static float axis_of(dq_t sum, bool q)
{
    return q ? sum.q : sum.d;
}

static void add(sine_step_t *step, const excite_seen_t *seen)
{
    const bool across = runs[step->run].across;
    sine_sum_add(&step->voltage, axis_of(seen->voltage_cos, across), axis_of(seen->voltage_sin, across));
    sine_sum_add(&step->along, axis_of(seen->current_cos, across), axis_of(seen->current_sin, across));
    sine_sum_add(&step->across, axis_of(seen->current_cos, !across), axis_of(seen->current_sin, !across));
}

static float length_square(sine_sum_t number)
{
    return number.re * number.re + number.im * number.im;
}

/* Variance of the relative error of L by the noise. */
static float variance_of(uint32_t run, const sine_step_t *step, const commission_tuning_t *tuning,
                         const commission_results_t *results)
{
    const float swing = step->swing[run];
    const float samples = (float)length_of(run, swing, tuning, results) * tuning->window / tuning->period;
    const float share = noise_of(tuning, results) / swing;
    return 2.0f * share * share / samples;
}

/* Returns I_s [A], and stores L_q without current in the results. 0: it is not known whether L_q depends on
 *the current.
 *
 * A relative change `bent` from the amplitude A_1 to A_2 is 3/8 (A_2^2 - A_1^2)/I_s^2, and L_q at the rated
 * current I is lower by 1/2 I^2/I_s^2: by 4/3 I^2/(A_2^2 - A_1^2) times `bent`. With this factor the errors
 * of `bent`, and a change that is too small to be detected, become errors of L_q. */
static float saturation_of(const sine_step_t *step, const commission_tuning_t *tuning,
                           commission_results_t *results)
{
    const float less = step->value[RUN_Q];
    const float more = step->value[RUN_Q_MORE];
    const float swing = step->swing[RUN_Q];
    const float swing_more = step->swing[RUN_Q_MORE];
    if (!(more > 0.0f && swing_more > REACHED * MORE_LEAST * step->current)) {
        return 0.0f;
    }
    const float bent = (less - more) / results->inductance_q;
    const float moved = results->inductance_q - less; /* by the motion of the rotor */
    const float error = root_or_none(variance_of(RUN_Q, step, tuning, results) +
                                     variance_of(RUN_Q_MORE, step, tuning, results));
    const float seen = bounds_more(BENT, BENT_SCATTER * error);
    const float rated = results->current_hold;
    const float wrong = WRONG * 0.75f * (swing_more * swing_more - swing * swing); /* over I^2, of bent */
    if (!(bent > seen)) { /* the true change can be larger than the measured one by its error */
        return (seen + RESULT * error) * rated * rated < wrong ? SINE_LINEAR : 0.0f;
    }
    if (!(bounds_more(RESULT * error, FRICTION * moved / results->inductance_q) * rated * rated < wrong)) {
        return 0.0f;
    }
    const float flux = results->inductance_q * swing;
    const float s = saturation_from(results->inductance_q, flux, more + moved, (more + moved) * swing_more);
    results->inductance_q *= 1.0f + s * flux * flux * (THREE_EIGHTHS + THE_NEXT * s * flux * flux);
    const float root = root_or_none(s);
    return root > 0.0f ? 1.0f / (results->inductance_q * root) : SINE_LINEAR;
}

static commission_verdict_t judge(const sine_step_t *step, const commission_tuning_t *tuning,
                                  commission_results_t *results)
{
    const float first = step->turn_q * step->turn_q;
    const float second = step->turn_lower * step->turn_lower;
    const float inductance_q =
        (step->value[RUN_Q] * first - step->value[RUN_Q_LOWER] * second) / (first - second);
    const float inductance_d = step->value[RUN_D];
    if (!(inductance_q > 0.4f * inductance_d && inductance_q < SALIENCY_MOST * inductance_d)) {
        return commission_failed(COMMISSION_REASON_INDUCTANCE_IMPLAUSIBLE, 0);
    }
    results->current_aligned = step->current;
    results->inductance_d = inductance_d;
    results->inductance_d_least = step->value[RUN_D_MOST];
    results->inductance_q = inductance_q;
    results->saturation_current = saturation_of(step, tuning, results);
    return bounds_less(inductance_d, inductance_q) < 2.0f * tuning->period * results->resistance
               ? commission_failed(COMMISSION_REASON_TIME_CONSTANT_SHORT, 0)
               : commission_finished();
}

/* Amplitude of the current along the sine of this run [A]. */
static float amplitude_seen(const sine_step_t *step, const commission_tuning_t *tuning)
{
    const float samples = (float)step->length * tuning->window / tuning->period;
    return 2.0f * root_or_none(length_square(step->along)) / samples;
}

/* Current across the sine over that along it, in phase [-]. */
static float beside_of(const sine_step_t *step)
{
    return (step->across.re * step->along.re + step->across.im * step->along.im) / length_square(step->along);
}

/* True if the sensors have different gains: a voltage along d and one along q have different answers across
 * them. A rotor that is aligned with the true current then answers with the other sign than the sensors. With
 * the same sign a load holds it aside; the sine across shakes it, so that it may be less aside in that run.
 */
static bool gains_differ(const sine_step_t *step)
{
    const float along = step->beside[RUN_D];
    const float rotor = step->beside[RUN_Q] * step->value[RUN_D] / step->value[RUN_Q];
    const float aside = bounds_more(along < 0.0f ? -rotor : rotor, 0.0f);
    return !bounds_within(along - rotor, GAIN_APART + GAIN_ASIDE * aside);
}

/* A window of a run. */
static commission_verdict_t run_on(sine_step_t *step, const commission_tuning_t *tuning,
                                   const commission_input_t *input, excite_order_t *order,
                                   commission_results_t *results)
{
    const uint32_t from = periods_of(SETTLE, tuning->window);
    step->windows++;
    order->current = standing_now(step, tuning);
    if (step->windows > from) {
        add(step, input->seen);
    }
    if (step->windows < from + step->length) {
        return commission_goes_on();
    }
    const rotation_t turn = trig_turn(order->turn);
    const float inductance = sine_solve(step->voltage, step->along, turn, tuning);
    if (!(inductance > 0.0f)) {
        return commission_failed(COMMISSION_REASON_INDUCTANCE_IMPLAUSIBLE, 0);
    }
    step->value[step->run] = inductance;
    step->swing[step->run] = amplitude_seen(step, tuning);
    results->point = (commission_point_t){
        runs[step->run].across ? -step->swing[step->run] : step->swing[step->run], inductance};
    step->beside[step->run] = beside_of(step);
    const bool leaves = !runs[step->run].probe &&
                        length_square(step->across) > CROSS_MOST * CROSS_MOST * length_square(step->along);
    if (step->run == RUN_Q_MORE) {
        step->value[RUN_Q_MORE] = leaves ? 0.0f : inductance;
        return judge(step, tuning, results);
    }
    if (leaves) {
        if (step->lowered == LOWERED_MOST) {
            return commission_failed(COMMISSION_REASON_ALIGNMENT_UNSTABLE, 0);
        }
        step->lowered++;
        step->current *= LESS;
        step->run = 0u;
    } else {
        step->guess_d = runs[step->run].across ? step->guess_d : inductance;
        step->guess_q = inductance;
        if (step->run == RUN_Q && gains_differ(step)) {
            return commission_failed(COMMISSION_REASON_SENSOR_GAIN, 0);
        }
        step->run++;
    }
    if (step->run == RUN_Q_MORE && !(amplitude_of(step, tuning, results, input->u_dc) > 0.0f)) {
        return judge(step, tuning, results);
    }
    prepare(step, tuning, input, results, order);
    return commission_goes_on();
}

static commission_verdict_t begin(sine_step_t *step, const commission_tuning_t *tuning,
                                  const commission_input_t *input, excite_order_t *order,
                                  const commission_results_t *results)
{
    if (!(results->resistance > 0.0f && results->inductance_pulse > 0.0f)) {
        return commission_failed(COMMISSION_REASON_EARLIER_STEP, 0);
    }
    step->current = results->current_hold;
    step->guess_d = results->inductance_pulse;
    step->guess_q = results->inductance_pulse;
    standing_begin(&step->standing, -SIXTH_TURN, input->u_dc, tuning, results, order);
    order->current = step->current;
    step->phase = (int32_t)SINE_ALIGN;
    return commission_goes_on();
}

commission_verdict_t sine_step(sine_step_t *step, const commission_tuning_t *tuning,
                               const commission_input_t *input, excite_order_t *order,
                               commission_results_t *results)
{
    if (step->phase == (int32_t)SINE_BEGIN) {
        return begin(step, tuning, input, order, results);
    }
    if (input->seen->serial != order->serial) {
        return commission_goes_on();
    }
    if (step->phase == (int32_t)SINE_RUNS) {
        return run_on(step, tuning, input, order, results);
    }
    if (step->phase == (int32_t)SINE_TURN) {
        if (standing_turn(&step->standing, 0.0f, tuning, input->seen, order)) {
            standing_wait(&step->standing);
            step->phase = (int32_t)SINE_STILL;
        }
        return commission_goes_on();
    }
    const standing_want_t want = {periods_of(BLOCK, tuning->window), order->current, ACROSS * order->current};
    const standing_state_t state = standing_step(&step->standing, want, input->seen);
    if (state != STANDING_STEADY) {
        return standing_verdict(state);
    }
    step->phase = (int32_t)(step->phase == (int32_t)SINE_ALIGN ? SINE_TURN : SINE_RUNS);
    if (step->phase == (int32_t)SINE_RUNS) {
        prepare(step, tuning, input, results, order);
    }
    return commission_goes_on();
}
