#include "fast/protect/still_watch.h"

#include <float.h>

#include "math/bounds.h"
#include "math/winding.h"

#define OFF_SHARE   0.05f    /* [-] of the range */
#define FAR_SHARE   0.15f    /* [-] of the range */
#define NONE_SHARE  0.0075f  /* [-] of the range: largest value of a phase without current */
#define OFF_PERIODS 4u       /* [periods]: a step of the reference is visible in the third sample */
#define ALONE       8u       /* [periods] without a change, where a phase has almost no current */
#define PUSHED      0x10000u /* [periods] in place of a count, after a jump of the voltage */
#define PUSH_SHARE  0.1f     /* [-] of the range: current that a jump of the voltage would have changed */
/* The largest change of the dead time's loss: the loss of three legs, 4/3 of that of one, with the opposite
 * sign in two periods. */
#define PUSH_DEAD 5.33333333f /* [-] */
/* [periods] sum of the distances from the first of three periods to the others, one and two */
#define PUSH_TURN 3.0f

still_watch_tuning_t still_watch_prepare(const still_watch_params_t *params)
{
    const uint32_t sensors = params->three_sensors ? UINT32_C(3) : UINT32_C(2);
    return (still_watch_tuning_t){
        .sensors = params->judged ? sensors : 0u,
        .off = OFF_SHARE * params->range,
        .far = FAR_SHARE * params->range,
        .none = NONE_SHARE * params->range,
        .slow = winding_slow_link(params->inductance, params->range, params->period),
        .push = PUSH_SHARE * params->range * params->inductance / params->period + PUSH_DEAD * params->drop,
        .push_link = PUSH_DEAD * params->dead_time / params->period,
        .turn = PUSH_TURN * params->period,
    };
}

/* The jump of the voltage of each phase [V]: the sum of the last two of three periods, minus twice the
 * voltage of the first one. The control responds to a sample in the second of three periods. */
static abc_t jumps(const still_watch_t *watch, ab_t voltage)
{
    const ab_t was = watch->voltage[1];
    return frames_inverse_clarke((ab_t){voltage.alpha + watch->voltage[0].alpha - 2.0f * was.alpha,
                                        voltage.beta + watch->voltage[0].beta - 2.0f * was.beta});
}

/* Largest jump that a rotating EMF, the dead time and a small change of the current explain [V]. */
static float explained(const still_watch_t *watch, const still_watch_tuning_t *tuning, float u_dc,
                       float omega_e)
{
    const ab_t was = watch->voltage[1];
    const float length = bounds_magnitude(was.alpha) + bounds_magnitude(was.beta);
    return tuning->push + tuning->push_link * u_dc + tuning->turn * bounds_magnitude(omega_e) * length;
}

/* Limits of a period. */
typedef struct {
    float off;       /* largest difference from the reference [A] */
    float push;      /* largest jump of the voltage [V] */
    uint32_t stands; /* [periods] for which a stuck value has not changed at least */
} limits_t;

/* Limits for these inputs. While the link allows only a slow change, no difference counts. */
static limits_t limits_of(const still_watch_t *watch, const still_watch_tuning_t *tuning,
                          const still_watch_input_t *input)
{
    const abc_t current = *input->current;
    const bool alone = bounds_within(current.a, tuning->none) || bounds_within(current.b, tuning->none) ||
                       bounds_within(current.c, tuning->none);
    const bool counts = !input->limited || input->u_dc > tuning->slow;
    return (limits_t){
        .off = !counts ? FLT_MAX : alone ? tuning->far : tuning->off,
        .push = explained(watch, tuning, input->u_dc, input->omega_e),
        .stands = alone ? ALONE : STILL_SOME,
    };
}

/* One period of sensor `n`, with the reference [A] and the jump of the voltage [V] of its phase. true: it is
 * stuck. */
static inline bool is_stuck(still_watch_t *watch, uint32_t n, float asked, float jump, const limits_t *limits)
{
    const uint32_t still = watch->still[n];
    if (still < STILL_SOME) {
        watch->off[n] = 0u;
        return false;
    }
    uint32_t off = still == STILL_SOME ? 0u : watch->off[n];
    if (off >= PUSHED || !bounds_within(jump, limits->push)) {
        off = PUSHED;
    } else {
        off = bounds_within(asked - watch->value[n], limits->off) ? 0u : off + 1u;
    }
    watch->off[n] = off;
    return off >= OFF_PERIODS && still >= limits->stands;
}

bool still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning,
                       const still_watch_input_t *input)
{
    const abc_t asked = frames_inverse_clarke(input->asked);
    const abc_t jump = jumps(watch, *input->voltage);
    const limits_t limits = limits_of(watch, tuning, input);
    const bool a = is_stuck(watch, 0u, asked.a, jump.a, &limits);
    const bool b = is_stuck(watch, 1u, asked.b, jump.b, &limits);
    if (tuning->sensors < 3u) {
        return a || b;
    }
    const bool c = is_stuck(watch, 2u, asked.c, jump.c, &limits);
    return (a || b || c) && !winding_adds_up(input->current, tuning->off);
}
