/* Many runs on all cores, their results as lines, and the summary. */
#include "host_sim/lab/campaign.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <pthread.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/campaign_parts.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/times.h"
#include "settings/reasons.h"

/* ---- on all cores ---- */

typedef struct {
    const campaign_t *campaign;
    campaign_result_t *results;
    pthread_mutex_t lock; /* of keep, progress and done */
    uint32_t done, of;
} work_t;

static uint32_t shard_runs(const campaign_t *campaign)
{
    return (campaign->runs - (campaign->shard - 1u) + campaign->shards - 1u) / campaign->shards;
}

static bool make_run(void *context, size_t n, char why[POOL_WHY])
{
    work_t *work = context;
    const campaign_t *campaign = work->campaign;
    const uint32_t run = campaign->shard - 1u + (uint32_t)n * campaign->shards;
    campaign_case_t drawn;
    campaign_result_t result;
    char text[CAMPAIGN_TEXT_SIZE];
    const char *scenario = NULL;
    if (work->results[run].end != CAMPAIGN_NOT_DONE || (campaign->stop != NULL && *campaign->stop != 0)) {
        return true;
    }
    if (campaign->scenario != NULL) {
        campaign_draw_around(campaign->seed, run, campaign->scenario, &drawn);
    } else {
        campaign_draw(campaign->seed, run, campaign->seconds, &drawn);
    }
    if (!campaign_run(&drawn, campaign->stop, &result)) {
        return true;
    }
    if (result.end == CAMPAIGN_VIOLATED) {
        if (!campaign->as_drawn) {
            (void)campaign_shrink(&drawn, &result, campaign->stop);
        }
        if (campaign->stop != NULL && *campaign->stop != 0) {
            return true; /* not minimised completely: the run is repeated */
        }
        result.reproduced = campaign_reproduces(&drawn, &result);
        (void)campaign_text(&drawn, &result, text, sizeof text);
        scenario = text;
    } else if (campaign_is_alarm(&result)) {
        (void)campaign_text(&drawn, NULL, text, sizeof text);
        scenario = text;
    }
    pthread_mutex_lock(&work->lock);
    const bool kept = campaign->keep == NULL || campaign->keep(campaign->context, run, &result, scenario);
    work->results[run] = result;
    work->done++;
    if (campaign->progress != NULL) {
        campaign->progress(campaign->context, work->done, work->of);
    }
    pthread_mutex_unlock(&work->lock);
    if (!kept) {
        snprintf(why, POOL_WHY, "the result of run %" PRIu32 " could not be kept", run);
    }
    return kept;
}

bool campaign_all(const campaign_t *campaign, campaign_result_t *results, char why[POOL_WHY])
{
    work_t work = {.campaign = campaign, .results = results, .of = shard_runs(campaign)};
    for (uint32_t run = campaign->shard - 1u; run < campaign->runs; run += campaign->shards) {
        work.done += results[run].end != CAMPAIGN_NOT_DONE;
    }
    const pool_t pool = {.count = work.of, .piece = make_run, .work = &work};
    pthread_mutex_init(&work.lock, NULL);
    const bool good = pool_run(&pool, campaign->threads, why);
    pthread_mutex_destroy(&work.lock);
    return good;
}

/* ---- lines ---- */

#define HEAD "# lagless campaign: tables %08" PRIx32 ", seed %" PRIu64 ", runs %" PRIu32 ", seconds %.9g\n"
#define HEAD_READ                                                                                            \
    "# lagless campaign: tables %8" SCNx32 ", seed %20" SCNu64 ", runs %10" SCNu32 ", seconds %lf"

/* A hash of all that determines a run in addition to its number: all tables, including those of the
 * campaign, and the scenario.
 */
