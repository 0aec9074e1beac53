#include "medium/protect/motion_watch.h"

#include <string.h>

#include "math/bounds.h"
#include "math/filter.h"
#include "math/periods.h"

/* [-] least approach to the reference over the noise of the speed. */
#define PROGRESS_NOISE 2.0f
#define PROGRESS_LEAST 0.5f /* [rad/s] */

/* [-] least speed of a runaway that is reported, over the speed at its beginning. */
#define GROWN 1.1f

/* Number of judgements in this time; 0 only for a time of 0. */
static uint32_t judgements_in(float time, float period)
{
    const uint32_t whole = periods_of(time, period);
    return time > 0.0f && whole == 0u ? 1u : whole;
}

static float larger(float a, float b)
{
    return a > b ? a : b;
}

motion_watch_tuning_t motion_watch_prepare(const motion_watch_params_t *params)
{
    const float period = params->period * (float)params->every;
    const float full = params->per_ampere * params->current_limit;
    const float tau = larger(MOTION_TAU_MIN, MOTION_TAU_NOISE * params->noise / full);
    const float share = lowpass_share(1.0f / tau, period);
    const float behind = period * (1.0f / share - 1.0f); /* delay of the low-pass in a ramp [s] */
    return (motion_watch_tuning_t){
        .share = share,
        .per_speed = 1.0f / (params->per_ampere * behind),
        .load_most = MOTION_LOAD_MOST * params->current_limit,
        .gained_most = MOTION_LOAD_HIT * full * behind,
        .pushes = MOTION_PUSHES * params->current_limit,
        .forgets = lowpass_share(1.0f / MOTION_SWING, period),
        .standing = params->standing,
        .progress = larger(PROGRESS_LEAST, PROGRESS_NOISE * params->noise),
        .runaway = judgements_in(larger(MOTION_RUNAWAY_TIME, MOTION_RUNAWAY_TAUS * tau), period),
        .stall = judgements_in(params->stall_time, period),
        .speed_error = judgements_in(params->speed_error_time, period),
        .overrun = judgements_in(MOTION_OVERRUN_TIME, period),
    };
}

void motion_watch_init(motion_watch_t *watch, const motion_watch_tuning_t *tuning)
{
    memset(watch, 0, sizeof *watch);
    motion_watch_take(watch, tuning);
}

/* Computes the load that explains the motion. True if the shaft gains speed against its current
 * by more than that load explains. */
static bool runs_away(motion_watch_t *watch, const motion_watch_input_t *input)
{
    const motion_watch_tuning_t *tuning = &watch->tuning;
    const float share = watch->settled != 0u ? tuning->share : 1.0f;
    watch->settled = 1u;
    watch->current = lowpass_step(watch->current, share, input->i_q);
    watch->omega = lowpass_step(watch->omega, share, input->omega_m);
    const float gained = bounds_clamp(input->omega_m - watch->omega, tuning->gained_most);
    watch->omega = input->omega_m - gained;
    watch->load = watch->current - tuning->per_speed * gained;
    return bounds_magnitude(watch->load) > tuning->load_most && watch->load * watch->current > 0.0f &&
           bounds_magnitude(watch->current) > tuning->pushes && gained * watch->current < 0.0f &&
           gained * input->omega_m > 0.0f;
}

/* True if the current is at its limit, and the speed is neither at its
 * reference nor nearer to it than before. */
static bool is_stuck(motion_watch_t *watch, const motion_watch_input_t *input)
{
    const motion_watch_tuning_t *tuning = &watch->tuning;
    const float off = input->omega_m_ref - input->omega_m;
    const float far = larger(MOTION_ASKED * bounds_magnitude(input->omega_m_ref), tuning->progress);
    const uint32_t forward = off > 0.0f ? UINT32_C(1) : UINT32_C(0);
    const float towards = forward != 0u ? input->omega_m : -input->omega_m;
    if (!input->asked || bounds_within(off, far) ||
        bounds_within(input->i_q_ref, MOTION_AT_LIMIT * input->limit)) {
        return false;
    }
    if (watch->stuck == 0u || forward != watch->forward || towards > watch->base + tuning->progress) {
        watch->forward = forward;
        watch->base = towards;
        watch->stuck = 0u;
    }
    return true;
}

/* True if a load has driven the shaft beyond its reference against all of the braking current, for
 * MOTION_OVERRUN_TIME and ever faster. */
static bool overruns(motion_watch_t *watch, const motion_watch_input_t *input)
{
    const motion_watch_tuning_t *tuning = &watch->tuning;
    const float speed = bounds_magnitude(input->omega_m);
    const float beyond = MOTION_OVERRUN * bounds_magnitude(input->omega_m_ref) + tuning->progress;
    const bool over = input->asked && input->i_q_ref * input->omega_m < 0.0f &&
                      input->omega_m * input->omega_m_ref > 0.0f && tuning->speed_error != 0u &&
                      speed > beyond && !bounds_within(input->i_q_ref, MOTION_AT_LIMIT * input->limit) &&
                      input->running > tuning->overrun;
    if (!over || watch->over == 0u || speed < watch->overrun) {
        watch->overrun = speed;
        watch->over = 0u;
        if (over) {
            watch->over = 1u;
        }
        return false;
    }
    watch->over = watch->over < tuning->overrun ? watch->over + 1u : tuning->overrun;
    return watch->over >= tuning->overrun && speed >= watch->overrun + tuning->progress;
}

uint32_t motion_watch_step(motion_watch_t *watch, const motion_watch_input_t *input)
{
    const motion_watch_tuning_t *tuning = &watch->tuning;
    uint32_t bits = 0u;
    if (!input->measured) {
        watch->settled = 0u;
        watch->away = 0u;
    } else {
        watch->away = runs_away(watch, input) && !input->confirmed ? watch->away + 1u : 0u;
    }
    const float speed = bounds_magnitude(input->omega_m);
    if (watch->away == 0u) {
        watch->calm = larger(speed, lowpass_step(watch->calm, tuning->forgets, speed));
    }
    if (watch->away >= tuning->runaway && speed >= GROWN * watch->calm) {
        watch->away = tuning->runaway;
        bits |= MOTION_RUNAWAY;
    }
    if (is_stuck(watch, input)) {
        watch->stuck++;
    } else if (watch->stuck > 0u) {
        watch->stuck--;
    }
    if (tuning->stall != 0u && watch->stuck >= tuning->stall &&
        bounds_within(input->omega_m, tuning->standing)) {
        bits |= MOTION_STALLED;
    }
    const bool overrun = overruns(watch, input);
    if (overrun || (tuning->speed_error != 0u && watch->stuck >= tuning->speed_error)) {
        bits |= MOTION_SPEED_ERROR;
    }
    return bits;
}
