/* A case as a scenario: the motor from its shares, the rows from the motor, the text from the rows. */
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"

#define ROOT_3        1.7320508075688772
#define SPEED_MIN     60.0   /* [rad/s] rated, mechanical */
#define SPEED_MAX     1000.0 /* [rad/s] likewise */
#define ELECTRIC_MAX  2000.0 /* [rad/s] rated, electrical: 3 % of a turn a period */
#define RUN_UP_MIN    4e-3   /* [s] to rated speed by rated torque: the smallest servo motors */
#define RIPPLE_MAX    0.3    /* [-] of rated current, peak to peak: V_dc T_s/(6 L) */
#define LOOP_MIN      200.0  /* [rad/s] */
#define LOOP_MAX      1000.0 /* [rad/s] a tenth of the carrier's */
#define LINK          1e-3   /* [F] where what breaks needs a capacitor */
#define SHAFT_DAMPING 0.02   /* [-] of an elastic shaft */
#define PERIOD        ((double)BOARD_PERIOD)

/* The one whose rows are the defaults: the paper's. */
static campaign_motor_t default_motor(void)
{
    const double torque_per_ampere = 1.5 * rig_initial(rig_row_by_name("plant.pole_pairs")) *
                                     rig_initial(rig_row_by_name("plant.flux_linkage"));
    const double current = rig_initial(rig_row_by_name("current_limit"));
    return (campaign_motor_t){
        .pole_pairs = rig_initial(rig_row_by_name("plant.pole_pairs")),
        .resistance = rig_initial(rig_row_by_name("plant.resistance")),
        .inductance_d = rig_initial(rig_row_by_name("plant.inductance_d")),
        .inductance_q = rig_initial(rig_row_by_name("plant.inductance_q")),
        .flux_linkage = rig_initial(rig_row_by_name("plant.flux_linkage")),
        .inertia = rig_initial(rig_row_by_name("plant.inertia")),
        .speed = rig_initial(rig_row_by_name("overspeed_trip")) / 1.4,
        .torque = torque_per_ampere * current,
        .current = current,
        .trip = rig_initial(rig_row_by_name("overcurrent_trip")),
    };
}

campaign_motor_t campaign_motor(const campaign_case_t *drawn)
{
    if (CAMPAIGN_VALUE(drawn, motor_drawn) == 0.0) {
        return default_motor();
    }
    /* E the peak EMF of a phase at rated speed; run-up t = J omega/T, T = 1.5 E I/omega */
    const double emf = CAMPAIGN_VALUE(drawn, emf_share) * 270.0 / ROOT_3;
    const double inertia = CAMPAIGN_VALUE(drawn, inertia);
    const double most = inertia * SPEED_MAX * SPEED_MAX / (1.5 * emf * RUN_UP_MIN);
    const double current = fmax(0.5, fmin(CAMPAIGN_VALUE(drawn, current), most));
    const double asked = sqrt(1.5 * emf * current * CAMPAIGN_VALUE(drawn, run_up) / inertia);
    const double speed = fmax(SPEED_MIN, fmin(asked, SPEED_MAX));
    const double pole_pairs = fmax(1.0, fmin(CAMPAIGN_VALUE(drawn, pole_pairs), floor(ELECTRIC_MAX / speed)));
    const double by_reactance = CAMPAIGN_VALUE(drawn, reactance) * emf / (pole_pairs * speed * current);
    const double by_ripple = CAMPAIGN_VALUE(drawn, dc_voltage) * PERIOD / (6.0 * RIPPLE_MAX * current);
    const double inductance = fmin(fmax(by_reactance, by_ripple), 0.5);
    return (campaign_motor_t){
        .pole_pairs = pole_pairs,
        .resistance = CAMPAIGN_VALUE(drawn, resistive) * emf / current,
        .inductance_d = inductance,
        .inductance_q = inductance * CAMPAIGN_VALUE(drawn, saliency),
        .flux_linkage = emf / (pole_pairs * speed),
        .inertia = inertia,
        .speed = speed,
        .torque = 1.5 * emf * current / speed,
        .current = current,
        .trip = fmin(1.5 * current, 0.95 * rig_max(rig_row_by_name("overcurrent_trip"))),
    };
}