static uint32_t space_hash(const campaign_t *campaign)
{
    uint32_t hash = rig_tables_hash();
    for (const char *c = boards_line(); *c != '\0'; c++) {
        hash = (hash ^ (unsigned char)*c) * UINT32_C(16777619);
    }
    const campaign_case_t any = {.around = campaign->scenario};
    const campaign_quantity_row_t *rows;
    const uint32_t count = campaign_rows(&any, &rows);
    for (const char *c = campaign->scenario != NULL ? campaign->scenario->source : ""; *c != '\0'; c++) {
        hash = (hash ^ (unsigned char)*c) * UINT32_C(16777619);
    }
    for (uint32_t n = 0; n < count; n++) {
        const campaign_quantity_row_t *row = &rows[n];
        const double values[3] = {row->initial, row->least, row->most};
        unsigned char octets[sizeof values];
        memcpy(octets, values, sizeof values);
        for (size_t k = 0; k < sizeof octets; k++) {
            hash = (hash ^ octets[k]) * UINT32_C(16777619);
        }
    }
    return hash ^ campaign_fault_count ^ ((uint32_t)CAMPAIGN_INVARIANT_COUNT << 16);
}

void campaign_head(const campaign_t *campaign, char line[CAMPAIGN_LINE_SIZE])
{
    snprintf(line, CAMPAIGN_LINE_SIZE, HEAD, space_hash(campaign), campaign->seed, campaign->runs,
             campaign->seconds);
}

bool campaign_read_head(const char *line, campaign_t *campaign)
{
    uint32_t tables;
    char again[CAMPAIGN_LINE_SIZE];
    if (sscanf(line, HEAD_READ, &tables, &campaign->seed, &campaign->runs, &campaign->seconds) != 4) {
        return false;
    }
    campaign_head(campaign, again);
    return strcmp(line, again) == 0 && campaign->runs >= 1u && campaign->runs <= CAMPAIGN_RUNS_MAX &&
           campaign->seconds > 0.0 && campaign->seconds <= CAMPAIGN_SECONDS_MAX;
}

void campaign_line(uint32_t run, const campaign_result_t *result, char line[CAMPAIGN_LINE_SIZE])
{
    snprintf(line, CAMPAIGN_LINE_SIZE,
             "%" PRIu32 ",%u,%u,%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%" PRId32 ",%" PRIu32 ",%" PRIu32
             ",%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%" PRIu32 ",%" PRIu32 "\n",
             run, (unsigned)result->end, (unsigned)result->invariant, result->period, result->row,
             result->fault, result->reason, result->excused, result->from, result->reproduced,
             result->latched, result->second, result->calm, result->tracked, result->inside, result->share);
}

bool campaign_read_line(const char *line, uint32_t runs, uint32_t *run, campaign_result_t *result)
{
    unsigned end;
    unsigned invariant;
    char again[CAMPAIGN_LINE_SIZE];
    const int read =
        sscanf(line,
               "%10" SCNu32 ",%2u,%2u,%10" SCNu32 ",%10" SCNu32 ",%10" SCNu32 ",%10" SCNd32 ",%10" SCNu32
               ",%10" SCNu32 ",%1" SCNu32 ",%10" SCNu32 ",%10" SCNu32 ",%1" SCNu32 ",%10" SCNu32 ",%10" SCNu32
               ",%10" SCNu32,
               run, &end, &invariant, &result->period, &result->row, &result->fault, &result->reason,
               &result->excused, &result->from, &result->reproduced, &result->latched, &result->second,
               &result->calm, &result->tracked, &result->inside, &result->share);
    if (read != 16 || result->inside > result->tracked || result->reproduced > 1u || result->calm > 1u ||
        *run >= runs || end < CAMPAIGN_HELD || end > CAMPAIGN_REFUSED || invariant > CAMPAIGN_NO_INVARIANT ||
        (end == CAMPAIGN_VIOLATED) != (invariant < CAMPAIGN_NO_INVARIANT) ||
        result->fault >= campaign_fault_count || result->second >= campaign_fault_count) {
        return false;
    }
    result->end = (campaign_end_t)end;
    result->invariant = (campaign_invariant_t)invariant;
    campaign_line(*run, result, again);
    return strcmp(line, again) == 0;
}

void campaign_file_name(uint32_t run, char name[32])
{
    snprintf(name, 32u, "run-%06" PRIu32 ".toml", run);
}

/* ---- the summary ---- */

typedef struct {
    uint32_t done, held, refused, violated, reproduced, excused, faulted, injected;
    uint32_t calm, alarms;
    bool alarmed; /* more alarms than chance explains */
    campaign_sigma_t sigma;
    uint32_t violations[CAMPAIGN_INVARIANT_COUNT];
} counts_t;

