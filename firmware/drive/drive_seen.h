/* What the guard is told of a period. For those who ask whether it has to be called, and who call it. */
#ifndef DRIVE_DRIVE_SEEN_H
#define DRIVE_DRIVE_SEEN_H

#include "drive/drive.h"

/* So long a suspicion against a sensor or a wire goes before what the EMF says of the rotor. */
#define DRIVE_SUSPICION_PERIODS DRIVE_PERIODS(3.5e-3f)

/* The moments in which rows of the fault table count. */
static inline uint32_t drive_moments(const drive_t *drive)
{
    const manoeuvres_t *manoeuvres = &drive->manoeuvres;
    if (!drive_bridge_on(drive) || drive->sequence.state == (int32_t)DRIVE_SWITCHED_ON) {
        return GUARD_ALWAYS;
    }
    return GUARD_ALWAYS | GUARD_RUNNING | (manoeuvres->sensorless != 0u ? 0u : GUARD_ENCODER) |
           (manoeuvres_judged(manoeuvres) ? GUARD_TRACKING : 0u) |
           (link_excuses(&drive->link) ? 0u : GUARD_SUPPLIED);
}

/* Has the background stayed away for too long? */
static inline uint32_t drive_stalled(const drive_t *drive)
{
    return drive->unattended > drive->unattended_max ? 1u : 0u;
}

/* Is the EMF beyond the link? It may be that of a sensor or a wire: while one is suspected its own row has
 * the first word, for a while. */
static inline uint32_t drive_too_fast(const drive_t *drive)
{
    const manoeuvres_t *m = &drive->manoeuvres;
    return (m->failed & MANOEUVRE_TOO_FAST) != 0u && ((drive->current_faults & CURRENT_WATCH_MAYBE) == 0u ||
                                                      m->catching.periods_beyond >= DRIVE_SUSPICION_PERIODS)
               ? 1u
               : 0u;
}

/* What is wrong with the loops: GUARD_LOOP_... bits. */
static inline uint32_t drive_loops(const drive_t *drive)
{
    const manoeuvres_t *m = &drive->manoeuvres;
    return (m->limits.slow_loop != 0u ? GUARD_LOOP_SLOW : 0u) |
           (m->run.calm < 1.0f ? GUARD_LOOP_OSCILLATED : 0u);
}

/* What the rows of the fault table compare; `look`: the slow ones are judged, too. */
static inline guard_input_t drive_seen(const drive_t *drive, bool look)
{
    const manoeuvres_t *manoeuvres = &drive->manoeuvres;
    return (guard_input_t){
        .measured = &drive->measure.measured,
        .omega_m = drive->omega_m,
        .estimate_invalid = drive->estimator.estimate.invalid,
        .unlocked = manoeuvres->unlocked,
        .failed = manoeuvres->failed,
        .too_fast = drive_too_fast(drive),
        .unattended = drive_stalled(drive),
        .reported = drive->reported,
        .encoder_wrong = drive->encoder_wrong,
        .moves_wrong = drive->moves_wrong,
        .encoder_lost = manoeuvres->encoder_lost,
        .current_faults = drive->current_faults,
        .heat = drive->thermal.conditions,
        .link = drive->link.conditions,
        .loops = drive_loops(drive),
        .now = drive_moments(drive),
        .look = look ? 1u : 0u,
    };
}

#endif
