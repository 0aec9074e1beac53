#include "medium/commission/swing_step.h"

#include "math/angle.h"
#include "math/bounds.h"
#include "math/periods.h"
#include "math/root.h"
#include "math/trig.h"

#define JUMPS         5u     /* the first one only measures the voltage at rest in the second direction */
#define BLOCK         0.1f   /* [s] of a mean at rest */
#define LEAST         0.25f  /* [s] of a jump */
#define ACROSS        0.004f /* current across over that along of a rotor at rest [-] */
#define ACROSS_LEAST  0.01f  /* [A] added to it */
#define SLOW          0.2f   /* of the largest speed of a jump: its motion ends [-] */
#define UNDER_WAY     0.8f   /* cosine of the least angle before that [-] */
#define THIRD_TURN    2.09439510f /* [rad] */
#define SHARE_MOST    0.9f        /* of the largest current [-] */
#define HOLD_MOST     1.3f        /* of the held current, for a short time [-] */
#define SALIENT_SHARE 0.35f       /* of psi_f that the current of a salient rotor takes away [-] */
#define SALIENT_FROM  1.1f        /* L_q/L_d from which on a rotor counts as salient [-] */
#define SALIENT_MOST  0.5f        /* the same beyond which the jumps are repeated with less current [-] */
#define AGAIN_MOST    3u          /* [-] times */
#define SEEN_SHARE    0.05f       /* least share of J in the square of the impulse [-] */
#define FREER         7.0f        /* factor of the resistance across the axis where J does not show [-] */
#define FREER_MOST    2u          /* [-] times */
#define FLUX_LEAST    2e-4f       /* [Wb] */
#define FLUX_SHARE    0.04f       /* least psi_f over L_d I: the integral has errors of this size [-] */
#define SPREAD_MOST   2.0f        /* largest over least psi_f of the jumps: an error of a third [-] */
#define ANY_CURRENT   1e3f        /* [A] no limit; [1/A] no zone */

/* A window of the motion, in the stationary frame. */
typedef struct {
    ab_t voltage;  /* sum over the periods [V] */
    ab_t current;  /* sum over the periods [A] */
    ab_t sample;   /* at its end [A] */
    float periods; /* [periods] */
} swing_window_t;

void swing_step_begin(swing_step_t *step)
{
    *step = (swing_step_t){.phase = (int32_t)SWING_BEGIN};
}

/* The loss of the legs for this current [V]. */
static ab_t lost(ab_t current, const commission_results_t *results)
{
    const abc_t phases = frames_inverse_clarke(current);
    const float leg = results->dead_voltage;
    const float per_zone = results->current_zone > 0.0f ? 1.0f / results->current_zone : ANY_CURRENT;
    const ab_t signs = frames_clarke((abc_t){bounds_clamp(per_zone * phases.a, 1.0f),
                                             bounds_clamp(per_zone * phases.b, 1.0f),
                                             bounds_clamp(per_zone * phases.c, 1.0f)});
    return (ab_t){leg * signs.alpha, leg * signs.beta};
}

static inline float cross(ab_t a, ab_t b)
{
    return a.alpha * b.beta - a.beta * b.alpha;
}

/* The active flux of a motion that began with a known Psi_m. */
static ab_t active(const swing_motion_t *motion, const commission_results_t *results)
{
    const float l_d = results->inductance_d;
    const float l_q = results->inductance_q;
    return (ab_t){
        motion->before.alpha + l_d * motion->from.alpha + motion->flux.alpha - l_q * motion->last.alpha,
        motion->before.beta + l_d * motion->from.beta + motion->flux.beta - l_q * motion->last.beta};
}

/* The same at its beginning. */
static ab_t begun_of(const swing_motion_t *motion, const commission_results_t *results)
{
    const float apart = results->inductance_d - results->inductance_q;
    return (ab_t){motion->before.alpha + apart * motion->from.alpha,
                  motion->before.beta + apart * motion->from.beta};
}

