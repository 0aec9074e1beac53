#include "fast/reference/catch.h"

#include <stdbool.h>

#include "math/angle.h"
#include "math/bounds.h"
#include "math/filter.h"
#include "math/periods.h"
#include "math/root.h"
#include "math/trig.h"

#define TRAIL_CUTOFF  200.0f /* [rad/s] of <e>: the slowest rotor rotates by some degrees in 1/200 s */
#define TRAIL_MOST    0.08f  /* [-] largest expected e x <e>/e^2: omega/200 of a slow rotor */
#define TRAIL_PART    0.4f   /* [-] required part of the expected value */
#define TRAIL_FAST    0.6f /* [-] of the share of the low-pass: a rotor faster than FAST makes at least 0.77 */
#define STEADY_PART   0.7f     /* [-] of the EMF of the slowest rotor: least mean in its frame */
#define LENGTH_PART   0.6f     /* [-] of <|e|>: least mean in its frame; of noise alone 0.2 remains */
#define CLEAR_OF_ZONE 3.0f     /* [-] of the doubtful current: b and c carry half of the current of a */
#define LENGTH_CUTOFF 330.0f   /* [rad/s] of <|e|> */
#define EMF_CUTOFF    600.0f   /* [rad/s] a fifth of the noise remains, 3 % of the start after 6 ms */
#define SLIP_NATURAL  430.0f   /* [rad/s] of the loop of the slip: damping 0.7 with EMF_CUTOFF */
#define SLIP_SPEED    80.0f    /* [rad/s] below it the EMF is too noisy, and the error is within reach */
#define SLIP_MOST     0.5f     /* [-] of <|e|>/psi_f: an error of psi_f by a third */
#define SLIP_SURE     0.1f     /* [-] of <|e|>/psi_f: 6 ms leave a sixth of the slip, 1.7 % of the speed */
#define TURN_CUTOFF   3000.0f  /* [rad/s] of the turn in a period: an eighth of the noise, within 0.3 ms */
#define FAST          500.0f   /* [rad/s] from here on the EMF is so long that its turn shows the speed */
#define EARLY_TIME    0.6e-3f  /* [s] the observer's error is a tenth of the EMF by then, and decreases */
#define EARLY_TURN    0.1f     /* [rad] in a period, from here on noise in the turn is so small ... */
#define EARLY_PERIODS 3u       /* [periods] ... that it is valid as soon as it agrees with the length */
#define SEEN_TIME     2.0e-3f  /* [s] the observer has converged by then: the mean begins there */
#define SETTLED_TIME  4.0e-3f  /* [s] the sum of the direction has a sign by then */
#define SURE_TIME     10.0e-3f /* [s] the lengths have settled by then */
#define SURE_TURN     1.0f     /* [rad] since the direction is known */
#define BEYOND_TIME   1.0e-3f  /* [s] */

float catch_current_along(float doubtful, float current_d, bool salient)
{
    const float clear = CLEAR_OF_ZONE * doubtful;
    const float along = current_d > clear ? current_d : clear;
    return salient ? -along : along;
}

catch_tuning_t catch_prepare(const catch_params_t *params)
{
    const float clear = CLEAR_OF_ZONE * params->doubtful;
    const float slowest = params->flux_linkage * params->speed_min;
    return (catch_tuning_t){
        .trail_share = lowpass_share(TRAIL_CUTOFF, params->period),
        .trail_time = 1.0f / TRAIL_CUTOFF,
        .length_share = lowpass_share(LENGTH_CUTOFF, params->period),
        .emf_share = lowpass_share(EMF_CUTOFF, params->period),
        .turn_share = lowpass_share(TURN_CUTOFF, params->period),
        .period = params->period,
        .frequency = 1.0f / params->period,
        .speed_per_volt = 1.0f / params->flux_linkage,
        .speed_min = params->speed_min,
        .emf_min_square = STEADY_PART * STEADY_PART * slowest * slowest,
        .current = clear,
        .current_d = catch_current_along(params->doubtful, params->current_d, params->salient),
        .lead = 1.5f * params->period,
        .reach = params->reach,
        .early = periods_of(EARLY_TIME, params->period),
        .seen = periods_of(SEEN_TIME, params->period),
        .settled = periods_of(SETTLED_TIME, params->period),
        .sure = periods_of(SURE_TIME, params->period),
        .turn_sure = SURE_TURN / params->period,
        .beyond = periods_of(BEYOND_TIME, params->period),
    };
}

