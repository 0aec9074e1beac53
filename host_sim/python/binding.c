#include "host_sim/python/binding.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/times.h"
#include "host_sim/lab/units.h"
#include "settings/reasons.h"

/* ---- tables ---- */

uint32_t binding_layout(void)
{
    const size_t sizes[] = {
        sizeof(binding_row_t),       sizeof(binding_samples_t),   sizeof(binding_scenario_t),
        sizeof(scenario_error_t),    sizeof(binding_outcome_t),   sizeof(binding_verdict_t),
        sizeof(plant_truth_t),       sizeof(binding_plant_now_t), sizeof(binding_campaign_t),
        sizeof(binding_ask_t),       sizeof(binding_history_t),   sizeof(binding_commission_t),
        sizeof(commission_result_t), sizeof(board_facts_t),
    };
    uint32_t hash = UINT32_C(2166136261);
    for (size_t n = 0; n < sizeof sizes / sizeof sizes[0]; n++) {
        hash = (hash ^ (uint32_t)sizes[n]) * UINT32_C(16777619);
    }
    return hash;
}

const char *binding_version(void)
{
    return LAGLESS_VERSION;
}

const char *binding_board(void)
{
    return rig_board;
}

const board_facts_t *binding_boards(uint32_t n)
{
    uint32_t count = 0;
    while (board_facts[count] != NULL) {
        count++;
    }
    return n < count ? board_facts[n] : NULL;
}

void binding_no_board(const char *name, char why[WHY_SIZE])
{
    char text[BOARDS_TEXT_SIZE];
    (void)boards_find(name, text);
    snprintf(why, WHY_SIZE, "%s", text);
}

double binding_period(void)
{
    return RIG_PERIOD_SECONDS;
}

bool binding_row(uint32_t n, binding_row_t *to)
{
    static __thread char key[96];
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        if (n >= table->count) {
            n -= table->count;
            continue;
        }
        const table_row_t *row = &table->rows[n];
        const bool shown = row->access == TABLE_READ;
        scenario_row_name(row, key, sizeof key);
        *to = (binding_row_t){
            .id = row->id,
            .kind = (uint32_t)row->kind,
            .access = (uint32_t)row->access,
            .table = table->name,
            .name = row->name,
            .key = key,
            .unit = row->unit,
            .text = row->text,
            .choices = row->choices,
            .initial = shown ? 0.0 : rig_initial(row),
            .min = shown ? 0.0 : rig_min(row),
            .max = shown ? 0.0 : rig_max(row),
        };
        return true;
    }
    return false;
}

bool binding_value(uint32_t id, const char *text, double *value, char why[WHY_SIZE])
{
    units_error_t error;
    const table_row_t *row = rig_row(id);
    if (row == NULL) {
        snprintf(why, WHY_SIZE, "no row has the id %lu", (unsigned long)id);
        return false;
    }
    if (rig_is_flux_map(row)) {
        *value = (double)rig_read_flux_map(text, why, WHY_SIZE);
        return *value > 0.0;
    }
    const bool good = units_read(text, units_of_row(row), value, &error);
    if (!good) {
        snprintf(why, WHY_SIZE, "%s: %s", row->name, error.text);
    }
    return good;
}

bool binding_reason(int32_t number, const char **name, const char **text, const char **remedy)
{
    const reason_row_t *row = reason_by_number(number);
    if (row != NULL) {
        *name = row->name;
        *text = row->text;
        *remedy = row->remedy;
    }
    return row != NULL;
}

void binding_seconds(const uint32_t *periods, double *seconds, uint64_t count)
{
    for (uint64_t n = 0; n < count; n++) {
        seconds[n] = times_seconds(periods[n], RIG_PERIOD_TICKS);
    }
}

/* ---- the rig ---- */

rig_t *binding_rig_create(uint64_t seed)
{
    return rig_create(seed);
}

void binding_rig_free(rig_t *rig)
{
    rig_free(rig);
}

uint32_t binding_rig_run(rig_t *rig, uint32_t periods)
{
    return rig_run(rig, periods);
}

uint32_t binding_rig_period(const rig_t *rig)
{
    return rig_period(rig);
}

bool binding_rig_get(rig_t *rig, uint32_t id, double *value)
{
    return rig_get(rig, id, value);
}

bool binding_rig_set(rig_t *rig, uint32_t id, double value)
{
    return rig_set(rig, id, value);
}

bool binding_rig_apply(rig_t *rig)
{
    return rig_apply(rig);
}

void binding_rig_set_motion(rig_t *rig, double theta_m, double omega_m)
{
    rig_set_motion(rig, theta_m, omega_m);
}

void binding_rig_power_cycle(rig_t *rig)
{
    rig_power_cycle(rig);
}

bool binding_rig_stop_when(rig_t *rig, uint32_t id, uint32_t compare, double value)
{
    return rig_stop_when(rig, id, (rig_compare_t)compare, value);
}

static void keep_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    binding_samples_t *samples = context;
    if (samples->used < samples->room) {
        memcpy(&samples->slots[samples->used * count], slots, count * sizeof slots[0]);
        samples->periods[samples->used] = period;
    }
    samples->used++;
}

bool binding_rig_tap(rig_t *rig, const uint32_t *ids, uint32_t count, uint32_t every,
                     binding_samples_t *samples)
{
    return rig_tap(rig, ids, count, every, count > 0u ? keep_sample : NULL, samples);
}

const char *binding_rig_error(const rig_t *rig)
{
    return rig_error(rig);
}

uint64_t binding_rig_state_size(void)
{
    return rig_state_size();
}

void binding_rig_save(const rig_t *rig, void *state)
{
    rig_save(rig, state);
}

