#include "medium/protect/current_watch_parts.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/periods.h"
#include "math/trig.h"

#define DEAD_VECTOR  1.33333333f /* [-] of a leg's loss: the sum of three legs */
#define SMALL_TURN   0.1f        /* [rad] below it the series of sin(x)/x is exact to 1e-6 */
#define SIXTH        0.16666667f /* [-] of x^2 in this series */
#define WRONG_R      0.5f        /* [-] of R: assumed error */
#define HELD_SHARE   0.25f       /* [-] of the dead-time loss, while a current stays constant */
#define HELD_ASIDE   1.25f       /* [-] beyond it: two legs with the wrong sign, 1.5 */
#define STUCK_SHARE  0.05f       /* [-] of the range: limit of the current that must have flowed */
#define STUCK_TIME   0.4e-3f     /* [s] for which a stuck value has not changed */
#define STILL_TIME   1.2e-3f     /* [s] the same for a value near zero ... */
#define JUMP_TIME    0.6e-3f     /* [s] ... that was reached by a jump which no current can make */
#define LONG_STILL   15e-3f      /* [s] longest time without a change of a sound value while others change */
#define SILENT       16u         /* [periods] without a change of a value with a noise of NOISY_CODES */
#define NOISY_CODES  2.0f        /* [-] standard deviation */
#define QUIET        0.25f       /* [-] of the square of NOISY_CODES: one code */
#define CODES        2048.0f     /* [-] of the range */
#define BESIDE_SHARE 0.002f      /* [-] of the range: change of another sensor by then, four codes */
#define URGENT       3.0f        /* [-] of the limit: beyond it any stuck value is reported after JUMP_TIME */
#define SURPRISE     0.15f       /* [-] of the range: largest observer error of a sound current */
#define JUMP_SHARE   0.5f        /* [-] of p: error by a wrong L */
#define GAIN_SHARE   0.03f       /* [-] of the range: smallest Dp */
#define GAIN_MIN     0.65f       /* [-] assumed L 30 % too small: 0.7 */
#define GAIN_MAX     1.45f       /* [-] assumed L 30 % too large: 1.3 */
#define GAIN_RATIO   1.2f        /* [-] of two sensors, if L is the same along all axes */
#define GAIN_APART   1e-3f       /* [-] below this the ratio of two sensors is not limited */
#define GAIN_SALIENT 0.05f       /* [-] (L_q - L_d)/(L_q + L_d) from which the position of the rotor counts */
#define GAIN_AXIS    0.33333333f /* [-] half of the vector along the axis of the sensor: 3/4 of a square 1/4 */
/* [-] Dp over psi_f K |i| T_w^2/L. A rotor that the current turns from its unstable equilibrium reaches
 * omega_e^2 = 4 K |i| on the axis, and its EMF then turns by psi_f omega_e^2 T_w in a window: an error of 4
 * of these units. The ratio of m to p stays above GAIN_MIN if the error is at most 1 - GAIN_MIN of p. */
#define GAIN_SWING    (4.0f / (1.0f - GAIN_MIN))
#define GAIN_PAIR     2.5f        /* [-] of the smallest Dp^2: least Dp^2 of a sensor that is compared */
#define NONE_SHARE    0.0075f     /* [-] of the range: largest value of a phase without current */
#define CARRIES_SHARE 0.02f       /* [-] of the range: least requested current, least current of another */
#define LOSS_TIME     3.2e-3f     /* [s] */
#define FLUX_TURN     2.9f        /* [-] of psi_f: half a turn, and an assumed psi_f that is 0.3 too small */
#define SUM_SHARE     0.08f       /* [-] of the range */
#define TURN_DOUBT    3.33333333f /* [-] speed of a tracked rotor over the speed whose EMF is uncertain */
#define KNOWN         3u          /* [windows] from which on p - m of the last but one is known */

