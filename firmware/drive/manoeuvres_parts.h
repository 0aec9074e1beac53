/* What the files of manoeuvres.h share; nobody else. */
#ifndef DRIVE_MANOEUVRES_PARTS_H
#define DRIVE_MANOEUVRES_PARTS_H

#include "drive/manoeuvres.h"
#include "math/bounds.h"

/* A catch takes so long. */
#define CATCH_PERIODS DRIVE_PERIODS(20e-3f)

/* Another manoeuvre begins; its rooms are entered by the caller, or by the two that follow. */
void manoeuvres_enter(manoeuvres_t *m, manoeuvre_t manoeuvre);

/* A catch of so many periods, from this speed [rad/s]; and run, from this current [A] in the rotor's frame at
 * this speed [rad/s], electrical. */
void manoeuvres_enter_catch(manoeuvres_t *m, manoeuvre_t manoeuvre, uint32_t periods, float omega_e);
void manoeuvres_enter_run(manoeuvres_t *m, dq_t current, float omega_e);

/* The speed that is wished for [rad/s], electrical; a wish for a current starts in its direction. */
static inline float manoeuvres_wanted(const manoeuvres_t *m, const run_wish_t *wish)
{
    switch (wish->mode) {
    case RUN_SPEED:
        return wish->omega_m_ref * m->limits.pole_pairs;
    case RUN_CURRENT:
        return wish->current.q < 0.0f ? -m->limits.handover_speed : m->limits.handover_speed;
    case RUN_ZERO:
    case RUN_STOP:
        break;
    }
    return 0.0f;
}

/* Does control turn with an estimate that may be judged? Not shortly after a hand-over, nor in a reversal
 * where there is no EMF, and should be none: its length [V] and the speed of the estimate [rad/s] are both
 * less than at handover_speed. */
static inline void manoeuvres_judge(manoeuvres_t *m, float amplitude, float omega_e)
{
    const float fast = m->limits.handover_speed;
    const bool clear =
        m->reversing == 0u || amplitude > m->limits.flux_linkage * fast || !bounds_within(omega_e, fast);
    m->judged = m->now == (int32_t)MANOEUVRE_RUN && clear && m->periods > MANOEUVRE_MASKED_PERIODS &&
                m->sensorless != 0u;
}

/* The loop shall be locked there in this period, on an EMF of this length [V]. */
void manoeuvres_lock_to(manoeuvres_t *m, position_t position, float emf);

/* Run in this frame of the rotor, with this EMF [V] and mechanical speed [rad/s]; the change from one source
 * to another while running keeps the voltage. */
static inline void manoeuvres_run_by(manoeuvres_t *m, const manoeuvres_input_t *input, const frame_t *rotor,
                                     dq_t emf, float omega_m, demand_t *demand)
{
    demand->frame = *rotor;
    demand->change = (int32_t)(m->other_source != 0u ? FRAME_TURNS : FRAME_GOES_ON);
    demand->emf = emf;
    run_step(&m->run, &input->wish, rotor->omega_e, omega_m, demand);
    m->other_source = 0u;
}

/* Run in the estimate's frame at this mechanical speed [rad/s], with the EMF that is observed, as the loop
 * filters it: within a period or two it is right whatever the angle, so that an angle that is lost sets no
 * current free. */
static inline void manoeuvres_run_observed(manoeuvres_t *m, const manoeuvres_input_t *input, float omega_m,
                                           demand_t *demand)
{
    manoeuvres_run_by(m, input, &input->estimate->frame, input->estimate->emf_loop, omega_m, demand);
}

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
