/* R and the voltage that a leg loses by its dead time, from a staircase of currents on a standing vector, in
 * six directions:
 *
 *     u = R i + 4/3 V      u: voltage of the duties along the axis, V: loss of a leg, whose sign is certain
 *                          for all three legs on these axes (currents i, -i/2, -i/2)
 *
 * The slope is the resistance of winding and devices, the rest at zero current is the loss. Offsets and
 * differences of the legs cancel in the mean of the directions; their scatter is the uncertainty.
 *
 * Zone: half width z of the linear passage of a leg's loss through zero current. In the last direction the
 * staircase continues downwards, to a current i at which the share m of 4/3 V is missing. Half of 4/3 V is
 * the loss of the first leg, half that of the other two, which carry only -i/2 and enter their zone first:
 *
 *     i = 2 z (1 - 2 m)      m <= 1/4: the first leg is outside of its zone
 *     i = 4/3 z (1 - m)      m > 1/4
 *
 * The current need not reach its reference, because the passage acts like a large resistance. */
#ifndef MEDIUM_COMMISSION_RESISTANCE_STEP_H
#define MEDIUM_COMMISSION_RESISTANCE_STEP_H

#include "medium/commission/standing.h"

#define RESISTANCE_DIRECTIONS 6u

typedef enum {
    RESISTANCE_BEGIN,
    RESISTANCE_FIRST,
    RESISTANCE_HALF,
    RESISTANCE_FULL,
    RESISTANCE_TURN,
    RESISTANCE_STILL,
    RESISTANCE_LEVELS,
    RESISTANCE_ZONE
} resistance_phase_t;

typedef struct {
    int32_t phase;      /* [-] resistance_phase_t */
    uint32_t direction; /* [-] in steps of 60 degrees */
    uint32_t level;     /* [-] of the staircase */
    uint32_t windows;   /* [windows] of this level */
    uint32_t repeated;  /* [-] 1: the second staircase */
    float current;      /* I_h [A] */
    dq_t first;         /* current and voltage of the first level [A], [V] */
    commission_mean_t mean;
    standing_t standing;
    float n, x, y, xx, xy;               /* sums of the line of this direction, about its first level */
    float slope[RESISTANCE_DIRECTIONS];  /* R by direction [ohm] */
    float before[RESISTANCE_DIRECTIONS]; /* the same of the first staircase [ohm] */
    float rest[RESISTANCE_DIRECTIONS];   /* 4/3 V by direction [V] */
} resistance_step_t;

void resistance_step_begin(resistance_step_t *step);

commission_verdict_t resistance_step(resistance_step_t *step, const commission_tuning_t *tuning,
                                     const commission_input_t *input, excite_order_t *order,
                                     commission_results_t *results);

#endif
