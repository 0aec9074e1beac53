/* A case as a scenario: the text of its rows, its events and its faults, and the expectation that fails
 * because of a violation. */
#include <math.h>
#include <stdarg.h>
#include <string.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/campaign_parts.h"

typedef campaign_writing_t text_t;
#define say campaign_say

#define NOISE_SHIFT 24u /* [bits] place of the noise's number in the seed, above that of the run */

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

static void say_settings(text_t *text, const campaign_settings_t *settings)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        bool first = true;
        for (uint32_t n = 0; n < settings->count; n++) {
            const table_row_t *row = settings->settings[n].row;
            if (scenario_table_of(row) == table) {
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
    say(text, "%s.%s = ", scenario_table_of(row)->name, row->name);
    campaign_say_value(text, row, value);
}

/* `enable`; an earlier request for a reset is cleared with it, so that another one can follow. */
static void say_enable(text_t *text, const campaign_case_t *drawn, uint32_t number, double value)
{
    bool reset = false;
    for (uint32_t n = 0; n < number; n++) {
        reset = reset || drawn->events[n].kind == CAMPAIGN_V_RESET;
    }
    say_at(text, "enable", value);
    if (reset) {
        say_at(text, "fault_reset", 0.0);
    }
}

/* One of the parameters that may change while the motor runs: motor data are wrong by 30 % at most, as
 * from the start; the others change by a quarter at most. */
static void say_parameter(text_t *text, const campaign_case_t *drawn, const campaign_motor_t *motor,
                          double value)
{
    const double configured = 0.7 + 0.6 * (value - floor(value));
    const double share = 0.75 + 0.5 * (value - floor(value));
    switch ((int)value) {
    case 0:
        say_at(text, "motor_resistance", configured * motor->resistance);
        break;
    case 1:
        say_at(text, "motor_inertia", configured * campaign_inertia(drawn));
        break;
    case 2:
        say_at(text, "current_bandwidth", share * rig_initial_named("current_bandwidth"));
        break;
    default:
        say_at(text, "current_limit", fmin(share, 1.0) * motor->current);
        break;
    }
}

static void say_event(text_t *text, const campaign_case_t *drawn, const campaign_motor_t *motor,
                      const campaign_event_t *event, uint32_t number)
{
    say(text, "\n[[at]]\ntime = %.9g\n", event->time);
    switch (event->kind) {
    case CAMPAIGN_V_SPEED:
    case CAMPAIGN_V_SLOW:
        say_at(text, "mode", 0.0);
        say_at(text, "speed_request", campaign_speed_of(drawn, event) * motor->speed);
        break;
    case CAMPAIGN_V_LOAD:
        say_at(text, "plant.load_torque", event->value * motor->torque);
        break;
    case CAMPAIGN_V_QUICK_STOP:
        say_at(text, "enable", 2.0);
        break;
    case CAMPAIGN_V_OFF:
        say_enable(text, drawn, number, 0.0);
        break;
    case CAMPAIGN_V_ON:
        say_enable(text, drawn, number, 1.0);
        break;
    case CAMPAIGN_V_RESET:
        say_at(text, "fault_reset", 1.0);
        break;
    case CAMPAIGN_V_DRIFT:
        say_at(text, "plant.current_offset_a", CAMPAIGN_VALUE(drawn, offset_a) + event->value);
        say_at(text, "plant.current_offset_b", CAMPAIGN_VALUE(drawn, offset_b) - event->value);
        break;
    case CAMPAIGN_V_PARAMS:
        say_parameter(text, drawn, motor, event->value);
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
        say_at(text, "position_source", campaign_has_encoder(drawn) == (changes % 2u == 0u) ? 0.0 : 1.0);
        break;
    }
    case CAMPAIGN_EVENT_KINDS:
        break;
    }
}

/* The value of a row at t = 0. */
static double initial_of(const table_row_t *row, const campaign_settings_t *settings)
{
    double initial = rig_initial(row);
    for (uint32_t n = 0; n < settings->count; n++) {
        initial = settings->settings[n].row == row ? settings->settings[n].value : initial;
    }
    return initial;
}

