/* Judgement of a set of parameters: every row in its range, then the rules between rows (rules.h).
 *
 * The accepted range of a row is not computed by inverting each rule, but by evaluating the rules: bisection
 * between an end of the row's range that keeps all rules and the end that breaks one, down to neighbouring
 * numbers. The reported end is therefore the last number that the judgement itself accepts. */
#include <string.h>

#include "estimator/chosen.h"
#include "math/float_bits.h"
#include "settings/reasons.h"
#include "settings/rules.h"

/* Text of the rule for the formats of the fixed-point version, which depend on several rows; the range is
 * reported. */
#define FORMATS "the value must fit the number formats of the fixed-point estimator"

static const table_row_t *row_of(param_t param)
{
    return &params_table.rows[param];
}

/* True if a rule is judged: the rows that it reads, apart from `except`, are in their ranges. */
static bool is_judged(const rule_t *rule, const params_t *params, param_t except)
{
    for (int32_t n = 0; n < rule->count; n++) {
        const param_t param = rule->levers[n].row;
        if (param != except && !table_holds(row_of(param), params)) {
            return false;
        }
    }
    return true;
}

/* ---- the accepted range ---- */

/* A row in which a range is searched, on a set of its own. Its values are numbered in their
 * order, neighbouring values by neighbouring numbers: integers directly, floats, which are
 * never negative here, by their bits. */
typedef struct {
    params_t params;
    param_t param;
    uint32_t min, max; /* numbers of the ends */
    bool none;         /* no value is accepted */
} search_t;

static uint32_t number_of(const table_row_t *row, float value)
{
    return row->kind == SLOT_FLOAT ? float_bits(value) : (uint32_t)(int32_t)value;
}

static void put(search_t *search, uint32_t number)
{
    const table_row_t *row = row_of(search->param);
    if (row->kind == SLOT_FLOAT) {
        table_set(row, &search->params, float_of_bits(number));
    } else {
        table_set_whole(row, &search->params, (int64_t)number);
    }
}

/* The field of the estimator's parameters that belongs to a row. */
typedef struct {
    const char *field;
    param_t param;
} origin_t;

/* An error that the estimator reports although every rule above is kept: the formats of the fixed-point
 * version. -1: the row's value is too small for them, 1: too large, 0: the row is not the cause. */
static int32_t estimator_blames(const params_t *params, param_t *param, params_error_t *why)
{
    static const origin_t origins[] = {
        {"gain", PARAM_observer_gain},
        {"slope", PARAM_observer_slope},
        {"emf_cutoff", PARAM_observer_emf_cutoff},
        {"resistance", PARAM_motor_resistance},
        {"inductance", PARAM_motor_inductance_q},
        {"flux_linkage", PARAM_motor_flux_linkage},
        {"amplitude_floor", PARAM_motor_flux_linkage},
        {"torque_feedforward", PARAM_torque_feedforward},
        {"speed_min", PARAM_estimate_speed_min},
        {"speed_max", PARAM_overspeed_trip},
    };
    estimator_params_t estimator;
    const assumed_t assumed = params_configured(params);
    params_estimator(params, &assumed, &estimator);
    if (chosen_params_check(&estimator, why)) {
        return 0;
    }
    *param = PARAM_pll_bandwidth;
    for (uint32_t n = 0; n < sizeof origins / sizeof origins[0]; n++) {
        if (strcmp(origins[n].field, why->field) == 0) {
            *param = origins[n].param;
        }
    }
    return why->value < why->min ? -1 : 1;
}

static int32_t estimator_side(const search_t *search)
{
    params_error_t ignored;
    param_t blamed = search->param;
    const int32_t side = estimator_blames(&search->params, &blamed, &ignored);
    return blamed == search->param ? side : 0;
}

/* True if the row's value keeps the rule (RULES: the estimator's formats, from below or from above). */
static bool is_kept(const search_t *search, rule_number_t rule, lever_sense_t sense)
{
    if (rule != RULES) {
        return rules_hold(rule, &search->params);
    }
    return sense == MORE_HELPS ? estimator_side(search) >= 0 : estimator_side(search) <= 0;
}