/* docs/theory.md, 23: 1.15 times what could be mistaken for an EMF, the dead time's voltage or R I, but 0.3
 * of overspeed_trip at most. */
double campaign_handover_speed(const campaign_case_t *drawn)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    const double dead =
        rig_initial(rig_row_by_name("dead_time")) / PERIOD * rig_initial(rig_row_by_name("dc_overvoltage"));
    const double drop = motor.resistance * CAMPAIGN_VALUE(drawn, resistance_belief) * motor.current;
    const double flux = motor.flux_linkage * CAMPAIGN_VALUE(drawn, flux_belief);
    return fmin(1.15 * fmax(dead, drop) / (flux * motor.pole_pairs), 0.3 * 1.4 * motor.speed);
}

double campaign_blind_speed(const campaign_case_t *drawn)
{
    const double turns = CAMPAIGN_TURN / CAMPAIGN_ANGLE_SECONDS / campaign_motor(drawn).pole_pairs;
    const double weak = fmax(CAMPAIGN_VALUE(drawn, flux_belief), 1.0);
    return fmax(weak * campaign_handover_speed(drawn), turns);
}

bool campaign_is_coded(const campaign_case_t *drawn, double time)
{
    bool coded = CAMPAIGN_VALUE(drawn, encoder) != 0.0;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        coded = coded != (drawn->events[n].kind == CAMPAIGN_V_SOURCE && drawn->events[n].time <= time);
    }
    return coded;
}

/* ---- rows ---- */

typedef struct {
    const table_row_t *row;
    double value;
} setting_t;

#define SETTINGS_MAX 96u

typedef struct {
    setting_t settings[SETTINGS_MAX];
    uint32_t count;
} settings_t;

/* Only what is not the default is set. */
static void set(settings_t *to, const char *name, double value)
{
    const table_row_t *row = rig_row_by_name(name);
    const double slot = row->kind == SLOT_FLOAT ? (double)(float)value : floor(value + 0.5);
    if (slot != rig_initial(row) && to->count < SETTINGS_MAX) {
        to->settings[to->count++] = (setting_t){row, slot};
    }
}

static void set_times(settings_t *to, const char *name, double factor)
{
    set(to, name, factor * rig_initial(rig_row_by_name(name)));
}

/* What the rules of thumb make of what is believed of the motor. */
static void set_drive(settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    const double flux = motor->flux_linkage * CAMPAIGN_VALUE(drawn, flux_belief);
    const double inductance = motor->inductance_q * CAMPAIGN_VALUE(drawn, inductance_belief);
    const double overspeed = 1.4 * motor->speed;
    const double gain = 1.75 * flux * motor->pole_pairs * motor->speed;
    const double slope = 1.6 * inductance / (gain * PERIOD);
    set(to, "motor_pole_pairs", motor->pole_pairs);
    set(to, "overspeed_trip", overspeed);
    set(to, "current_limit", motor->current);
    set(to, "overcurrent_trip", motor->trip);
    set(to, "low_speed_current", 0.2 * motor->current);
    set(to, "observer_gain", gain);
    set(to, "observer_slope", slope);
    set(to, "estimate_current_max", fmin(4.0 / slope, 100.0));
    set(to, "estimate_speed_min", 0.02 * motor->speed);
}

static void set_motor(settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    set(to, "plant.pole_pairs", motor->pole_pairs);
    set(to, "plant.resistance", motor->resistance);
    set(to, "plant.inductance_d", motor->inductance_d);
    set(to, "plant.inductance_q", motor->inductance_q);
    set(to, "plant.flux_linkage", motor->flux_linkage);
    set(to, "plant.inertia", motor->inertia);
    set(to, "emf_5th", CAMPAIGN_VALUE(drawn, emf_5th));
    set(to, "emf_7th", CAMPAIGN_VALUE(drawn, emf_7th));
    set(to, "motor_resistance", motor->resistance * CAMPAIGN_VALUE(drawn, resistance_belief));
    set(to, "motor_inductance_d", motor->inductance_d * CAMPAIGN_VALUE(drawn, inductance_belief));
    set(to, "motor_inductance_q", motor->inductance_q * CAMPAIGN_VALUE(drawn, inductance_belief));
    set(to, "motor_flux_linkage", motor->flux_linkage * CAMPAIGN_VALUE(drawn, flux_belief));
    set(to, "motor_inertia",
        motor->inertia * (1.0 + CAMPAIGN_VALUE(drawn, second_mass)) * CAMPAIGN_VALUE(drawn, inertia_belief));
    if (CAMPAIGN_VALUE(drawn, motor_drawn) != 0.0) {
        set_drive(to, drawn, motor);
    }
}