/* Value of the row that the fault changes, in its unit. */
static double fault_value(const campaign_injected_t *injected, const campaign_motor_t *motor,
                          const campaign_settings_t *settings)
{
    const campaign_fault_t *fault = &campaign_faults[injected->kind];
    switch (fault->scale) {
    case CAMPAIGN_OF_TORQUE:
        return injected->value * motor->torque;
    case CAMPAIGN_OF_CURRENT:
        return injected->value * motor->current;
    case CAMPAIGN_OF_ROW:
        return injected->value * initial_of(rig_row_by_name(fault->row), settings);
    case CAMPAIGN_OF_SWITCH:
        return ldexp(1.0, (int)injected->value);
    case CAMPAIGN_OF_STATE:
        return floor(injected->value * CAMPAIGN_STATE_WORDS);
    case CAMPAIGN_AS_IT_IS:
        break;
    }
    return injected->value;
}

static void say_fault(text_t *text, const campaign_injected_t *injected, const campaign_motor_t *motor,
                      const campaign_settings_t *settings)
{
    const campaign_fault_t *fault = &campaign_faults[injected->kind];
    say(text, "\n[[at]] # fault: %s\ntime = %.9g\n", fault->name, injected->time);
    if (fault->scale == CAMPAIGN_OF_STATE) {
        const double words = injected->value * CAMPAIGN_STATE_WORDS;
        say_at(text, "flip_bit", floor(32.0 * (words - floor(words))));
    }
    say_at(text, fault->row, fault_value(injected, motor, settings));
}

double campaign_drift(const campaign_case_t *drawn, double time)
{
    double drift = 0.0;
    for (uint32_t n = 0; n < drawn->event_count; n++) {
        const campaign_event_t *event = &drawn->events[n];
        drift = event->kind == CAMPAIGN_V_DRIFT && event->time < time ? event->value : drift;
    }
    return drift;
}

/* The value of a row at this time without its fault: the initial one, and an offset has drifted since. */
static double sound_value(const campaign_case_t *drawn, const char *row, const campaign_settings_t *settings,
                          double time)
{
    const double drift = campaign_drift(drawn, time);
    const double initial = initial_of(rig_row_by_name(row), settings);
    const bool a = strcmp(row, "current_offset_a") == 0;
    const bool b = strcmp(row, "current_offset_b") == 0;
    return a ? initial + drift : b ? initial - drift : initial;
}

/* The end of the fault, if it is before the end of the run. */
static void say_fault_end(text_t *text, const campaign_case_t *drawn, const campaign_injected_t *injected,
                          const campaign_settings_t *settings)
{
    const campaign_fault_t *fault = &campaign_faults[injected->kind];
    const double end = injected->time + injected->lasts;
    if (injected->lasts > 0.0 && end < drawn->seconds) {
        say(text, "\n[[at]] # %s has gone\ntime = %.9g\n", fault->name, end);
        say_at(text, fault->row, sound_value(drawn, fault->row, settings, end));
    }
}

/* The expectation on a signal that corresponds to an invariant; a statistic without a name: none corresponds.
 */
typedef struct {
    const char *statistic;
    const char *limits; /* "at_most" or "at_least" */
    double limit;       /* [unit of the signal] */
} claim_t;

static claim_t claim_of(const campaign_case_t *drawn, const campaign_result_t *result)
{
    const double limit = campaign_invariants[result->invariant].limit;
    switch (result->invariant) {
    case CAMPAIGN_I_NUMBER:
        return (claim_t){"max", "at_most", 1e300}; /* a NaN is not below the limit */
    case CAMPAIGN_I_CURRENT: /* if all samples exceed the limit, so does their rms value */
        return (claim_t){"rms", "at_most", limit * campaign_trip(drawn)};
    case CAMPAIGN_I_ANGLE:
        return (claim_t){"rms", "at_most", limit};
    case CAMPAIGN_I_LATE:
        return (claim_t){"max", "at_most", (double)(CAMPAIGN_LATE_FLAG - 1u)};
    case CAMPAIGN_I_LEGS:
    case CAMPAIGN_I_CHIP:
    case CAMPAIGN_I_REASON_TRUE:
        return (claim_t){"max", "at_most", 0.0};
    case CAMPAIGN_I_STOP: /* the last state before the violation */
        return (claim_t){"max", "at_most",
                         (double)table_choice(rig_row_by_name("state"), "operation_enabled")};
    case CAMPAIGN_I_PERSIST:
        return (claim_t){"max", "at_least", (double)table_choice(rig_row_by_name("state"), "switched_on")};
    case CAMPAIGN_I_TRIP_SPEED:
        return (claim_t){"rms", "at_most", limit * campaign_overspeed(drawn)};
    case CAMPAIGN_I_TRIP_LINK:
        return (claim_t){"mean", "at_most", campaign_initial(drawn, "dc_overvoltage")};
    case CAMPAIGN_I_AWAY:
        return (claim_t){"rms", "at_most", limit * campaign_motor(drawn).torque};
    case CAMPAIGN_I_REACH:
        return (claim_t){"rms", "at_most", limit * campaign_motor(drawn).speed};
    case CAMPAIGN_I_NOTICE:
        return result->row == rig_row_by_name("true_u_dc")->id
                   ? (claim_t){"mean", "at_least", campaign_initial(drawn, "dc_undervoltage")}
                   : (claim_t){"max", "at_least", 1.0};
    case CAMPAIGN_I_LEARN: /* the violation appears only in the comparison of two runs */
    case CAMPAIGN_I_OFF:   /* gates are no signal */
    case CAMPAIGN_I_GATES:
    case CAMPAIGN_I_REASON:
    case CAMPAIGN_I_REPEAT:
    case CAMPAIGN_I_EXPECT: /* the expectation belongs to the scenario */
    case CAMPAIGN_INVARIANT_COUNT:
        break;
    }
    return (claim_t){NULL, NULL, 0.0};
}

