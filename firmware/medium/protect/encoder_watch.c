#include "medium/protect/encoder_watch.h"

#include <string.h>

#include "math/filter.h"
#include "math/periods.h"
#include "math/root.h"
#include "math/trig.h"

/* [windows] after a rest until two are known: the turn of the EMF is measured from one to the next. */
#define FOR_A_TURN 2u

/* Limits for a rotor that turns the other way: its speed over that of the encoder, and
 * the error of the EMF's length. */
#define BACKWARD       0.5f   /* [-] */
#define BACKWARD_MOST  300.0f /* [rad/s] at higher speeds the sine of its turn is less accurate */
#define BACKWARD_ERROR 0.3f   /* [-] of psi_f |omega| */

/* Of psi_f |omega|, for a rotor that turns the other way: a longer EMF may come from an uncontrolled
 * current and must last twice as long. */
#define TOO_LONG 1.5f /* [-] */

#define MUCH_BESIDE 0.3f /* [-] of the EMF: above the effect of a wrong psi_f */
#define PHASE_SINE  0.4f /* [-] of three times the angle to the axis of a phase: 8 degrees */

#define EMF_NOISE                                                                                            \
    2.12f /* [-] three standard deviations of the mean of two windows: of both ends, sqrt(2)/2 each */

#define SAME_AXIS 0.01f /* [-] square of the sine since it reached an axis: 6 degrees */

encoder_watch_tuning_t encoder_watch_prepare(const encoder_watch_params_t *params)
{
    const float every = (float)params->every;
    const float window = every * params->period;
    const float rate = 1.0f / window;
    const float noise = EMF_NOISE * params->noise * params->inductance * rate;
    const float judged = params->flux_linkage * params->speed_least;
    const float least = judged > noise ? judged : noise;
    const float alone = ENCODER_WATCH_ALONE * least;
    return (encoder_watch_tuning_t){
        .flux_linkage = params->flux_linkage,
        .emf_least = least,
        .doubtful = params->doubtful * params->doubtful,
        .alone = alone * alone,
        .noise = 4.0f * noise * noise,
        .leap = ENCODER_WATCH_LEAP + 2.0f * params->step,
        .share = lowpass_share(ENCODER_WATCH_CUTOFF, window),
        .winding = winding_prepare(params->resistance, params->inductance, params->period),
        .periods = every,
        .volts = params->inductance * rate,
        .middle = -0.5f * window,
        .rate = rate,
        .holds = ENCODER_WATCH_TIME * rate * least,
        .settles = periods_of(ENCODER_WATCH_SETTLE, window),
        .waits = periods_of(ENCODER_WATCH_WAIT, window),
    };
}

void encoder_watch_init(encoder_watch_t *watch, const encoder_watch_tuning_t *tuning)
{
    memset(watch, 0, sizeof *watch);
    encoder_watch_take(watch, tuning);
}

/* Speed of the EMF in the encoder's frame [rad/s]: from the sine of its turn in a judgement, and the whole
 * sine for more than a quarter of a turn. */
static float slip(const encoder_watch_t *watch, dq_t emf)
{
    const dq_t last = watch->last;
    const float squares = (emf.d * emf.d + emf.q * emf.q) * (last.d * last.d + last.q * last.q);
    const float cross = (last.d * emf.q - last.q * emf.d) * inverse_root(squares);
    const float along = last.d * emf.d + last.q * emf.q;
    return watch->tuning.rate * (along > 0.0f ? cross : (cross < 0.0f ? -1.0f : 1.0f));
}

/* The values of a judgement, of one window or of the mean of two. */
typedef struct {
    float along;       /* e_q in the direction of rotation [V] */
    float length;      /* |e| [V] */
    float expected;    /* psi_f |omega| [V] */
    rotation_t middle; /* the encoder's angle in the middle of the window */
} seen_t;

/* The mean EMF of the window, with which the next one begins [V]. */
static ab_t emf_of(encoder_watch_t *watch, const encoder_watch_input_t *input)
{
    const encoder_watch_tuning_t *tuning = &watch->tuning;
    const ab_t given =
        winding_given(&tuning->winding, watch->voltage, tuning->periods, watch->current, input->current);
    const ab_t emf = {tuning->volts * (given.alpha - input->current.alpha + watch->current.alpha),
                      tuning->volts * (given.beta - input->current.beta + watch->current.beta)};
    watch->voltage = (ab_t){0.0f, 0.0f};
    watch->current = input->current;
    return emf;
}

static seen_t see(encoder_watch_t *watch, const encoder_watch_input_t *input)
{
    const encoder_watch_tuning_t *tuning = &watch->tuning;
    const float omega_e = input->omega_e;
    const rotation_t middle = trig_advance(input->encoder, tuning->middle * omega_e);
    const dq_t emf = frames_park(emf_of(watch, input), middle);
    const dq_t last = watch->last;
    const float omega_emf = omega_e + slip(watch, emf);
    const bool backward = omega_e < 0.0f;
    watch->omega_emf = lowpass_step(watch->omega_emf, watch->windows >= FOR_A_TURN ? tuning->share : 1.0f,
                                    backward ? -omega_emf : omega_emf);
    watch->last = emf;
    const float share = emf.d * emf.d + emf.q * emf.q > tuning->alone ? 0.0f : 0.5f;
    const dq_t judged = {emf.d + share * (last.d - emf.d), emf.q + share * (last.q - emf.q)};
    const float square = judged.d * judged.d + judged.q * judged.q;
    return (seen_t){backward ? -judged.q : judged.q, square * inverse_root(square),
                    tuning->flux_linkage * bounds_magnitude(omega_e), middle};
}

