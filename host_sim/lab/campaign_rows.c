/* A case as rows of the tables: the settings at t = 0. */
#include <math.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"

/* [-] standard deviation of R and L beside their configured values, which are 0.7 to 1.3 of the true ones */
#define CAMPAIGN_DATA_UNCERTAINTY 0.19

#define LOOP_SLOWER    14.0   /* [-] bandwidth of the tracking loop over that of the speed control */
#define LOOP_MIN       200.0  /* [rad/s] */
#define LOOP_MAX       1000.0 /* [rad/s] a tenth of the carrier's */
#define CHOPPER_ABOVE  1.05   /* [-] of the source: least chopper_voltage */
#define LINK           1e-3   /* [F] if the fault needs a capacitor */
#define SHAFT_DAMPING  0.02   /* [-] of an elastic shaft */
#define SPRING_SECONDS 2.0    /* [s] at rated speed, after which a spring has its full torque */
#define PERIOD         ((double)BOARD_PERIOD)
#define EDGE_ABOVE     0.03 /* [-] of dc_overvoltage: largest distance of the source below it */
#define EDGE_BELOW     0.05 /* [-] of dc_undervoltage: largest distance of the source above it */

/* Only values that differ from their default are set. */
static void set(campaign_settings_t *to, const char *name, double value)
{
    const table_row_t *row = rig_row_by_name(name);
    const double slot = row->kind == SLOT_FLOAT ? (double)(float)value : floor(value + 0.5);
    if (slot != rig_initial(row) && to->count < CAMPAIGN_SETTINGS_MAX) {
        to->settings[to->count++] = (campaign_setting_t){row, slot};
    }
}

static void set_times(campaign_settings_t *to, const char *name, double factor)
{
    set(to, name, factor * rig_initial_named(name));
}

/* Parameters that follow from the configured motor by simple rules. */
static void set_drive(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    const double flux = motor->flux_linkage * CAMPAIGN_VALUE(drawn, flux_configured);
    const double inductance = motor->inductance_q * campaign_inductance_configured(drawn);
    const double gain = 1.75 * flux * motor->pole_pairs * motor->speed;
    const double slope = 1.6 * inductance / (gain * PERIOD);
    set(to, "motor_pole_pairs", motor->pole_pairs);
    set(to, "overspeed_trip", campaign_overspeed(drawn));
    set(to, "current_limit", motor->current);
    set(to, "overcurrent_trip", motor->trip);
    set(to, "low_speed_current", 0.2 * motor->current);
    if (campaign_is_salient(drawn)) { /* the rules of the drive determine the other parameters */
        set(to, "motor_saturation_current", motor->saturation);
        set(to, "plant.saturation_q", motor->saturation);
    } else {
        set(to, "observer_gain", gain);
        set(to, "observer_slope", slope);
        set(to, "estimate_current_max", fmin(4.0 / slope, 100.0));
    }
    set(to, "estimate_speed_min", 0.02 * motor->speed);
}

static void set_motor(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    set(to, "plant.pole_pairs", motor->pole_pairs);
    set(to, "plant.resistance", motor->resistance);
    set(to, "plant.inductance_d", motor->inductance_d);
    set(to, "plant.inductance_q", motor->inductance_q);
    set(to, "plant.flux_linkage", motor->flux_linkage);
    set(to, "plant.inertia", motor->inertia);
    set(to, "emf_5th", CAMPAIGN_VALUE(drawn, emf_5th));
    set(to, "emf_7th", CAMPAIGN_VALUE(drawn, emf_7th));
    set(to, "motor_resistance",
        drawn->true_values ? campaign_series_resistance(drawn)
                           : motor->resistance * CAMPAIGN_VALUE(drawn, resistance_configured));
    set(to, "motor_inductance_d", motor->inductance_d * campaign_inductance_configured(drawn));
    set(to, "motor_inductance_q", motor->inductance_q * campaign_inductance_configured(drawn));
    set(to, "motor_data_uncertainty", CAMPAIGN_DATA_UNCERTAINTY);
    set(to, "motor_flux_linkage", motor->flux_linkage * CAMPAIGN_VALUE(drawn, flux_configured));
    set(to, "motor_inertia",
        motor->inertia * (1.0 + CAMPAIGN_VALUE(drawn, second_mass)) *
            CAMPAIGN_VALUE(drawn, inertia_configured));
    if (CAMPAIGN_VALUE(drawn, motor_drawn) != 0.0) {
        set_drive(to, drawn, motor);
    }
}

