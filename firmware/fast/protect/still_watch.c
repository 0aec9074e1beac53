#include "fast/protect/still_watch.h"

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

bool still_watch_judge(still_watch_t *watch, const still_watch_tuning_t *tuning,
                       const still_watch_input_t *input)
{
    const abc_t current = input->current;
    const abc_t jump = jumps(watch, input->voltage);
    const float wanted[3] = {input->asked.a, input->asked.b, input->asked.c};
    const float jumped[3] = {jump.a, jump.b, jump.c};
    const bool alone = bounds_within(current.a, tuning->none) || bounds_within(current.b, tuning->none) ||
                       bounds_within(current.c, tuning->none);
    const float most = alone ? tuning->far : tuning->off;
    const float push = explained(watch, tuning, input->u_dc, input->omega_e);
    const bool counts = !input->limited || input->u_dc > tuning->slow;
    const bool sound = tuning->sensors == 3u && winding_adds_up(&current, tuning->off);
    bool stuck = false;
    for (uint32_t n = 0; n < tuning->sensors; n++) {
        const uint32_t still = watch->still[n];
        if (still <= STILL_SOME) {
            watch->off[n] = 0u;
        }
        if (still < STILL_SOME) {
            continue;
        }
        const bool off = counts && !bounds_within(wanted[n] - watch->value[n], most);
        const bool pushed = watch->off[n] >= PUSHED || !bounds_within(jumped[n], push);
        watch->off[n] = pushed ? PUSHED : off ? watch->off[n] + 1u : 0u;
        stuck = stuck || (watch->off[n] >= OFF_PERIODS && (!alone || still >= ALONE));
    }
    return stuck && !sound;
}
