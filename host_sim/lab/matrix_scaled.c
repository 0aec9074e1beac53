/* Scales the faults of a scenario to its motor, its link and its limits, as those of the table are scaled to
 * the paper's rig. */
#include <math.h>
#include <string.h>

#include "host_sim/lab/matrix.h"
#include "host_sim/rig/rig.h"

#define JAM        100.0 /* [N m] a brake beyond it holds any shaft */
#define SQRT_3     1.7320508075688772
#define JUST_BELOW 0.95 /* [-] of dc_undervoltage */
#define WITHIN_LEFT                                                                                          \
    0.4 /* [-] of the torque that the load leaves: largest torque of a brake within current_limit */

/* The sensors of the paper's rig. */
#define PAPER_PER_CODE (40.0 / 4095.0) /* [A] */
#define PAPER_AT_0V    (-20.0)         /* [A] */

/* Rows of the paper's rig whose defaults are those of the board: faults and promises of the table refer to
 * these values, for each board on which the scenario runs. */
static const struct {
    const char *row;
    double value;
} paper_rig[] = {
    {"current_limit", 10.0},    {"overcurrent_trip", 15.0},  {"dc_overvoltage", 400.0},
    {"dc_undervoltage", 200.0}, {"plant.dc_voltage", 311.0},
};

double matrix_standard(const char *row)
{
    for (size_t n = 0; n < sizeof paper_rig / sizeof paper_rig[0]; n++) {
        if (strcmp(paper_rig[n].row, row) == 0) {
            return paper_rig[n].value;
        }
    }
    return rig_initial_named(row);
}

/* The scenario's value of a row over that of the paper's rig; 1 if one of them is 0. */
static double ratio(rig_t *rig, const char *row)
{
    const double standard = matrix_standard(row);
    const double own = rig_value(rig, row);
    return standard > 0.0 && own > 0.0 ? own / standard : 1.0;
}

/* Torque that current_limit makes [N m]. */
static double able(double pole_pairs, double flux_linkage, double current)
{
    return 1.5 * pole_pairs * flux_linkage * current;
}

static double able_now(rig_t *rig)
{
    return able(rig_value(rig, "plant.pole_pairs"), rig_value(rig, "plant.flux_linkage"),
                rig_value(rig, "current_limit"));
}

static double able_by_default(void)
{
    return able(matrix_standard("plant.pole_pairs"), matrix_standard("plant.flux_linkage"),
                matrix_standard("current_limit"));
}

/* A brake that is stronger than current_limit stays stronger; a brake well within current_limit stays within
 * the torque that the scenario's own load leaves. */
static double brake(rig_t *rig, double torque)
{
    const double most = able_now(rig);
    const double scaled = torque * most / able_by_default();
    const double left = fmax(
        most - fabs(rig_value(rig, "plant.load_torque")) - rig_value(rig, "plant.friction_coulomb"), 0.0);
    if (torque >= JAM) {
        return fmin(fmax(torque, scaled), rig_max(rig_row_by_name("rig.brake_torque")));
    }
    return torque < able_by_default() ? fmin(scaled, WITHIN_LEFT * left) : scaled;
}

/* A link voltage is scaled with the trip that it exceeds, or between the trips with the link voltage itself.
 */
static double link_voltage(rig_t *rig, double volts)
{
    const double over = matrix_standard("dc_overvoltage");
    const double under = matrix_standard("dc_undervoltage");
    if (volts > over) {
        return volts / over * rig_value(rig, "dc_overvoltage");
    }
    /* Below the EMF between two lines the diodes charge the link. Therefore a low link voltage stays above
     * this EMF if possible. */
    const double own = rig_value(rig, "dc_undervoltage");
    const double emf = SQRT_3 * rig_value(rig, "plant.flux_linkage") * rig_value(rig, "plant.pole_pairs") *
                       fabs(rig_value(rig, "true_omega_m"));
    return volts < under ? fmax(volts / under * own, fmin(emf, JUST_BELOW * own)) : volts / under * own;
}

/* The capacitor holds the same share of a second's work of the motor at its limit: C U^2 over torque times
 * speed. */
static double capacitor(rig_t *rig, double farads)
{
    const double volts = ratio(rig, "plant.dc_voltage");
    return farads * able_now(rig) / able_by_default() * ratio(rig, "overspeed_trip") / (volts * volts);
}

double matrix_scaled(rig_t *rig, const char *row, double value)
{
    const double amperes = ratio(rig, "current_limit");
    if (strcmp(row, "rig.brake_torque") == 0 || strcmp(row, "plant.holding_torque") == 0) {
        return brake(rig, value);
    }
    if (strcmp(row, "plant.dc_voltage") == 0) {
        return link_voltage(rig, value);
    }
    if (strcmp(row, "plant.dc_ripple") == 0 || strcmp(row, "plant.leg_a_drop") == 0) {
        return value * ratio(rig, "plant.dc_voltage");
    }
    if (strcmp(row, "plant.dc_capacitance") == 0) {
        return capacitor(rig, value);
    }
    if (strcmp(row, "plant.chopper_voltage") == 0) {
        return value * ratio(rig, "dc_overvoltage");
    }
    if (strcmp(row, "plant.dc_resistance") == 0 || strcmp(row, "plant.chopper_resistance") == 0) {
        return value * 1e-3 / capacitor(rig, 1e-3);
    }
    if (strcmp(row, "plant.leg_a_resistance") == 0) {
        return value * ratio(rig, "plant.resistance");
    }
    if (strcmp(row, "plant.current_offset_a") == 0 || strcmp(row, "plant.current_noise") == 0) {
        return value * amperes;
    }
    if (strcmp(row, "plant.sink_temperature") == 0) {
        return value - matrix_standard("sink_temperature_max") + rig_value(rig, "sink_temperature_max");
    }
    if (strcmp(row, "plant.motor_temperature") == 0) {
        return value - matrix_standard("motor_temperature_max") + rig_value(rig, "motor_temperature_max");
    }
    if (strncmp(row, "rig.stuck_current_", 18) == 0 && value > 0.0 &&
        value < 4095.0) { /* a value that is not at an end of the range of the sensor */
        const double per_code = (double)BOARD_CURRENT_PER_CODE;
        const double shown = value * PAPER_PER_CODE + PAPER_AT_0V;
        const double current = shown + floor(shown + 0.5) * (amperes - 1.0);
        return fmin(fmax((current - (double)BOARD_CURRENT_AT_0V) / per_code, 1.0), 4094.0);
    }
    return value;
}
