#include "host_sim/lab/paper_drive.h"

const setting_t paper_drive[] = {
    {"params.position_source", 0.0},
    {"params.speed_kp", 0.5},
    {"params.speed_ki", 2.5},
    {"params.speed_setpoint_weight", 1.0},
    {"params.low_speed_current", 0.0},
    {"params.speed_feedback", 1.0},
    {"params.inductance_adaptation", 0.0},
    {"params.dead_time_adaptation", 0.0},
    {"params.inertia_adaptation", 0.0},
    {"params.torque_feedforward", 0.0},
};
const size_t paper_drive_count = sizeof paper_drive / sizeof paper_drive[0];

bool paper_drive_put(rig_t *rig, const setting_t *settings, size_t count)
{
    for (size_t n = 0; n < count; n++) {
        if (!rig_put(rig, settings[n].row, settings[n].value)) {
            return false;
        }
    }
    return true;
}

bool paper_drive_without_encoder(rig_t *rig)
{
    return rig_put(rig, "params.position_source", 1.0) && rig_apply(rig);
}
