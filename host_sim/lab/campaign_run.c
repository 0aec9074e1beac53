/* One run, and its minimisation. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/campaign_parts.h"

#define REPEATED_EVERY 64u  /* [-] one run of this number is made twice */
#define SHRINK_RUNS    400u /* [runs] a violation is not minimised by more than these */
/* [s] by which a shortened run continues after the violation, so that its end is visible */
#define AFTERWARDS 1e-3

static uint32_t row_of(const char *name)
{
    const table_row_t *row = rig_row_by_name(name);
    return row != NULL ? row->id : 0u;
}

/* A refusal without a row or without a reason is a violation. */
static void refused(const scenario_error_t *error, campaign_result_t *result)
{
    result->row = row_of(error->name);
    result->end = CAMPAIGN_REFUSED;
    if (result->row == 0u || error->message[0] == '\0') {
        result->end = CAMPAIGN_VIOLATED;
        result->invariant = CAMPAIGN_I_REASON;
    }
}

/* The first failed expectation of the scenario itself, or an end that none of them names. */
static void unmet(const runner_result_t *run, const campaign_case_t *drawn, campaign_result_t *result)
{
    for (uint32_t n = 0; n < run->verdict_count; n++) {
        const scenario_expect_t *expect = run->verdicts[n].expect;
        if (run->verdicts[n].judgement == RUNNER_FAILED) {
            result->end = CAMPAIGN_VIOLATED;
            result->invariant = CAMPAIGN_I_EXPECT;
            result->from = expect->begin;
            result->period = expect->end - 1u;
            result->row = expect->row->id;
            return;
        }
    }
    /* a run that is drawn at random has injected faults and no expectations; its invariants judge them */
    if (run->unexpected && drawn->around != NULL) {
        const bool fault = run->fault_reason != 0;
        result->end = CAMPAIGN_VIOLATED;
        result->invariant = CAMPAIGN_I_EXPECT;
        result->from = fault ? run->fault_period : run->periods - 1u;
        result->period = run->periods - 1u;
        result->row = row_of(fault ? "fault_reason" : "refusal");
    }
}

/* Data of a run that are kept in addition to its result. */
typedef struct {
    uint64_t hash;
    campaign_angles_t angles;
} kept_t;

/* Runs a text under the judge. false: interrupted. */
static bool run_text(const char *text, size_t octets, const campaign_case_t *drawn,
                     const volatile sig_atomic_t *stop, campaign_result_t *result, kept_t *kept)
{
    uint32_t ids[CAMPAIGN_WATCHED_MAX];
    uint32_t floats;
    scenario_error_t error;
    campaign_watch_t watch;
    runner_result_t run;
    *result = (campaign_result_t){
        .invariant = CAMPAIGN_NO_INVARIANT,
        .fault = drawn->faults[0].kind,
        .second = drawn->faults[1].kind,
        .calm = campaign_is_calm(drawn) ? UINT32_C(1) : UINT32_C(0),
    };
    kept->hash = 0u;
    campaign_angles_begin(&kept->angles, drawn);
    scenario_t *scenario = scenario_read_text("campaign", text, octets, &error);
    if (scenario == NULL) {
        refused(&error, result);
        return true;
    }
    campaign_watch_begin(&watch, drawn, result, stop);
    watch.angles = campaign_is_paired(drawn) ? &kept->angles : NULL;
    const runner_options_t options = {
        .record = ids,
        .record_count = campaign_watched(ids, &floats),
        .record_every = 1u,
        .sink = campaign_watch_sample,
        .sink_context = &watch,
        .edge_sink = campaign_watch_edge,
        .edge_context = &watch,
        .stop = &watch.stop,
    };
    const bool ran = runner_run(scenario, &options, &run);
    if (!ran) {
        refused(&run.error, result);
    } else if (result->end != CAMPAIGN_VIOLATED) {
        result->end = run.end == RUNNER_COMPLETE ? CAMPAIGN_HELD : CAMPAIGN_NOT_DONE;
        result->period = run.fault_period;
    }
    result->reason = ran ? run.fault_reason : 0;
    result->latched = result->reason != 0 ? run.fault_period : 0u;
    kept->hash = run.hash;
    if (ran && result->end == CAMPAIGN_HELD) {
        unmet(&run, drawn, result);
    }
    runner_result_free(&run);
    scenario_free(scenario);
    return result->end != CAMPAIGN_NOT_DONE;
}

typedef enum { PAIR_INTERRUPTED, PAIR_HELD, PAIR_WORST } pair_t;

/* Compares the run with learning with CAMPAIGN_PAIR_NOISES runs without it, which differ in the noise of the
 * sensors. The comparisons end with the first run that is not better. `last`: the last one of these runs. */