current_watch_tuning_t current_watch_prepare(const current_watch_params_t *params)
{
    const float inductance = 0.5f * (params->inductance_d + params->inductance_q);
    const float larger = bounds_more(params->inductance_d, params->inductance_q);
    const float smaller = bounds_less(params->least, bounds_less(params->inductance_d, params->inductance_q));
    const float saliency = (larger - smaller) / (larger + smaller);
    const float apart = 1.0f - 2.0f * saliency; /* from zero on the ratio of two sensors is unlimited */
    const winding_t winding = winding_prepare(params->resistance, inductance, params->period);
    const float per_speed = winding.per_volt * params->flux_linkage;
    const float least = GAIN_SHARE * params->range;
    const float noisy = NOISY_CODES / CODES * params->range;
    return (current_watch_tuning_t){
        .judged = params->judged ? 1u : 0u,
        .winding = winding,
        .per_speed = per_speed,
        .back = -0.5f * params->period,
        .dead_link = DEAD_VECTOR * winding.per_volt * params->dead_time / params->period,
        .dead = DEAD_VECTOR * winding.per_volt * params->drop,
        .per_current = WRONG_R * winding.per_volt * params->resistance,
        .flux = FLUX_TURN * params->flux_linkage / inductance,
        .slow_link = winding_slow_link(larger, params->range, params->period),
        .stuck = STUCK_SHARE * params->range,
        .beside = BESIDE_SHARE * params->range,
        .still = {[STILL_STUCK] = periods_of(STUCK_TIME, params->period),
                  [STILL_JUMP] = periods_of(JUMP_TIME, params->period),
                  [STILL_ZERO] = periods_of(STILL_TIME, params->period)},
        .long_still = periods_of(LONG_STILL, params->period),
        .noisy = noisy * noisy,
        .surprise = SURPRISE * params->range,
        .gain.least = least * least,
        .gain.pair = GAIN_PAIR * least * least,
        .gain.axis = saliency > GAIN_SALIENT ? GAIN_AXIS : 0.0f,
        .gain.ratio = GAIN_RATIO * (1.0f + 2.0f * saliency) / (apart > GAIN_APART ? apart : GAIN_APART),
        .gain.swing = GAIN_SWING * per_speed * params->per_ampere * params->period,
        .gain.min = GAIN_MIN * inductance / larger,
        .gain.max = GAIN_MAX * inductance / smaller,
        .none = NONE_SHARE * params->range,
        .carries = CARRIES_SHARE * params->range,
        .absent = (int32_t)periods_of(LOSS_TIME, params->period),
        .sum = SUM_SHARE * params->range,
        .sensors = params->three_sensors ? 3u : 2u,
    };
}

void current_watch_init(current_watch_t *watch, const current_watch_tuning_t *tuning)
{
    *watch = (current_watch_t){.tuning = *tuning};
}

void current_watch_begin(current_watch_t *watch)
{
    watch->suspected = 0u;
    watch->current = (ab_t){0.0f, 0.0f};
    watch->emf = 0.0f;
    watch->asked = 0.0f;
    watch->steered = 0u;
    watch->windows = 0u;
    watch->unknown = 0u;
    for (uint32_t n = 0; n < 3u; n++) {
        watch->phase[n] = (current_watch_phase_t){.value = 0.0f};
    }
    watch->noise = 0.0f;
    watch->all = (current_watch_gain_t){.side = 0};
    watch->pair = (current_watch_gain_t){.side = 0};
}

bool current_watch_lacks(const current_watch_t *watch, abc_t current, abc_t asked)
{
    const current_watch_tuning_t *tuning = &watch->tuning;
    float now[3];
    float wanted[3];
    spread(now, current);
    spread(wanted, asked);
    bool lacks = false;
    for (uint32_t n = 0; n < 3u; n++) {
        const current_watch_phase_t *phase = &watch->phase[n];
        const int32_t twice = 2 * phase->absent;
        const bool open = twice >= tuning->absent || -twice >= tuning->absent;
        lacks = lacks || (bounds_within(now[n], tuning->none) && bounds_within(phase->value, tuning->none) &&
                          (open || !bounds_within(wanted[n], tuning->carries)));
    }
    return lacks;
}

/* Length of the mean of a vector that turns by 2 `half` [rad] over the length of the vector: sin(half)/half.
 */
static inline float mean_of(float half, float sine)
{
    return bounds_within(half, SMALL_TURN) ? 1.0f - SIXTH * half * half : sine / half;
}

static void see_window(current_watch_window_t *window, const current_watch_t *watch,
                       const current_watch_input_t *input)
{
    const current_watch_tuning_t *tuning = &watch->tuning;
    const float periods = (float)(int32_t)input->periods;
    const ab_t current = frames_clarke(input->current);
    const ab_t given = winding_given(&tuning->winding, input->voltage, periods, watch->current, current);
    const float half = -tuning->back * periods * input->omega_e;
    const rotation_t turn = trig_turn(angle_wrap(half));
    const rotation_t middle = frames_between(turn, input->rotor);
    const float per_speed = tuning->per_speed * periods;
    const float emf = per_speed * input->omega_e;
    const float chord = emf * mean_of(half, turn.sin);
    const ab_t moved = {given.alpha + chord * middle.sin, given.beta - chord * middle.cos};
    window->periods = periods;
    window->current = current;
    spread(window->value, input->current);
    spread(window->error, frames_inverse_clarke(input->error));
    spread(window->given, frames_inverse_clarke(given));
    spread(window->moved, frames_inverse_clarke(moved));
    window->largest = 0.0f;
    for (uint32_t n = 0; n < 3u; n++) {
        const float amount = bounds_magnitude(window->value[n]);
        window->largest = amount > window->largest ? amount : window->largest;
        window->change[n] = window->value[n] - watch->phase[n].value;
    }
    window->dead = periods * (tuning->dead + tuning->dead_link * input->u_dc);
    window->resistive = tuning->per_current * periods * window->largest;
    window->emf = per_speed * input->doubt;
    window->any = bounds_magnitude(emf) + window->emf;
    window->reverse = 2.0f * bounds_magnitude(emf) + window->emf;
}