/* The expectation that fails because of the violation; a violation that no signal shows has none. */
static void say_expect(text_t *text, const campaign_case_t *drawn, const campaign_result_t *result)
{
    const campaign_invariant_row_t *invariant = &campaign_invariants[result->invariant];
    const claim_t claim = claim_of(drawn, result);
    if (claim.statistic == NULL) {
        return;
    }
    say(text, "\n[[expect]] # %s\nname = \"%s\"\nsignal = \"%s\"\nstatistic = \"%s\"\n", invariant->text,
        invariant->name, rig_row(result->row)->name, claim.statistic);
    if (result->invariant == CAMPAIGN_I_REACH) {
        say(text, "minus = \"speed_request\"\n");
    }
    say(text, "from = %.9g\nto = %.9g\n%s = %.9g\n", result->from * RIG_PERIOD_SECONDS,
        (result->period + 1u) * RIG_PERIOD_SECONDS, claim.limits, claim.limit);
}

static void say_drawn(text_t *text, const campaign_case_t *drawn, const char *what)
{
    const campaign_motor_t motor = campaign_motor(drawn);
    campaign_settings_t settings;
    campaign_set_all(&settings, drawn, &motor);
    say(text, "schema = 1\n%stitle = \"Campaign of seed %llu, run %lu%s%s\"\n", boards_line(),
        (unsigned long long)drawn->seed, (unsigned long)drawn->run, what[0] != '\0' ? ": " : "", what);
    say(text, "\n[run]\nduration = %.9g\nseed = %lu\n", drawn->seconds,
        (unsigned long)(drawn->run + (drawn->noise << NOISE_SHIFT)));
    if (CAMPAIGN_VALUE(drawn, angle) != 0.0 || CAMPAIGN_VALUE(drawn, speed) != 0.0) {
        say(text, "\n[start]\nangle = %.9g\nspeed = %.9g\n", CAMPAIGN_VALUE(drawn, angle),
            CAMPAIGN_VALUE(drawn, speed) * motor.speed);
    }
    say_settings(text, &settings);
    bool said[CAMPAIGN_FAULTS_MAX] = {false};
    for (uint32_t n = 0; n <= drawn->event_count; n++) {
        const double until = n < drawn->event_count ? drawn->events[n].time : (double)INFINITY;
        for (uint32_t f = 0; f < CAMPAIGN_FAULTS_MAX; f++) {
            const campaign_injected_t *injected = &drawn->faults[f];
            if (!said[f] && injected->kind != 0u && injected->time < until) {
                say_fault(text, injected, &motor, &settings);
                said[f] = true;
            }
        }
        if (n < drawn->event_count) {
            say_event(text, drawn, &motor, &drawn->events[n], n);
        }
    }
    for (uint32_t f = 0; f < CAMPAIGN_FAULTS_MAX; f++) {
        if (drawn->faults[f].kind != 0u) {
            say_fault_end(text, drawn, &drawn->faults[f], &settings);
        }
    }
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
        say_expect(&text, drawn, result);
    }
    return text.used < size - 1u ? text.used : 0u;
}
