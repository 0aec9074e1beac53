#include "medium/protect/encoder_watch.h"

#include <string.h>

#include "math/filter.h"
#include "math/root.h"
#include "math/trig.h"

/* [windows] after a rest until two are known, because the turn of the EMF is measured from one to the next.
 * The step with which a sign begins, which is no turn, may extend over as many windows. */
#define FOR_A_TURN 2u

/* Limits for a rotor that turns the other way: its speed over that of the encoder, and
 * the error of the EMF's length. */
#define BACKWARD       0.5f   /* [-] */
#define BACKWARD_MOST  300.0f /* [rad/s] at higher speeds the sine of its turn is less accurate */
#define BACKWARD_ERROR 0.3f   /* [-] of psi_f |omega| */

/* Of psi_f |omega| of an encoder that turns. A longer EMF must last twice as long, because it may come from a
 * current that is not controlled, which is reported in the next periods. */
#define TOO_LONG 1.5f /* [-] */

#define MUCH_BESIDE 0.3f   /* [-] of the EMF: above the effect of a wrong psi_f */
#define CARRIES     4.0f   /* [-] of `doubtful`: square of a phase's current by a wrong trim of offsets */
#define SHORT       0.125f /* [-] of the current of a phase: least part of the request that a switch prevents */
/* [-] sine of three times the largest angle to the axis of a phase at which a difference may be that of its
 * wire, 10 degrees, and at which it is not elsewhere, 8 degrees */
#define PHASE_SINE 0.5f
#define NEAR_SINE  0.4f

#define SAME_AXIS 0.01f /* [-] square of the sine since it reached an axis: 6 degrees */
/* Square of a difference over that of the known axis, from which on it shows this axis better: noise and the
 * dead time turn it by less. The difference of a wrong encoder turns, but hardly becomes so much longer. */
#define LONGER_AXIS 2.0f /* [-] */

/* The mean difference: over these windows the noise, which has opposite signs from one window to the next,
 * falls to a fifth of a single window's, and a difference that turns at 100 rad/s lags by 14 degrees. */
#define OFF_WINDOWS 4u
/* Square of the difference over that of this part from which a single window shows the axis: in the mean a
 * difference that turns with the rotor becomes so small that it may have any direction. */
#define OFF_CLEAR 16.0f /* [-] */
/* [-] of psi_f/T_j: the most of a wrong psi_f omega in the mean difference. It turns with the rotor, by
 * x = omega T_j per window, and the mean keeps the share 1/sqrt(1 + 12 x^2): MUCH_BESIDE/sqrt(12). */
#define OFF_TURNING 0.0866f

/* [windows] on one axis, minus ALONG_MISSED for each window off it, after which a wire is the cause: a rotor
 * at the lowest speed that is judged, 12 rad/s or more, leaves the axis within 20. */
#define ALONG_WINDOWS 32u
#define ALONG_MISSED  8u

/* The mean over 16 windows of a difference that turns at 180 rad/s, at twice its angle, has a fifth of its
 * square. At less than 130 rad/s the mean is over more windows, 1/0.6 rad of the rotor's turn, and has a
 * third. That of a wire, with a part that turns of up to the same mean square, has a half. */
#define LINE_SHARE  (1.0f / 16.0f)  /* [-] */
#define LINE_LEAST  (1.0f / 128.0f) /* [-] at standstill */
#define LINE_TURN   1.2f            /* [-] share over the turn of half a window [1/rad] */
#define LINE_PART   0.5f            /* [-] */
#define LINE_KNOWN  0.75f           /* [-] of the square of the difference that is judged */
#define LINE_WAITED 32u /* [windows] postponed, after which the differences must lie along a line */

void encoder_watch_init(encoder_watch_t *watch, const encoder_watch_tuning_t *tuning)
{
    memset(watch, 0, sizeof *watch);
    encoder_watch_take(watch, tuning);
}