/* Moves the end of the range that breaks the rule to the last value that keeps it. */
static void narrow(search_t *search, rule_number_t rule, lever_sense_t sense)
{
    const bool more = sense == MORE_HELPS;
    const float least = rules_least_above_zero(search->param);
    uint32_t good = more ? search->max : search->min;
    uint32_t bad = more ? search->min : search->max;
    if (!more && good == 0u) {
        good = float_bits(least);
    }
    put(search, good);
    search->none = search->none || !is_kept(search, rule, sense);
    if (more && bad == 0u) {
        bad = float_bits(least);
    }
    put(search, bad);
    if (search->none || is_kept(search, rule, sense)) {
        return;
    }
    while (good > bad + 1u || bad > good + 1u) {
        const uint32_t middle = good < bad ? good + (bad - good) / 2u : bad + (good - bad) / 2u;
        put(search, middle);
        if (is_kept(search, rule, sense)) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    if (more) {
        search->min = good;
    } else {
        search->max = good;
    }
}

/* The values of a row that the whole judgement accepts with every other row unchanged. */
static search_t accepted(const params_t *params, param_t param)
{
    const table_row_t *row = row_of(param);
    search_t search = {.params = *params,
                       .param = param,
                       .min = number_of(row, table_min(row)),
                       .max = number_of(row, table_max(row))};
    for (rule_number_t rule = RULE_TRIP; rule < RULES && !search.none; rule++) {
        const lever_sense_t sense = rules_sense(rule, param);
        if (sense != IS_READ && is_judged(&rules[rule], params, param)) {
            narrow(&search, rule, sense);
        }
    }
    if (!search.none) {
        narrow(&search, RULES, MORE_HELPS);
    }
    if (!search.none) {
        narrow(&search, RULES, LESS_HELPS);
    }
    return search;
}

/* ---- the row to change ---- */

/* The rule of thumb for a row, with the other rows unchanged, in its unit; 0: there is none. */
static float thumb(const params_t *params, param_t param)
{
    if (param != PARAM_observer_gain && param != PARAM_observer_slope &&
        param != PARAM_estimate_current_max) {
        return 0.0f;
    }
    const assumed_t assumed = params_configured(params);
    params_t by_rule = *params;
    table_set(row_of(param), &by_rule, 0.0f);
    const observer_rows_t observer = params_observer(&by_rule, &assumed);
    return param == PARAM_observer_gain    ? observer.gain
           : param == PARAM_observer_slope ? observer.slope
                                           : observer.current_max;
}

static float between(float value, float min, float max)
{
    const float upper = value < max ? value : max;
    return upper > min ? upper : min;
}

/* True if `param` has an accepted range when the row of this lever is moved as far as it
 * helps, or to its rule of thumb. */
static bool makes_room(const params_t *params, param_t param, const lever_t *lever, float *advice)
{
    const table_row_t *row = row_of(lever->row);
    const float rule_of_thumb = thumb(params, lever->row);
    params_t changed = *params;
    float value = lever->sense == MORE_HELPS ? table_max(row) : table_min(row);
    if (rule_of_thumb > 0.0f) {
        value = between(rule_of_thumb, table_min(row), table_max(row));
    }
    *advice = rule_of_thumb > 0.0f ? value : 0.0f;
    table_set(row, &changed, value);
    return !accepted(&changed, param).none;
}

/* If `param` has no accepted range: names another row of a rule that contains it. */
static void advise_another(const params_t *params, param_t param, params_error_t *why)
{
    const table_row_t *row = row_of(param);
    const float rule_of_thumb = thumb(params, param);
    params_t wished = *params;
    if (rule_of_thumb > 0.0f) {
        table_set(row, &wished, between(rule_of_thumb, table_min(row), table_max(row)));
    }
    why->change = 0u;
    for (rule_number_t rule = RULE_TRIP; rule < RULES; rule++) {
        for (int32_t n = 0; n < rules[rule].count && rules_sense(rule, param) != IS_READ; n++) {
            const lever_t *lever = &rules[rule].levers[n];
            if (why->change == 0u && lever->row != param && lever->sense != IS_READ &&
                makes_room(&wished, param, lever, &why->advice)) {
                why->change = row_of(lever->row)->id;
            }
        }
    }
}

/* ---- the judgement ---- */

static bool refuse(const params_t *params, param_t param, reason_t reason, const char *rule,
                   params_error_t *why)
{
    const table_row_t *row = row_of(param);
    const search_t search = accepted(params, param);
    *why = (params_error_t){.field = row->name,
                            .rule = rule,
                            .value = table_get(row, params),
                            .min = table_max(row),
                            .max = table_min(row),
                            .id = row->id,
                            .reason = (int32_t)reason};
    if (search.none) {
        advise_another(params, param, why);
        return false;
    }
    search_t ends = search;
    put(&ends, search.min);
    why->min = table_get(row, &ends.params);
    put(&ends, search.max);
    why->max = table_get(row, &ends.params);
    const float rule_of_thumb = thumb(params, param);
    why->change = row->id;
    why->advice = rule_of_thumb > 0.0f ? between(rule_of_thumb, why->min, why->max) : 0.0f;
    return false;
}

bool params_check(const params_t *params, params_error_t *why)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        if (!table_holds(&params_table.rows[n], params)) {
            return refuse(params, (param_t)n, REASON_OUT_OF_RANGE, PARAMS_RANGE, why);
        }
    }
    for (rule_number_t rule = RULE_TRIP; rule < RULES; rule++) {
        if (!rules_hold(rule, params)) {
            return refuse(params, rules[rule].levers[0].row, REASON_CROSS_RULE, rules[rule].text, why);
        }
    }
    param_t blamed = PARAM_motor_pole_pairs;
    return estimator_blames(params, &blamed, why) == 0 ||
           refuse(params, blamed, REASON_CROSS_RULE, FORMATS, why);
}

static bool differs(const table_row_t *row, const params_t *one, const params_t *other)
{
    if (row->kind == SLOT_FLOAT) {
        return table_get(row, one) != table_get(row, other);
    }
    return table_whole(row, one) != table_whole(row, other);
}

bool params_check_live(const params_t *active, const params_t *next, params_error_t *why)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        if (row->access == TABLE_OFF && differs(row, next, active)) {
            const float now = table_get(row, active);
            *why = (params_error_t){.field = row->name,
                                    .rule = "changes only while the bridge is off",
                                    .value = table_get(row, next),
                                    .min = now,
                                    .max = now,
                                    .id = row->id,
                                    .reason = (int32_t)REASON_BRIDGE_ON,
                                    .change = row->id};
            return false;
        }
    }
    return true;
}
