/* Expressions of an experiment's file, and conditions. */
#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/experiment_parts.h"

#define DEEP 40u /* parentheses and signs in each other */

typedef struct {
    value_t *value;
    const char *at;
    unsigned depth;
} parser_t;

const experiment_run_t *experiment_run_at(const experiment_t *experiment, const uint32_t *point)
{
    size_t n = 0;
    for (uint32_t s = experiment->sweep_count; s-- > 0u;) {
        n = n * experiment->sweeps[s].count + point[s];
    }
    return &experiment->runs[n];
}

uint32_t experiment_measure_of(const experiment_t *experiment, const char *name, size_t length)
{
    uint32_t n = 0;
    while (n < experiment->measure_count && (strlen(experiment->measures[n].look.name) != length ||
                                             strncmp(experiment->measures[n].look.name, name, length) != 0)) {
        n++;
    }
    return n;
}

double experiment_initial(const experiment_run_t *run, const table_row_t *row)
{
    const scenario_event_t *initial = &run->scenario->events[0];
    for (uint32_t n = 0; n < initial->count; n++) {
        if (initial->settings[n].row == row) {
            return initial->settings[n].value;
        }
    }
    return rig_initial(row);
}

static double __attribute__((format(printf, 2, 3))) wrong(parser_t *parser, const char *format, ...)
{
    if (parser->value->why[0] == '\0') {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(parser->value->why, sizeof parser->value->why, format, arguments);
        va_end(arguments);
    }
    return (double)NAN;
}

static void skip(parser_t *parser)
{
    parser->at += strspn(parser->at, " \t\n");
}

static bool take(parser_t *parser, const char *sign)
{
    skip(parser);
    const size_t length = strlen(sign);
    const bool is = strncmp(parser->at, sign, length) == 0;
    parser->at += is ? length : 0u;
    return is;
}

static size_t word(const char *text)
{
    size_t length = 0;
    while (isalnum((unsigned char)text[length]) || text[length] == '_') {
        length++;
    }
    return length;
}

static double condition(parser_t *parser);

static double call(parser_t *parser, const char *name, size_t length)
{
    const experiment_function_t *function = experiment_function(name, length);
    double arguments[ARGUMENTS_MAX] = {0};
    uint32_t count = 0;
    if (function == NULL) {
        return wrong(parser, "no function is called %.*s; accepted: %s", (int)length, name,
                     experiment_function_names);
    }
    if (function->most == 0u) {
        return take(parser, ")") ? function->of(arguments, 0u)
                                 : wrong(parser, "%s takes no numbers", function->name);
    }
    do {
        if (count == ARGUMENTS_MAX) {
            return wrong(parser, "%s takes at most %u numbers", function->name, function->most);
        }
        arguments[count++] = condition(parser);
    } while (take(parser, ","));
    if (!take(parser, ")")) {
        return wrong(parser, "a ) is missing at \"%.20s\"", parser->at);
    }
    if (count < function->least || count > function->most) {
        return wrong(parser, "%s takes %u%s numbers, not %u", function->name, function->least,
                     function->least < function->most ? " or more" : "", count);
    }
    return function->of(arguments, count);
}

/* @POINT, as often as there are: what it names replaces the claim's own. */
static bool other_points(parser_t *parser, uint32_t *point)
{
    const experiment_t *experiment = parser->value->experiment;
    while (*parser->at == '@') {
        const bool quoted = parser->at[1] == '\'';
        const char *name = parser->at + (quoted ? 2 : 1);
        const size_t length = quoted ? strcspn(name, "'") : word(name);
        bool known = false;
        for (uint32_t s = 0; s < experiment->sweep_count; s++) {
            for (uint32_t p = 0; p < experiment->sweeps[s].count; p++) {
                const char *of = experiment->sweeps[s].points[p].name;
                if (!known && strlen(of) == length && strncmp(of, name, length) == 0) {
                    point[s] = p;
                    known = true;
                }
            }
        }
        if (!known) {
            wrong(parser, "no point of a sweep is called %.*s", (int)length, name);
            return false;
        }
        parser->at = name + length + (quoted && name[length] == '\'' ? 1 : 0);
    }
    return true;
}

static statistic_t statistic_of(const char *name, size_t length)
{
    statistic_t n = STATISTIC_MEAN;
    while (n < STATISTICS &&
           (strlen(statistic_text(n)) != length || strncmp(statistic_text(n), name, length) != 0)) {
        n++;
    }
    return n;
}

/* TABLE.ROW at t = 0, or MEASURE.STATISTIC. */
static double reference(parser_t *parser, const char *name, size_t length)
{
    const experiment_t *experiment = parser->value->experiment;
    const char *part = parser->at + 1;
    const size_t size = word(part);
    uint32_t point[SWEEPS_MAX];
    memcpy(point, parser->value->point, experiment->sweep_count * sizeof point[0]);
    parser->at = part + size;
    if (!other_points(parser, point)) {
        return (double)NAN;
    }
    const experiment_run_t *run = experiment_run_at(experiment, point);
    const uint32_t measure = experiment_measure_of(experiment, name, length);
    if (measure < experiment->measure_count) {
        const statistic_t statistic = statistic_of(part, size);
        if (statistic == STATISTICS) {
            return wrong(parser,
                         "no statistic is called \"%.*s\"; accepted: mean, min, max, peak, sd, rms, last",
                         (int)size, part);
        }
        parser->value->lost = parser->value->lost || run->lost;
        return tally_value(&run->tallies[measure], statistic);
    }
    char row_name[2u * NAMES_LENGTH_MAX];
    scenario_error_t error;
    snprintf(row_name, sizeof row_name, "%.*s.%.*s", (int)length, name, (int)size, part);
    const table_row_t *row = scenario_row(row_name, &error);
    if (row == NULL || row->access == TABLE_READ) {
        return wrong(parser,
                     "%.60s is neither a [[measure]] with a statistic nor a row that has a value at t = 0",
                     row_name);
    }
    return experiment_initial(run, row);
}