/* True if noise determines the least EMF. The sign of a judgement counts then only with a mean difference of
 * OFF_WINDOWS windows, whose direction shows whether it is that of a wire. */
static inline bool is_lowpass(const encoder_watch_tuning_t *tuning)
{
    return tuning->before > 0.5f;
}

static inline float product(ab_t a, ab_t b)
{
    return a.alpha * b.alpha + a.beta * b.beta;
}

static inline float square_of(ab_t a)
{
    return product(a, a);
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
    float square;      /* |e|^2 of the last window alone [V^2] */
    float expected;    /* psi_f |omega| [V] */
    float off;         /* square of the difference to psi_f omega on the q axis [V^2] */
    rotation_t middle; /* the encoder's angle to which the EMF belongs */
} seen_t;

/* The flux of the saliency and of the saturation at this current, s over T_j [V]. */
static ab_t flux_apart(const encoder_watch_tuning_t *tuning, const encoder_watch_input_t *input)
{
    const dq_t current = frames_park(input->current, input->encoder);
    const dq_t apart = {tuning->salient * current.d, -tuning->rate * input->excess * current.q};
    return frames_inverse_park(apart, input->encoder);
}

/* The mean EMF of the window, with which the next one begins [V]. The angle of the encoder at the beginning
 * of the first window after a rest is not known: there the part of saliency and saturation is omitted. */
static ab_t emf_of(encoder_watch_t *watch, const encoder_watch_input_t *input)
{
    const encoder_watch_tuning_t *tuning = &watch->tuning;
    const ab_t given =
        winding_given(&tuning->winding, watch->voltage, tuning->periods, watch->current, input->current);
    const ab_t apart = flux_apart(tuning, input);
    const ab_t before = watch->windows != 0u ? watch->apart : apart;
    const ab_t emf = {tuning->volts * (given.alpha - input->current.alpha + watch->current.alpha) +
                          apart.alpha - before.alpha,
                      tuning->volts * (given.beta - input->current.beta + watch->current.beta) + apart.beta -
                          before.beta};
    watch->apart = apart;
    watch->voltage = (ab_t){0.0f, 0.0f};
    watch->current = input->current;
    return emf;
}

static seen_t see(encoder_watch_t *watch, const encoder_watch_input_t *input)
{
    const encoder_watch_tuning_t *tuning = &watch->tuning;
    const float omega_e = input->omega_e;
    const ab_t mean = emf_of(watch, input);
    const float turn = tuning->middle * omega_e;
    const bool slow = bounds_within(turn, 0.5f * WINDING_TURN_MOST);
    const rotation_t middle = slow ? trig_advance(input->encoder, turn) : input->encoder;
    const dq_t emf = frames_park(slow ? mean : input->emf, middle);
    const dq_t last = watch->last;
    const float omega_emf = omega_e + slip(watch, emf);
    const bool backward = omega_e < 0.0f;
    watch->omega_emf = lowpass_step(watch->omega_emf, watch->windows >= FOR_A_TURN ? tuning->share : 1.0f,
                                    backward ? -omega_emf : omega_emf);
    watch->last = emf;
    watch->known = 1u;
    const float alone = emf.d * emf.d + emf.q * emf.q;
    const float share = alone > tuning->alone || watch->windows == 0u ? 0.0f : tuning->before;
    const dq_t before = is_lowpass(tuning) ? watch->judged : last;
    const dq_t judged = {emf.d + share * (before.d - emf.d), emf.q + share * (before.q - emf.q)};
    const float speed = is_lowpass(tuning) ? omega_e + share * (watch->speed - omega_e) : omega_e;
    watch->judged = judged;
    watch->speed = speed;
    const float square = judged.d * judged.d + judged.q * judged.q;
    const float off = judged.q - tuning->flux_linkage * speed;
    return (seen_t){speed < 0.0f ? -judged.q : judged.q,
                    square * inverse_root(square),
                    alone,
                    tuning->flux_linkage * bounds_magnitude(speed),
                    judged.d * judged.d + off * off,
                    middle};
}