void catch_enter(catch_t *catching, uint32_t periods, float omega_e)
{
    catching->trail = (ab_t){0.0f, 0.0f};
    catching->seen.emf = (ab_t){0.0f, 0.0f};
    catching->seen.cross = 0.0f;
    catching->turn = (ab_t){0.0f, 0.0f};
    catching->seen.cross_min = 0.0f;
    catching->seen.length = 0.0f;
    catching->slip = 0.0f;
    catching->omega_e = omega_e;
    catching->turned = 0.0f;
    catching->periods = 0u;
    catching->seen.turning = 0u;
    catching->found = 0u;
    catching->wanted = periods;
    catching->seen.periods_beyond = 0u;
}

/* Direction of the d axis for this EMF, whose speed has the sign of omega_e. */
static rotation_t direction(ab_t emf, float omega_e)
{
    const float square = emf.alpha * emf.alpha + emf.beta * emf.beta;
    const float share = omega_e < 0.0f ? -inverse_root(square) : inverse_root(square);
    return (rotation_t){-share * emf.alpha, share * emf.beta};
}

/* Rotates a vector [V] by the angle that the rotor turns in this time [s]. */
static ab_t turned_on(const catch_t *catching, ab_t emf, float time)
{
    static const rotation_t none = {0.0f, 1.0f};
    return frames_inverse_park((dq_t){emf.alpha, emf.beta}, trig_advance(none, time * catching->omega_e));
}

/* One period of the slip: `emf` is compared with `before`, the vector of the frame, whose low-pass is the
 * proportional part of the loop. The natural frequency of the loop is not above the rotor's speed, because
 * a constant voltage error rotates in this frame. Its effect on the slip is limited to its share of the EMF.
 */
static float slip_of(const catch_t *catching, const catch_tuning_t *tuning, ab_t before, ab_t emf,
                     float speed)
{
    const float across = before.alpha * emf.beta - before.beta * emf.alpha;
    const float sine = across * inverse_root(before.alpha * before.alpha + before.beta * before.beta) *
                       inverse_root(emf.alpha * emf.alpha + emf.beta * emf.beta);
    const float natural = bounds_clamp(speed > SLIP_SPEED ? speed - SLIP_SPEED : 0.0f, SLIP_NATURAL);
    return bounds_clamp(catching->slip + natural * natural * tuning->period * sine, SLIP_MOST * speed);
}

/* true: the mean EMF in its frame is long enough for the slowest rotor, and not much shorter than the mean of
 * the EMF's length. Noise has a length but no mean: where noise dominates, the length is no speed. */
static bool is_steady(const catch_t *catching, const catch_tuning_t *tuning)
{
    const ab_t emf = catching->seen.emf;
    const float square = emf.alpha * emf.alpha + emf.beta * emf.beta;
    const float length = LENGTH_PART * catching->seen.length;
    return square >= tuning->emf_min_square && square >= length * length;
}

/* Speed from the turn of the EMF in a period [rad/s]: the arc of its sine by a series, within 0.06 % to 0.63
 * rad and 2 % to 1.05 rad. The lag of an observer that has found the EMF is constant, and has no effect. */
static float turning_speed(catch_t *catching, const catch_tuning_t *tuning, ab_t last, ab_t emf)
{
    ab_t turn = catching->turn;
    turn.alpha = lowpass_step(turn.alpha, tuning->turn_share, last.alpha * emf.alpha + last.beta * emf.beta);
    turn.beta = lowpass_step(turn.beta, tuning->turn_share, last.alpha * emf.beta - last.beta * emf.alpha);
    catching->turn = turn;
    const float sine = turn.beta * inverse_root(turn.alpha * turn.alpha + turn.beta * turn.beta);
    const float square = sine * sine;
    const float arc =
        sine * (1.0f + square * (1.0f / 6.0f + square * (3.0f / 40.0f + 5.0f / 112.0f * square)));
    return tuning->frequency * arc;
}

/* Updates omega_e. `last`: the EMF of the last period; after the loop of the slip has started, this EMF
 * rotated with the rotor by one period. Noise, and a voltage error that does not rotate, are excluded because
 * their rotation does not agree with their length. */