/* Psi_m(t) - Psi_m(0). */
static ab_t moved(const swing_motion_t *motion, bool known, const commission_results_t *results)
{
    const float l_d = results->inductance_d;
    const ab_t round = {motion->flux.alpha - l_d * (motion->last.alpha - motion->from.alpha),
                        motion->flux.beta - l_d * (motion->last.beta - motion->from.beta)};
    const ab_t a = active(motion, results);
    const float square = a.alpha * a.alpha + a.beta * a.beta;
    if (!known || !(square > 0.0f)) {
        return round;
    }
    const float i_d = a.alpha * motion->last.alpha + a.beta * motion->last.beta; /* times |a| */
    const float share = 1.0f + (results->inductance_q - l_d) * i_d / square;
    return (ab_t){share * a.alpha - motion->before.alpha, share * a.beta - motion->before.beta};
}

/* true: the direction has turned by more than an error can explain. */
static bool is_under_way(ab_t from, ab_t now)
{
    const float along = from.alpha * now.alpha + from.beta * now.beta;
    const float squares =
        (from.alpha * from.alpha + from.beta * from.beta) * (now.alpha * now.alpha + now.beta * now.beta);
    return along < 0.0f || along * along < UNDER_WAY * UNDER_WAY * squares;
}

/* Adds speed and torque of a window to the regression, from the active flux at its ends. */
static void learn(swing_step_t *step, const commission_tuning_t *tuning, const commission_results_t *results,
                  ab_t before, ab_t after, ab_t current, float time)
{
    swing_motion_t *motion = &step->motion;
    const ab_t middle = {0.5f * (before.alpha + after.alpha), 0.5f * (before.beta + after.beta)};
    const ab_t change = {after.alpha - before.alpha, after.beta - before.beta};
    const float length = middle.alpha * middle.alpha + middle.beta * middle.beta;
    const float impulse = 1.5f * tuning->pole_pairs * cross(middle, current) * time;
    if (!(length > 0.0f)) {
        return;
    }
    const float omega_e = cross(middle, change) / (length * time);
    motion->peak = bounds_more(motion->peak, bounds_magnitude(omega_e));
    if (bounds_within(omega_e, SLOW * motion->peak) && is_under_way(begun_of(motion, results), after)) {
        motion->over = 1u;
    }
    if (motion->over != 0u) {
        return;
    }
    const float omega_m = omega_e / tuning->pole_pairs;
    const float until = motion->impulse + 0.5f * impulse; /* the speed is that of the middle of the window */
    swing_fit_t *fit = &step->fit;
    motion->impulse += impulse;
    motion->moving += omega_e > 0.0f ? time : -time;
    fit->ww += omega_m * omega_m;
    fit->wt += omega_m * motion->moving;
    fit->tt += motion->moving * motion->moving;
    fit->wp += omega_m * until;
    fit->tp += motion->moving * until;
    fit->pp += until * until;
}

/* Adds a point of the circle to the fit. */
static void add_point(swing_motion_t *motion, ab_t point)
{
    const float square = point.alpha * point.alpha + point.beta * point.beta;
    motion->xx += point.alpha * point.alpha;
    motion->xy += point.alpha * point.beta;
    motion->yy += point.beta * point.beta;
    motion->xz += point.alpha * square;
    motion->yz += point.beta * square;
}

/* The centre of the circle; zero: no circle fits. */
static ab_t centre_of(const swing_motion_t *motion)
{
    const float det = motion->xx * motion->yy - motion->xy * motion->xy;
    const float share = det > 0.0f ? 0.5f / det : 0.0f;
    return (ab_t){share * (motion->xz * motion->yy - motion->yz * motion->xy),
                  share * (motion->yz * motion->xx - motion->xz * motion->xy)};
}

/* The direction of a jump, as an index of `rest`. */
static uint32_t direction_of(uint32_t jump)
{
    return 1u - jump % 2u;
}

static void add(swing_step_t *step, const commission_tuning_t *tuning, const swing_window_t *window,
                const commission_results_t *results)
{
    swing_motion_t *motion = &step->motion;
    const float share = 1.0f / window->periods;
    const float time = window->periods * tuning->period;
    const ab_t current = {share * window->current.alpha, share * window->current.beta};
    const ab_t voltage = {share * window->voltage.alpha, share * window->voltage.beta};
    const ab_t loss = lost(current, results);
    const bool known = results->flux_first > 0.0f;
    const ab_t before = active(motion, results);
    const ab_t rest = step->rest[step->jump == 0u ? 0u : direction_of(step->jump)];
    motion->flux.alpha +=
        time * (voltage.alpha - results->resistance * current.alpha - loss.alpha - rest.alpha);
    motion->flux.beta += time * (voltage.beta - results->resistance * current.beta - loss.beta - rest.beta);
    motion->last = window->sample;
    add_point(motion, moved(motion, known, results));
    if (known) {
        learn(step, tuning, results, before, active(motion, results), current, time);
    }
}