static counts_t count_all(const campaign_t *campaign, const campaign_result_t *results)
{
    counts_t counts = {0};
    for (uint32_t run = 0; run < campaign->runs; run++) {
        const campaign_result_t *result = &results[run];
        counts.done += result->end != CAMPAIGN_NOT_DONE;
        counts.held += result->end == CAMPAIGN_HELD;
        counts.refused += result->end == CAMPAIGN_REFUSED;
        counts.violated += result->end == CAMPAIGN_VIOLATED;
        counts.reproduced += result->end == CAMPAIGN_VIOLATED && result->reproduced != 0u;
        counts.excused += result->end == CAMPAIGN_HELD && result->excused != 0u;
        counts.faulted += result->end == CAMPAIGN_HELD && result->reason != 0;
        counts.injected += result->end != CAMPAIGN_NOT_DONE && result->fault != 0u;
        if (result->end == CAMPAIGN_VIOLATED) {
            counts.violations[result->invariant]++;
        }
    }
    counts.alarmed = !campaign_alarms(campaign, results, &counts.calm, &counts.alarms);
    counts.sigma = campaign_sigma(campaign, results);
    return counts;
}

static const char *reason_name(int32_t number)
{
    const reason_row_t *row = reason_by_number(number);
    return row != NULL ? row->name : "?";
}

static const char *row_name(uint32_t id)
{
    const table_row_t *row = rig_row(id);
    return row != NULL ? row->name : "?";
}

/* A counted quantity and its name. */
typedef struct {
    FILE *file;
    bool json, first;
} list_t;

static void say_count(list_t *list, const char *name, uint32_t healthy, uint32_t broken)
{
    if (healthy + broken == 0u) {
        return;
    }
    if (list->json) {
        fprintf(list->file, "%s\"%s\": [%" PRIu32 ", %" PRIu32 "]", list->first ? "" : ", ", name, healthy,
                broken);
    } else {
        fprintf(list->file, "  %-24s %8" PRIu32 " %8" PRIu32 "\n", name, healthy, broken);
    }
    list->first = false;
}

/* Excused deviations by cause: number of runs, and their share of all runs. */
static void say_excuse(list_t *list, const char *because, uint32_t count, uint32_t done)
{
    if (count == 0u) {
        return;
    }
    if (list->json) {
        fprintf(list->file, "%s\"%s\": %" PRIu32, list->first ? "" : ", ", because, count);
    } else {
        fprintf(list->file, "  %5" PRIu32 " %6.2f %%  %s\n", count, 100.0 * count / (double)done, because);
    }
    list->first = false;
}

/* True if this is the excuse of the fault's row. */
static bool excuses(uint32_t fault, uint32_t excused, const char *because)
{
    return (campaign_faults[fault].excused & excused) != 0u &&
           strcmp(campaign_faults[fault].because, because) == 0;
}

static bool is_by_fault(const campaign_result_t *result)
{
    return ((campaign_faults[result->fault].excused | campaign_faults[result->second].excused) &
            result->excused) != 0u;
}

static void say_excuses(list_t *list, const campaign_t *campaign, const campaign_result_t *results)
{
    uint32_t done = 0;
    uint32_t diodes = 0;
    for (uint32_t run = 0; run < campaign->runs; run++) {
        const campaign_result_t *result = &results[run];
        done += result->end != CAMPAIGN_NOT_DONE;
        diodes += result->end == CAMPAIGN_HELD && result->excused != 0u && !is_by_fault(result);
    }
    for (uint32_t n = 0; n < campaign_fault_count; n++) {
        const char *because = campaign_faults[n].because;
        uint32_t count = 0;
        bool first = because[0] != '\0';
        for (uint32_t before = 0; before < n; before++) {
            first = first && strcmp(campaign_faults[before].because, because) != 0;
        }
        for (uint32_t run = 0; first && run < campaign->runs; run++) {
            const campaign_result_t *result = &results[run];
            count += result->end == CAMPAIGN_HELD && (excuses(result->fault, result->excused, because) ||
                                                      excuses(result->second, result->excused, because));
        }
        say_excuse(list, because, count, done);
    }
    say_excuse(
        list,
        "a rotor drives the current by itself if all gates are off, or if it is caught above overspeed_trip",
        diodes, done);
}

/* Prints the faults of the drive by reason, in runs without a violation: with and without an injected fault.
 * */