static void find_speed(catch_t *catching, const catch_tuning_t *tuning, ab_t last, ab_t emf)
{
    const float speed = catching->seen.length * tuning->speed_per_volt;
    if (catching->periods < tuning->settled) {
        const float by_turn = turning_speed(catching, tuning, last, emf);
        const float apart = bounds_magnitude(by_turn) - speed;
        catching->slip = 0.0f;
        const uint32_t early = speed * tuning->period < EARLY_TURN ? tuning->early : EARLY_PERIODS;
        if (speed >= FAST && bounds_within(apart, SLIP_MOST * speed) && catching->periods >= early) {
            catching->omega_e = by_turn;
            catching->slip = by_turn < 0.0f ? -apart : apart;
        }
        return;
    }
    const float signed_speed = catching->seen.cross < 0.0f ? -speed : speed;
    if (catching->periods > tuning->settled) { /* from here on `last` is rotated with the rotor */
        catching->slip = slip_of(catching, tuning, last, emf, speed);
    }
    catching->omega_e = signed_speed + catching->slip;
    catching->turned += speed;
}

catch_outcome_t catch_step(catch_t *catching, const catch_tuning_t *tuning, ab_t emf, float length,
                           float voltage_max)
{
    catching->seen.cross += catching->trail.alpha * emf.beta - catching->trail.beta * emf.alpha;
    catching->trail.alpha = lowpass_step(catching->trail.alpha, tuning->trail_share, emf.alpha);
    catching->trail.beta = lowpass_step(catching->trail.beta, tuning->trail_share, emf.beta);
    const float share = catching->periods < tuning->seen ? 1.0f : tuning->length_share;
    catching->seen.length = lowpass_step(catching->seen.length, share, length);
    const ab_t last = catching->seen.emf;
    const ab_t before = turned_on(catching, last, tuning->period);
    const float along = catching->periods < tuning->settled ? 1.0f : tuning->emf_share;
    catching->seen.emf.alpha = lowpass_step(before.alpha, along, emf.alpha);
    catching->seen.emf.beta = lowpass_step(before.beta, along, emf.beta);
    catching->seen.periods_beyond =
        length > tuning->reach * voltage_max ? catching->seen.periods_beyond + 1u : 0u;
    catching->periods++;
    const float speed = catching->seen.length * tuning->speed_per_volt;
    const float slow = TRAIL_PART * bounds_clamp(speed * tuning->trail_time, TRAIL_MOST);
    catching->seen.cross_min += (speed < FAST ? slow : TRAIL_FAST * tuning->trail_share) *
                                catching->seen.length * catching->seen.length;
    if (catching->seen.periods_beyond >= tuning->beyond) {
        return CATCH_TOO_FAST;
    }
    const bool crosses = bounds_magnitude(catching->seen.cross) >= catching->seen.cross_min;
    find_speed(catching, tuning, catching->periods < tuning->settled ? last : before, emf);
    const bool turning = crosses && speed >= tuning->speed_min && is_steady(catching, tuning);
    catching->seen.turning = turning && catching->periods >= tuning->settled;
    const bool found =
        bounds_within(catching->slip, SLIP_SURE * speed); /* the loop of the slip has settled */
    const bool sure = found && catching->periods >= tuning->sure && catching->turned >= tuning->turn_sure;
    const bool over = catching->periods >= catching->wanted;
    if (turning && (sure || over)) {
        catching->found = 1u;
        return CATCH_TURNING;
    }
    return over ? CATCH_STANDING : CATCH_GOES_ON;
}

void catch_turn(catch_t *catching, const catch_tuning_t *tuning)
{
    catching->seen.emf = turned_on(catching, catching->seen.emf, tuning->period);
}

ab_t catch_current(const catch_t *catching, const catch_tuning_t *tuning)
{
    if (catching->seen.turning == 0u) {
        return (ab_t){tuning->current, 0.0f};
    }
    const rotation_t rotor = direction(catching->seen.emf, catching->omega_e);
    return (ab_t){tuning->current_d * rotor.cos, tuning->current_d * rotor.sin};
}

ab_t catch_voltage(const catch_t *catching, const catch_tuning_t *tuning, ab_t emf)
{
    return turned_on(catching, emf, tuning->lead);
}

float catch_angle(ab_t emf, float omega_e)
{
    return trig_angle(direction(emf, omega_e));
}

frame_t catch_rotor(const catch_t *catching)
{
    const rotation_t rotor = direction(catching->seen.emf, catching->omega_e);
    return (frame_t){trig_angle(rotor), catching->omega_e, rotor};
}

float catch_length(const catch_t *catching)
{
    const ab_t emf = catching->seen.emf;
    const float square = emf.alpha * emf.alpha + emf.beta * emf.beta;
    return square * inverse_root(square);
}
