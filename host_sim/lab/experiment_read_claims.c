/* Reads the claims of an experiment, and judges them as far as possible without a run. */
#include "host_sim/lab/experiment_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- [let] ---- */

/* True if the name already has a meaning in expressions. */
static bool is_taken(const file_t *file, const toml_entry_t *entry)
{
    static const char *const words[] = {"pi", "rpm", "mrad", "value", "lost", "for", "if", "and"};
    const experiment_t *experiment = file->experiment;
    bool taken = false;
    for (size_t n = 0; n < sizeof words / sizeof words[0]; n++) {
        taken = taken || strcmp(words[n], entry->key) == 0;
    }
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        taken = taken || strcmp(experiment->sweeps[s].name, entry->key) == 0;
    }
    return taken &&
           !file_fail(file, entry, "this name already has a meaning in expressions; accepted: another name");
}

bool file_read_lets(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    const toml_entry_t *table = reading_find(&file->reading, file_top(file), "let");
    if (table == NULL) {
        return true;
    }
    if (!reading_is_type(&file->reading, table, TOML_TABLE)) {
        return false;
    }
    experiment->lets = file_take(file, reading_count(&file->reading, table), sizeof *experiment->lets);
    for (const toml_entry_t *entry = reading_first(&file->reading, table);
         entry != NULL && experiment->lets != NULL; entry = reading_next(&file->reading, table, entry)) {
        if (!reading_is_text(&file->reading, entry, false) || !file_is_word(file, entry, entry->key) ||
            is_taken(file, entry)) {
            return false;
        }
        experiment->lets[experiment->let_count++] = (named_t){entry->key, entry->text, reading_place(entry)};
    }
    return experiment->lets != NULL;
}

bool file_check_lets(const file_t *file)
{
    const experiment_t *experiment = file->experiment;
    for (uint32_t n = 0; n < experiment->let_count; n++) {
        const named_t *let = &experiment->lets[n];
        value_t value = {
            .experiment = experiment, .point = experiment->runs[0].point, .own = 1.0, .unmeasured = true};
        (void)experiment_evaluate(&value, let->text);
        if (value.why[0] != '\0') {
            return scenario_fail(file->reading.error, let->place, let->name, "%s", value.why);
        }
    }
    return true;
}

/* ---- [[claim]] ---- */

/* A number, or an expression. */
bool file_number(const file_t *file, const toml_entry_t *entry, double *number, const char **text)
{
    if (entry->type == TOML_INTEGER || entry->type == TOML_FLOAT) {
        *number = entry->number;
        return isfinite(*number) || file_fail(file, entry, "it is not a finite number");
    }
    if (text == NULL) {
        return file_fail(file, entry, "accepted: a number in the unit of the claim");
    }
    if (!reading_is_text(&file->reading, entry, false)) {
        return false;
    }
    *text = entry->text;
    return true;
}

static bool read_tolerance(const file_t *file, const toml_entry_t *table, claim_t *claim)
{
    const experiment_t *experiment = file->experiment;
    const toml_entry_t *tolerance = reading_find(&file->reading, table, "tolerance");
    for (uint32_t n = 0; n < experiment->each_count && tolerance != NULL; n++) {
        const toml_entry_t *entry = tolerance;
        if (!claim->each[n]) {
            continue;
        }
        if (tolerance->type == TOML_TABLE && experiment->each_sweep < experiment->sweep_count) {
            const sweep_t *sweep = &experiment->sweeps[experiment->each_sweep];
            const char *name = sweep->points[experiment->each[n]].name;
            entry = reading_find(&file->reading, tolerance, name);
            if (entry == NULL) {
                return reading_missing(&file->reading, tolerance, name, "tolerance = {real = 4, ideal = 1}");
            }
        }
        if (!file_number(file, entry, &claim->tolerance[n], NULL)) {
            return false;
        }
        if (claim->tolerance[n] < 0.0) {
            return file_fail(file, entry, "it is negative; accepted: 0 or more");
        }
    }
    return true;
}

