#include "medium/manoeuvre/lock.h"

#include "math/periods.h"

/* Below this share of `speed_slow` the least projection no longer falls with the speed. */
#define FLOOR_SHARE 0.4f

lock_tuning_t lock_prepare(const lock_params_t *params)
{
    return (lock_tuning_t){
        .share = lowpass_share(LOCK_CUTOFF, params->period),
        .flux_linkage = params->flux_linkage,
        .speed_floor = FLOOR_SHARE * params->speed_slow,
        .speed_slow = params->speed_slow,
        .speed_asked = params->speed_asked,
        .standing = 2u * periods_of(LOCK_STANDING, params->period),
    };
}

void lock_init(lock_t *lock, const lock_tuning_t *tuning)
{
    lock_take(lock, tuning);
    lock_reset(lock, 0.0f);
}

void lock_reset(lock_t *lock, float omega_e)
{
    const float speed = bounds_magnitude(omega_e);
    const float floor = lock->tuning.speed_floor;
    lock->expected = lock->tuning.flux_linkage * (speed > floor ? speed : floor);
    lock->projection = lock->expected;
    lock->scatter = 0.0f;
    lock->stood = 0u;
}