/* The present value of a sensor is suspected, and p - m was `bias` before. It must not change for this time:
 * the noise of a wire without current is one or two codes. */
static void suspect(current_watch_t *watch, uint32_t n, float value, float beside, float p, float bias,
                    current_watch_still_t near_zero)
{
    current_watch_phase_t *phase = &watch->phase[n];
    const uint32_t bit = UINT32_C(1) << n;
    watch->suspected |= bit;
    watch->biased = watch->windows >= KNOWN ? watch->biased | bit : watch->biased & ~bit;
    phase->beside = beside;
    phase->path = 0.0f;
    phase->stuck = 0.0f;
    phase->still = 0u;
    phase->held = p;
    phase->bias = bias;
    phase->emf = watch->emf;
    phase->sure = watch->tuning.still[bounds_within(value, watch->tuning.none) ? near_zero : STILL_STUCK];
}

/* True if the value has not changed for so long that it cannot be a current, while another sensor's value
 * has changed, and p went up and down. Wrong assumed values move p as well, but then the current follows
 * another law and its value changes. */
static bool stands(const current_watch_tuning_t *tuning, const current_watch_phase_t *phase, float beside)
{
    return phase->still >= tuning->long_still && phase->path > tuning->stuck &&
           !bounds_within(beside - phase->beside, tuning->beside);
}

/* True if the noise of the sensors makes so long a constant value impossible, whatever the current is. With a
 * noise of two codes a value equals the one before with the probability 1/(2 sqrt(pi) 2) = 0.14, and 16 times
 * in succession with 2e-14. */
static bool is_silent(const current_watch_tuning_t *tuning, uint32_t still, float noise)
{
    return still >= SILENT && noise >= tuning->noisy;
}

/* By how much a value that stays constant contradicts the law of the winding in this window [A]. It is the
 * largest of three: p beyond its uncertainty; the change of p since the value was first constant; and p less
 * the p - m of a window in which the value was right. The uncertain part of the EMF turns with the rotor
 * between the two windows, which are at most one window more than `still` apart. The smaller of both EMFs
 * counts, because the rotor that is assumed now may depend on the suspected sensor. */
static float contradiction(const current_watch_t *watch, uint32_t n, const current_watch_window_t *window,
                           float doubt)
{
    const current_watch_phase_t *phase = &watch->phase[n];
    const float p = window->moved[n];
    const float emf = window->emf < phase->emf ? window->emf : phase->emf;
    const float turn = -2.0f * TURN_DOUBT * watch->tuning.back * doubt; /* in a period */
    const float apart = turn * ((float)(int32_t)phase->still + window->periods);
    const float turned = (apart < 2.0f ? apart : 2.0f) * emf + HELD_SHARE * window->dead;
    const float beyond = bounds_magnitude(p) - window->dead - window->resistive - emf;
    const float changed = bounds_magnitude(p - window->periods * phase->held) - turned;
    const float biased = bounds_magnitude(p - phase->bias) - window->resistive - turned;
    const float more = beyond > changed ? beyond : changed;
    return (watch->biased >> n & 1u) != 0u && biased > more ? biased : more;
}

/* Limit of the sum that contradicts a constant value [A]. A sensor with a wrong offset shows a constant value
 * other than zero while its phase carries no current: the dead time holds the current at zero, and is
 * compensated with the wrong sign. With a noise of one code, a value equals the one before with the
 * probability 0.28, and 16 times in succession with 1e-9, whatever its current is. */
static float most_of(const current_watch_t *watch, const current_watch_phase_t *phase,
                     const current_watch_input_t *input)
{
    const current_watch_tuning_t *tuning = &watch->tuning;
    const bool lively = input->noise >= QUIET * tuning->noisy && phase->still >= SILENT;
    if (lively || bounds_within(phase->value, tuning->none)) {
        return tuning->stuck;
    }
    const float dead = tuning->dead + tuning->dead_link * input->u_dc;
    return tuning->stuck + HELD_ASIDE * dead * (float)(int32_t)phase->still;
}

