/* One mechanical turn: the rotor follows a current vector by as many electrical turns as the plate has pole
 * pairs, forward, and stops. The pole pairs cannot be measured electrically, because p and J act alike; the
 * user sees whether the shaft has made one turn, and in which direction. */
#ifndef MEDIUM_COMMISSION_TURN_STEP_H
#define MEDIUM_COMMISSION_TURN_STEP_H

#include "medium/commission/standing.h"

typedef enum { TURN_BEGIN, TURN_ALIGN, TURN_TURNS, TURN_STILL } turn_phase_t;

typedef struct {
    int32_t phase; /* [-] turn_phase_t */
    float left;    /* electrical angle to go [rad] */
    standing_t standing;
} turn_step_t;

void turn_step_begin(turn_step_t *step);

commission_verdict_t turn_step(turn_step_t *step, const commission_tuning_t *tuning,
                               const commission_input_t *input, excite_order_t *order,
                               const commission_results_t *results);

#endif
