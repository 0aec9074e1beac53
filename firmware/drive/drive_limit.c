/* Protections that limit before they trip: what heat and DC link leave of the current, and a lost supply. */
#include "drive/drive.h"

#include "drive/reasons.h"
#include "math/bounds.h"

/* Within ride_through_time a link that sinks opens the bridge, which comes on again with the supply: the
 * rotor is caught. After that time it is the fault that it always was. */
static void ride_through(drive_t *drive)
{
    const uint32_t conditions = drive->link.conditions;
    if (drive_bridge_on(drive)) {
        drive->coasting = (conditions & LINK_SINKS) != 0u ? UINT32_C(1) : UINT32_C(0);
        if (drive->coasting != 0u) {
            sequence_coast(&drive->sequence);
        }
    } else if (drive->requests.enable == (int32_t)REQUEST_OFF) {
        drive->coasting = 0u;
    } else if (drive->coasting != 0u && (conditions & LINK_LOST) != 0u) {
        drive->coasting = 0u;
        drive_stop(drive, REASON_DC_UNDERVOLTAGE);
    }
}

/* A quick stop without a ramp only brakes: what the speed control held against a load when it began must not
 * drive the motor on until the integral has come down. */
static bool only_brakes(const drive_t *drive)
{
    return drive->sequence.state == (int32_t)DRIVE_QUICK_STOP &&
           drive->manoeuvres.run.tuning.stop_ramp == 0.0f;
}

/* What both leave, on the side of the speed. */
static void put_in_force(drive_t *drive)
{
    const float most = drive->thermal.limit;
    const float braking = bounds_clamp(drive->link.braking, most);
    const float asked = bounds_clamp(drive->link.driving, most);
    const float least = braking < 0.0f ? -braking : 0.0f; /* what a full link gives away */
    const float driving = only_brakes(drive) && asked > least ? least : asked;
    if (drive->omega_m < 0.0f) {
        run_limit(&drive->manoeuvres.run, -driving, braking);
    } else {
        run_limit(&drive->manoeuvres.run, -braking, driving);
    }
}

void drive_limit(drive_t *drive, bool look)
{
    const measured_t *measured = &drive->measure.measured;
    link_t *link = &drive->link;
    bool changes = !look || only_brakes(drive); /* else only where a limit may have changed */
    if (look && drive->period % DRIVE_LIMIT_PERIODS < GUARD_LOOK_PERIODS) {
        thermal_add(&drive->thermal, measured->current_abc);
        if (thermal_is_due(&drive->thermal)) {
            thermal_step(&drive->thermal, measured);
            changes = true;
        }
    } else if (look) {
        link_look(link, measured->u_dc);
        ride_through(drive);
    }
    if (link_is_near(link, measured->u_dc)) {
        /* in a forced frame the limits of i_q do not act: the rotor feeds nothing on their behalf */
        const bool forced = manoeuvres_forces(&drive->manoeuvres) && drive->manoeuvres.sensorless != 0u;
        link_limit(link, measured->u_dc, forced ? 0.0f : drive->omega_m);
        changes = true;
    }
    if (changes) {
        put_in_force(drive);
    }
}
