/* Checks the wiring by pulses that do not move the rotor: a motor is connected, no phase is open, and each
 * sensor is on its phase. The step also gives a first value of L.
 *
 *     zero vector   no current may flow
 *     search        pulses in three directions, with a voltage that grows by a quarter, later a longer pulse,
 *                   until an answer reaches 0.1 of the largest current, 0.4 A and 50 times the noise
 *     matrix        pulses in six directions: wiring_map.h
 *     less the three directions with 0.85 of the voltage: the difference of two answers contains no loss of
 *     the dead time, L = 0.15 U n T/(i(U) - i(0.85 U))
 *     map          the map of the sensors that fits the matrix best */
#ifndef MEDIUM_COMMISSION_WIRING_STEP_H
#define MEDIUM_COMMISSION_WIRING_STEP_H

#include "medium/commission/commission_types.h"
#include "medium/commission/wiring_map.h"

typedef enum { WIRING_ZERO, WIRING_SEARCH, WIRING_MATRIX, WIRING_COMPARE, WIRING_MAP } wiring_phase_t;

typedef struct {
    int32_t phase;      /* [-] wiring_phase_t */
    uint32_t direction; /* [-] of the present pulse, in steps of 60 degrees */
    uint32_t windows;   /* [windows] of the present pulse */
    float voltage;      /* [V] */
    uint32_t periods;   /* [periods] of half a pulse */
    uint32_t repeated;  /* [-] 1: the matrix is measured again, because its answers did not cancel */
    float largest;      /* answer of this search [A] */
    wiring_matrix_t matrix;
    ab_t sum;                       /* of the answers [A] */
    float lengths;                  /* of the answers, summed [A] */
    float along[WIRING_DIRECTIONS]; /* answers along their directions [A] */
    float inductances;              /* sum of L [H] */
    wiring_search_t search;
} wiring_step_t;

void wiring_step_begin(wiring_step_t *step);

/* One window; fills the order and results->inductance_pulse. */
commission_verdict_t wiring_step(wiring_step_t *step, const commission_tuning_t *tuning,
                                 const commission_input_t *input, excite_order_t *order,
                                 commission_results_t *results);

#endif
