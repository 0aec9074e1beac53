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
    {"params.encoder_fault_reaction", 2.0}, /* an EMF that chatters cannot be compared with the encoder */
};
const size_t paper_drive_count = sizeof paper_drive / sizeof paper_drive[0];

/* Inverter and sensors without error: the turn-off delay is equal to the delay of the other edge by the dead
 * band.
 */
const setting_t paper_ideal[] = {
    {"plant.turn_on_delay", 0.0},  {"plant.turn_off_delay", 2.5e-6},
    {"plant.igbt_voltage", 0.0},   {"plant.igbt_resistance", 0.0},
    {"plant.diode_voltage", 0.0},  {"plant.diode_resistance", 0.0},
    {"plant.current_zone", 0.0},   {"plant.current_noise", 0.0},
    {"params.turn_on_delay", 0.0}, {"params.turn_off_delay", 2.5e-6},
    {"params.device_drop", 0.0},   {"params.device_resistance", 0.0},
    {"params.current_zone", 1e-3}, {"rig.sensors", 1.0},
};
const size_t paper_ideal_count = sizeof paper_ideal / sizeof paper_ideal[0];

/* The rig; the criteria of a lost estimate and of sensors and wires, which the paper does not have; and data
 * without uncertainty, because the R and L of the drive are those of the machine. */
const setting_t paper_common[] = {
    {"params.current_bandwidth", 1000.0},
    {"params.overspeed_trip", 200.0}, /* [rad/s]; the smallest k_s covers the EMF up to here */
    {"params.observer_gain", 200.0},
    {"params.observer_slope", 1.0},
    {"params.pll_damping", 1.0},
    {"params.flux_adaptation", 0.0},
    {"params.dead_time_adaptation", 0.0},
    {"params.motor_data_uncertainty", 0.0}, /* the loop of (22) has no lean */
    {"params.estimate_amplitude_min", 0.0},
    {"params.estimate_amplitude_max", 1.0},
    {"params.estimate_detector_max", 0.0},
    {"params.estimate_current_max", 100.0},
    {"params.estimate_speed_min", 0.0},
    {"params.lock_judged", 0.0},
    {"rig.fidelity", 1.0},
};
const size_t paper_common_count = sizeof paper_common / sizeof paper_common[0];

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
