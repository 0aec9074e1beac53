/* A motor that is held by a current vector, for the steps that need one: the gains of the hold, the slow turn
 * of its axis, and the test whether rotor and current have settled. */
#ifndef MEDIUM_COMMISSION_STANDING_H
#define MEDIUM_COMMISSION_STANDING_H

#include "math/angle.h"
#include "math/trig.h"
#include "medium/commission/commission_types.h"

typedef enum {
    STANDING_NOT_YET,
    STANDING_STEADY,
    STANDING_SWINGS, /* the current has its value, but the rotor does not come to rest */
    STANDING_NEVER   /* the current does not reach its value */
} standing_state_t;

typedef struct {
    float angle;            /* of the axis [rad] */
    uint32_t windows;       /* [windows] of the present block */
    uint32_t tries;         /* [-] blocks that have not agreed */
    float last;             /* mean voltage of the last block [V]; below 0: none yet */
    commission_mean_t mean; /* of the present block, or of the last one when steady */
} standing_t;

/* Points the axis at this angle [rad]. */
static inline void standing_point(standing_t *standing, float angle, excite_order_t *order)
{
    standing->angle = angle_wrap(angle);
    order->axis = trig_turn(standing->angle);
}

/* Begins a hold with zero current at this angle [rad]; the gains follow from L [H] and R [ohm] of the
 * results. */
void standing_begin(standing_t *standing, float angle, float u_dc, const commission_tuning_t *tuning,
                    const commission_results_t *results, excite_order_t *order);

/* The gains for a resistance that is now known [ohm]. */
void standing_gains(float u_dc, const commission_tuning_t *tuning, const commission_results_t *results,
                    excite_order_t *order);

/* Restarts the wait until rotor and current are steady. */
void standing_wait(standing_t *standing);

/* One window of the turn towards an angle [rad]. The turn is slower while a current flows across the axis,
 * because the rotor lags, or because the loss of the dead time lies on the axis only at multiples of 60
 * degrees. true: it has arrived. */
bool standing_turn(standing_t *standing, float angle, const commission_tuning_t *tuning,
                   const excite_seen_t *seen, excite_order_t *order);

/* The conditions for a steady rotor and current. */
typedef struct {
    uint32_t block; /* [windows] of a mean; two in succession agree */
    float current;  /* along the axis [A] */
    float across;   /* largest current across the axis of a rotor at rest [A] */
} standing_want_t;

/* The verdict on a step while its hold is not steady: it waits, or ends with a reason. */
static inline commission_verdict_t standing_verdict(standing_state_t state)
{
    if (state == STANDING_SWINGS) {
        return commission_failed(COMMISSION_REASON_ROTOR_SWINGS, 0);
    }
    return state == STANDING_NEVER ? commission_failed(COMMISSION_REASON_NO_STEADY_CURRENT, 0)
                                   : commission_goes_on();
}

/* One window. */
standing_state_t standing_step(standing_t *standing, standing_want_t want, const excite_seen_t *seen);

#endif
