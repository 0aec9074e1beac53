#include "host_sim/plant/flux_map_file.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/plant/flux_map.h"

#define COLUMNS 4u
#define LINE    512u

static const char *const names[COLUMNS] = {"i_d", "i_q", "psi_d", "psi_q"};

#define ACCEPTED                                                                                             \
    "accepted: a first line with the columns i_d, i_q, psi_d, psi_q, then their numbers in A and Wb, "       \
    "separated by commas"

typedef struct {
    double value[COLUMNS]; /* [A], [A], [Wb], [Wb] */
    uint32_t line;
} point_t;

typedef struct {
    const char *path;
    char *why;
    size_t size;
    uint32_t line;
    uint32_t column[COLUMNS]; /* of the file, for each name */
    point_t *points;
    uint32_t count, room;
} file_t;

__attribute__((format(printf, 3, 4))) static bool fail(const file_t *file, uint32_t line, const char *format,
                                                       ...)
{
    va_list arguments;
    const int length = line > 0u ? snprintf(file->why, file->size, "%s:%u: ", file->path, line)
                                 : snprintf(file->why, file->size, "%s: ", file->path);
    va_start(arguments, format);
    if (length >= 0 && (size_t)length < file->size) {
        (void)vsnprintf(file->why + length, file->size - (size_t)length, format, arguments);
    }
    va_end(arguments);
    return false;
}

/* The next cell of a line, without the blanks around it; NULL: there is none. */
static char *next_cell(char **rest)
{
    char *cell = *rest;
    if (cell == NULL) {
        return NULL;
    }
    char *comma = strchr(cell, ',');
    *rest = comma != NULL ? comma + 1 : NULL;
    if (comma != NULL) {
        *comma = '\0';
    }
    cell += strspn(cell, " \t\"");
    size_t length = strlen(cell);
    while (length > 0u && strchr(" \t\"\r\n", cell[length - 1u]) != NULL) {
        cell[--length] = '\0';
    }
    return cell;
}

static bool read_names(file_t *file, char *text)
{
    bool found[COLUMNS] = {false, false, false, false};
    uint32_t at = 0u;
    for (char *cell = next_cell(&text); cell != NULL; cell = next_cell(&text), at++) {
        uint32_t n = 0u;
        cell[strcspn(cell, " [")] = '\0'; /* a unit after the name */
        while (n < COLUMNS && strcmp(cell, names[n]) != 0) {
            n++;
        }
        if (n == COLUMNS) {
            return fail(file, file->line, "column %u, '%s', has no such name; " ACCEPTED, at + 1u, cell);
        }
        if (found[n]) {
            return fail(file, file->line, "column %s occurs twice; " ACCEPTED, names[n]);
        }
        found[n] = true;
        file->column[n] = at;
    }
    for (uint32_t n = 0; n < COLUMNS; n++) {
        if (!found[n]) {
            return fail(file, file->line, "column %s is missing; " ACCEPTED, names[n]);
        }
    }
    return true;
}

static point_t *new_point(file_t *file)
{
    if (file->count == file->room) {
        const uint32_t room = file->room > 0u ? 2u * file->room : 256u;
        point_t *points = room <= 2u * FLUX_MAP_POINTS * FLUX_MAP_POINTS
                              ? realloc(file->points, room * sizeof *points)
                              : NULL;
        if (points == NULL) {
            (void)fail(file, file->line, "too many points; accepted: up to %u values of each current",
                       FLUX_MAP_POINTS);
            return NULL;
        }
        file->points = points;
        file->room = room;
    }
    return &file->points[file->count++];
}

static bool read_point(file_t *file, char *text)
{
    point_t *point = new_point(file);
    if (point == NULL) {
        return false;
    }
    *point = (point_t){{NAN, NAN, NAN, NAN}, file->line};
    uint32_t at = 0u;
    for (char *cell = next_cell(&text); cell != NULL; cell = next_cell(&text), at++) {
        uint32_t n = 0u;
        char *end;
        while (n < COLUMNS && file->column[n] != at) {
            n++;
        }
        if (n == COLUMNS) {
            return fail(file, file->line, "more than the four columns of line 1; " ACCEPTED);
        }
        point->value[n] = strtod(cell, &end);
        if (*cell == '\0' || *end != '\0' || !isfinite(point->value[n])) {
            return fail(file, file->line, "%s: '%s' is not a number; " ACCEPTED, names[n], cell);
        }
    }
    return at == COLUMNS || fail(file, file->line, "%u of the four columns; " ACCEPTED, at);
}