static void say_faults(list_t *list, const campaign_t *campaign, const campaign_result_t *results)
{
    enum { NUMBERS = 256 };
    uint32_t counts[2][NUMBERS] = {{0}};
    for (uint32_t run = 0; run < campaign->runs; run++) {
        const campaign_result_t *result = &results[run];
        if (result->end == CAMPAIGN_HELD && result->reason > 0 && result->reason < NUMBERS) {
            counts[result->fault != 0u][result->reason]++;
        }
    }
    for (int32_t n = 1; n < NUMBERS; n++) {
        say_count(list, reason_name(n), counts[0][n], counts[1][n]);
    }
}

static void say_refused(list_t *list, const campaign_t *campaign, const campaign_result_t *results)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count; n++) {
            uint32_t counts[2] = {0};
            for (uint32_t run = 0; run < campaign->runs; run++) {
                const campaign_result_t *result = &results[run];
                const bool here = result->end == CAMPAIGN_REFUSED && result->row == table->rows[n].id;
                counts[result->fault != 0u] += here;
            }
            say_count(list, table->rows[n].name, counts[0], counts[1]);
        }
    }
}

static void say_violation(FILE *file, bool json, bool first, uint32_t run, const campaign_result_t *result)
{
    char name[32];
    const char *invariant = campaign_invariants[result->invariant].name;
    const double seconds = result->period * RIG_PERIOD_SECONDS;
    campaign_file_name(run, name);
    if (json) {
        fprintf(file,
                "%s\n  {\"run\": %" PRIu32
                ", \"invariant\": \"%s\", \"injected\": \"%s\", \"fault\": \"%s\", \"fault_s\": ",
                first ? "" : ",", run, invariant, campaign_faults[result->fault].name,
                reason_name(result->reason));
        json_number(file, result->reason != 0 ? result->latched * RIG_PERIOD_SECONDS : (double)NAN);
        fprintf(file, ", \"signal\": \"%s\", \"seconds\": %.9g, \"file\": \"%s\", \"reproduced\": %s}",
                row_name(result->row), seconds, name, result->reproduced != 0u ? "true" : "false");
    } else {
        char when[TIMES_TEXT_SIZE];
        fprintf(file, "  %s  %-8s at %9.4f s  %-14s fault %s", name, invariant, seconds,
                row_name(result->row), reason_name(result->reason));
        if (result->reason != 0) {
            fprintf(file, " at %s s", times_text(when, result->latched));
        }
        fprintf(file, ", injected %s%s\n", campaign_faults[result->fault].name,
                result->reproduced != 0u ? "" : ", NOT REPRODUCED from its file");
    }
}

static void say_violations(FILE *file, bool json, const campaign_t *campaign,
                           const campaign_result_t *results)
{
    bool first = true;
    for (uint32_t run = 0; run < campaign->runs; run++) {
        if (results[run].end == CAMPAIGN_VIOLATED) {
            say_violation(file, json, first, run, &results[run]);
            first = false;
        }
    }
}

/* Prints how often each case was drawn. */
static uint32_t quantity_count(const campaign_t *campaign)
{
    const campaign_case_t any = {.around = campaign->scenario};
    const campaign_quantity_row_t *rows;
    return campaign_rows(&any, &rows);
}

static uint32_t event_count(const campaign_t *campaign)
{
    return campaign->scenario == NULL ? (uint32_t)CAMPAIGN_EVENT_KINDS : 0u;
}

static uint32_t fault_count(const campaign_t *campaign)
{
    return campaign->scenario == NULL ? campaign_fault_count - 1u : 0u;
}