static void set_shaft(settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    const double friction = CAMPAIGN_VALUE(drawn, friction) * motor->torque;
    const double viscous = CAMPAIGN_VALUE(drawn, viscous) * motor->torque / motor->speed;
    set(to, "friction_coulomb", friction);
    /* a hair more, so that it is no less as a float either */
    set(to, "friction_breakaway", CAMPAIGN_VALUE(drawn, stiction) * friction * 1.000001);
    set(to, "friction_viscous", viscous);
    set(to, "load_kind", CAMPAIGN_VALUE(drawn, load_kind));
    set(to, "load_torque", CAMPAIGN_VALUE(drawn, load) * motor->torque);

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

static void set_power(settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    static const char *const drops[] = {"igbt_voltage", "igbt_resistance", "diode_voltage",
                                        "diode_resistance"};
    const bool needed = strcmp(campaign_faults[drawn->fault].row, "supply_lost") == 0;
    const double capacitance =
        needed && CAMPAIGN_VALUE(drawn, dc_soft) == 0.0 ? LINK : CAMPAIGN_VALUE(drawn, dc_soft);
    set(to, "dc_voltage", CAMPAIGN_VALUE(drawn, dc_voltage));
    set(to, "dc_capacitance", capacitance);
    set(to, "dc_resistance", capacitance > 0.0 ? 0.5 : 0.0);
    set_times(to, "plant.turn_on_delay", CAMPAIGN_VALUE(drawn, turn_on_delay));
    for (size_t n = 0; n < sizeof drops / sizeof drops[0]; n++) {
        set_times(to, drops[n], CAMPAIGN_VALUE(drawn, drops));
    }
    set(to, "leg_a_resistance", CAMPAIGN_VALUE(drawn, leg_resistance) * motor->resistance);
    set(to, "leg_b_drop", CAMPAIGN_VALUE(drawn, leg_drop));
    set(to, "leg_c_delay", CAMPAIGN_VALUE(drawn, leg_delay));
    set_times(to, "params.turn_off_delay", CAMPAIGN_VALUE(drawn, dead_belief));
    set_times(to, "params.device_drop", CAMPAIGN_VALUE(drawn, dead_belief));
}

static void set_sensors(settings_t *to, const campaign_case_t *drawn)
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

static bool encoder(const campaign_case_t *drawn)
{
    return CAMPAIGN_VALUE(drawn, encoder) != 0.0;
}

/* Of the tracking loop, by the rule for another motor: what rated torque accelerates must be followed. */
static void set_loop(settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    const double inertia = motor->inertia * (1.0 + CAMPAIGN_VALUE(drawn, second_mass));
    const double asked = 6.4 * sqrt(motor->pole_pairs * motor->torque / inertia);
    const double bandwidth = fmax(LOOP_MIN, fmin(asked, LOOP_MAX)) * CAMPAIGN_VALUE(drawn, loop_share);
    set(to, "pll_bandwidth", bandwidth);
    set(to, "feedforward_cutoff", 0.25 * bandwidth);
}

static void set_all(settings_t *to, const campaign_case_t *drawn, const campaign_motor_t *motor)
{
    to->count = 0;
    set_motor(to, drawn, motor);
    set_shaft(to, drawn, motor);
    set_power(to, drawn, motor);
    set_sensors(to, drawn);
    set(to, "position_source", encoder(drawn) ? 0.0 : 1.0);
    set_loop(to, drawn, motor);
}

/* ---- text ---- */

typedef campaign_writing_t text_t;
#define say campaign_say

void campaign_say(campaign_writing_t *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text->to + text->used, text->size - text->used, format, arguments);
    va_end(arguments);
    text->used = length < 0 || (size_t)length >= text->size - text->used ? text->size - 1u
                                                                         : text->used + (size_t)length;
}

