/* Writes the scenario of a run as text, with errors of its plant. */
#include <math.h>
#include <string.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/campaign_parts.h"
#include "host_sim/lab/scenario_parts.h"

#define WRONG(drawn, name) ((drawn)->quantities[CAMPAIGN_E_##name])

/* The factor of a row of the plant, and the share of another row that is added. */
typedef struct {
    const char *row;
    campaign_error_t error;
    const char *share_of; /* NULL: the error is a factor; "": it is added; else this share of the named row is
                             added */
} wrong_t;

static const wrong_t wrongs[] = {
    {"plant.resistance", CAMPAIGN_E_resistance, NULL},
    {"plant.inductance_d", CAMPAIGN_E_inductance, NULL},
    {"plant.inductance_q", CAMPAIGN_E_inductance, NULL},
    {"plant.flux_linkage", CAMPAIGN_E_flux_linkage, NULL},
    {"plant.inertia", CAMPAIGN_E_inertia, NULL},
    {"plant.friction_coulomb", CAMPAIGN_E_friction, NULL},
    {"plant.friction_breakaway", CAMPAIGN_E_friction, NULL},
    {"plant.friction_viscous", CAMPAIGN_E_friction, NULL},
    {"plant.dc_voltage", CAMPAIGN_E_dc_voltage, NULL},
    {"plant.turn_on_delay", CAMPAIGN_E_turn_on_delay, NULL},
    {"plant.igbt_voltage", CAMPAIGN_E_drops, NULL},
    {"plant.igbt_resistance", CAMPAIGN_E_drops, NULL},
    {"plant.diode_voltage", CAMPAIGN_E_drops, NULL},
    {"plant.diode_resistance", CAMPAIGN_E_drops, NULL},
    {"plant.current_offset_a", CAMPAIGN_E_offset_a, "plant.current_range"},
    {"plant.current_offset_b", CAMPAIGN_E_offset_b, "plant.current_range"},
    {"plant.current_gain_error_a", CAMPAIGN_E_gain_a, ""},
    {"plant.current_gain_error_b", CAMPAIGN_E_gain_b, ""},
    {"plant.current_noise", CAMPAIGN_E_current_noise, NULL},
    {"plant.dc_gain_error", CAMPAIGN_E_dc_gain, ""},
};

/* The value of the row at t = 0, or that of an event of the scenario. */
static double wrong_value(const campaign_case_t *drawn, const table_row_t *row, double value)
{
    for (size_t n = 0; n < sizeof wrongs / sizeof wrongs[0]; n++) {
        const wrong_t *wrong = &wrongs[n];
        const double by = drawn->quantities[wrong->error];
        if (rig_row_by_name(wrong->row) != row) {
            continue;
        }
        if (wrong->share_of == NULL) {
            return by == 1.0 ? value : by * value;
        }
        return value + by * (wrong->share_of[0] != '\0'
                                 ? scenario_initial(drawn->around, rig_row_by_name(wrong->share_of))
                                 : 1.0);
    }
    return value;
}

static void say_quoted(campaign_writing_t *text, const char *key, const char *value)
{
    campaign_say(text, "%s = \"", key);
    for (; *value != '\0'; value++) {
        campaign_say(text, *value == '"' || *value == '\\' ? "\\%c" : "%c", *value);
    }
    campaign_say(text, "\"\n");
}

/* Every row that differs from its default. */
static void say_initial(campaign_writing_t *text, const campaign_case_t *drawn)
{
    for (size_t t = 0; t < SCENARIO_SETTABLE; t++) {
        const table_t *table = scenario_table(scenario_settable[t]);
        bool first = true;
        for (uint32_t n = 0; n < table->count; n++) {
            const table_row_t *row = &table->rows[n];
            const double value = wrong_value(drawn, row, scenario_initial(drawn->around, row));
            if (value != rig_initial(row)) {
                campaign_say(text, "%s%s%s%s = ", first ? "\n[" : "", first ? table->name : "",
                             first ? "]\n" : "", row->name);
                campaign_say_value(text, row, value);
                first = false;
            }
        }
    }
}

static void say_events(campaign_writing_t *text, const campaign_case_t *drawn)
{
    const scenario_t *scenario = drawn->around;
    for (uint32_t e = 1; e < scenario->event_count; e++) {
        const scenario_event_t *event = &scenario->events[e];
        if (event->time >= drawn->seconds) {
            break;
        }
        campaign_say(text, "\n[[at]]\ntime = %.9g\n", event->time);
        if (event->ramp > 0.0) {
            campaign_say(text, "ramp = %.9g\n", fmin(event->ramp, drawn->seconds - event->time));
        }
        for (uint32_t n = 0; n < event->count; n++) {
            const scenario_setting_t *setting = &event->settings[n];
            campaign_say(text, "%s.%s = ", scenario_table_of(setting->row)->name, setting->row->name);
            campaign_say_value(text, setting->row, wrong_value(drawn, setting->row, setting->value));
        }
    }
}

static void say_expects(campaign_writing_t *text, const campaign_case_t *drawn)
{
    const scenario_t *scenario = drawn->around;
    for (uint32_t n = 0; n < scenario->expect_count; n++) {
        const scenario_expect_t *expect = &scenario->expects[n];
        char name[128];
        if (expect->to > drawn->seconds) {
            continue;
        }
        campaign_say(text, "\n[[expect]]\n");
        if (expect->name[0] != '\0') {
            say_quoted(text, "name", expect->name);
        }
        scenario_row_name(expect->row, name, sizeof name);
        say_quoted(text, "signal", name);
        if (expect->minus != NULL) {
            scenario_row_name(expect->minus, name, sizeof name);
            say_quoted(text, "minus", name);
        }
        say_quoted(text, "statistic", statistic_text(expect->statistic));
        campaign_say(text, "from = %.9g\nto = %.9g\n", expect->from, expect->to);
        if (isfinite(expect->at_least)) {
            campaign_say(text, "at_least = %.17g\n", expect->at_least);
        }
        if (isfinite(expect->at_most)) {
            campaign_say(text, "at_most = %.17g\n", expect->at_most);
        }
        if (expect->needs_none) {
            say_quoted(text, "needs_drive", "no");
        }
    }
}

void campaign_say_around(campaign_writing_t *text, const campaign_case_t *drawn, const char *what)
{
    const scenario_t *scenario = drawn->around;
    const double angle = scenario->start_angle + WRONG(drawn, angle);
    campaign_say(text, "schema = 1\n%stitle = \"Campaign around a scenario, seed %llu, run %lu%s%s\"\n",
                 boards_line(), (unsigned long long)drawn->seed, (unsigned long)drawn->run,
                 what[0] != '\0' ? ": " : "", what);
    campaign_say(text, "\n[run]\nduration = %.9g\nseed = %lu\n", drawn->seconds, (unsigned long)drawn->run);
    if (scenario->has_start_speed || angle != 0.0) {
        campaign_say(text, "\n[start]\nangle = %.9g\n", angle);
    }
    if (scenario->has_start_speed) {
        campaign_say(text, "speed = %.9g\n", scenario->start_speed);
    }
    say_initial(text, drawn);
    say_events(text, drawn);
    say_expects(text, drawn);
}