static pair_t compare_noises(campaign_case_t *longer, const volatile sig_atomic_t *stop,
                             const campaign_angles_t *with, campaign_result_t *result,
                             campaign_angles_t *last)
{
    char text[CAMPAIGN_TEXT_SIZE];
    for (uint32_t n = 0; n < CAMPAIGN_PAIR_NOISES; n++) {
        campaign_result_t other;
        kept_t kept;
        longer->noise = n;
        const size_t octets = campaign_text(longer, NULL, text, sizeof text);
        if (!run_text(text, octets, longer, stop, &other, &kept)) {
            return PAIR_INTERRUPTED;
        }
        *last = kept.angles;
        if (other.end != CAMPAIGN_HELD || !campaign_compare_angles(with, &kept.angles, result)) {
            return PAIR_HELD;
        }
    }
    return PAIR_WORST;
}

/* The same run, longer, with learning and without. Noise alone may decide in which of two states a drive
 * ends, for example whether its speed hunts. Without an effect of the learning, the run with learning is as
 * likely as each of the others to be the worst one. It is a violation only if it is worse than each of them:
 * by chance in less than one of 20 of such drives. An error of a configured value may damp such a state: if
 * the learnt values are nearer to the true ones, the run must also be worse than each run in which the true
 * values are configured. false: interrupted. */
static bool compare_learning(const campaign_case_t *drawn, const volatile sig_atomic_t *stop,
                             campaign_result_t *result)
{
    char text[CAMPAIGN_TEXT_SIZE];
    campaign_case_t longer = *drawn;
    campaign_result_t judged = *result;
    campaign_result_t other;
    kept_t with;
    campaign_angles_t without;
    longer.seconds += CAMPAIGN_PAIR_SECONDS;
    const size_t octets = campaign_text(&longer, NULL, text, sizeof text);
    if (!run_text(text, octets, &longer, stop, &other, &with)) {
        return false;
    }
    if (other.end != CAMPAIGN_HELD) {
        return true;
    }
    longer.unlearnt = true;
    pair_t pair = compare_noises(&longer, stop, &with.angles, &judged, &without);
    if (pair == PAIR_WORST && campaign_is_truer(&with.angles, &without)) {
        judged = *result;
        longer.true_values = true;
        pair = compare_noises(&longer, stop, &with.angles, &judged, &without);
    }
    *result = pair == PAIR_WORST ? judged : *result;
    return pair != PAIR_INTERRUPTED;
}

bool campaign_run(const campaign_case_t *drawn, const volatile sig_atomic_t *stop, campaign_result_t *result)
{
    char text[CAMPAIGN_TEXT_SIZE];
    const size_t octets = campaign_text(drawn, NULL, text, sizeof text);
    kept_t kept[2];
    if (!run_text(text, octets, drawn, stop, result, &kept[0])) {
        return false;
    }
    if (result->end == CAMPAIGN_HELD && campaign_is_paired(drawn) && !compare_learning(drawn, stop, result)) {
        return false;
    }
    if (result->end == CAMPAIGN_HELD && drawn->run % REPEATED_EVERY == 0u) {
        campaign_result_t again;
        if (!run_text(text, octets, drawn, stop, &again, &kept[1])) {
            return false;
        }
        if (kept[0].hash != kept[1].hash) {
            result->end = CAMPAIGN_VIOLATED;
            result->invariant = CAMPAIGN_I_REPEAT;
        }
    }
    return true;
}

bool campaign_reproduces(const campaign_case_t *drawn, campaign_result_t *result)
{
    char text[CAMPAIGN_TEXT_SIZE];
    const size_t octets = campaign_text(drawn, result, text, sizeof text);
    const runner_options_t plain = {0};
    scenario_error_t error;
    campaign_result_t again;
    runner_result_t run;
    scenario_t *scenario = scenario_read_text("campaign", text, octets, &error);
    bool fails = false;
    const bool judged = scenario != NULL && scenario->expect_count > 0u;
    if (scenario != NULL && runner_run(scenario, &plain, &run)) {
        result->reason = run.fault_reason;
        result->latched = run.fault_reason != 0 ? run.fault_period : 0u;
        /* of a run that is drawn at random an injected fault is no violation */
        fails = run.failed > (run.unexpected && result->invariant != CAMPAIGN_I_EXPECT ? 1u : 0u);
        runner_result_free(&run);
    }
    scenario_free(scenario);
    if (judged || result->invariant == CAMPAIGN_I_EXPECT) {
        return fails;
    }
    return campaign_run(drawn, NULL, &again) && again.end == CAMPAIGN_VIOLATED &&
           again.invariant == result->invariant;
}

/* ---- smaller ---- */

typedef struct {
    campaign_case_t *best;
    campaign_result_t *result;
    const volatile sig_atomic_t *stop;
    uint32_t runs;
} shrink_t;