void campaign_say_value(campaign_writing_t *text, const table_row_t *row, double value)
{
    if (row->kind == SLOT_ENUM) {
        const char *choice = row->choices;
        for (uint32_t n = 0; n < (uint32_t)value; n++) {
            choice = strchr(choice, '|') + 1;
        }
        say(text, "\"%.*s\"\n", (int)strcspn(choice, "|"), choice);
    } else {
        say(text, "%.9g\n", value);
    }
}

static void say_settings(text_t *text, const settings_t *settings)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        bool first = true;
        for (uint32_t n = 0; n < settings->count; n++) {
            const table_row_t *row = settings->settings[n].row;
            if (row >= table->rows && row < table->rows + table->count) {
                say(text, "%s%s%s%s = ", first ? "\n[" : "", first ? table->name : "", first ? "]\n" : "",
                    row->name);
                campaign_say_value(text, row, settings->settings[n].value);
                first = false;
            }
        }
    }
}

/* A row of any table under its own key, as [[at]] has it. */
static void say_at(text_t *text, const char *name, double value)
{
    const table_row_t *row = rig_row_by_name(name);
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        if (row >= table->rows && row < table->rows + table->count) {
            say(text, "%s.%s = ", table->name, row->name);
        }
    }
    campaign_say_value(text, row, value);
}

static void say_event(text_t *text, const campaign_case_t *drawn, const campaign_motor_t *motor,
                      const campaign_event_t *event, uint32_t number)
{
    say(text, "\n[[at]]\ntime = %.9g\n", event->time);
    switch (event->kind) {
    case CAMPAIGN_V_SPEED:
    case CAMPAIGN_V_SLOW:
        say_at(text, "mode", 0.0);
        say_at(text, "speed_request", event->value * motor->speed);
        break;
    case CAMPAIGN_V_LOAD:
        say_at(text, "plant.load_torque", event->value * motor->torque);
        break;
    case CAMPAIGN_V_QUICK_STOP:
        say_at(text, "enable", 2.0);
        break;
    case CAMPAIGN_V_OFF:
        say_at(text, "enable", 0.0);
        break;
    case CAMPAIGN_V_ON:
        say_at(text, "enable", 1.0);
        break;
    case CAMPAIGN_V_CURRENT:
        say_at(text, "mode", 1.0);
        say_at(text, "i_q_request", event->value * motor->current);
        break;
    case CAMPAIGN_V_SOURCE: {
        uint32_t changes = 1;
        for (uint32_t n = 0; n < number; n++) {
            changes += drawn->events[n].kind == CAMPAIGN_V_SOURCE;
        }
        say_at(text, "position_source", encoder(drawn) == (changes % 2u == 0u) ? 0.0 : 1.0);
        break;
    }
    case CAMPAIGN_EVENT_KINDS:
        break;
    }
}

/* Value of the row that breaks, in its unit. */
static double fault_value(const campaign_case_t *drawn, const campaign_motor_t *motor,
                          const settings_t *settings)
{
    const campaign_fault_t *fault = &campaign_faults[drawn->fault];
    const table_row_t *row = rig_row_by_name(fault->row);
    const double drawn_value = drawn->fault_value;
    switch (fault->scale) {
    case CAMPAIGN_OF_TORQUE:
        return drawn_value * motor->torque;
    case CAMPAIGN_OF_CURRENT:
        return drawn_value * motor->current;
    case CAMPAIGN_OF_ROW: {
        double initial = rig_initial(row);
        for (uint32_t n = 0; n < settings->count; n++) {
            initial = settings->settings[n].row == row ? settings->settings[n].value : initial;
        }
        return drawn_value * initial;
    }
    case CAMPAIGN_OF_SWITCH:
        return ldexp(1.0, (int)drawn_value);
    case CAMPAIGN_OF_STATE:
        return floor(drawn_value * CAMPAIGN_STATE_WORDS);
    case CAMPAIGN_AS_IT_IS:
        break;
    }
    return drawn_value;
}

static void say_fault(text_t *text, const campaign_case_t *drawn, const campaign_motor_t *motor,
                      const settings_t *settings)
{
    const campaign_fault_t *fault = &campaign_faults[drawn->fault];
    say(text, "\n[[at]] # fault: %s\ntime = %.9g\n", fault->name, drawn->fault_time);
    if (fault->scale == CAMPAIGN_OF_STATE) {
        const double words = drawn->fault_value * CAMPAIGN_STATE_WORDS;
        say_at(text, "flip_bit", floor(32.0 * (words - floor(words))));
    }
    say_at(text, fault->row, fault_value(drawn, motor, settings));
}