/* The points of one sweep: those of `at`; without it the only one, or that of the flavour. */
static bool read_at(const file_t *file, const toml_entry_t *table, uint32_t s, claim_t *claim)
{
    const experiment_t *experiment = file->experiment;
    const sweep_t *sweep = &experiment->sweeps[s];
    const toml_entry_t *at = reading_find(&file->reading, table, "at");
    const toml_entry_t *entry = at != NULL ? reading_find(&file->reading, at, sweep->name) : NULL;
    claim->at[s] = file_take(file, sweep->count, sizeof *claim->at[s]);
    const toml_entry_t **names = file_take(file, sweep->count, sizeof *names);
    if (claim->at[s] == NULL || names == NULL) {
        return false;
    }
    claim->at_count[s] = 1u;
    if (s == experiment->each_sweep) {
        return entry == NULL ||
               file_fail(file, entry, "this sweep is that of `each`; accepted: the other sweeps");
    }
    if (entry == NULL) { /* the first point of the sweep, if `value` combines the points; file_check_claims
                            tests this */
        claim->unsaid |= sweep->count > 1u ? UINT32_C(1) << s : 0u;
        return true;
    }
    claim->at_count[s] = file_list(file, entry, names, sweep->count);
    for (uint32_t n = 0; n < claim->at_count[s]; n++) {
        claim->at[s][n] = sweep_point(sweep, names[n]->text);
        if (claim->at[s][n] == sweep->count) {
            return file_no_point(file, names[n], sweep);
        }
    }
    return claim->at_count[s] > 0u;
}

/* Checks that `at` contains only sweeps, and each sweep that needs a point. */
static bool read_points(const file_t *file, const toml_entry_t *table, claim_t *claim)
{
    const experiment_t *experiment = file->experiment;
    const toml_entry_t *at = reading_find(&file->reading, table, "at");
    char names[200] = "";
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", s > 0u ? "|" : "", experiment->sweeps[s].name);
    }
    if (at != NULL &&
        (!reading_is_type(&file->reading, at, TOML_TABLE) ||
         !reading_only_keys(&file->reading, at, names, names[0] != '\0' ? names : "nothing: no [[sweep]]"))) {
        return false;
    }
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        if (!read_at(file, table, s, claim)) {
            return false;
        }
    }
    return true;
}

/* The measured quantity: value, or `of` a measure. */
static bool read_value(const file_t *file, const toml_entry_t *table, claim_t *claim)
{
    const reading_t *reading = &file->reading;
    const toml_entry_t *measure = reading_find(reading, table, "measure");
    const toml_entry_t *of = reading_find(reading, table, "of");
    const toml_entry_t *value = reading_find(reading, table, "value");
    if ((value == NULL) == (measure == NULL) || (measure == NULL) != (of == NULL)) {
        return file_fail(file, table, "accepted: measure and of, or value");
    }
    if (value != NULL) {
        claim->value = value->text;
        return reading_is_text(reading, value, false);
    }
    if (!reading_is_text(reading, measure, false) || !reading_statistic(reading, of, &claim->of)) {
        return false;
    }
    claim->measure = experiment_measure_of(file->experiment, measure->text, strlen(measure->text));
    if (claim->measure == file->experiment->measure_count) {
        names_search_t search = names_search(measure->text);
        for (uint32_t n = 0; n < file->experiment->measure_count; n++) {
            names_consider(&search, file->experiment->measures[n].look.name);
        }
        const char *near = names_found(&search);
        return scenario_fail(reading->error, reading_place(measure), "measure",
                             "no [[measure]] is called \"%.60s\"%s%s", measure->text,
                             near != NULL ? "; nearest: " : "", near != NULL ? near : "");
    }
    return true;
}

/* Reads the `each` of the claim: a subset of that of the experiment. */
static bool read_judged(const file_t *file, const toml_entry_t *table, claim_t *claim)
{
    const experiment_t *experiment = file->experiment;
    const toml_entry_t *each = reading_find(&file->reading, table, "each");
    const toml_entry_t *names[EACH_MAX];
    if (each == NULL) {
        for (uint32_t n = 0; n < experiment->each_count; n++) {
            claim->each[n] = true;
        }
        return true;
    }
    if (experiment->each_sweep == experiment->sweep_count) {
        return file_fail(file, each, "[experiment] has no each; add that list first");
    }
    const sweep_t *sweep = &experiment->sweeps[experiment->each_sweep];
    const uint32_t count = file_list(file, each, names, EACH_MAX);
    for (uint32_t n = 0; n < count; n++) {
        uint32_t of = 0;
        while (of < experiment->each_count &&
               strcmp(sweep->points[experiment->each[of]].name, names[n]->text) != 0) {
            of++;
        }
        if (of == experiment->each_count) {
            return file_fail(file, names[n],
                             "no such name in [experiment] each; accepted: names of that list");
        }
        claim->each[of] = true;
    }
    return count > 0u;
}