/* Keeps the smaller case if it breaks the same invariant. */
static bool try_smaller(shrink_t *shrink, const campaign_case_t *smaller)
{
    campaign_result_t result;
    if (shrink->runs >= SHRINK_RUNS) {
        return false;
    }
    shrink->runs++;
    if (!campaign_run(smaller, shrink->stop, &result) || result.end != CAMPAIGN_VIOLATED ||
        result.invariant != shrink->result->invariant ||
        (result.invariant == CAMPAIGN_I_EXPECT && result.row != shrink->result->row)) {
        return false; /* a violation of another expectation is a different violation */
    }
    *shrink->best = *smaller;
    *shrink->result = result;
    return true;
}

/* Removes the events after the violation, and the remaining time. */
static void end_sooner(shrink_t *shrink)
{
    campaign_case_t smaller = *shrink->best;
    const double known = (shrink->result->period + 1u) * RIG_PERIOD_SECONDS + AFTERWARDS;
    if (known >= smaller.seconds || shrink->result->period == 0u) {
        return;
    }
    smaller.seconds = known;
    while (smaller.event_count > 0u && smaller.events[smaller.event_count - 1u].time >= known) {
        smaller.event_count--;
    }
    for (uint32_t n = 0; n < CAMPAIGN_FAULTS_MAX; n++) {
        smaller.faults[n].kind = smaller.faults[n].time >= known ? 0u : smaller.faults[n].kind;
    }
    (void)try_smaller(shrink, &smaller);
}

static bool without_fault(shrink_t *shrink, uint32_t n)
{
    campaign_case_t smaller = *shrink->best;
    smaller.faults[n] = (campaign_injected_t){0u, 0.0, 0.0, 0.0};
    return shrink->best->faults[n].kind != 0u && try_smaller(shrink, &smaller);
}

/* The flag stays set for the rest of the run. */
static bool for_good(shrink_t *shrink, uint32_t n)
{
    campaign_case_t smaller = *shrink->best;
    smaller.faults[n].lasts = 0.0;
    return shrink->best->faults[n].lasts != 0.0 && try_smaller(shrink, &smaller);
}

static bool without_event(shrink_t *shrink, uint32_t n)
{
    campaign_case_t smaller = *shrink->best;
    smaller.event_count--;
    memmove(&smaller.events[n], &smaller.events[n + 1u],
            (smaller.event_count - n) * sizeof smaller.events[0]);
    campaign_drop_drifts(&smaller);
    return try_smaller(shrink, &smaller);
}

/* Returns all quantities of a group to their defaults; CAMPAIGN_GROUPS: those of all groups. */
static bool without_group(shrink_t *shrink, campaign_group_t group)
{
    campaign_case_t smaller = *shrink->best;
    bool less = false;
    const campaign_quantity_row_t *rows;
    const uint32_t count = campaign_rows(&smaller, &rows);
    for (uint32_t n = 0; n < count; n++) {
        const campaign_quantity_row_t *row = &rows[n];
        if (group == CAMPAIGN_GROUPS || row->group == group) {
            less = less || smaller.quantities[n] != row->initial;
            smaller.quantities[n] = row->initial;
        }
    }
    return less && try_smaller(shrink, &smaller);
}

static bool without_quantity(shrink_t *shrink, uint32_t n)
{
    campaign_case_t smaller = *shrink->best;
    const campaign_quantity_row_t *rows;
    (void)campaign_rows(&smaller, &rows);
    smaller.quantities[n] = rows[n].initial;
    return shrink->best->quantities[n] != rows[n].initial && try_smaller(shrink, &smaller);
}

static bool pass(shrink_t *shrink)
{
    bool any = false;
    for (uint32_t n = CAMPAIGN_FAULTS_MAX; n-- > 0u;) {
        any = without_fault(shrink, n) || any;
        any = for_good(shrink, n) || any;
    }
    for (uint32_t n = shrink->best->event_count; n-- > 0u;) {
        any = without_event(shrink, n) || any;
    }
    for (campaign_group_t group = CAMPAIGN_GROUPS + 1u; group-- > 0u;) {
        any = without_group(shrink, group) || any;
    }
    const campaign_quantity_row_t *rows;
    const uint32_t count = campaign_rows(shrink->best, &rows);
    for (uint32_t n = 0; n < count; n++) {
        any = without_quantity(shrink, n) || any;
    }
    return any;
}

uint32_t campaign_shrink(campaign_case_t *drawn, campaign_result_t *result, const volatile sig_atomic_t *stop)
{
    shrink_t shrink = {drawn, result, stop, 0u};
    if (result->invariant == CAMPAIGN_I_REASON || result->invariant == CAMPAIGN_I_REPEAT) {
        return 0u;
    }
    end_sooner(&shrink);
    while (shrink.runs < SHRINK_RUNS && pass(&shrink)) {
        end_sooner(&shrink);
    }
    return shrink.runs;
}