/* Selects the next direction: the jumps alternate between two directions. */
static void jump(swing_step_t *step, const commission_input_t *input, ab_t before, excite_order_t *order)
{
    step->motion = (swing_motion_t){.from = input->current, .last = input->current, .before = before};
    order->axis = trig_turn(direction_of(step->jump) != 0u ? 0.0f : -THIRD_TURN);
    step->windows = 0u;
    step->phase = (int32_t)SWING_JUMP;
}

/* The voltage at rest, from the mean of a block, that R and the loss of the legs do not explain. */
static ab_t rest_of(const swing_step_t *step, const commission_results_t *results, rotation_t axis)
{
    const dq_t voltage = commission_mean_of(&step->standing.mean, step->standing.mean.voltage);
    const dq_t current = commission_mean_of(&step->standing.mean, step->standing.mean.current);
    const ab_t flows = frames_inverse_park(current, axis);
    const ab_t stands = frames_inverse_park(voltage, axis);
    const ab_t loss = lost(flows, results);
    return (ab_t){stands.alpha - results->resistance * flows.alpha - loss.alpha,
                  stands.beta - results->resistance * flows.beta - loss.beta};
}

/* J by the regression; 0: it has no solution. */
static float inertia_of(const swing_fit_t *fit)
{
    const float det = fit->ww * fit->tt - fit->wt * fit->wt;
    const float inertia = det > 0.0f ? (fit->wp * fit->tt - fit->tp * fit->wt) / det : 0.0f;
    return bounds_more(inertia, 0.0f);
}

/* The current that reduces the active flux by this share of psi_f [A]; without limit for a round rotor. */
static float salient_current(float share, float psi, const commission_results_t *results)
{
    const float apart = bounds_magnitude(results->inductance_q - results->inductance_d);
    return apart * ANY_CURRENT > psi ? share * psi / apart : ANY_CURRENT;
}