static bool read_claim(const file_t *file, const toml_entry_t *entry, claim_t *claim)
{
    const reading_t *reading = &file->reading;
    if (!reading_is_type(reading, entry, TOML_TABLE) ||
        !reading_only_keys(
            reading, entry,
            "id|text|unit|each|measure|of|value|at|printed|theory|tolerance|holds_if|why_not|where",
            "id, text, unit, each, measure, of, value, at, printed, theory, tolerance, holds_if, why_not, "
            "where")) {
        return false;
    }
    const toml_entry_t *printed = reading_find(reading, entry, "printed");
    const toml_entry_t *theory = reading_find(reading, entry, "theory");
    claim->why_not = printed != NULL ? "the number is different" : "the source has no number";
    claim->where = "";
    claim->printed = (double)NAN;
    claim->theory_number = (double)INFINITY;
    if (!file_needed(file, entry, "id", "id = \"accelerating\"", &claim->id) ||
        !file_needed(file, entry, "text", "text = \"error while accelerating\"", &claim->text) ||
        !file_needed(file, entry, "unit", "unit = \"mrad\"", &claim->unit) ||
        !read_value(file, entry, claim) ||
        (printed != NULL && !file_number(file, printed, &claim->printed, NULL)) ||
        (theory != NULL && !file_number(file, theory, &claim->theory_number, &claim->theory)) ||
        !file_text(file, entry, "holds_if", &claim->holds_if) ||
        !file_text(file, entry, "why_not", &claim->why_not) ||
        !file_text(file, entry, "where", &claim->where)) {
        return false;
    }
    if (printed != NULL && theory != NULL) {
        return file_fail(file, theory, "the claim has a printed number; accepted: one of them");
    }
    if (printed == NULL && theory == NULL && claim->holds_if == NULL) {
        return reading_missing(reading, entry, "printed",
                               "printed = 355, or theory = 350, or holds_if = \"...\"");
    }
    if ((printed != NULL || theory != NULL) && reading_find(reading, entry, "tolerance") == NULL) {
        return reading_missing(reading, entry, "tolerance", "tolerance = 10");
    }
    return read_judged(file, entry, claim) && read_tolerance(file, entry, claim) &&
           read_points(file, entry, claim);
}

bool file_read_claims(const file_t *file)
{
    experiment_t *experiment = file->experiment;
    bool good;
    uint32_t count;
    const toml_entry_t *array = reading_tables(&file->reading, file_top(file), "claim", &count, &good);
    experiment->claims = good ? file_take(file, count, sizeof *experiment->claims) : NULL;
    if (good && array == NULL) {
        return reading_missing(&file->reading, file_top(file), "claim",
                               "[[claim]] with id, text, measure, of, printed");
    }
    for (const toml_entry_t *entry = experiment->claims != NULL ? reading_first(&file->reading, array) : NULL;
         entry != NULL; entry = reading_next(&file->reading, array, entry)) {
        claim_t *claim = &experiment->claims[experiment->claim_count];
        if (!read_claim(file, entry, claim) || !file_is_first(file, array, entry, "id")) {
            return false;
        }
        experiment->claim_count++;
        if (experiment_row_count(experiment) > EXPERIMENT_ROWS_MAX) {
            return scenario_fail(
                file->reading.error, reading_place(entry), "claim",
                "the claims of all points make more than %u rows; accepted: at most that many",
                EXPERIMENT_ROWS_MAX);
        }
    }
    return experiment->claims != NULL;
}

