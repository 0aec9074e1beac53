#include <string.h>

#include "medium/manoeuvre/manoeuvres_parts.h"

/* A power of two above the number of manoeuvres: an index that a flipped bit has changed still finds a row.
 */
#define ROWS 16u

static const manoeuvre_row_t rows[ROWS] = {
#define MANOEUVRE_ROW(NAME, name, source, compared, step) {(int32_t)(source), (int32_t)(compared)},
    MANOEUVRES(MANOEUVRE_ROW)
#undef MANOEUVRE_ROW
};

const manoeuvre_row_t *manoeuvres_row(const manoeuvres_t *m)
{
    return &rows[(uint32_t)m->now % ROWS];
}

void manoeuvres_enter(manoeuvres_t *m, manoeuvre_t manoeuvre)
{
    m->now = (int32_t)manoeuvre;
    m->windows = 0u;
    m->forced.stalling = 0u;
    m->passage.missing = 0u;
    m->judged = 0u;
    m->unlocked = 0u;
}

void manoeuvres_enter_catch(manoeuvres_t *m, manoeuvre_t manoeuvre, uint32_t periods, float omega_e,
                            setpoint_t *setpoint)
{
    manoeuvres_enter(m, manoeuvre);
    m->tracking = 0u;
    m->entered = setpoint->number;
    setpoint->source = (int32_t)SOURCE_CATCH;
    setpoint->enter = 1u;
    setpoint->change = (int32_t)FRAME_ANEW;
    setpoint->lock = (int32_t)LOCK_KEEP;
    setpoint->catching.periods = periods;
    setpoint->catching.speed = omega_e;
    setpoint->current = (dq_t){m->limits.current_caught, 0.0f};
    setpoint->omega_m_ref = 0.0f;
}

void manoeuvres_enter_run(manoeuvres_t *m, dq_t current, float omega_e)
{
    manoeuvres_enter(m, MANOEUVRE_RUN);
    m->tracking = 1u;
    m->reversing = 0u;
    m->proving = 0u;
    m->sound_windows = 0u;
    m->omega_ref = omega_e;
    lock_reset(&m->lock, omega_e);
    run_enter(&m->run, current, omega_e * m->limits.pole_pairs_inverse);
}

/* Updates the source of control's angle. Returns true if it is another source than before. */
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
    handover_take(&m->handover, &tuning->handover);
    lock_take(&m->lock, &tuning->lock);
    proof_take(&m->proof, &tuning->proof);
    run_take(&m->run, &tuning->run);
    m->limits = tuning->limits;
    const uint32_t other = source(m, m->limits.sensorless | m->encoder_lost);
    m->other_source ^= other; /* two changes of the source before the next window cancel each other */
    if (other != 0u) {
        manoeuvres_judge(m, 0.0f, 0.0f); /* a reversal is judged only after run has measured the EMF */
    }
}

void manoeuvres_begin(manoeuvres_t *m, float omega_m, setpoint_t *setpoint)
{
    m->start_try = 0u;
    m->losses.count = 0u;
    m->losses.relocks = 0u;
    m->losses.brief = 0u;
    m->failed = 0u;
    m->encoder_lost = 0u;
    m->other_source = 0u;
    m->run.swings = 0u;
    run_calm(&m->run, true);
    (void)source(m, m->limits.sensorless);
    if (m->sensorless != 0u) {
        manoeuvres_enter_catch(m, MANOEUVRE_CATCH, MANOEUVRE_CATCH_PERIODS, 0.0f, setpoint);
    } else {
        manoeuvres_enter_run(m, (dq_t){0.0f, 0.0f}, omega_m * m->limits.pole_pairs);
        setpoint->source = (int32_t)SOURCE_ENCODER;
        setpoint->change = (int32_t)FRAME_ANEW;
        setpoint->lock = (int32_t)LOCK_FOLLOWS;
        setpoint->current = (dq_t){0.0f, 0.0f};
    }
}

void manoeuvres_stand(manoeuvres_t *m, setpoint_t *setpoint)
{
    if (m->now == (int32_t)MANOEUVRE_COMMISSION) {
        return;
    }
    manoeuvres_enter(m, MANOEUVRE_COMMISSION);
    m->tracking = 0u;
    setpoint->source = (int32_t)SOURCE_FORCED;
    setpoint->enter = 1u;
    setpoint->change = (int32_t)FRAME_ANEW;
    setpoint->lock = (int32_t)LOCK_RELEASE;
    setpoint->forced = (setpoint_forced_t){0.0f, 0.0f, 0.0f, 0.0f};
    setpoint->current = (dq_t){0.0f, 0.0f};
    setpoint->omega_m_ref = 0.0f;
}

/* Commissioning has ended with the bridge on: the rotor is caught. */
static void manoeuvres_resume(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    manoeuvres_begin(m, input->omega_m, setpoint);
}

void manoeuvres_step(manoeuvres_t *m, const manoeuvres_input_t *input, setpoint_t *setpoint)
{
    m->clock++;
    m->windows++;
    if (m->sensorless == 0u && m->now != (int32_t)MANOEUVRE_COMMISSION) {
        manoeuvres_run_on_encoder(m, input, setpoint);
        return;
    }
    switch ((manoeuvre_t)m->now) {
#define MANOEUVRE_STEP(NAME, name, source, compared, step)                                                   \
    case MANOEUVRE_##NAME:                                                                                   \
        manoeuvres_##step(m, input, setpoint);                                                               \
        break;
        MANOEUVRES(MANOEUVRE_STEP)
#undef MANOEUVRE_STEP
    }
}
