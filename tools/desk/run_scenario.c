/* Runs one scenario file as a test. Exit status: 0 if there is an expectation and all are met, 1 if one
 * failed, 2 if the file is wrong. */
#include <stdio.h>

#include "host_sim/lab/runner.h"

static const char *judgement_text(runner_judgement_t judgement)
{
    return judgement == RUNNER_MET ? "met" : judgement == RUNNER_FAILED ? "FAILED" : "NOT JUDGED";
}

int main(int argc, char **argv)
{
    char text[1200];
    scenario_error_t error;
    if (argc != 2) {
        fputs("usage: run_scenario FILE.toml\n", stderr);
        return 2;
    }
    scenario_t *scenario = scenario_read(argv[1], &error);
    if (scenario == NULL) {
        fprintf(stderr, "%s\n", scenario_error_text(&error, text, sizeof text));
        return 2;
    }
    const runner_options_t options = {0};
    runner_result_t result;
    const bool ran = runner_run(scenario, &options, &result);
    printf("%s\n", scenario->title);
    for (uint32_t n = 0; n < result.verdict_count; n++) {
        printf("  %-6s  %s\n", judgement_text(result.verdicts[n].judgement),
               runner_verdict_text(&result.verdicts[n], text, sizeof text));
    }
    if (result.unexpected) {
        printf("  FAILED  %s\n", runner_unexpected_text(&result, text, sizeof text));
    }
    if (!ran) {
        printf("  refused: %s\n", scenario_error_text(&result.error, text, sizeof text));
    } else {
        printf("  state %ld, fault reason %ld, %lu periods, %.0f ns each, rig %016llx\n", (long)result.state,
               (long)result.fault_reason, (unsigned long)result.periods,
               1e9 * result.seconds / result.periods, (unsigned long long)result.hash);
    }
    const bool good = ran && result.failed == 0u && result.verdict_count > 0u;
    runner_result_free(&result);
    scenario_free(scenario);
    return good ? 0 : 1;
}