/* After all jumps: computes the values, or repeats the jumps with less braking. */
static commission_verdict_t conclude(swing_step_t *step, const commission_input_t *input, ab_t before,
                                     commission_results_t *results, excite_order_t *order)
{
    const swing_fit_t *fit = &step->fit;
    const float inertia = inertia_of(fit);
    const float share = fit->pp > 0.0f ? inertia * inertia * fit->ww / fit->pp : 0.0f;
    if (step->flux_most > SPREAD_MOST * step->flux_least) {
        results->flux_first = 0.0f;
        return commission_failed(COMMISSION_REASON_EMF_TOO_SMALL, 0);
    }
    if (step->freer == 0u || share > step->share) {
        step->flux = results->flux_first;
        step->inertia = inertia;
        step->share = share;
    }
    if (step->share < SEEN_SHARE && step->freer < FREER_MOST) {
        step->freer++;
        step->jump = 1u; /* the voltages at rest are known */
        step->flux_sum = 0.0f;
        step->fit = (swing_fit_t){0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        results->flux_first = 0.0f;
        order->across *= FREER;
        jump(step, input, before, order);
        return commission_goes_on();
    }
    if (step->current > salient_current(SALIENT_MOST, step->flux, results) && step->again < AGAIN_MOST) {
        *step = (swing_step_t){.phase = (int32_t)SWING_BEGIN, .again = step->again + 1u, .flux = step->flux};
        return commission_goes_on();
    }
    results->flux_first = step->flux;
    results->inertia_first = step->inertia;
    return commission_finished();
}

/* Psi_m of the rotor at rest. A salient rotor is assumed to lie on the axis: the errors of `shown`, the Psi_m
 * from the last motion, would turn the active flux in the next motion. */
static ab_t begins_at(const commission_results_t *results, rotation_t axis, ab_t shown, float psi)
{
    if (results->inductance_q < SALIENT_FROM * results->inductance_d) {
        return shown;
    }
    return (ab_t){psi * axis.cos, psi * axis.sin};
}

/* Called when the rotor is at rest after a jump. */
static commission_verdict_t judge(swing_step_t *step, const commission_input_t *input,
                                  commission_results_t *results, excite_order_t *order)
{
    const ab_t rest = rest_of(step, results, order->axis);
    step->rest[direction_of(step->jump)] = rest;
    const ab_t end = moved(&step->motion, results->flux_first > 0.0f, results);
    const ab_t centre = centre_of(&step->motion);
    const float psi = root_or_none(centre.alpha * centre.alpha + centre.beta * centre.beta);
    const ab_t now = {end.alpha - centre.alpha, end.beta - centre.beta};
    const ab_t before = begins_at(results, order->axis, now, psi);
    results->point = (commission_point_t){(float)step->jump, psi};
    if (step->jump > 0u) {
        /* the first circle gives only a first value: for the others the direction of the rotor is known */
        step->flux_sum += step->jump > 1u ? psi : 0.0f;
        step->flux_least = step->jump > 2u ? bounds_less(step->flux_least, psi) : psi;
        step->flux_most = step->jump > 2u ? bounds_more(step->flux_most, psi) : psi;
        results->flux_first = step->jump > 1u ? step->flux_sum / (float)(step->jump - 1u) : psi;
        if (results->flux_first <
            bounds_more(FLUX_LEAST, FLUX_SHARE * results->inductance_d * step->current)) {
            return commission_failed(COMMISSION_REASON_EMF_TOO_SMALL, 0);
        }
        if (!is_under_way((ab_t){-centre.alpha, -centre.beta}, now)) {
            return commission_failed(COMMISSION_REASON_ROTOR_NOT_TURNING, 0);
        }
    }
    step->jump++;
    if (step->jump < JUMPS) {
        jump(step, input, before, order);
        return commission_goes_on();
    }
    return conclude(step, input, before, results, order);
}

static swing_window_t window_of(const commission_input_t *input, rotation_t axis)
{
    const excite_seen_t *seen = input->seen;
    return (swing_window_t){
        .voltage = frames_inverse_park(seen->voltage, axis),
        .current = frames_inverse_park(seen->current, axis),
        .sample = input->current,
        .periods = (float)seen->periods,
    };
}

commission_verdict_t swing_step(swing_step_t *step, const commission_tuning_t *tuning,
                                const commission_input_t *input, excite_order_t *order,
                                commission_results_t *results)
{
    if (step->phase == (int32_t)SWING_BEGIN) {
        if (!(results->resistance > 0.0f && results->inductance_d > 0.0f)) {
            return commission_failed(COMMISSION_REASON_EARLIER_STEP, 0);
        }
        const float psi = step->again > 0u ? step->flux : tuning->flux_linkage;
        results->flux_first = 0.0f;
        step->current = bounds_less(SHARE_MOST * tuning->current_max, HOLD_MOST * results->current_hold);
        step->current = bounds_less(step->current, salient_current(SALIENT_SHARE, psi, results));
        standing_begin(&step->standing, -THIRD_TURN, input->u_dc, tuning, results, order);
        order->current = step->current;
        step->phase = (int32_t)SWING_ALIGN;
        return commission_goes_on();
    }
    if (input->seen->serial != order->serial) {
        return commission_goes_on();
    }
    if (step->phase == (int32_t)SWING_JUMP) {
        const swing_window_t window = window_of(input, input->seen->axis);
        add(step, tuning, &window, results);
        step->windows++;
        if (step->windows >= periods_of(LEAST, tuning->window)) {
            standing_wait(&step->standing);
            step->phase = (int32_t)SWING_REST;
        }
        return commission_goes_on();
    }
    if (step->phase == (int32_t)SWING_REST) {
        const swing_window_t window = window_of(input, input->seen->axis);
        add(step, tuning, &window, results);
    }
    const standing_want_t want = {periods_of(BLOCK, tuning->window), order->current,
                                  ACROSS * order->current + ACROSS_LEAST};
    const standing_state_t state = standing_step(&step->standing, want, input->seen);
    if (state != STANDING_STEADY) {
        return standing_verdict(state);
    }
    if (step->phase == (int32_t)SWING_REST) {
        return judge(step, input, results, order);
    }
    step->rest[0] = rest_of(step, results, order->axis);
    jump(step, input, (ab_t){0.0f, 0.0f}, order);
    return commission_goes_on();
}
