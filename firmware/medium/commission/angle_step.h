/* Direction of the d axis of a rotor that cannot turn, from its inductance in twelve directions theta. The
 * rotor is held by a brake or by the user.
 *
 *     1/L(theta) = y_0 + y_1 cos(theta - theta_d) + y_2 cos 2(theta - theta_d)
 *
 * y_2 is the saliency, which shows the axis but not its polarity. y_1 is the saturation: a standing current
 * along the flux of the magnets saturates the iron further, and lowers L; the opposite current raises it.
 * Therefore y_1 gives the direction with its polarity, also for L_q = L_d. The standing current changes y_2
 * as well, even its sign. Therefore the sine acts twice: without a standing current for y_2, with one for
 * y_1.
 *
 *     y_1 seen, y_2 not     theta_d is the phase of y_1
 *     y_1 and y_2 seen      theta_d is the axis by y_2 that is nearest to the phase of y_1
 *     y_1 not seen          `no_standstill_angle`; detail 1: y_2 is seen, the polarity is not known; detail
 *                           2: ripple and zone of the legs would bring a phase current to zero
 *
 * The directions are 15, 45, ... degrees. There no phase current of the standing current is near zero, and
 * the loss of the dead time is the same in all directions. A rotor that follows the current has the same L in
 * all directions, and ends the step with `no_standstill_angle`. */
#ifndef MEDIUM_COMMISSION_ANGLE_STEP_H
#define MEDIUM_COMMISSION_ANGLE_STEP_H

#include "medium/commission/sine_step.h"
#include "medium/commission/standing.h"

/* Details of `no_standstill_angle`. */
#define ANGLE_AXIS_ONLY 1
#define ANGLE_NOT_CLEAR 2

/* First and second harmonic of 1/L over the directions: sums [1/H]. */
typedef struct {
    float mean;
    float cos_1, sin_1;
    float cos_2, sin_2;
} angle_harmonics_t;

typedef enum { ANGLE_BEGIN, ANGLE_ALIGN, ANGLE_TURN, ANGLE_RUNS } angle_phase_t;

typedef struct {
    int32_t phase;      /* [-] angle_phase_t */
    uint32_t direction; /* [-] 0 to 12; with a standing current the last one is the first again */
    uint32_t biased;    /* [-] 1: with a standing current */
    uint32_t windows;   /* [windows] of this direction */
    uint32_t length;    /* [windows] whose sums it takes */
    float guess;        /* L by which the next voltage is chosen [H] */
    float bias;         /* largest standing current [A] */
    standing_t standing;
    sine_sum_t voltage;      /* sums of this direction [V], */
    sine_sum_t current;      /* along the sine [A] */
    angle_harmonics_t plain; /* without a standing current, */
    angle_harmonics_t bent;  /* with one */
} angle_step_t;

void angle_step_begin(angle_step_t *step);

commission_verdict_t angle_step(angle_step_t *step, const commission_tuning_t *tuning,
                                const commission_input_t *input, excite_order_t *order,
                                commission_results_t *results);

#endif
