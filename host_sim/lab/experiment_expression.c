/* Expressions of an experiment's file. */
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
    unsigned ranging; /* number of enclosing `for` */
} parser_t;

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
static double whole(parser_t *parser);

/* ---- functions ---- */

/* Position of `for` in these arguments; NULL: there is none. */
static const char *find_for(const char *text)
{
    unsigned depth = 0;
    bool in_word = false;
    for (const char *c = text; *c != '\0' && (*c != ')' || depth > 0u); c++) {
        if (*c == '\'') {
            const size_t length = strcspn(c + 1, "'");
            c += length + (c[length + 1u] == '\'' ? 1u : 0u);
        } else if (depth == 0u && !in_word && strncmp(c, "for ", 4) == 0) {
            return c;
        }
        depth += *c == '(';
        depth -= *c == ')';
        in_word = isalnum((unsigned char)*c) || *c == '_' || *c == '.' || *c == '@';
    }
    return NULL;
}

static uint32_t sweep_of(const experiment_t *experiment, const char *name, size_t length)
{
    uint32_t s = 0;
    while (s < experiment->sweep_count && (strlen(experiment->sweeps[s].name) != length ||
                                           strncmp(experiment->sweeps[s].name, name, length) != 0)) {
        s++;
    }
    return s;
}

/* The sweeps named after `for`, one bit each; 0: the text is wrong. */
static uint32_t ranges(parser_t *parser)
{
    const experiment_t *experiment = parser->value->experiment;
    uint32_t sweeps = 0;
    parser->at += 3; /* for */
    do {
        skip(parser);
        const size_t length = word(parser->at);
        const uint32_t s = sweep_of(experiment, parser->at, length);
        if (s == experiment->sweep_count) {
            wrong(parser, "no sweep is called \"%.*s\"; accepted: (... for SWEEP, SWEEP if ...)", (int)length,
                  parser->at);
            return 0u;
        }
        sweeps |= UINT32_C(1) << s;
        parser->at += length;
    } while (take(parser, ","));
    parser->value->ranged |= sweeps;
    return sweeps;
}

typedef struct {
    const experiment_function_t *function;
    const char *numbers, *condition,
        *end; /* begin of the numbers, of the condition (NULL: none), and the closing parenthesis */
    double *arguments;
    uint32_t count, most;
    bool empty; /* no run exists at any of its points */
} range_t;

/* The numbers of one point, if its condition holds. */
static bool add_point(parser_t *parser, range_t *range)
{
    range->empty = false;
    if (range->condition != NULL) {
        parser->at = range->condition;
        const bool holds = condition(parser) != 0.0;
        skip(parser);
        range->end = parser->at;
        if (!holds && !parser->value->unmeasured) {
            return true;
        }
    }
    parser->at = range->numbers;
    for (uint32_t n = 0; n < range->function->each && range->count < range->most; n++) {
        if (n > 0u && !take(parser, ",")) {
            break;
        }
        range->arguments[range->count++] = condition(parser);
    }
    skip(parser);
    if (range->count % range->function->each != 0u || strncmp(parser->at, "for ", 4) != 0) {
        wrong(parser, "%s takes %u number%s of each point; accepted: %s(%s for SWEEP)", range->function->name,
              range->function->each, range->function->each > 1u ? "s" : "", range->function->name,
              range->function->each > 1u ? "X, Y" : "X");
        return false;
    }
    return true;
}

/* Over all points of these sweeps that run; the other sweeps keep their present values. */
static void add_points(parser_t *parser, range_t *range, uint32_t sweeps)
{
    const experiment_t *experiment = parser->value->experiment;
    const uint32_t *outer = parser->value->point;
    uint32_t point[SWEEPS_MAX] = {0};
    memcpy(point, outer, experiment->sweep_count * sizeof point[0]);
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        point[s] = (sweeps & (UINT32_C(1) << s)) != 0u ? 0u : point[s];
    }
    parser->value->point = point;
    parser->ranging++;
    bool more = true;
    while (more && parser->value->why[0] == '\0') {
        more = (experiment_run_at(experiment, point) == NULL || add_point(parser, range)) &&
               experiment_next(experiment, sweeps, point);
    }
    parser->ranging--;
    parser->value->point = outer;
}

