/* theta_sigma beside the true error of the angle, over the runs of a campaign without an injected fault. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"
#include "host_sim/lab/json.h"

#define ENOUGH_PERIODS 1000u /* of a run whose share counts in the median */
#define JUDGED_PERIODS                                                                                       \
    10000000.0 /* of a campaign that is judged: a run has at most a five hundredth of these */

static int compare_shares(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a;
    const uint32_t y = *(const uint32_t *)b;
    return x < y ? -1 : x > y;
}

static bool counts(const campaign_result_t *result)
{
    return result->end == CAMPAIGN_HELD && result->tracked >= ENOUGH_PERIODS;
}

/* Median of the runs' shares [-]; 0 if no run counts. NaN: no memory. */
static double median_of(const campaign_t *campaign, const campaign_result_t *results)
{
    uint32_t count = 0;
    uint32_t *shares = calloc(campaign->runs > 0u ? campaign->runs : 1u, sizeof *shares);
    if (shares == NULL) {
        return (double)NAN;
    }
    for (uint32_t run = 0; run < campaign->runs; run++) {
        if (counts(&results[run])) {
            shares[count++] = results[run].share;
        }
    }
    qsort(shares, count, sizeof *shares, compare_shares);
    const double median =
        count == 0u ? 0.0 : 0.5 * ((double)shares[(count - 1u) / 2u] + (double)shares[count / 2u]);
    free(shares);
    return median / CAMPAIGN_PER_MILLE;
}

campaign_sigma_t campaign_sigma(const campaign_t *campaign, const campaign_result_t *results)
{
    campaign_sigma_t sigma = {.periods = 0.0};
    for (uint32_t run = 0; run < campaign->runs; run++) {
        const campaign_result_t *result = &results[run];
        if (result->end == CAMPAIGN_HELD) {
            sigma.periods += (double)result->tracked;
            sigma.inside += (double)result->inside;
            sigma.runs += counts(result) ? 1u : 0u;
        }
    }
    sigma.median = median_of(campaign, results);
    sigma.judged = campaign->scenario == NULL && sigma.periods >= JUDGED_PERIODS;
    sigma.kept =
        sigma.inside >= CAMPAIGN_SIGMA_INSIDE * sigma.periods && sigma.median <= CAMPAIGN_SIGMA_SHARE;
    return sigma;
}

void campaign_say_sigma(FILE *file, const campaign_sigma_t *sigma)
{
    fprintf(
        file,
        "sigma     the true error of the angle is within 3 theta_sigma in %.2f %% of %.0f periods without a "
        "fault; %g %% are promised;\n          theta_sigma is %.2f times the rms error in the median of "
        "%" PRIu32 " runs, at most %g; %s\n",
        sigma->periods > 0.0 ? 100.0 * sigma->inside / sigma->periods : 100.0, sigma->periods,
        100.0 * CAMPAIGN_SIGMA_INSIDE, sigma->median, sigma->runs, CAMPAIGN_SIGMA_SHARE,
        !sigma->judged ? "judged from 1e7 periods on, in a campaign that is not around a scenario"
        : sigma->kept  ? "kept"
                       : "NOT KEPT");
}

void campaign_json_sigma(FILE *file, const campaign_sigma_t *sigma)
{
    fprintf(file, "\"sigma\": {\"periods\": %.0f, \"inside\": %.0f, \"runs\": %" PRIu32 ", \"median\": ",
            sigma->periods, sigma->inside, sigma->runs);
    json_number(file, sigma->median);
    fprintf(file, ", \"judged\": %s, \"kept\": %s}", sigma->judged ? "true" : "false",
            sigma->kept ? "true" : "false");
}
