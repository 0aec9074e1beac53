#include <string.h>

#include "drive/manoeuvres_parts.h"

void manoeuvres_enter(manoeuvres_t *m, manoeuvre_t manoeuvre)
{
    m->now = (int32_t)manoeuvre;
    m->periods = 0u;
    m->stall_periods = 0u;
    m->slow_periods = 0u;
    m->judged = 0u;
    m->unlocked = 0u;
}

void manoeuvres_enter_catch(manoeuvres_t *m, manoeuvre_t manoeuvre, uint32_t periods, float omega_e)
{
    manoeuvres_enter(m, manoeuvre);
    catch_enter(&m->catching, periods, omega_e);
    m->tracking = 0u;
}

void manoeuvres_enter_run(manoeuvres_t *m, dq_t current, float omega_e)
{
    manoeuvres_enter(m, MANOEUVRE_RUN);
    m->tracking = 1u;
    m->reversing = 0u;
    m->proving = 0u;
    m->sound_periods = 0u;
    m->omega_ref = omega_e;
    lock_reset(&m->lock, omega_e);
    run_enter(&m->run, current, omega_e * m->limits.pole_pairs_inverse);
}

void manoeuvres_lock_to(manoeuvres_t *m, position_t position, float emf)
{
    m->locking = 1u;
    m->locked = position;
    m->locked_emf = emf;
    m->tracking = 1u;
    lock_reset(&m->lock, position.omega_e);
}

/* Where control's angle comes from now; is it another source than before? */
static uint32_t source(manoeuvres_t *m, uint32_t sensorless)
{
    const uint32_t other = m->sensorless != sensorless ? UINT32_C(1) : UINT32_C(0);
    m->sensorless = sensorless;
    run_keep_low(&m->run, sensorless != 0u);
    return other;
}

void manoeuvres_init(manoeuvres_t *m, const manoeuvres_tuning_t *tuning)
{
    memset(m, 0, sizeof *m);
    forced_init(&m->forced, &tuning->forced);
    catch_init(&m->catching, &tuning->catching);
    handover_init(&m->handover, &tuning->handover);
    lock_init(&m->lock, &tuning->lock);
    proof_init(&m->proof, &tuning->proof);
    run_init(&m->run, &tuning->run);
    m->limits = tuning->limits;
    (void)source(m, m->limits.sensorless);
    manoeuvres_enter(m, MANOEUVRE_OFF);
}

void manoeuvres_take(manoeuvres_t *m, const manoeuvres_tuning_t *tuning)
{
    forced_take(&m->forced, &tuning->forced);
    catch_take(&m->catching, &tuning->catching);
    handover_take(&m->handover, &tuning->handover);
    lock_take(&m->lock, &tuning->lock);
    proof_take(&m->proof, &tuning->proof);
    run_take(&m->run, &tuning->run);
    m->limits = tuning->limits;
    m->other_source = source(m, m->limits.sensorless | m->encoder_lost);
    if (m->other_source != 0u) {
        manoeuvres_judge(m, 0.0f, 0.0f); /* in a reversal not before run has seen the EMF */
    }
}

void manoeuvres_begin(manoeuvres_t *m, float omega_m)
{
    m->start_try = 0u;
    m->lock_losses = 0u;
    m->failed = 0u;
    m->encoder_lost = 0u;
    run_calm(&m->run, true);
    (void)source(m, m->limits.sensorless);
    if (m->sensorless != 0u) {
        manoeuvres_enter_catch(m, MANOEUVRE_CATCH, CATCH_PERIODS, 0.0f);
    } else {
        manoeuvres_enter_run(m, (dq_t){0.0f, 0.0f}, omega_m * m->limits.pole_pairs);
    }
}

void manoeuvres_step(manoeuvres_t *m, const manoeuvres_input_t *input, demand_t *demand)
{
    m->clock++;
    m->periods++;
    m->locking = 0u;
    if (m->sensorless == 0u) {
        manoeuvres_run_on_encoder(m, input, demand);
        return;
    }
    switch ((manoeuvre_t)m->now) {
    case MANOEUVRE_OFF:
    case MANOEUVRE_CATCH:
    case MANOEUVRE_RELOCK:
        manoeuvres_catch(m, input, demand);
        break;
    case MANOEUVRE_ALIGN:
        manoeuvres_align(m, input, demand);
        break;
    case MANOEUVRE_RAMP:
    case MANOEUVRE_FORCED:
    case MANOEUVRE_REVERSE:
        manoeuvres_force(m, input, demand);
        break;
    case MANOEUVRE_HANDOVER:
        manoeuvres_hand_over(m, input, demand);
        break;
    case MANOEUVRE_RUN:
        manoeuvres_run(m, input, demand);
        break;
    }
}
