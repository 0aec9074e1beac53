#include "host_sim/lab/dynamometer.h"

#include <math.h>

#include "host_sim/lab/paper_drive.h"

#define HOLD   0.1  /* [s] current and estimator settle; five time constants of the PLL's bandwidth */
#define FOLLOW 0.01 /* [s] 15 time constants of the encoder's speed */

static double choice(const char *row, const char *name)
{
    return table_choice(rig_row_by_name(row), name);
}

double dynamometer_current(double load, double friction, double torque_per_ampere, double limit, double speed)
{
    return copysign(fmin((load + friction) / torque_per_ampere, limit), speed);
}

bool dynamometer_wait(rig_t *rig)
{
    const table_row_t *state = rig_row_by_name("state");
    if (!rig_stop_when(rig, state->id, RIG_EQUAL, table_choice(state, "ready"))) {
        return false;
    }
    rig_run(rig, rig_periods(DYNAMOMETER_READY));
    return rig_stop_when(rig, state->id, RIG_NEVER, 0.0);
}

bool dynamometer_begin(rig_t *rig, const dynamometer_t *to)
{
    if (!rig_put(rig, "plant.shaft_locked_speed", to->speed) || !rig_put(rig, "plant.shaft_locked", 1.0) ||
        !rig_put(rig, "plant.load_torque", to->load)) {
        return false;
    }
    rig_set_motion(rig, 0.0, to->speed);
    rig_run(rig, rig_periods(FOLLOW));
    if (!rig_put(rig, "mode", choice("mode", "current")) || !rig_put(rig, "i_q_request", to->current) ||
        !rig_put(rig, "enable", choice("enable", "on"))) {
        return false;
    }
    rig_run(rig, rig_periods(HOLD));
    return (!to->estimate || paper_drive_without_encoder(rig)) && rig_put(rig, "speed_request", to->speed) &&
           rig_put(rig, "mode", choice("mode", "speed")) && rig_put(rig, "plant.shaft_locked", 0.0);
}
