/* What the files of the medium task share; nobody else. */
#ifndef MEDIUM_MEDIUM_PARTS_H
#define MEDIUM_MEDIUM_PARTS_H

#include "medium/medium.h"

/* The steps of the task, in the order in which it takes them. */

/* Means of the window, and what they teach: of the sensors' offsets, psi_f, inertia and load, dead time, L
 * and R. */
void medium_learn(medium_t *medium, const window_t *window);

/* medium->found.current_faults: what the winding says of current sensors and wires. */
void medium_watch_currents(medium_t *medium, const window_t *window);

/* medium->found.encoder_wrong and moves_wrong: what the motion of the rotor says of encoder and shaft. An
 * encoder that is wrong is left here. */
void medium_watch_motion(medium_t *medium, const window_t *window, const requests_t *requests);

/* What heat leaves of the current, what the DC link does, and the bridge off while a supply is lost. */
void medium_limit(medium_t *medium, const medium_tuning_t *tuning, const window_t *window,
                  const requests_t *requests);

/* What is seen at the end of the window, of a fault with this reason. */
drive_fault_t medium_seen_in(const window_t *window, int32_t reason);

/* What the manoeuvres are told of a window. */
manoeuvres_input_t medium_manoeuvres_input(medium_t *medium, const window_t *window, run_wish_t wish);

#endif
