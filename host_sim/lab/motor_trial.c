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

static void take_result(const runner_result_t *result, motor_trial_t *trial)
{
    trial->speed_error = value_of(result, "speed under load") / trial->tune.speed_top;
    trial->angle_mean = value_of(result, "angle under load");
    trial->angle_sd = value_of(result, "and its scatter");
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

bool motor_trial(const motor_sheet_t *sheet, motor_trial_t *trial, scenario_error_t *error)
{
    *trial = (motor_trial_t){.met = false};
    if (!motor_make(sheet, &trial->motor, error) || !tune_motor(&trial->motor, &trial->tune, error)) {
        return false;
    }
    char *text = NULL;
    size_t octets = 0;
    FILE *memory = open_memstream(&text, &octets);
    if (memory == NULL) {
        return scenario_no_memory(error);
    }
    tune_scenario(memory, sheet, &trial->motor, &trial->tune);
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
        const scenario_event_t *last = &scenario->events[scenario->event_count - 1u];
        trial->load = last->settings[last->count - 1u].value;
        trial->seconds = scenario->duration;
        take_result(&result, trial);
    } else {
        *error = result.error;
    }
    runner_result_free(&result);
    scenario_free(scenario);
    return ran;
}