/* The window's EMF less that of the rotor at the encoder's angle [V]. */
static ab_t beside(const encoder_watch_t *watch, float omega_e, rotation_t middle)
{
    const dq_t off = {watch->last.d, watch->last.q - watch->tuning.flux_linkage * omega_e};
    return frames_inverse_park(off, middle);
}

static inline bool hardly_flows(const encoder_watch_tuning_t *tuning, ab_t current)
{
    return square_of(current) < tuning->doubtful;
}

/* The least EMF that is judged at this current [V]. */
static inline float least_at(const encoder_watch_tuning_t *tuning, ab_t current)
{
    return hardly_flows(tuning, current) ? ENCODER_WATCH_SIGNS * tuning->emf_least : tuning->emf_least;
}

/* Square of the error of a false EMF by noise [V^2]. It is used while nearly no current flows, when the
 * current watch cannot yet report a wire. */
static inline float noise_of(const encoder_watch_t *watch)
{
    return hardly_flows(&watch->tuning, watch->current) ? watch->tuning.noise : 0.0f;
}

/* True if it lies along the axis of one phase, in either direction. On each axis the sine of three times its
 * angle is 0; it is at most `most` [-]. A part `beside` the axis [V^2] increases that sine by up to three
 * times the share of this part. */
static bool is_along(ab_t off, float most, float beside)
{
    const float square = square_of(off);
    const float sine = off.beta * (3.0f * off.alpha * off.alpha - off.beta * off.beta);
    return sine * sine < (most * most * square + 9.0f * beside) * square * square;
}

/* True if the currents are too small for the current watch to report a wire. */
static inline bool is_unseen(const encoder_watch_t *watch)
{
    return square_of(watch->current) < watch->tuning.unseen;
}

/* True if noise may turn the difference of a single window off the axis of its phase. */
static inline bool is_noisy(const encoder_watch_t *watch, ab_t off)
{
    return 9.0f * watch->tuning.noise > PHASE_SINE * PHASE_SINE * square_of(off);
}

/* True if noise, or with small currents the dead time, matters in the difference of a single window. */
static inline bool needs_mean(const encoder_watch_t *watch, ab_t off)
{
    return is_noisy(watch, off) || (is_unseen(watch) && square_of(off) < OFF_CLEAR * watch->tuning.beside);
}

/* Adds the difference of a wrong window to the means of its squares. */
static void add_square(encoder_watch_t *watch, float omega_e, ab_t off)
{
    const float turn = bounds_magnitude(watch->tuning.middle * omega_e);
    const float share = bounds_less(bounds_more(LINE_TURN * turn, LINE_LEAST), LINE_SHARE);
    watch->square += share * (square_of(off) - watch->square);
    watch->line.alpha += share * (off.alpha * off.alpha - off.beta * off.beta - watch->line.alpha);
    watch->line.beta += share * (2.0f * off.alpha * off.beta - watch->line.beta);
}

/* Adds the difference of a wrong window to the mean of consecutive ones. If neither noise nor the dead time
 * matters, only the last window counts. */
static void add_off(encoder_watch_t *watch, bool wrong, bool in_mean, float omega_e, ab_t off)
{
    if (!wrong) {
        watch->wrong >>= 1;
        return;
    }
    static const float shares[OFF_WINDOWS] = {1.0f, 1.0f / 2.0f, 1.0f / 3.0f, 1.0f / 4.0f};
    const uint32_t last = watch->wrong < OFF_WINDOWS ? watch->wrong : OFF_WINDOWS - 1u;
    const float share = in_mean ? shares[last] : 1.0f;
    watch->wrong += watch->wrong < OFF_WINDOWS ? 1u : 0u;
    watch->off.alpha += share * (off.alpha - watch->off.alpha);
    watch->off.beta += share * (off.beta - watch->off.beta);
    add_square(watch, omega_e, off);
}