static bool read_lines(file_t *file, FILE *stream)
{
    char text[LINE];
    bool named = false;
    while (fgets(text, sizeof text, stream) != NULL) {
        file->line++;
        if (strchr(text, '\n') == NULL && strlen(text) == LINE - 1u) {
            return fail(file, file->line, "the line is longer than %u characters; " ACCEPTED, LINE - 2u);
        }
        if (text[0] == '#' || text[strspn(text, " \t\r\n")] == '\0') {
            continue;
        }
        if (named ? !read_point(file, text) : !read_names(file, text)) {
            return false;
        }
        named = true;
    }
    return file->count > 0u || fail(file, 0u, "no points; " ACCEPTED);
}

static int by_currents(const void *a, const void *b)
{
    const point_t *x = a;
    const point_t *y = b;
    const int along = (x->value[0] > y->value[0]) - (x->value[0] < y->value[0]);
    return along != 0 ? along : (x->value[1] > y->value[1]) - (x->value[1] < y->value[1]);
}

/* The sorted points are a full grid: each row of equal i_d has the i_q of the first row. */
static bool is_grid(const file_t *file, uint32_t across)
{
    for (uint32_t n = 1; n < file->count; n++) {
        const point_t *point = &file->points[n];
        const uint32_t m = n % across;
        if (by_currents(point, point - 1) == 0) {
            return fail(file, point->line > point[-1].line ? point->line : point[-1].line,
                        "the point i_d = %g A, i_q = %g A is in line %u, too; accepted: each point once",
                        point->value[0], point->value[1],
                        point->line < point[-1].line ? point->line : point[-1].line);
        }
        if ((m > 0u && point->value[0] != point[-1].value[0]) ||
            point->value[1] != file->points[m].value[1]) {
            return fail(
                file, point->line,
                "i_d = %g A, i_q = %g A is not on the grid of the other points, or one before it is missing; "
                "accepted: the values of i_q of the first i_d, with each i_d",
                point->value[0], point->value[1]);
        }
    }
    return file->count % across == 0u ||
           fail(file, 0u,
                "the number of points, %u, is no multiple of the %u values of i_q; accepted: a full grid",
                file->count, across);
}

static uint32_t add(const file_t *file, uint32_t across)
{
    const uint32_t along = file->count / across;
    double *block = malloc((along + across + 2u * file->count) * sizeof *block);
    if (block == NULL) {
        (void)fail(file, 0u, "not enough memory");
        return 0u;
    }
    double *i_q = block + along;
    double *flux_d = i_q + across;
    double *flux_q = flux_d + file->count;
    for (uint32_t n = 0; n < file->count; n++) {
        block[n / across] = file->points[n].value[0];
        i_q[n % across] = file->points[n].value[1];
        flux_d[n] = file->points[n].value[2];
        flux_q[n] = file->points[n].value[3];
    }
    flux_map_error_t error;
    const uint32_t number =
        flux_map_add(&(flux_map_grid_t){along, across, block, i_q, flux_d, flux_q}, &error);
    if (number == 0u) {
        (void)fail(file, 0u,
                   "at i_d = %g A, i_q = %g A: %s; accepted: a map of a motor, with the current along d in "
                   "the first column",
                   error.i_d, error.i_q, error.rule);
    }
    free(block);
    return number;
}

uint32_t flux_map_file_read(const char *path, char *why, size_t size)
{
    file_t file = {.path = path, .why = why, .size = size};
    FILE *stream = fopen(path, "r");
    if (stream == NULL) {
        (void)fail(&file, 0u,
                   "%s; accepted: a CSV file beside the scenario with the columns i_d, i_q, psi_d, psi_q",
                   strerror(errno));
        return 0u;
    }
    uint32_t number = 0u;
    if (read_lines(&file, stream)) {
        uint32_t across = 1u;
        qsort(file.points, file.count, sizeof *file.points, by_currents);
        while (across < file.count && file.points[across].value[0] == file.points[0].value[0]) {
            across++;
        }
        number = is_grid(&file, across) ? add(&file, across) : 0u;
    }
    fclose(stream);
    free(file.points);
    return number;
}
