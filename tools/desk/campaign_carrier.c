/* Runs `lagless campaign` on the board of the libraries that it is linked with, for carriers for which there
 *is no separate `lagless` program.
 *
 * usage: campaign_carrier campaign --seed S --runs N --json --as-drawn in the order in which
 * tools/judge-campaign writes the options
 *
 * Exit status as of `lagless campaign`: 0 all held, 1 violated, 2 wrong use. */
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/lab/board_facts.h"
#include "host_sim/lab/campaign.h"

/* No scenario of a campaign names a board's file: tune_scenario.c, which reads them, finds none. */
const board_facts_t *const board_facts[] = {NULL};

/* Reads a whole number from 1 to `most`; 0: the text is no such number. */
static uint64_t number(const char *word, uint64_t most)
{
    char *end = NULL;
    const unsigned long long value = strtoull(word, &end, 10);
    return end != word && *end == '\0' && value <= most ? (uint64_t)value : 0u;
}

int main(int argc, char **argv)
{
    static const char *const words[] = {"campaign", "--seed", NULL, "--runs", NULL, "--json", "--as-drawn"};
    bool right = argc == 8;
    for (int n = 0; n < 7 && right; n++) {
        right = words[n] == NULL || strcmp(words[n], argv[n + 1]) == 0;
    }
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const campaign_t campaign = {
        .seed = right ? number(argv[3], UINT64_MAX) : 0u,
        .runs = right ? (uint32_t)number(argv[5], CAMPAIGN_RUNS_MAX) : 0u,
        .seconds = 2.0,
        .shard = 1u,
        .shards = 1u,
        .threads = cores > 0 ? (unsigned)cores : 1u,
        .as_drawn = true,
    };
    if (campaign.seed == 0u || campaign.runs == 0u) {
        fprintf(stderr,
                "usage: campaign_carrier campaign --seed S --runs N --json --as-drawn, S from 1, N from 1 to "
                "%u\n",
                CAMPAIGN_RUNS_MAX);
        return 2;
    }
    char why[POOL_WHY] = "";
    campaign_result_t *results = calloc(campaign.runs, sizeof *results);
    if (results == NULL || !campaign_all(&campaign, results, why)) {
        fprintf(stderr, "campaign_carrier: %s\n", results == NULL ? "no memory for so many runs" : why);
        free(results);
        return 3;
    }
    const uint32_t violated = campaign_summary(stdout, &campaign, results, true);
    free(results);
    return violated > 0u ? 1 : 0;
}
