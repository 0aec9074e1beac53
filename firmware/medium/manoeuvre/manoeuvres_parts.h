/* Declarations shared by the files of manoeuvres.h alone. */
#ifndef MEDIUM_MANOEUVRE_MANOEUVRES_PARTS_H
#define MEDIUM_MANOEUVRE_MANOEUVRES_PARTS_H

#include "math/bounds.h"
#include "medium/manoeuvre/manoeuvres.h"

/* Another manoeuvre begins; the caller, or one of the next two functions,
 * initialises the modules that it uses. */
void manoeuvres_enter(manoeuvres_t *m, manoeuvre_t manoeuvre);

/* Begins a catch of this many periods, from this speed [rad/s]; or run, from this current [A] in the rotor's
 * frame at this speed [rad/s], electrical. */
void manoeuvres_enter_catch(manoeuvres_t *m, manoeuvre_t manoeuvre, uint32_t periods, float omega_e,
                            setpoint_t *setpoint);
void manoeuvres_enter_run(manoeuvres_t *m, dq_t current, float omega_e);

/* The requested speed [rad/s], electrical; for a requested current the motor starts
 * in the direction of the current. */
static inline float manoeuvres_wanted(const manoeuvres_t *m, const run_wish_t *wish)
{
    switch (wish->mode) {
    case RUN_SPEED:
        return wish->omega_m_ref * m->limits.pole_pairs;
    case RUN_CURRENT:
        return wish->current.q < 0.0f ? -m->limits.handover_speed : m->limits.handover_speed;
    case RUN_TORQUE:
        return wish->torque < 0.0f ? -m->limits.handover_speed : m->limits.handover_speed;
    case RUN_ZERO:
    case RUN_STOP:
        break;
    }
    return 0.0f;
}

/* Updates whether control uses an estimate that may be judged: not shortly after a hand-over, and not in a
 * reversal while no EMF is expected or present: its length [V] and the estimated speed [rad/s] are both
 * below those at handover_speed. */
static inline void manoeuvres_judge(manoeuvres_t *m, float amplitude, float omega_e)
{
    const float fast = m->limits.handover_speed;
    const bool clear =
        m->reversing == 0u || amplitude > m->limits.flux_linkage * fast || !bounds_within(omega_e, fast);
    m->judged =
        m->now == (int32_t)MANOEUVRE_RUN && clear && m->windows > MANOEUVRE_MASKED && m->sensorless != 0u;
}

/* Run at this electrical and mechanical speed of the rotor [rad/s]; a change of the source
 * while running keeps the voltage. */
static inline void manoeuvres_run_at(manoeuvres_t *m, const manoeuvres_input_t *input, float omega_e,
                                     float omega_m, setpoint_t *setpoint)
{
    setpoint->source = (int32_t)(m->sensorless != 0u ? SOURCE_ESTIMATE : SOURCE_ENCODER);
    if (m->other_source != 0u) {
        setpoint->change = (int32_t)FRAME_TURNS;
        setpoint->lock = setpoint->lock == (int32_t)LOCK_KEEP ? (int32_t)LOCK_FOLLOWS : setpoint->lock;
    }
    run_step(&m->run, &input->wish, omega_e, omega_m, &setpoint->current, &setpoint->omega_m_ref);
    setpoint->current.q = m->run.i_q_standing;
    setpoint->stiffness = m->run.stiffness;
    m->other_source = 0u;
}

/* One window of each manoeuvre. */
void manoeuvres_catch(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);
void manoeuvres_begin_start(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);
void manoeuvres_align(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);
void manoeuvres_force(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);
void manoeuvres_hand_over(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);
void manoeuvres_fall_back(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);
void manoeuvres_run(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);
void manoeuvres_run_on_encoder(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint);

#endif
