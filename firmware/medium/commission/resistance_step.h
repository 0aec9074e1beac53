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
 * staircase continues downwards. The missing part of 4/3 V, integrated over the current i, is 3/4 z times 4/3
 * V: the missing share of a leg is a triangle of the area z/2 over its own current, and the two legs with
 * -i/2 reach the end of their zone only at i = 2 z. */
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
    float missing;                       /* of the loss at the last level, over the whole one [-] */
    float area;                          /* of the missing share over the current [A] */
} resistance_step_t;

void resistance_step_begin(resistance_step_t *step);

commission_verdict_t resistance_step(resistance_step_t *step, const commission_tuning_t *tuning,
                                     const commission_input_t *input, excite_order_t *order,
                                     commission_results_t *results);

#endif
