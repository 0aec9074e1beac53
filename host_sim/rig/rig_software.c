/* What the desk does with the software that runs on its chip. */
#include "host_sim/rig/rig_parts.h"

/* The rig whose chip and application run on this thread: for the interrupts, which get no argument. */
static __thread rig_t *bound;

void rig_software_bind(rig_t *rig)
{
    bound = rig;
}

/* Ideal sensors: the truth of t_k. The drive takes off the zero that it has measured of the real sensors; it
 * is put on, so that sensors may change at any time after that. */
static void take_exact(const rig_truth_t *truth, const drive_t *drive, drive_samples_t *samples)
{
    const bool measuring = drive->sequence.state == (int32_t)DRIVE_NOT_READY;
    samples->i_a = truth->true_i_a + (measuring ? 0.0f : drive->measure.offset.a);
    samples->i_b = truth->true_i_b + (measuring ? 0.0f : drive->measure.offset.b);
    samples->i_c = truth->true_i_c + (measuring ? 0.0f : drive->measure.offset.c);
    samples->u_dc = truth->true_u_dc;
}

void desk_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command)
{
    drive_samples_t taken = *samples;
    if (bound->state.conditions.sensors != 0) {
        take_exact(&bound->state.truth, drive, &taken);
    }
    drive_step(drive, &taken, command);
}