/* True if the differences of the last windows lie along one line: at twice its angle, both of its directions
 * are the same. Differences that turn with the rotor, and noise, have no mean there. */
static bool is_on_a_line(const encoder_watch_t *watch)
{
    const float least = LINE_PART * watch->square;
    return square_of(watch->line) > least * least;
}

/* True if the mean of their squares, which begins at zero, has reached theirs, or if the judgement has waited
 * for long: the differences of a wire must then lie along a line. */
static inline bool knows_line(const encoder_watch_t *watch, const seen_t *seen)
{
    return watch->square > LINE_KNOWN * seen->off || watch->waited >= LINE_WAITED;
}

/* True if the difference may be that of an open phase. It has no current: its square is at most `most` [A^2],
 * or within an error `noise` [V^2] the current is perpendicular to the difference. Or it is that of an open
 * switch: the difference opposes the current, which falls (from 3 A in 0.1 H for 8 ms) and is shorter than
 * the request by `lacks` [A]. */
static inline bool may_be_open(const encoder_watch_t *watch, ab_t off, ab_t lacks, float most, float noise)
{
    const float along = product(off, watch->current);
    const bool falls = along > 0.0f && product(off, lacks) > SHORT * along;
    return falls || along * along <= most * square_of(off) + noise * square_of(watch->current);
}

/* Square of the noise in the mean difference [V^2]: consecutive windows share the sample between them, whose
 * noise has opposite signs in both, so that the noise of the two ends remains in the mean of n of them, 1/n
 * of a single window's. */
static float noise_left(const encoder_watch_t *watch)
{
    static const float squares[OFF_WINDOWS] = {1.0f, 1.0f / 4.0f, 1.0f / 9.0f, 1.0f / 16.0f};
    return squares[watch->wrong != 0u ? watch->wrong - 1u : 0u] * watch->tuning.noise;
}

/* The same where the direction of the difference allows for it [V^2]: while nearly no current flows, or none
 * in the direction of the difference. The current watch reports no wire of a phase in which nearly no current
 * is requested. */
static float noise_of_mean(const encoder_watch_t *watch)
{
    const ab_t none = {0.0f, 0.0f};
    const float noise = noise_left(watch);
    const bool used = is_unseen(watch) ? hardly_flows(&watch->tuning, watch->current)
                                       : may_be_open(watch, watch->off, none, watch->tuning.doubtful, noise);
    return used ? noise : 0.0f;
}

/* True if the mean difference of at least two windows, or with a known axis of one, lies along the axis of
 * one phase alone, and has not moved since it reached this axis. A longer difference on an axis, and a mean
 * of more windows, show the direction of the axis better, and replace the known one. The EMF of a rotor that
 * turns the other way is constant and may lie there; that of a rotor whose encoder does not turn leaves it. A
 * difference that has already stayed on an axis passes through zero twice per turn of the rotor, and returns
 * to the same axis with the other sign. Near zero the error `wrong_flux` of psi_f omega [V] turns it by more
 * than the angle that shows an axis: it is then compared with the known axis only: with small currents, or
 * after ALONG_WINDOWS. */
static bool is_of_a_phase(encoder_watch_t *watch, bool in_mean, float wrong_flux)
{
    const ab_t off = watch->off;
    watch->axis = watch->along != 0u ? watch->axis : off;
    const ab_t axis = watch->axis;
    const bool returns = watch->along >= (is_unseen(watch) ? 1u : ALONG_WINDOWS);
    const float beside = (is_unseen(watch) ? watch->tuning.beside : 0.0f) + noise_of_mean(watch);
    const float most = OFF_TURNING * watch->tuning.flux_linkage * watch->tuning.rate;
    const float error = in_mean ? bounds_less(wrong_flux, most) : wrong_flux;
    const float about = beside + (returns ? error * error : 0.0f);
    const float cross = off.alpha * axis.beta - off.beta * axis.alpha;
    const float a = square_of(off);
    const float b = square_of(axis);
    const bool on_one = is_along(off, PHASE_SINE, returns ? 0.0f : beside);
    const bool stays = (watch->wrong >= 2u || watch->along != 0u) && (returns || on_one) &&
                       cross * cross < SAME_AXIS * a * b + about * (a + b);
    const bool averages = in_mean && watch->along < OFF_WINDOWS; /* this mean has less noise than the axis */
    if (stays && on_one && (averages || a > LONGER_AXIS * b)) {
        watch->axis = off;
    }
    return stays;
}