/* True if there is a run at all points of the claim. */
static bool check_points(const file_t *file, const claim_t *claim, const toml_entry_t *entry)
{
    const experiment_t *experiment = file->experiment;
    for (uint32_t each = 0; each < experiment->each_count; each++) {
        for (size_t n = 0; claim->each[each] && n < experiment_claim_points(experiment, claim); n++) {
            uint32_t point[SWEEPS_MAX] = {0};
            experiment_claim_point(experiment, claim, each, n, point);
            if (experiment_run_at(experiment, point) == NULL) {
                char names[200] = "";
                for (uint32_t s = 0; s < experiment->sweep_count; s++) {
                    const size_t used = strlen(names);
                    snprintf(names + used, sizeof names - used, "%s%s", s > 0u ? ", " : "",
                             experiment->sweeps[s].points[point[s]].name);
                }
                return scenario_fail(
                    file->reading.error, reading_place(entry), "at",
                    "of claim %s: there is no run at %s; accepted: points that can be combined, "
                    "and entries of `each` that can be combined with them: each = [...]",
                    claim->id, names);
            }
        }
    }
    return true;
}

/* A sweep of several points that neither `at` nor a `for` of the value mentions. */
static bool check_said(const file_t *file, const claim_t *claim, const toml_entry_t *entry, uint32_t ranged)
{
    const experiment_t *experiment = file->experiment;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        const sweep_t *sweep = &experiment->sweeps[s];
        if ((claim->unsaid & ~ranged & (UINT32_C(1) << s)) != 0u) {
            return scenario_fail(file->reading.error, reading_place(entry), "at",
                                 "it names no point of the sweep %s; write for example at = {%s = \"%s\"}",
                                 sweep->name, sweep->name, sweep->points[0].name);
        }
    }
    return true;
}

static bool check_claim(const file_t *file, const claim_t *claim, const toml_entry_t *entry)
{
    const experiment_t *experiment = file->experiment;
    const char *const texts[] = {claim->value, claim->theory, claim->holds_if, claim->why_not, claim->where};
    static const char *const keys[] = {"value", "theory", "holds_if", "why_not", "where"};
    uint32_t point[SWEEPS_MAX] = {0};
    uint32_t ranged = 0;
    uint32_t each = 0;
    if (!check_points(file, claim, entry)) {
        return false;
    }
    while (each + 1u < experiment->each_count && !claim->each[each]) {
        each++;
    }
    experiment_claim_point(experiment, claim, each, 0, point);
    for (size_t n = 0; n < sizeof texts / sizeof texts[0]; n++) {
        value_t value = {.experiment = experiment, .point = point, .own = 1.0, .unmeasured = true};
        char filled[TEXT_MAX];
        const toml_entry_t *place = reading_find(&file->reading, entry, keys[n]);
        if (n < 3u && texts[n] != NULL) {
            (void)experiment_evaluate(&value, texts[n]);
        } else if (texts[n] != NULL) {
            (void)experiment_text(&value, texts[n], filled, sizeof filled);
        }
        ranged |= n == 0u ? value.ranged : 0u;
        if (value.why[0] != '\0') {
            return scenario_fail(file->reading.error, reading_place(place != NULL ? place : entry), keys[n],
                                 "of claim %s: %s", claim->id, value.why);
        }
    }
    return check_said(file, claim, entry, ranged);
}

static bool check_condition(const file_t *file)
{
    const experiment_t *experiment = file->experiment;
    char filled[TEXT_MAX];
    value_t value = {.experiment = experiment, .point = experiment->runs[0].point, .unmeasured = true};
    if (experiment_text(&value, experiment->condition, filled, sizeof filled)) {
        return true;
    }
    const toml_entry_t *table = reading_find(&file->reading, file_top(file), "experiment");
    return file_fail(file, reading_find(&file->reading, table, "condition"), value.why);
}

bool file_check_claims(const file_t *file)
{
    const toml_entry_t *array = reading_find(&file->reading, file_top(file), "claim");
    const toml_entry_t *entry = reading_first(&file->reading, array);
    for (uint32_t n = 0; n < file->experiment->claim_count; n++) {
        if (!check_claim(file, &file->experiment->claims[n], entry)) {
            return false;
        }
        entry = reading_next(&file->reading, array, entry);
    }
    return check_condition(file);
}
