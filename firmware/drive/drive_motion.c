/* What the rotor's motion says: whether the encoder is right, and whether the shaft goes where the torque
 * takes it. The middle between firmware/protect/ and the rows of the fault table. */
#include "drive/drive.h"

/* Is the encoder to be judged: does control turn with it, and is the EMF known beside it? */
static bool judges_encoder(const drive_t *drive)
{
    const manoeuvres_t *m = &drive->manoeuvres;
    return m->sensorless == 0u && m->limits.encoder_fault != (int32_t)ENCODER_FAULT_IGNORED &&
           drive->estimating != 0u;
}

static uint32_t look_at_motion(drive_t *drive)
{
    const manoeuvres_t *m = &drive->manoeuvres;
    const int32_t state = drive->sequence.state;
    const bool speed = drive->requests.mode == (int32_t)MODE_SPEED || state == (int32_t)DRIVE_QUICK_STOP;
    const motion_watch_input_t input = {
        .i_q = drive->current.q,
        .i_q_ref = drive->demand.current.q,
        .limit = run_room(&m->run),
        .omega_m = drive->omega_m,
        .omega_m_ref = drive->demand.omega_m_ref,
        .believed = m->sensorless == 0u,
        .asked = speed,
    };
    return motion_watch_step(&drive->motion_watch, &input);
}

/* May the EMF be wrong, by a wire or a current sensor? Those are told by the current watch, which needs
 * longer than a large EMF that is off the encoder's axis. A sensor that is only suspected is no doubt: the
 * watch expects the EMF where the encoder puts it. */
static bool doubts_emf(const drive_t *drive)
{
    const abc_t asked =
        frames_inverse_clarke(frames_inverse_park(drive->demand.current, drive->demand.frame.rotation));
    return current_watch_lacks(&drive->current_watch, drive->measure.measured.current_abc, asked);
}

/* At a wrong encoder: is there a way on without? Then it is taken, from this period on. */
static bool goes_on_without(drive_t *drive)
{
    manoeuvres_t *m = &drive->manoeuvres;
    if (m->limits.encoder_fault != (int32_t)ENCODER_FAULT_SENSORLESS) {
        return false;
    }
    manoeuvres_leave_encoder(m, &drive->estimator.estimate, drive->measure.measured.current);
    encoder_watch_rest(&drive->encoder_watch);
    motion_watch_rest(&drive->motion_watch);
    current_watch_begin(&drive->current_watch);
    drive_believe(drive);
    return true;
}

/* Nobody drives the shaft. */
static void rest(drive_t *drive)
{
    encoder_watch_rest(&drive->encoder_watch);
    motion_watch_rest(&drive->motion_watch);
    oscillation_watch_rest(&drive->oscillation_watch);
    drive->moves_wrong = 0u;
    drive->encoder_wrong = 0u;
}

/* A speed loop that oscillates is made slower. In mode current nothing is controlled by the speed. */
static void look_for_oscillation(drive_t *drive)
{
    oscillation_watch_t *watch = &drive->oscillation_watch;
    if (drive->requests.mode != (int32_t)MODE_SPEED) {
        oscillation_watch_rest(watch);
    } else if (oscillation_watch_step(watch, drive->demand.current.q, drive->demand.omega_m_ref)) {
        run_calm(&drive->manoeuvres.run, false);
    }
}

void drive_watch_motion(drive_t *drive, bool in_slot, bool jumped)
{
    const bool running = drive_bridge_on(drive) && drive->sequence.state != (int32_t)DRIVE_SWITCHED_ON &&
                         drive->manoeuvres.now == (int32_t)MANOEUVRE_RUN;
    if (!running) {
        rest(drive);
        return;
    }
    if (in_slot) {
        drive->encoder_wrong = 0u;
        look_for_oscillation(drive);
        if (drive->period % DRIVE_MOTION_PERIODS < GUARD_LOOK_PERIODS) {
            drive->moves_wrong = look_at_motion(drive);
        }
    }
    if (!judges_encoder(drive)) {
        encoder_watch_rest(&drive->encoder_watch);
        return;
    }
    const bool late =
        (drive->measure.measured.flags & DRIVE_SAMPLE_LATE) != 0u; /* who knows how far it turned */
    drive->encoder_wrong |= jumped && !late ? ENCODER_WATCH_JUMP : 0u;
    if (in_slot) {
        const encoder_watch_input_t input = {
            .current = drive->measure.measured.current,
            .encoder = drive->encoder_frame.rotation,
            .omega_e = drive->encoder_frame.omega_e,
            .doubtful = doubts_emf(drive),
        };
        drive->encoder_wrong |= encoder_watch_step(&drive->encoder_watch, &input);
    }
    if ((drive->encoder_wrong & ~ENCODER_WATCH_DIRECTION) != 0u && goes_on_without(drive)) {
        drive->encoder_wrong = 0u;
    }
}