/* Counts for how long the difference has stayed on one axis. A difference that is too small to be wrong
 * has no axis. One for which the judgement has waited longer than single windows off the axis explain, and
 * which leaves it, turns: it is not that of a wire, and the judgement does not wait any longer, unless the
 * currents are `doubtful`. */
static void count_along(encoder_watch_t *watch, bool wrong, bool doubtful)
{
    if (watch->of_a_phase != 0u) {
        watch->along += watch->along < 2u * ALONG_WINDOWS ? 1u : 0u;
    } else if (wrong && watch->wrong >= 2u && watch->along != 0u) {
        const bool leaves = watch->along <= ALONG_MISSED;
        watch->along = leaves ? 0u : watch->along - ALONG_MISSED;
        if (leaves && !doubtful && watch->waited > 2u * ALONG_MISSED) {
            watch->waited = watch->tuning.waits;
        }
    }
}

/* True if the difference is large and does not lie along the axis of a phase. */
static bool is_elsewhere(const encoder_watch_t *watch, ab_t off)
{
    const dq_t emf = watch->last;
    return square_of(off) > MUCH_BESIDE * MUCH_BESIDE * (emf.d * emf.d + emf.q * emf.q) &&
           !is_along(off, NEAR_SINE, noise_of(watch));
}

/* True if the EMF's speed is larger than noise alone can explain. */
static bool is_beyond_noise(const encoder_watch_t *watch, float length)
{
    const float turn = watch->omega_emf * length;
    return turn * turn > watch->tuning.turn_noise;
}

/* The step with which a sign begins is no turn: the EMF's speed keeps its value. */
static inline void hold_speed(encoder_watch_t *watch, bool wrong, float omega_emf)
{
    if (wrong && watch->wrong < FOR_A_TURN && watch->windows >= watch->tuning.settles) {
        watch->omega_emf = omega_emf;
    }
}

/* What the EMF of a judgement says against the encoder. */
typedef struct {
    bool aside; /* it has another direction, or it is too long */
    bool half;  /* it is only too long */
    bool wrong; /* a sign: one of these, or no EMF, beyond a voltage error */
    bool open;  /* no sign, but only because nearly no current flows */
} sign_t;

/* The sign of an EMF above `least`, which is emf_least [V] or, while nearly no current flows, more. While the
 * EMF is too long for the encoder's speed, the sign of this speed may be that of noise. */
static inline sign_t sign_of(const seen_t *seen, float emf_least, float least)
{
    const float axis = ENCODER_WATCH_AXIS * seen->length;
    const float longest = ENCODER_WATCH_LONGER * seen->expected;
    const bool longer = seen->square > longest * longest;
    const bool turned = longer ? bounds_within(seen->along, axis) : seen->along < axis;
    const bool off = turned || longer;
    const bool aside = off && seen->length > least;
    const bool gone = seen->expected > least && seen->length < ENCODER_WATCH_GONE * seen->expected;
    const bool wrong = (aside || gone) && seen->off > least * least;
    return (sign_t){aside, aside && !turned, wrong,
                    !wrong && off && seen->length > emf_least && seen->length <= least};
}

/* Adds a judgement with the sign. Returns the condition once the sign has lasted for long enough. `turns`:
 * the encoder turns; `opposite`: the EMF turns against it. */
