#include "host_sim/lab/motor_trial.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/runner.h"
#include "host_sim/lab/scenario_parts.h"
#include "settings/reasons.h"

static const runner_verdict_t *verdict_of(const runner_result_t *result, const char *name)
{
    for (uint32_t n = 0; n < result->verdict_count; n++) {
        if (strcmp(result->verdicts[n].expect->name, name) == 0) {
            return &result->verdicts[n];
        }
    }
    return NULL;
}

static double value_of(const runner_result_t *result, const char *name)
{
    const runner_verdict_t *verdict = verdict_of(result, name);
    return verdict != NULL ? verdict->value : (double)NAN;
}

/* Takes the verdict on a run: `miss` is "" or what failed first. */
static void judge(const runner_result_t *result, motor_trial_t *trial)
{
    trial->met = result->failed == 0u && result->fault_reason == 0;
    if (result->fault_reason != 0) {
        snprintf(trial->miss, sizeof trial->miss, "%s at %.2f s",
                 reason_by_number(result->fault_reason)->name, result->fault_period * RIG_PERIOD_SECONDS);
        return;
    }
    for (uint32_t n = 0; n < result->verdict_count; n++) {
        if (result->verdicts[n].judgement != RUNNER_MET) {
            (void)runner_verdict_text(&result->verdicts[n], trial->miss, sizeof trial->miss);
            return;
        }
    }
    (void)runner_unexpected_text(result, trial->miss, sizeof trial->miss);
}

static void take_start(const scenario_t *scenario, const runner_result_t *result, motor_trial_t *trial)
{
    const scenario_event_t *last = &scenario->events[scenario->event_count - 1u];
    trial->load = last->settings[last->count - 1u].value;
    trial->seconds = scenario->duration;
    trial->speed_error = value_of(result, "speed under load") / trial->tune.speed_top;
    trial->angle_mean = value_of(result, "angle under load");
    trial->angle_sd = value_of(result, "and its scatter");
    judge(result, trial);
}

static void take_grid(const scenario_t *scenario, const runner_result_t *result, motor_trial_t *trial)
{
    (void)scenario;
    for (uint32_t n = 0; n + 1u < result->verdict_count; n += 2u) { /* the last one is not of a point */
        trial->grid_mean = fmax(trial->grid_mean, fabs(result->verdicts[n].value));
        const runner_verdict_t *sd = &result->verdicts[n + 1u];
        if (sd->value > trial->grid_sd) {
            trial->grid_sd = sd->value;
            snprintf(trial->grid_at, sizeof trial->grid_at, "%.79s", sd->expect->name);
        }
    }
    judge(result, trial);
}

typedef void write_t(FILE *to, const motor_sheet_t *sheet, const motor_t *motor, const tune_t *tune);
typedef void take_t(const scenario_t *scenario, const runner_result_t *result, motor_trial_t *trial);

/* Writes a scenario, runs it and takes its result. */
static bool run(write_t *write, take_t *take, const motor_sheet_t *sheet, motor_trial_t *trial,
                scenario_error_t *error)
{
    char *text = NULL;
    size_t octets = 0;
    FILE *memory = open_memstream(&text, &octets);
    if (memory == NULL) {
        return scenario_no_memory(error);
    }
    write(memory, sheet, &trial->motor, &trial->tune);
    fclose(memory);
    scenario_t *scenario = scenario_read_text(sheet->name, text, octets, error);
    free(text);
    if (scenario == NULL) {
        return false;
    }
    const runner_options_t options = {.has_seed = false};
    runner_result_t result;
    const bool ran = runner_run(scenario, &options, &result);
    if (ran) {
        take(scenario, &result, trial);
    } else {
        *error = result.error;
    }
    runner_result_free(&result);
    scenario_free(scenario);
    return ran;
}

bool motor_trial(const motor_sheet_t *sheet, motor_trial_t *trial, scenario_error_t *error)
{
    *trial = (motor_trial_t){.met = false};
    return motor_make(sheet, &trial->motor, error) && tune_motor(&trial->motor, &trial->tune, error) &&
           run(tune_scenario, take_start, sheet, trial, error);
}

bool motor_trial_grid(const motor_sheet_t *sheet, motor_trial_t *trial, scenario_error_t *error)
{
    return !trial->met || run(tune_grid, take_grid, sheet, trial, error);
}