/* True if a value is stuck: it has not changed by one bit in all periods of a window and the following ones,
 * and p contradicts that, or the value stays for too long. A value is suspected as well if it has jumped by
 * more than any EMF explains, or if it differs from the observer's. */
static bool is_stuck(current_watch_t *watch, uint32_t n, const current_watch_window_t *window,
                     const current_watch_input_t *input)
{
    const current_watch_tuning_t *tuning = &watch->tuning;
    current_watch_phase_t *phase = &watch->phase[n];
    const bool moved = (input->moved >> n & 1u) != 0u;
    const bool before = (watch->suspected >> n & 1u) != 0u;
    const float p = window->moved[n];
    const float change = window->change[n];
    const float beside = window->value[n == 0u ? 1u : 0u];
    const float right = phase->error; /* of the last window but one */
    phase->error = phase->expected - phase->change;
    if (moved) {
        const float given = window->given[n];
        const float doubt =
            window->dead + window->resistive + window->reverse + JUMP_SHARE * bounds_magnitude(given);
        if (bounds_magnitude(change - given) > doubt + 2.0f * tuning->stuck ||
            !bounds_within(window->error[n], tuning->surprise)) {
            suspect(watch, n, window->value[n], beside, 0.0f, phase->error, STILL_JUMP);
        }
        return false;
    }
    if (!before) {
        suspect(watch, n, phase->value, beside, p / window->periods, right, STILL_ZERO);
    }
    phase->still += (uint32_t)(int32_t)window->periods;
    const float more = contradiction(watch, n, window, input->doubt);
    phase->stuck += more > 0.0f ? more : 0.0f;
    phase->path += bounds_magnitude(p - window->periods * phase->held);
    const uint32_t jump = tuning->still[STILL_JUMP];
    const uint32_t sure = phase->stuck > URGENT * tuning->stuck && phase->sure > jump ? jump : phase->sure;
    return (phase->still >= sure && phase->stuck > most_of(watch, phase, input) &&
            (phase->still >= tuning->still[STILL_ZERO] || !current_watch_feeds_another(watch, n))) ||
           stands(tuning, phase, beside) || is_silent(tuning, phase->still, input->noise);
}

/* Judges each sensor and the wires. */
static uint32_t judge_phases(current_watch_t *watch, const current_watch_input_t *input,
                             const current_watch_window_t *window)
{
    bool stuck = false;
    for (uint32_t n = 0; n < watch->tuning.sensors; n++) {
        stuck = is_stuck(watch, n, window, input) || stuck;
    }
    const current_watch_tuning_t *tuning = &watch->tuning;
    const bool sound = tuning->sensors == 3u && winding_adds_up(&input->current, tuning->stuck);
    uint32_t bits = stuck && !sound ? CURRENT_WATCH_STUCK : 0u;
    bits |= current_watch_wires(watch, input, window);
    return watch->suspected != 0u ? bits | CURRENT_WATCH_MAYBE : bits;
}

/* Stores in which windows control has changed the length of the current. A current that only turns may be
 * that of a rotor that swings. */
static void see_reference(current_watch_t *watch, dq_t reference, float largest)
{
    const float asked = reference.d * reference.d + reference.q * reference.q;
    const bool changes = !bounds_within(asked - watch->asked, 2.0f * watch->tuning.stuck * largest);
    watch->steered = (watch->steered << 1 & 6u) | (changes ? 1u : 0u);
    watch->asked = asked;
}

/* Stores the values with which the next window begins. */
static void remember(current_watch_t *watch, const current_watch_window_t *window, bool comparable)
{
    if (!comparable) {
        watch->unknown = watch->windows;
    }
    watch->windows++;
    watch->current = window->current;
    watch->emf = window->emf;
    for (uint32_t n = 0; n < 3u; n++) {
        watch->phase[n].value = window->value[n];
        watch->phase[n].change = window->change[n];
        watch->phase[n].expected = window->moved[n];
    }
}

uint32_t current_watch_step(current_watch_t *watch, const current_watch_input_t *input)
{
    const abc_t now = input->current;
    current_watch_window_t window;
    see_window(&window, watch, input);
    uint32_t bits = 0u;
    watch->suspected &= ~input->moved;
    see_reference(watch, input->reference, window.largest);
    if (watch->windows > 0u) {
        bits = judge_phases(watch, input, &window);
        bits |= current_watch_gain(watch, input, &window) ? CURRENT_WATCH_GAIN : 0u;
        bits |= bounds_within(now.a + now.b + now.c, watch->tuning.sum) ? 0u : CURRENT_WATCH_SUM;
    }
    remember(watch, &window, input->comparable);
    return bits;
}