static void set_shaft(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    const double friction = CAMPAIGN_VALUE(drawn, friction) * motor->torque;
    const double viscous = CAMPAIGN_VALUE(drawn, viscous) * motor->torque / motor->speed;
    set(to, "friction_coulomb", friction);
    /* slightly more, so that the value as a float is not below it */
    set(to, "friction_breakaway", CAMPAIGN_VALUE(drawn, stiction) * friction * 1.000001);
    set(to, "friction_viscous", viscous);
    set(to, "load_kind", CAMPAIGN_VALUE(drawn, load_kind));
    set(to, "load_torque", CAMPAIGN_VALUE(drawn, load) * motor->torque);
    set(to, "load_quadratic", CAMPAIGN_VALUE(drawn, fan) * motor->torque / (motor->speed * motor->speed));
    set(to, "load_sine", CAMPAIGN_VALUE(drawn, sine) * motor->torque);
    if (CAMPAIGN_VALUE(drawn, sine) != 0.0) {
        set(to, "load_sine_cycles", CAMPAIGN_VALUE(drawn, sine_cycles));
    }
    set(to, "load_spring", CAMPAIGN_VALUE(drawn, spring) * motor->torque / (motor->speed * SPRING_SECONDS));

    /* both ends free: omega^2 = k (1/J + 1/J_load); c of a damping ratio of a fiftieth */
    const double load_inertia = CAMPAIGN_VALUE(drawn, second_mass) * motor->inertia;
    if (load_inertia > 0.0) {
        const double omega = CAMPAIGN_VALUE(drawn, resonance);
        const double reduced = motor->inertia * load_inertia / (motor->inertia + load_inertia);
        set(to, "load_inertia", load_inertia);
        set(to, "shaft_stiffness", omega * omega * reduced);
        set(to, "shaft_damping", 2.0 * SHAFT_DAMPING * omega * reduced);
    }
}

/* [V] Voltage of the source: as drawn, or within a few per cent of a limit of the drive. */
static double source_voltage(const campaign_case_t *drawn)
{
    const double edge = CAMPAIGN_VALUE(drawn, dc_edge);
    if (edge > 0.0) {
        return rig_initial_named("dc_overvoltage") * (1.0 - EDGE_ABOVE * edge);
    }
    if (edge < 0.0) {
        return rig_initial_named("dc_undervoltage") * (1.0 - EDGE_BELOW * edge);
    }
    return CAMPAIGN_VALUE(drawn, dc_voltage);
}

/* Battery, brake resistor and limits of the supply's current. The chopper is above the source, and its
 * resistor takes twice the rated power unless the switch of the board carries less. */
static void set_supply(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor,
                       double capacitance)
{
    const double over = rig_initial_named("dc_overvoltage");
    const double source = source_voltage(drawn);
    const double power = motor->torque * motor->speed;
    const double chops = CAMPAIGN_VALUE(drawn, chopper) * over;
    const bool soft = capacitance > 0.0;
    set(to, "dc_returns", soft ? CAMPAIGN_VALUE(drawn, battery) : 0.0);
    set(to, "supply_current_max", CAMPAIGN_VALUE(drawn, supply_drawn) * power / source);
    set(to, "supply_current_regen_max", CAMPAIGN_VALUE(drawn, supply_returned) * power / source);
    if (!soft || chops <= CHOPPER_ABOVE * source || BOARD_CHOPPER_OUTPUT == BOARD_NONE) {
        return;
    }
    const double least = 1.01 * over * 1e3 / BOARD_CHOPPER_CURRENT_MA;
    const double ohms = fmin(fmax(0.5 * chops * chops / power, least), 10000.0);
    set(to, "params.chopper_voltage", chops);
    set(to, "params.chopper_resistance", ohms);
    set(to, "plant.chopper_resistance", ohms);
    set(to, "chopper_power", fmax(2.0 * power, 1.0));
    set(to, "chopper_driven", 1.0);
}

/* The configured delays and drops, of which the drive computes the voltage that a leg loses. */
static void set_losses(campaign_settings_t *to, const campaign_case_t *drawn)
{
    if (drawn->true_values) {
        set(to, "params.turn_off_delay",
            rig_initial_named("dead_time") + rig_initial_named("params.turn_on_delay") -
                campaign_lost_time(drawn));
        set(to, "params.device_drop", campaign_lost_voltage(drawn));
        return;
    }
    set_times(to, "params.turn_off_delay", CAMPAIGN_VALUE(drawn, dead_configured));
    set_times(to, "params.device_drop", CAMPAIGN_VALUE(drawn, dead_configured));
}