bool binding_rig_load(rig_t *rig, const void *state, uint64_t size)
{
    return rig_load(rig, state, (size_t)size);
}

uint64_t binding_rig_hash(const rig_t *rig)
{
    return rig_hash(rig);
}

/* ---- scenarios ---- */

scenario_t *binding_scenario_read(const char *path, const char *text, uint64_t octets,
                                  scenario_error_t *error, char why[WHY_SIZE])
{
    scenario_t *scenario = text != NULL ? scenario_read_text_to_mend(path, text, (size_t)octets, error)
                                        : scenario_read_to_mend(path, error);
    if (scenario == NULL) {
        scenario_error_text(error, why, WHY_SIZE);
    }
    return scenario;
}

void binding_scenario_free(scenario_t *scenario)
{
    scenario_free(scenario);
}

bool binding_scenario_override(scenario_t *scenario, const char *assignment, scenario_error_t *error,
                               char why[WHY_SIZE])
{
    const bool good = scenario_override(scenario, assignment, error);
    if (!good) {
        scenario_error_text(error, why, WHY_SIZE);
    }
    return good;
}

bool binding_scenario_check(scenario_t *scenario, scenario_error_t *error, char why[WHY_SIZE])
{
    const bool good = scenario_check(scenario, error);
    if (!good) {
        scenario_error_text(error, why, WHY_SIZE);
    }
    return good;
}

void binding_scenario_about(const scenario_t *scenario, binding_scenario_t *about)
{
    *about = (binding_scenario_t){
        .title = scenario->title,
        .source = scenario->source,
        .unsuited = scenario->unsuited,
        .seed = scenario->seed,
        .periods = scenario->periods,
        .every = scenario->every,
        .record = scenario->record,
        .record_count = scenario->record_count,
        .expect_count = scenario->expect_count,
    };
}

double binding_scenario_initial(const scenario_t *scenario, uint32_t id)
{
    return scenario_initial(scenario, rig_row(id));
}

typedef struct {
    int (*call)(double fraction);
    volatile sig_atomic_t stop;
} progress_t;

static void on_progress(void *context, double fraction)
{
    progress_t *progress = context;
    progress->stop = progress->call(fraction) != 0;
}

struct binding_run {
    runner_result_t result;
    runner_history_t history;
};

binding_run_t *binding_run(scenario_t *scenario, const binding_ask_t *ask, scenario_error_t *error,
                           char why[WHY_SIZE])
{
    progress_t progress = {ask->progress, 0};
    binding_run_t *run = calloc(1, sizeof *run);
    if (run == NULL) {
        snprintf(why, WHY_SIZE, "not enough memory");
        return NULL;
    }
    const runner_options_t options = {
        .has_seed = true,
        .seed = ask->seed,
        .record = ask->record,
        .record_count = ask->record_count,
        .record_every = ask->record_every,
        .sink = ask->record_count > 0u ? keep_sample : NULL,
        .sink_context = ask->samples,
        .history = ask->record_count > 0u ? &run->history : NULL,
        .progress = ask->progress != NULL ? on_progress : NULL,
        .progress_context = &progress,
        .stop = &progress.stop,
    };
    if (!runner_run(scenario, &options, &run->result)) {
        *error = run->result.error;
        scenario_error_text(error, why, WHY_SIZE);
        binding_run_free(run);
        return NULL;
    }
    return run;
}

void binding_run_free(binding_run_t *run)
{
    if (run != NULL) {
        runner_result_free(&run->result);
    }
    free(run);
}

bool binding_history(const binding_run_t *run, binding_history_t *to)
{
    const runner_history_t *history = &run->history;
    *to = (binding_history_t){
        .rows = history->rows,
        .slots = history->slots,
        .columns = history->columns,
        .periods = history->periods,
        /* the step that the drive counts as its first is that of period 0 */
        .first_period = history->last_period - history->periods,
        .fault_reason = history->fault_reason,
    };
    return history->periods > 0u;
}

void binding_outcome(const binding_run_t *run, binding_outcome_t *outcome, char unexpected[WHY_SIZE])
{
    const runner_result_t *result = &run->result;
    (void)runner_unexpected_text(result, unexpected, WHY_SIZE);
    *outcome = (binding_outcome_t){
        .seed = result->seed,
        .hash = result->hash,
        .seconds = result->seconds,
        .end = (uint32_t)result->end,
        .failed = result->failed,
        .periods = result->periods,
        .fault_period = result->fault_period,
        .state = result->state,
        .fault_reason = result->fault_reason,
        .refusal = result->refusal,
        .not_on = result->not_on,
        .manoeuvre = result->manoeuvre,
    };
}

void binding_verdict(const binding_run_t *run, uint32_t n, binding_verdict_t *to, char text[WHY_SIZE])
{
    const runner_verdict_t *verdict = &run->result.verdicts[n];
    const scenario_expect_t *expect = verdict->expect;
    *to = (binding_verdict_t){
        .name = expect->name,
        .statistic = statistic_text(expect->statistic),
        .value = verdict->value,
        .at_least = expect->at_least,
        .at_most = expect->at_most,
        .from = times_seconds(expect->begin, RIG_PERIOD_TICKS),
        .to = times_seconds(expect->end, RIG_PERIOD_TICKS),
        .id = expect->row->id,
        .minus = expect->minus != NULL ? expect->minus->id : 0u,
        .samples = verdict->samples,
        .measure = expect->measure,
        .judgement = (uint32_t)verdict->judgement,
    };
    runner_verdict_text(verdict, text, WHY_SIZE);
}

void binding_free(void *memory)
{
    free(memory);
}
