/* Campaigns: the runs of a shard, and the summary of the lines of any shards. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/campaign.h"
#include "host_sim/python/binding.h"

typedef struct {
    const binding_campaign_t *campaign;
    volatile sig_atomic_t stop;
} keeper_t;

static campaign_t campaign_of(const binding_campaign_t *from)
{
    return (campaign_t){
        .seed = from->seed,
        .runs = from->runs,
        .seconds = from->seconds,
        .shard = from->shard,
        .shards = from->shards,
        .threads = from->threads,
    };
}

static bool refuse(char why[WHY_SIZE], const char *text)
{
    snprintf(why, WHY_SIZE, "%s", text);
    return false;
}

static bool accepted(const binding_campaign_t *campaign, char why[WHY_SIZE])
{
    if (campaign->runs < 1u || campaign->runs > CAMPAIGN_RUNS_MAX) {
        snprintf(why, WHY_SIZE, "runs: accepted: 1 to %u", CAMPAIGN_RUNS_MAX);
        return false;
    }
    if (!(campaign->seconds >= CAMPAIGN_SECONDS_MIN && campaign->seconds <= CAMPAIGN_SECONDS_MAX)) {
        snprintf(why, WHY_SIZE, "seconds: accepted: %g to %g", CAMPAIGN_SECONDS_MIN, CAMPAIGN_SECONDS_MAX);
        return false;
    }
    if (campaign->shard < 1u || campaign->shard > campaign->shards || campaign->shards > campaign->runs) {
        return refuse(why, "shard, shards: accepted: 1 <= shard <= shards <= runs");
    }
    return true;
}

static bool keep(void *context, uint32_t run, const campaign_result_t *result, const char *scenario)
{
    keeper_t *keeper = context;
    char line[CAMPAIGN_LINE_SIZE];
    campaign_line(run, result, line);
    keeper->stop = keeper->campaign->keep(run, line, scenario) != 0;
    return true;
}

bool binding_campaign_head(const binding_campaign_t *campaign, char line[WHY_SIZE])
{
    const campaign_t how = campaign_of(campaign);
    if (!accepted(campaign, line)) {
        return false;
    }
    campaign_head(&how, line);
    return true;
}

bool binding_campaign(const binding_campaign_t *campaign, char why[WHY_SIZE])
{
    keeper_t keeper = {campaign, 0};
    char pool_why[POOL_WHY] = "";
    if (!accepted(campaign, why)) {
        return false;
    }
    campaign_t how = campaign_of(campaign);
    how.stop = &keeper.stop;
    how.keep = keep;
    how.context = &keeper;
    campaign_result_t *results = calloc(campaign->runs, sizeof *results);
    if (results == NULL) {
        return refuse(why, "no memory for this number of runs");
    }
    const bool good = campaign_all(&how, results, pool_why);
    free(results);
    return good || refuse(why, pool_why);
}

/* Reads every line after the head. */
static bool read_lines(const char *lines, uint32_t runs, campaign_result_t *results, char why[WHY_SIZE])
{
    while (*lines != '\0') {
        uint32_t run;
        campaign_result_t result = {0};
        char line[CAMPAIGN_LINE_SIZE];
        const size_t length = strcspn(lines, "\n") + 1u;
        snprintf(line, sizeof line, "%.*s", (int)(length < sizeof line ? length : sizeof line), lines);
        if (lines[length - 1u] == '\0' || !campaign_read_line(line, runs, &run, &result)) {
            snprintf(why, WHY_SIZE, "no result of a run: %.100s", line);
            return false;
        }
        if (results[run].end != CAMPAIGN_NOT_DONE && memcmp(&results[run], &result, sizeof result) != 0) {
            snprintf(why, WHY_SIZE, "run %lu has another result already", (unsigned long)run);
            return false;
        }
        results[run] = result;
        lines += length;
    }
    return true;
}

char *binding_campaign_summary(const char *lines, bool json, char why[WHY_SIZE])
{
    campaign_t campaign = {0};
    char *text = NULL;
    size_t size = 0;
    char head[CAMPAIGN_LINE_SIZE];
    const size_t length = strcspn(lines, "\n") + 1u;
    snprintf(head, sizeof head, "%.*s", (int)(length < sizeof head ? length : sizeof head), lines);
    if (lines[length - 1u] == '\0' || !campaign_read_head(head, &campaign)) {
        (void)refuse(why, "no campaign of this program: its tables differ");
        return NULL;
    }
    campaign_result_t *results = calloc(campaign.runs, sizeof *results);
    FILE *file = results != NULL ? open_memstream(&text, &size) : NULL;
    if (file == NULL) {
        (void)refuse(why, "no memory for this number of runs");
    } else {
        const bool good = read_lines(lines + length, campaign.runs, results, why);
        if (good) {
            (void)campaign_summary(file, &campaign, results, json);
        }
        fclose(file);
        if (!good) {
            free(text);
            text = NULL;
        }
    }
    free(results);
    return text;
}
