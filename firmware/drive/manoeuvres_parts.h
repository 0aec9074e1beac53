/* What the files of manoeuvres.h share; nobody else. */
#ifndef DRIVE_MANOEUVRES_PARTS_H
#define DRIVE_MANOEUVRES_PARTS_H

#include "drive/manoeuvres.h"

/* A catch takes so long. */
#define CATCH_PERIODS DRIVE_PERIODS(20e-3f)

/* Another manoeuvre begins; its rooms are entered by the caller, or by the two that follow. */
void manoeuvres_enter(manoeuvres_t *m, manoeuvre_t manoeuvre);

/* A catch of so many periods, from this speed [rad/s]; and run, from this current [A] in the rotor's frame at
 * this speed [rad/s], electrical. */
void manoeuvres_enter_catch(manoeuvres_t *m, manoeuvre_t manoeuvre, uint32_t periods, float omega_e);
void manoeuvres_enter_run(manoeuvres_t *m, dq_t current, float omega_e);

/* The speed that is wished for [rad/s], electrical; a wish for a current starts in its direction. */
float manoeuvres_wanted(const manoeuvres_t *m, const run_wish_t *wish);

/* The loop shall be locked there in this period. */
void manoeuvres_lock_to(manoeuvres_t *m, position_t position);

/* Run in the estimate's frame at this mechanical speed [rad/s], with the EMF that is observed, as the loop
 * filters it: within a period or two it is right whatever the angle, so that an angle that is lost sets no
 * current free. */
void manoeuvres_run_observed(manoeuvres_t *m, const manoeuvres_input_t *input, float omega_m,
                             demand_t *demand);

/* The demands of the manoeuvres, of one period each. */
void manoeuvres_catch(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);
void manoeuvres_begin_start(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);
void manoeuvres_align(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);
void manoeuvres_force(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);
void manoeuvres_hand_over(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);
void manoeuvres_fall_back(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);
void manoeuvres_run(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);
void manoeuvres_run_on_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand);

#endif