/* NAME(NUMBERS for SWEEPS if CONDITION), from `for` on. */
static double call_for(parser_t *parser, const experiment_function_t *function, const char *behind)
{
    range_t range = {
        .function = function, .numbers = parser->at, .most = 2u * EXPERIMENT_RUNS_MAX, .empty = true};
    if (function->each == 0u) {
        return wrong(parser, "%s does not combine points; accepted: sum, mean, max, min, worst, lowest_at",
                     function->name);
    }
    parser->at = behind;
    const uint32_t sweeps = ranges(parser);
    range.condition = sweeps != 0u && take(parser, "if ") ? parser->at : NULL;
    range.end = parser->at;
    range.arguments = sweeps != 0u ? calloc(range.most, sizeof *range.arguments) : NULL;
    if (range.arguments == NULL) {
        return wrong(parser, "no memory");
    }
    add_points(parser, &range, sweeps);
    if (range.empty) {
        (void)wrong(parser, "there is no run at the points of \"%.40s\"", behind);
    }
    const double result = range.count > 0u ? function->of(range.arguments, range.count) : function->none;
    free(range.arguments);
    parser->at = range.end;
    return take(parser, ")") ? result : wrong(parser, "a ) is missing at \"%.20s\"", parser->at);
}

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
    const char *behind = find_for(parser->at);
    if (behind != NULL) {
        return call_for(parser, function, behind);
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

/* ---- values of runs and rows ---- */

typedef enum { POINT_WRONG, POINT_NONE, POINT_THERE } point_found_t;

/* before(SWEEP): the point before in that sweep. */
static point_found_t point_before(parser_t *parser, uint32_t *point)
{
    const experiment_t *experiment = parser->value->experiment;
    const char *name = parser->at + strlen("before(");
    const size_t length = word(name);
    const uint32_t s = sweep_of(experiment, name, length);
    if (s == experiment->sweep_count || name[length] != ')') {
        wrong(parser, "no sweep is called \"%.*s\"; accepted: @before(SWEEP)", (int)length, name);
        return POINT_WRONG;
    }
    parser->at = name + length + 1;
    if (point[s] == 0u) {
        return POINT_NONE;
    }
    point[s]--;
    return POINT_THERE;
}

static point_found_t point_named(parser_t *parser, uint32_t *point)
{
    const experiment_t *experiment = parser->value->experiment;
    const bool quoted = *parser->at == '\'';
    const char *name = parser->at + (quoted ? 1 : 0);
    const size_t length = quoted ? strcspn(name, "'") : word(name);
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        for (uint32_t p = 0; p < experiment->sweeps[s].count; p++) {
            const char *of = experiment->sweeps[s].points[p].name;
            if (strlen(of) == length && strncmp(of, name, length) == 0) {
                point[s] = p;
                parser->at = name + length + (quoted && name[length] == '\'' ? 1 : 0);
                return POINT_THERE;
            }
        }
    }
    wrong(parser, "no point of a sweep is called %.*s", (int)length, name);
    return POINT_WRONG;
}

/* Any number of @POINT and @before(SWEEP): the named point replaces the point of the claim. NULL: there is no
 * such run, or the text is wrong. */
