/* Damaged lines of a campaign's results: each line is read with its values or rejected, and the summary of
 * all lines that were read agrees with the tables. usage: fuzz_campaign SEED SECONDS */
#include "fuzz.h"
#include "host_sim/lab/campaign.h"

#define RUNS 100u

static uint32_t pick(uint32_t usual)
{
    return fuzz_below(4u) == 0u ? (uint32_t)fuzz_bits() : fuzz_below(usual);
}

static void summarise(const campaign_result_t *results)
{
    static char text[65536];
    const campaign_t campaign = {.seed = 77u, .runs = RUNS, .seconds = 2.0, .shard = 1u, .shards = 1u};
    FILE *memory = fmemopen(text, sizeof text, "w");
    fuzz_expect(memory != NULL, "no memory");
    const uint32_t violated = campaign_summary(memory, &campaign, results, fuzz_below(2u) == 0u);
    fclose(memory);
    fuzz_expect(violated <= RUNS, "more violations than runs");
}

static void turn(void)
{
    static campaign_result_t results[RUNS];
    memset(results, 0, sizeof results);
    for (uint32_t n = 0; n < 50u; n++) {
        char line[2u * CAMPAIGN_LINE_SIZE];
        char again[CAMPAIGN_LINE_SIZE];
        uint32_t run = 0;
        campaign_result_t result = {0};
        size_t count =
            (size_t)snprintf(line, sizeof line, "%u,%u,%u,%u,%u,%u,%d,%u,%u,%u,%u,%u,%u\n", pick(RUNS),
                             pick(5u), pick(21u), pick(20000u), pick(4000u), pick(60u), (int)pick(90u),
                             pick(1024u), pick(20000u), pick(3u), pick(20000u), pick(60u), pick(3u));
        if (fuzz_below(3u) == 0u) {
            count = fuzz_mutate(line, count, CAMPAIGN_LINE_SIZE - 1u, line, count / 2u);
        }
        line[count < CAMPAIGN_LINE_SIZE ? count : CAMPAIGN_LINE_SIZE - 1u] = '\0';
        if (campaign_read_line(line, RUNS, &run, &result)) {
            campaign_line(run, &result, again);
            fuzz_expect(strcmp(line, again) == 0 && run < RUNS,
                        "a line that is another one when it is written");
            fuzz_expect((result.end == CAMPAIGN_VIOLATED) == (result.invariant < CAMPAIGN_NO_INVARIANT),
                        "a violation without an invariant");
            results[run] = result;
        }
    }
    summarise(results);
}

int main(int argc, char **argv)
{
    return fuzz_run(argc, argv, turn);
}
