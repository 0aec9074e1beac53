/* Prints the false alarms of a campaign: faults in calm runs, their rate, and the numbers of these runs. */
#include <inttypes.h>
#include <math.h>

#include "host_sim/lab/campaign_parts.h"
#include "host_sim/lab/times.h"
#include "settings/reasons.h"

/* Probability of `alarms` or more false alarms in `calm` runs, at the rate that is allowed: a binomial
 * tail, its terms one after the other. */
static double by_chance(uint32_t calm, uint32_t alarms)
{
    const double odds = CAMPAIGN_ALARM_RATE / (1.0 - CAMPAIGN_ALARM_RATE);
    double term = exp((double)calm * log1p(-CAMPAIGN_ALARM_RATE));
    double below = 0.0;
    for (uint32_t n = 0; n < alarms; n++) {
        below += term;
        term *= odds * (double)(calm - n) / (double)(n + 1u);
    }
    return fmax(1.0 - below, 0.0);
}

#define ALARM_CHANCE 1e-6 /* [-] of campaigns in which the rate is exceeded by chance */

bool campaign_is_alarm(const campaign_result_t *result)
{
    return result->end == CAMPAIGN_HELD && result->calm != 0u && result->reason != 0;
}

bool campaign_alarms(const campaign_t *campaign, const campaign_result_t *results, uint32_t *calm,
                     uint32_t *alarms)
{
    *calm = 0u;
    *alarms = 0u;
    for (uint32_t run = 0; run < campaign->runs; run++) {
        *calm += results[run].end == CAMPAIGN_HELD && results[run].calm != 0u ? 1u : 0u;
        *alarms += campaign_is_alarm(&results[run]) ? 1u : 0u;
    }
    return *alarms == 0u || by_chance(*calm, *alarms) >= ALARM_CHANCE;
}

void campaign_say_alarms(FILE *file, uint32_t calm, uint32_t alarms)
{
    const double chance = alarms == 0u ? 1.0 : by_chance(calm, alarms);
    fprintf(file,
            "alarms    %" PRIu32 " of %" PRIu32
            " calm runs (without a fault, whose load cannot overhaul the motor) ended in a fault, %.2f %%; "
            "%g %% are promised,\n          and with them as many or more have the probability %.2g: %s; "
            "below %g the campaign fails\n",
            alarms, calm, calm == 0u ? 0.0 : 100.0 * alarms / (double)calm, 100.0 * CAMPAIGN_ALARM_RATE,
            chance, chance < ALARM_CHANCE ? "MORE than chance explains" : "not excluded", ALARM_CHANCE);
}

void campaign_list_alarms(FILE *file, const campaign_t *campaign, const campaign_result_t *results)
{
    for (uint32_t run = 0; run < campaign->runs; run++) {
        const campaign_result_t *result = &results[run];
        const reason_row_t *row = reason_by_number(result->reason);
        char name[32];
        char when[TIMES_TEXT_SIZE];
        if (campaign_is_alarm(result)) {
            campaign_file_name(run, name);
            fprintf(file, "  %s  fault %s at %s s\n", name, row != NULL ? row->name : "?",
                    times_text(when, result->latched));
        }
    }
}