static const experiment_run_t *run_of(parser_t *parser)
{
    const experiment_t *experiment = parser->value->experiment;
    uint32_t point[SWEEPS_MAX] = {0};
    point_found_t found = POINT_THERE;
    memcpy(point, parser->value->point, experiment->sweep_count * sizeof point[0]);
    while (*parser->at == '@' && found != POINT_WRONG) {
        parser->at++;
        const point_found_t next =
            strncmp(parser->at, "before(", 7) == 0 ? point_before(parser, point) : point_named(parser, point);
        found = next != POINT_THERE ? next : found;
    }
    const experiment_run_t *run = found == POINT_THERE ? experiment_run_at(experiment, point) : NULL;
    if (run == NULL && found == POINT_THERE && parser->ranging == 0u) {
        wrong(parser, "there is no run at these points: one of them can only be combined with other points");
    }
    return run;
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
    parser->at = part + size;
    const experiment_run_t *run = run_of(parser);
    const uint32_t measure = experiment_measure_of(experiment, name, length);
    if (measure < experiment->measure_count) {
        const statistic_t statistic = statistic_of(part, size);
        if (statistic == STATISTICS) {
            return wrong(parser,
                         "no statistic is called \"%.*s\"; accepted: mean, min, max, peak, sd, rms, last",
                         (int)size, part);
        }
        parser->value->lost = parser->value->lost || (run != NULL && run->lost);
        return run != NULL ? tally_value(&run->tallies[measure], statistic) : (double)NAN;
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
    return run != NULL ? experiment_initial(run, row) : (double)NAN;
}

static const named_t *let_of(const experiment_t *experiment, const char *name, size_t length)
{
    for (uint32_t n = 0; n < experiment->let_count; n++) {
        if (strlen(experiment->lets[n].name) == length &&
            strncmp(experiment->lets[n].name, name, length) == 0) {
            return &experiment->lets[n];
        }
    }
    return NULL;
}

/* Evaluates the expression of a [let] name at the points of @. */
static double number_of_let(parser_t *parser, const named_t *let)
{
    const uint32_t *outer = parser->value->point;
    const experiment_run_t *run = run_of(parser);
    if (run == NULL) {
        return (double)NAN;
    }
    parser_t inner = {
        .value = parser->value, .at = let->text, .depth = parser->depth, .ranging = parser->ranging};
    parser->value->point = run->point;
    const double number = whole(&inner);
    parser->value->point = outer;
    return number;
}

/* The value of the point of a sweep. */
static double number_of(parser_t *parser, uint32_t s)
{
    const sweep_t *sweep = &parser->value->experiment->sweeps[s];
    const experiment_run_t *run = run_of(parser);
    if (run == NULL) {
        return (double)NAN;
    }
    const double number = sweep->points[run->point[s]].number;
    return isnan(number) ? wrong(parser, "the point %.60s of the sweep %.60s has no number",
                                 sweep->points[run->point[s]].name, sweep->name)
                         : number;
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
    if (length == 4u && strncmp(name, "lost", 4) == 0) {
        const experiment_run_t *run = run_of(parser);
        return run == NULL ? (double)NAN : run->lost ? 1.0 : 0.0;
    }
    const named_t *let = let_of(parser->value->experiment, name, length);
    if (let != NULL) {
        return number_of_let(parser, let);
    }
    const uint32_t s = sweep_of(parser->value->experiment, name, length);
    if (s < parser->value->experiment->sweep_count) {
        return number_of(parser, s);
    }
    return wrong(
        parser,
        "\"%.*s\" is no number; accepted: MEASURE.STATISTIC, TABLE.ROW, a sweep, one of [let], pi, rpm, "
        "mrad, value, lost",
        (int)length, name);
}

static double factor(parser_t *parser)
{
    skip(parser);
    if (++parser->depth > DEEP) {
        return wrong(parser, "the expression is too deep; accepted: up to %u nested parentheses and signs",
                     DEEP);
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

static double whole(parser_t *parser)
{
    const double result = condition(parser);
    skip(parser);
    if (*parser->at != '\0') {
        return wrong(parser, "the expression cannot be read from \"%.20s\" on", parser->at);
    }
    return parser->value->why[0] == '\0' ? result : (double)NAN;
}

double experiment_evaluate(value_t *value, const char *text)
{
    parser_t parser = {.value = value, .at = text};
    return whole(&parser);
}