static void say_text(FILE *file, const campaign_t *campaign, const campaign_result_t *results,
                     const counts_t *counts)
{
    list_t list = {file, false, true};
    fprintf(file, "space     %d quantities, %d kinds of event, %" PRIu32 " faults, %d invariants\n",
            (int)quantity_count(campaign), (int)event_count(campaign), fault_count(campaign),
            (int)CAMPAIGN_INVARIANT_COUNT);
    fprintf(file,
            "runs      %" PRIu32 " of %" PRIu32 ", seed %" PRIu64 ", %.9g s each, %" PRIu32
            " with a fault injected\n",
            counts->done, campaign->runs, campaign->seed, campaign->seconds, counts->injected);
    fprintf(file,
            "held      %" PRIu32 ", of which %" PRIu32 " ended in a fault of the drive and %" PRIu32
            " were excused something\n",
            counts->held, counts->faulted, counts->excused);
    campaign_say_alarms(file, counts->calm, counts->alarms);
    campaign_say_sigma(file, &counts->sigma);
    fprintf(file, "refused   %" PRIu32 "\n", counts->refused);
    fprintf(file, "violated  %" PRIu32 ", of which %" PRIu32 " failed again when their files were run\n",
            counts->violated, counts->reproduced);
    for (uint32_t n = 0; n < CAMPAIGN_INVARIANT_COUNT; n++) {
        fprintf(file, "  %-10s %6" PRIu32 "  %s", campaign_invariants[n].name, counts->violations[n],
                campaign_invariants[n].text);
        if (campaign_invariants[n].limit != 0.0) {
            fprintf(file, ": %g %s", campaign_invariants[n].limit, campaign_invariants[n].unit);
        }
        fprintf(file, "\n");
    }
    if (counts->excused > 0u) {
        fprintf(file, "\nexcused, in runs that held\n");
        say_excuses(&list, campaign, results);
        list.first = true;
    }
    if (counts->faulted > 0u) {
        fprintf(file, "\nfaults of the drive         healthy injected\n");
        say_faults(&list, campaign, results);
    }
    if (counts->refused > 0u) {
        fprintf(file, "\nrefused because of          healthy injected\n");
        say_refused(&list, campaign, results);
    }
    if (counts->alarms > 0u) {
        fprintf(file, "\nfalse alarms\n");
        campaign_list_alarms(file, campaign, results);
    }
    if (counts->violated > 0u) {
        fprintf(file, "\nviolations\n");
        say_violations(file, false, campaign, results);
    }
}

static void say_json(FILE *file, const campaign_t *campaign, const campaign_result_t *results,
                     const counts_t *counts)
{
    list_t faults = {file, true, true};
    list_t refusals = {file, true, true};
    list_t excused = {file, true, true};
    fprintf(file, "{\"seed\": %" PRIu64 ", \"runs\": %" PRIu32 ", \"done\": %" PRIu32 ", \"seconds\": ",
            campaign->seed, campaign->runs, counts->done);
    json_number(file, campaign->seconds);
    fprintf(file, ", \"quantities\": %d, \"events\": %d, \"faults\": %" PRIu32 ", \"injected\": %" PRIu32,
            (int)quantity_count(campaign), (int)event_count(campaign), fault_count(campaign),
            counts->injected);
    fprintf(file,
            ", \"held\": %" PRIu32 ", \"faulted\": %" PRIu32 ", \"excused\": %" PRIu32
            ", \"refused\": %" PRIu32 ", \"violated\": %" PRIu32 ",\n \"invariants\": {",
            counts->held, counts->faulted, counts->excused, counts->refused, counts->violated);
    for (uint32_t n = 0; n < CAMPAIGN_INVARIANT_COUNT; n++) {
        fprintf(file, "%s\"%s\": %" PRIu32, n == 0u ? "" : ", ", campaign_invariants[n].name,
                counts->violations[n]);
    }
    fprintf(file, "},\n \"calm\": %" PRIu32 ", \"alarms\": %" PRIu32 ", \"alarmed\": %s,\n ", counts->calm,
            counts->alarms, counts->alarmed ? "true" : "false");
    campaign_json_sigma(file, &counts->sigma);
    fprintf(file, ",\n \"excuses\": {");
    say_excuses(&excused, campaign, results);
    fprintf(file, "},\n \"reasons\": {");
    say_faults(&faults, campaign, results);
    fprintf(file, "},\n \"refusals\": {");
    say_refused(&refusals, campaign, results);
    fprintf(file, "},\n \"violations\": [");
    say_violations(file, true, campaign, results);
    fprintf(file, "]}\n");
}

uint32_t campaign_summary(FILE *file, const campaign_t *campaign, const campaign_result_t *results, bool json)
{
    const counts_t counts = count_all(campaign, results);
    if (json) {
        say_json(file, campaign, results, &counts);
    } else {
        say_text(file, campaign, results, &counts);
    }
    return counts.violated + (counts.alarmed ? 1u : 0u) +
           (counts.sigma.judged && !counts.sigma.kept ? 1u : 0u);
}
