/* Declarations shared by the files of the medium task alone. */
#ifndef MEDIUM_MEDIUM_PARTS_H
#define MEDIUM_MEDIUM_PARTS_H

#include "medium/medium.h"

/* The steps of the task, in the order in which it takes them. */

/* Means of the window, and the values learnt from them: offsets of the sensors, psi_f,
 * inertia and load, dead time, L and R. */
void medium_learn(medium_t *medium, const medium_tuning_t *tuning, const window_t *window);

/* medium->found.current_faults: errors of current sensors and wires by the law of the winding. */
void medium_watch_currents(medium_t *medium, const window_t *window);

/* medium->found.encoder_wrong and moves_wrong: errors of encoder and shaft by the motion of the rotor. The
 * encoder is replaced here if it is wrong. */
void medium_watch_motion(medium_t *medium, const window_t *window, const requests_t *requests);

/* The current limits by heat and by the current of the supply, the state of the DC link, and the bridge off
 * while a supply is lost. */
void medium_limit(medium_t *medium, const medium_tuning_t *tuning, const window_t *window,
                  const requests_t *requests);

/* The brake resistor, and the holding brake. */
void medium_watch_outputs(medium_t *medium, const medium_tuning_t *tuning, const window_t *window);

/* The outputs of the board that the setpoint permits: DRIVE_OUTPUT_... bits. `bridge` [-] 1: the bridge has
 * to be on.
 */
uint32_t medium_outputs(const medium_t *medium, const medium_tuning_t *tuning, uint32_t bridge);

/* The request while the holding brake is not released: its pre-torque, then speed zero. */
void medium_hold(const medium_t *medium, const medium_tuning_t *tuning, run_wish_t *wish);

/* The measurements at the end of the window, for a fault with this reason. */
drive_fault_t medium_seen_in(const window_t *window, int32_t reason);

/* The inputs of the manoeuvres from a window. */
manoeuvres_input_t medium_manoeuvres_input(medium_t *medium, const window_t *window, run_wish_t wish);

#endif
