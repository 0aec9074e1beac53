/* What the drive is watched by: the fault table's rows, with what the rooms of firmware/protect/ find. */
#include "drive/drive.h"

#include "drive/drive_seen.h"
#include "drive/guard_quantities.h"
#include "math/bounds.h"

/* Which of GUARD_LOOK_PERIODS the slow rows are judged in: none in which something is learnt. */
#define LOOK_SLOT 3u

/* Likewise of CURRENT_WATCH_PERIODS, in which the windows of the currents end; those of CURRENT_WATCH_QUICK
 * end in even periods, too, and the slots of all others are odd. */
#define CURRENT_SLOT 6u

/* [-] share of the EMF that may be wrong: psi_f by 20 % and the rotor's angle; where that is not known all of
 * it, in every direction. */
#define EMF_KNOWN   0.3f
#define EMF_UNKNOWN 1.3f

/* Does the EMF go on smoothly, or hardly count? Not where the loop tracks: that follows the sensors. */
static bool is_comparable(const manoeuvres_t *m)
{
    const bool begun = m->periods >= CURRENT_WATCH_PERIODS;
    switch ((manoeuvre_t)m->now) {
    case MANOEUVRE_CATCH:
        return m->catching.turning == 0u;
    case MANOEUVRE_ALIGN:
        return true;
    case MANOEUVRE_OFF:
    case MANOEUVRE_RUN:
    case MANOEUVRE_RELOCK:
    case MANOEUVRE_HANDOVER:
        break;
    case MANOEUVRE_RAMP:
    case MANOEUVRE_FORCED:
    case MANOEUVRE_REVERSE:
        return m->tracking == 0u && begun;
    }
    return false;
}

static void watch_currents(drive_t *drive)
{
    current_watch_t *watch = &drive->current_watch;
    const manoeuvres_t *m = &drive->manoeuvres;
    if (drive->estimating == 0u || watch->tuning.judged == 0u) {
        drive->current_faults = 0u;
        return;
    }
    const uint32_t slot = drive->period % CURRENT_WATCH_PERIODS;
    const bool last =
        slot == CURRENT_SLOT || (slot % CURRENT_WATCH_QUICK == CURRENT_SLOT % CURRENT_WATCH_QUICK &&
                                 current_watch_is_surprised(watch, drive->estimator.estimate.current_err));
    if (current_watch_add(watch, drive->acted, drive->demand.current, &drive->measure.measured.current_abc,
                          last)) {
        const bool known = m->sensorless == 0u || m->tracking != 0u;
        const float omega_e = m->limits.pole_pairs * drive->omega_m;
        const current_watch_input_t input = {
            .current = drive->measure.measured.current_abc,
            .error = drive->estimator.estimate.current_err,
            .reference = drive->demand.current,
            .frame = drive->demand.frame.rotation,
            .u_dc = drive->measure.measured.u_dc,
            .rotor = drive->rotor.rotation,
            .omega_e = known ? omega_e : 0.0f,
            .doubt = (known ? EMF_KNOWN : EMF_UNKNOWN) * bounds_magnitude(omega_e),
            .hidden = !known && !manoeuvres_knows(m) && omega_e == 0.0f,
            .forced = !known && manoeuvres_knows(m),
            .contradicted = drive->encoder_watch.of_a_phase != 0u,
            .comparable = is_comparable(m),
        };
        drive->current_faults = current_watch_step(watch, &input);
    }
}

/* The voltage's sum while control turns with the encoder, and does that jump? Both are worth nothing where
 * the motor does not run: drive_watch_motion() knows. */
static void watch_motion(drive_t *drive)
{
    const bool in_slot = drive->period % GUARD_LOOK_PERIODS == DRIVE_MOTION_SLOT;
    bool jumped = false;
    if (drive->manoeuvres.sensorless == 0u) {
        encoder_watch_add(&drive->encoder_watch, drive->acted);
        jumped = encoder_watch_jumped(&drive->encoder_watch, drive->encoder.missed);
    }
    if (in_slot || jumped) {
        drive_watch_motion(drive, in_slot, jumped);
    }
}

/* Has the guard nothing to do with the rows of this rate? */
static inline bool is_calm(const drive_t *drive, fault_rate_t rate)
{
    const guard_input_t input = drive_seen(drive, true);
    return guard_is_calm(&drive->guard, &input, rate);
}

void drive_protect(drive_t *drive)
{
    watch_currents(drive);
    watch_motion(drive);
    const bool look = drive->period % GUARD_LOOK_PERIODS == LOOK_SLOT;
    if (look) {
        drive->unattended += drive->unattended != 0u ? GUARD_LOOK_PERIODS : 0u;
    }
    if (look || drive->link.limits != 0u) {
        drive_limit(drive, look);
    }
    if (!is_calm(drive, FAULT_EACH) || (look && !is_calm(drive, FAULT_SLOW))) {
        drive_judge(drive, look);
    }
}