static double named(parser_t *parser)
{
    static const struct {
        const char *name;
        double value;
    } constants[] = {{"pi", 3.14159265358979323846}, {"rpm", 0.10471975511965977462}, {"mrad", 1e-3}};
    const char *name = parser->at;
    const size_t length = word(name);
    parser->at += length;
    if (*parser->at == '.') {
        return reference(parser, name, length);
    }
    if (take(parser, "(")) {
        return call(parser, name, length);
    }
    for (size_t n = 0; n < sizeof constants / sizeof constants[0]; n++) {
        if (strlen(constants[n].name) == length && strncmp(constants[n].name, name, length) == 0) {
            return constants[n].value;
        }
    }
    if (length == 5u && strncmp(name, "value", 5) == 0) {
        return parser->value->own;
    }
    return wrong(parser,
                 "\"%.*s\" is no number; accepted: MEASURE.STATISTIC, TABLE.ROW, pi, rpm, mrad, value",
                 (int)length, name);
}

static double factor(parser_t *parser)
{
    skip(parser);
    if (++parser->depth > DEEP) {
        return wrong(parser, "it is too deep; accepted: %u parentheses and signs in each other", DEEP);
    }
    double result;
    if (take(parser, "-")) {
        result = -factor(parser);
    } else if (take(parser, "(")) {
        result = condition(parser);
        if (!take(parser, ")")) {
            result = wrong(parser, "a ) is missing at \"%.20s\"", parser->at);
        }
    } else if (isdigit((unsigned char)*parser->at) || *parser->at == '.') {
        char *end;
        result = strtod(parser->at, &end);
        parser->at = end;
    } else if (word(parser->at) > 0u) {
        result = named(parser);
    } else {
        result = wrong(parser, "a number is missing at \"%.20s\"", parser->at);
    }
    parser->depth--;
    return result;
}

static double product(parser_t *parser)
{
    double result = factor(parser);
    for (;;) {
        if (take(parser, "*")) {
            result *= factor(parser);
        } else if (take(parser, "/")) {
            result /= factor(parser);
        } else {
            return result;
        }
    }
}

static double sum(parser_t *parser)
{
    double result = product(parser);
    for (;;) {
        if (take(parser, "+")) {
            result += product(parser);
        } else if (take(parser, "-")) {
            result -= product(parser);
        } else {
            return result;
        }
    }
}

static double comparison(parser_t *parser)
{
    const double left = sum(parser);
    if (take(parser, "<=")) {
        return left <= sum(parser) ? 1.0 : 0.0;
    }
    if (take(parser, ">=")) {
        return left >= sum(parser) ? 1.0 : 0.0;
    }
    if (take(parser, "<")) {
        return left < sum(parser) ? 1.0 : 0.0;
    }
    if (take(parser, ">")) {
        return left > sum(parser) ? 1.0 : 0.0;
    }
    return left;
}

static double condition(parser_t *parser)
{
    double result = comparison(parser);
    while (take(parser, "and ")) {
        const double more = comparison(parser);
        result = result != 0.0 && more != 0.0 ? 1.0 : 0.0;
    }
    return result;
}

double experiment_evaluate(value_t *value, const char *text)
{
    parser_t parser = {.value = value, .at = text};
    const double result = condition(&parser);
    skip(&parser);
    if (*parser.at != '\0') {
        return wrong(&parser, "it is not understood from \"%.20s\" on", parser.at);
    }
    return value->why[0] == '\0' ? result : (double)NAN;
}

/* ---- conditions ---- */

static bool fill(const experiment_t *experiment, const uint32_t *point, const char *name, char *to,
                 size_t size, char why[WHY_MAX])
{
    scenario_error_t error;
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        if (strcmp(experiment->sweeps[s].name, name) == 0) {
            snprintf(to, size, "%s", experiment->sweeps[s].points[point[s]].text);
            return true;
        }
    }
    const table_row_t *row = scenario_row(name, &error);
    if (row == NULL || row->access == TABLE_READ) {
        snprintf(why, WHY_MAX, "{%.60s} is neither a sweep nor a row that has a value at t = 0", name);
        return false;
    }
    const double value = experiment_initial(experiment_run_at(experiment, point), row);
    if (row->kind == SLOT_ENUM) {
        char text[UNITS_TEXT_SIZE];
        snprintf(to, size, "%s", units_row_text(text, value, row));
    } else {
        snprintf(to, size, "%g", value);
    }
    return true;
}

bool experiment_condition(const experiment_t *experiment, const uint32_t *point, char *to, size_t size,
                          char why[WHY_MAX])
{
    size_t used = 0;
    to[0] = '\0';
    for (const char *c = experiment->condition; *c != '\0' && used + 1u < size; c++) {
        char name[128];
        const size_t length = strcspn(c, "}");
        if (*c != '{' || c[length] == '\0' || length > sizeof name) {
            to[used++] = *c;
            to[used] = '\0';
            continue;
        }
        snprintf(name, sizeof name, "%.*s", (int)(length - 1u), c + 1);
        if (!fill(experiment, point, name, to + used, size - used, why)) {
            return false;
        }
        used += strlen(to + used);
        c += length;
    }
    return true;
}