static uint32_t add_sign(encoder_watch_t *watch, const sign_t *sign, const seen_t *seen, bool turns,
                         bool opposite)
{
    const encoder_watch_tuning_t *tuning = &watch->tuning;
    watch->held += bounds_clamp(sign->aside ? seen->length : seen->expected, tuning->holds);
    watch->count += sign->half ? 1u : 2u;
    if (watch->held < tuning->holds || watch->count < 2u * ENCODER_WATCH_LEAST) {
        return 0u;
    }
    const bool against =
        sign->aside && opposite && watch->omega_emf * tuning->flux_linkage < -0.5f * tuning->emf_least;
    const bool too_long = (turns || against) && seen->length > TOO_LONG * seen->expected;
    if (too_long && watch->count < 4u * ENCODER_WATCH_LEAST) {
        return 0u;
    }
    watch->held = tuning->holds;
    watch->count = 4u * ENCODER_WATCH_LEAST;
    if (watch->along >= ALONG_WINDOWS) {
        return ENCODER_WATCH_WIRE;
    }
    return against ? ENCODER_WATCH_DIRECTION : ENCODER_WATCH_MISMATCH;
}

uint32_t encoder_watch_step(encoder_watch_t *watch, const encoder_watch_input_t *input)
{
    const encoder_watch_tuning_t *tuning = &watch->tuning;
    const float omega_emf = watch->omega_emf;
    const seen_t seen = see(watch, input);
    const float least = least_at(tuning, input->current);
    const sign_t sign = sign_of(&seen, tuning->emf_least, least);
    hold_speed(watch, sign.wrong, omega_emf);
    const bool turns = seen.expected > 0.5f * tuning->emf_least;
    const bool opposite =
        turns && is_beyond_noise(watch, seen.length) &&
        watch->omega_emf < -bounds_clamp(BACKWARD * bounds_magnitude(input->omega_e), BACKWARD_MOST);
    const bool backward =
        opposite && bounds_within(seen.length - seen.expected, BACKWARD_ERROR * seen.expected);
    const ab_t off = beside(watch, input->omega_e, seen.middle);
    const bool in_mean = needs_mean(watch, off);
    const bool differs = sign.wrong || sign.open;
    const bool still = hardly_flows(tuning, input->current);
    add_off(watch, differs, in_mean, input->omega_e, off);
    const bool of_a_phase = differs && !backward &&
                            may_be_open(watch, watch->off, input->lacks, CARRIES * tuning->doubtful,
                                        tuning->beside + noise_left(watch)) &&
                            is_of_a_phase(watch, in_mean, MUCH_BESIDE * seen.expected) &&
                            (!knows_line(watch, &seen) || is_on_a_line(watch));
    watch->elsewhere =
        watch->windows > 0u && seen.length > least && is_elsewhere(watch, off) ? UINT32_C(1) : UINT32_C(0);
    watch->confirmed = 0u;
    if (watch->windows < tuning->settles) {
        watch->windows++;
        return 0u;
    }
    const bool grows = sign.half && !still; /* the EMF of exchanged sensors, with their current */
    watch->of_a_phase = of_a_phase && !grows ? UINT32_C(1) : UINT32_C(0);
    count_along(watch, differs && !grows, input->doubtful);
    if (watch->waited < tuning->waits && (input->doubtful || of_a_phase)) {
        watch->waited++;
        return 0u;
    }
    if (sign.open || (sign.wrong && is_lowpass(tuning) && watch->wrong < OFF_WINDOWS)) {
        return 0u;
    }
    if (!sign.wrong) {
        watch->confirmed = seen.length > least && watch->count == 0u ? UINT32_C(1) : UINT32_C(0);
        watch->held *= 0.5f;
        watch->count = watch->count >> 2 << 1; /* half of the whole judgements */
        watch->waited >>= 1;
        return 0u;
    }
    return add_sign(watch, &sign, &seen, turns, opposite);
}