static void set_power(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    static const char *const drops[] = {"igbt_voltage", "igbt_resistance", "diode_voltage",
                                        "diode_resistance"};
    bool needed = false;
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        needed = needed || strcmp(campaign_faults[drawn->faults[n].kind].row, "supply_lost") == 0;
    }
    const double capacitance =
        needed && CAMPAIGN_VALUE(drawn, dc_soft) == 0.0 ? LINK : CAMPAIGN_VALUE(drawn, dc_soft);
    set(to, "dc_voltage", source_voltage(drawn));
    set(to, "dc_capacitance", capacitance);
    set(to, "dc_resistance", capacitance > 0.0 ? 0.5 : 0.0);
    set_supply(to, drawn, motor, capacitance);
    set_times(to, "plant.turn_on_delay", CAMPAIGN_VALUE(drawn, turn_on_delay));
    for (size_t n = 0; n < sizeof drops / sizeof drops[0]; n++) {
        set_times(to, drops[n], CAMPAIGN_VALUE(drawn, drops));
    }
    set(to, "leg_a_resistance", CAMPAIGN_VALUE(drawn, leg_resistance) * motor->resistance);
    set(to, "leg_b_drop", CAMPAIGN_VALUE(drawn, leg_drop));
    set(to, "leg_c_delay", CAMPAIGN_VALUE(drawn, leg_delay));
    set_losses(to, drawn);
}

static void set_sensors(campaign_settings_t *to, const campaign_case_t *drawn)
{
    set(to, "current_offset_a", CAMPAIGN_VALUE(drawn, offset_a));
    set(to, "current_offset_b", CAMPAIGN_VALUE(drawn, offset_b));
    set(to, "current_gain_error_a", CAMPAIGN_VALUE(drawn, gain_a));
    set(to, "current_gain_error_b", CAMPAIGN_VALUE(drawn, gain_b));
    set(to, "current_noise", CAMPAIGN_VALUE(drawn, current_noise));
    set(to, "dc_gain_error", CAMPAIGN_VALUE(drawn, dc_gain));
    set(to, "dc_noise", CAMPAIGN_VALUE(drawn, dc_noise));
    set(to, "plant.encoder_lines", CAMPAIGN_VALUE(drawn, encoder_lines));
    set(to, "params.encoder_lines", CAMPAIGN_VALUE(drawn, encoder_lines));
}

bool campaign_has_encoder(const campaign_case_t *drawn)
{
    return CAMPAIGN_VALUE(drawn, encoder) != 0.0;
}

/* true: the parameter stays 0, and the rule of the drive applies. */
static bool is_loop_by_rule(const campaign_case_t *drawn)
{
    return CAMPAIGN_VALUE(drawn, loop_share) == 1.0 || campaign_is_salient(drawn);
}

/* [N m/(kg m^2)] Acceleration that the tracking loop must follow: that by half of the configured torque at
 * current_limit, as in the rule of the drive, or that by rated torque. */
static double followed(const campaign_case_t *drawn)
{
    const double acceleration = campaign_motor(drawn).torque / campaign_inertia(drawn);
    return is_loop_by_rule(drawn) ? 0.5 * acceleration * CAMPAIGN_VALUE(drawn, flux_configured) /
                                        CAMPAIGN_VALUE(drawn, inertia_configured)
                                  : acceleration;
}

double campaign_loop(const campaign_case_t *drawn)
{
    const double asked = 6.4 * sqrt(campaign_motor(drawn).pole_pairs * followed(drawn));
    return fmax(LOOP_MIN, fmin(asked, LOOP_MAX)) *
           (is_loop_by_rule(drawn) ? 1.0 : CAMPAIGN_VALUE(drawn, loop_share));
}

double campaign_speed_loop(const campaign_case_t *drawn)
{
    return campaign_loop(drawn) / LOOP_SLOWER;
}

static void set_loop(campaign_settings_t *to, const campaign_case_t *drawn)
{
    if (is_loop_by_rule(drawn)) {
        return;
    }
    const double bandwidth = campaign_loop(drawn);
    set(to, "pll_bandwidth", bandwidth);
    set(to, "feedforward_cutoff", 0.25 * bandwidth);
}

void campaign_set_all(campaign_settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    to->count = 0;
    set_motor(to, drawn, motor);
    set_shaft(to, drawn, motor);
    set_power(to, drawn, motor);
    set_sensors(to, drawn);
    set(to, "position_source", campaign_has_encoder(drawn) ? 0.0 : 1.0);
    set_loop(to, drawn);
    if (drawn->unlearnt) {
        set(to, "inductance_adaptation", 0.0);
        set(to, "dead_time_adaptation", 0.0);
    }
}