/* The window's EMF less that of the rotor at the encoder's angle [V]. */
static ab_t beside(const encoder_watch_t *watch, float omega_e, rotation_t middle)
{
    const dq_t off = {watch->last.d, watch->last.q - watch->tuning.flux_linkage * omega_e};
    return frames_inverse_park(off, middle);
}

static inline float square_of(ab_t a)
{
    return a.alpha * a.alpha + a.beta * a.beta;
}

static inline bool hardly_flows(const encoder_watch_tuning_t *tuning, ab_t current)
{
    return current.alpha * current.alpha + current.beta * current.beta < tuning->doubtful;
}

/* Square of the error of a false EMF by noise [V^2]. It is used while nearly no current flows, when the
 * current watch cannot yet report a wire. */
static inline float noise_of(const encoder_watch_t *watch)
{
    return hardly_flows(&watch->tuning, watch->current) ? watch->tuning.noise : 0.0f;
}

/* True if it lies along the axis of one phase, in either direction. On each axis the sine of three times its
 * angle is 0; with noise, that sine is three times the noise over its length. */
static bool is_along(const encoder_watch_t *watch, ab_t off)
{
    const float square = square_of(off);
    const float sine = off.beta * (3.0f * off.alpha * off.alpha - off.beta * off.beta);
    const float beside = PHASE_SINE * PHASE_SINE * square + 9.0f * noise_of(watch);
    return sine * sine < beside * square * square;
}

/* True if it lies along the axis of one phase alone. The EMF of a rotor that turns the other way is constant
 * and may lie there; that of a rotor whose encoder does not turn has moved one window later. */
static bool is_of_a_phase(encoder_watch_t *watch, float omega_e, rotation_t middle)
{
    const ab_t off = beside(watch, omega_e, middle);
    const ab_t before = watch->off;
    watch->off = watch->of_a_phase != 0u ? before : off;
    const float cross = off.alpha * before.beta - off.beta * before.alpha;
    const float a = square_of(off);
    const float b = square_of(before);
    return is_along(watch, off) && cross * cross < SAME_AXIS * a * b + noise_of(watch) * (a + b);
}

/* True if it is large and lies along no phase axis. */
static bool is_elsewhere(const encoder_watch_t *watch, const encoder_watch_input_t *input, rotation_t middle)
{
    const ab_t off = beside(watch, input->omega_e, middle);
    const dq_t emf = watch->last;
    return square_of(off) > MUCH_BESIDE * MUCH_BESIDE * (emf.d * emf.d + emf.q * emf.q) &&
           !is_along(watch, off);
}

uint32_t encoder_watch_step(encoder_watch_t *watch, const encoder_watch_input_t *input)
{
    const encoder_watch_tuning_t *tuning = &watch->tuning;
    const seen_t seen = see(watch, input);
    const float least =
        hardly_flows(tuning, input->current) ? ENCODER_WATCH_SIGNS * tuning->emf_least : tuning->emf_least;
    const bool aside = seen.length > least && seen.along < ENCODER_WATCH_AXIS * seen.length;
    const bool gone = seen.expected > least && seen.length < ENCODER_WATCH_GONE * seen.expected;
    const bool wrong = aside || gone;
    const bool turns = seen.expected > 0.5f * tuning->emf_least;
    const bool opposite =
        turns && watch->omega_emf < -bounds_clamp(BACKWARD * bounds_magnitude(input->omega_e), BACKWARD_MOST);
    const bool backward =
        opposite && bounds_within(seen.length - seen.expected, BACKWARD_ERROR * seen.expected);
    const bool of_a_phase = wrong && !backward && is_of_a_phase(watch, input->omega_e, seen.middle);
    watch->elsewhere = watch->windows > 0u && seen.length > least && is_elsewhere(watch, input, seen.middle)
                           ? UINT32_C(1)
                           : UINT32_C(0);
    watch->confirmed = 0u;
    if (watch->windows < tuning->settles) {
        watch->windows++;
        return 0u;
    }
    watch->of_a_phase = of_a_phase ? UINT32_C(1) : UINT32_C(0);
    if (watch->waited < tuning->waits && (input->doubtful || of_a_phase)) {
        watch->waited++;
        return 0u;
    }
    if (!wrong) {
        watch->confirmed = seen.length > least && watch->count == 0u ? UINT32_C(1) : UINT32_C(0);
        watch->held *= 0.5f;
        watch->count >>= 1;
        watch->waited >>= 1;
        return 0u;
    }
    watch->held += bounds_clamp(aside ? seen.length : seen.expected, tuning->holds);
    watch->count++;
    if (watch->held < tuning->holds || watch->count < ENCODER_WATCH_LEAST) {
        return 0u;
    }
    const bool against =
        aside && opposite && watch->omega_emf * tuning->flux_linkage < -0.5f * tuning->emf_least;
    if (against && seen.length > TOO_LONG * seen.expected && watch->count < 2u * ENCODER_WATCH_LEAST) {
        return 0u;
    }
    watch->held = tuning->holds;
    watch->count = ENCODER_WATCH_LEAST;
    return against ? ENCODER_WATCH_DIRECTION : ENCODER_WATCH_MISMATCH;
}