/* What fails because of the violation; one that no signal shows has none. */
static void say_expect(text_t *text, double trip, const campaign_result_t *result)
{
    const table_row_t *row = rig_row(result->row);
    const campaign_invariant_row_t *invariant = &campaign_invariants[result->invariant];
    const char *statistic = "max";
    double limit = 0.0;
    switch (result->invariant) {
    case CAMPAIGN_I_NUMBER:
        limit = 1e300; /* what is no number is not below it */
        break;
    case CAMPAIGN_I_CURRENT:
        statistic = "rms"; /* all samples are beyond: so is this */
        limit = invariant->limit * trip;
        break;
    case CAMPAIGN_I_ANGLE:
        statistic = "rms";
        limit = invariant->limit;
        break;
    case CAMPAIGN_I_LATE:
        limit = (double)(CAMPAIGN_LATE_FLAG - 1u);
        break;
    case CAMPAIGN_I_LEGS:
    case CAMPAIGN_I_CHIP:
        break;
    case CAMPAIGN_I_GATES:
    case CAMPAIGN_I_REASON:
    case CAMPAIGN_I_REPEAT:
    case CAMPAIGN_I_EXPECT: /* it stands in the scenario */
    case CAMPAIGN_INVARIANT_COUNT:
        return;
    }
    say(text, "\n[[expect]] # %s\nname = \"%s\"\nsignal = \"%s\"\nstatistic = \"%s\"\n", invariant->text,
        invariant->name, row->name, statistic);
    say(text, "from = %.9g\nto = %.9g\nat_most = %.9g\n", result->from * RIG_PERIOD_SECONDS,
        (result->period + 1u) * RIG_PERIOD_SECONDS, limit);
}

static void say_drawn(text_t *text, const campaign_case_t *drawn, const char *what)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    settings_t settings;
    set_all(&settings, drawn, &motor);
    say(text, "schema = 1\ntitle = \"Campaign of seed %llu, run %lu%s%s\"\n", (unsigned long long)drawn->seed,
        (unsigned long)drawn->run, what[0] != '\0' ? ": " : "", what);
    say(text, "\n[run]\nduration = %.9g\nseed = %lu\n", drawn->seconds, (unsigned long)drawn->run);
    if (CAMPAIGN_VALUE(drawn, angle) != 0.0 || CAMPAIGN_VALUE(drawn, speed) != 0.0) {
        say(text, "\n[start]\nangle = %.9g\nspeed = %.9g\n", CAMPAIGN_VALUE(drawn, angle),
            CAMPAIGN_VALUE(drawn, speed) * motor.speed);
    }
    say_settings(text, &settings);
    bool injected = drawn->fault == 0u;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        if (!injected && drawn->fault_time < drawn->events[n].time) {
            say_fault(text, drawn, &motor, &settings);
            injected = true;
        }
        say_event(text, drawn, &motor, &drawn->events[n], n);
    }
    if (!injected) {
        say_fault(text, drawn, &motor, &settings);
    }
}

double campaign_trip(const campaign_case_t *drawn)
{
    return drawn->around != NULL ? scenario_initial(drawn->around, rig_row_by_name("overcurrent_trip"))
                                 : campaign_motor(drawn).trip;
}

double campaign_overspeed(const campaign_case_t *drawn)
{
    return drawn->around != NULL ? scenario_initial(drawn->around, rig_row_by_name("overspeed_trip"))
                                 : 1.4 * campaign_motor(drawn).speed;
}

size_t campaign_text(const campaign_case_t *drawn, const campaign_result_t *result, char *to, size_t size)
{
    text_t text = {to, size, 0u};
    const bool violated = result != NULL && result->end == CAMPAIGN_VIOLATED;
    const char *what = violated ? campaign_invariants[result->invariant].name : "";
    if (drawn->around != NULL) {
        campaign_say_around(&text, drawn, what);
    } else {
        say_drawn(&text, drawn, what);
    }
    if (violated) {
        say_expect(&text, campaign_trip(drawn), result);
    }
    return text.used < size - 1u ? text.used : 0u;
}
