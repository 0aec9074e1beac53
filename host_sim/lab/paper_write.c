/* The data as CSV. */
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/paper_parts.h"
#include "host_sim/lab/times.h"

static const char *const column_names[COLUMNS] = {
    [C_SPEED] = "speed[r/min]",
    [C_SPEED_HAT] = "speed_hat[r/min]",
    [C_ERROR] = "theta_err[mrad]",
};

static const char *flavour(const result_t *result)
{
    return result->real ? "real" : "ideal";
}

/* ---- tables, a line a run ---- */

/* A number that a lost run may not have is left out. */
static void write_number(FILE *file, double number)
{
    fputc(',', file);
    if (isfinite(number)) {
        fprintf(file, "%.5g", number);
    }
}

static void write_beyond_speed(const paper_t *paper, FILE *file)
{
    fprintf(file,
            "flavour[text],variant[text],load[N m],speed[r/min],mean[mrad],sd[mrad],peak[mrad],lost[-]\n");
    for (size_t n = 0; n < paper->result_count; n++) {
        const result_t *result = &paper->results[n];
        if (paper_of_figure(result, BEYOND_SPEED)) {
            fprintf(file, "%s,%s,%g,%g", flavour(result), paper_variant(&result->run), result->run.load,
                    result->run.rpm);
            write_number(file, result->numbers[0].mean);
            write_number(file, result->numbers[0].sd);
            write_number(file, result->numbers[0].peak);
            fprintf(file, ",%d\n", result->lost);
        }
    }
}

static void write_beyond_bandwidth(const paper_t *paper, FILE *file)
{
    fprintf(file, "flavour[text],variant[text],bandwidth[rad/s],omega_c[rad/s],load[N m],"
                  "steady_accelerating[mrad],peak_accelerating[mrad],peak_decelerating[mrad],sd_100[mrad],"
                  "lost[-]\n");
    for (size_t n = 0; n < paper->result_count; n++) {
        const result_t *result = &paper->results[n];
        if (paper_of_figure(result, BEYOND_BANDWIDTH)) {
            fprintf(file, "%s,%s,%g,%g,%g", flavour(result), paper_variant(&result->run),
                    result->run.bandwidth, result->run.omega_c, result->run.load);
            write_number(file, result->numbers[UP].plateau);
            write_number(file, result->numbers[UP].peak);
            write_number(file, result->numbers[DOWN].peak);
            write_number(file, result->numbers[SLOW].sd);
            fprintf(file, ",%d\n", result->lost);
        }
    }
}

static void write_beyond_map(const paper_t *paper, FILE *file)
{
    fprintf(file, "deviation[text],adaptation[text],load[N "
                  "m],speed[r/min],mean[mrad],sd[mrad],peak[mrad],theory[mrad],lost[-]\n");
    for (size_t n = 0; n < paper->point_count; n++) {
        const map_point_t *point = &paper->points[n];
        fprintf(file, "%s,%s,%g,%g", map_deviation_name(point->deviation),
                map_adaptation_name(point->adaptation), point->load, point->rpm);
        write_number(file, point->mean_mrad);
        write_number(file, point->sd_mrad);
        write_number(file, point->peak_mrad);
        write_number(file, point->theory_mrad);
        fprintf(file, ",%d\n", !point->locked);
    }
}

void paper_write_more(const paper_t *paper, size_t figure, FILE *file)
{
    if (paper->more[figure] != NULL) {
        experiment_write_csv(paper->more[figure], file);
    }
}

/* ---- traces over time ---- */

/* The speed that is asked for at this time [r/min]. */
static double reference(const course_t *course, double time)
{
    double rpm = course->rpm;
    for (size_t n = 0; n < course->event_count; n++) {
        if (course->events[n].time <= time) {
            rpm = course->events[n].speed;
        }
    }
    return rpm;
}

#define REFERENCES_MAX 2

/* The different courses of a figure's runs, told apart by their speed at the start. */
static size_t find_references(const paper_t *paper, size_t figure, course_t references[REFERENCES_MAX])
{
    size_t count = 0;
    for (size_t n = 0; n < paper->result_count; n++) {
        const course_t course = paper_course(&paper->results[n].run);
        bool known = !paper_of_figure(&paper->results[n], figure);
        for (size_t r = 0; r < count; r++) {
            known = known || references[r].rpm == course.rpm;
        }
        if (!known) {
            assert(count < REFERENCES_MAX);
            references[count++] = course;
        }
    }
    return count;
}

static void write_traces(const paper_t *paper, size_t figure, FILE *file)
{
    const shown_t *shown = &paper_shown[figure];
    const size_t columns = paper_columns(figure);
    course_t references[REFERENCES_MAX];
    const size_t count =
        (shown->columns & BIT(C_SPEED)) != 0u ? find_references(paper, figure, references) : 0u;
    size_t rows = 0;
    fprintf(file, "time[s]");
    for (size_t n = 0; n < count; n++) {
        if (count == 1u) {
            fprintf(file, ",speed_ref[r/min]");
        } else {
            fprintf(file, ",speed_ref_%g[r/min]", references[n].rpm);
        }
    }
    for (size_t n = 0; n < paper->result_count; n++) {
        const result_t *result = &paper->results[n];
        if (paper_of_figure(result, figure)) {
            rows = result->rows > rows ? result->rows : rows;
            for (unsigned c = 0; c < COLUMNS; c++) {
                if ((shown->columns & BIT(c)) != 0u) {
                    fprintf(file, ",%s_%s_%s", result->run.name, flavour(result), column_names[c]);
                }
            }
        }
    }
    fprintf(file, "\n");
    for (size_t row = 0; row < rows; row++) {
        char when[TIMES_TEXT_SIZE];
        const double time = (double)row * shown->every * RIG_PERIOD_SECONDS;
        fprintf(file, "%s", times_text(when, (uint32_t)row * shown->every));
        for (size_t n = 0; n < count; n++) {
            fprintf(file, ",%g", reference(&references[n], time + 0.5 * RIG_PERIOD_SECONDS));
        }
        for (size_t n = 0; n < paper->result_count; n++) {
            const result_t *result = &paper->results[n];
            for (size_t c = 0; c < columns && paper_of_figure(result, figure); c++) {
                if (row < result->rows) {
                    write_number(file, (double)result->trace[columns * row + c]);
                } else {
                    fputc(',', file);
                }
            }
        }
        fprintf(file, "\n");
    }
}

void paper_write_csv(const paper_t *paper, size_t figure, FILE *file)
{
    assert(figure <= PAPER_OWN);
    if (!paper->wanted[figure]) {
        return;
    }
    if (paper->files[figure] != NULL) {
        experiment_write_csv(paper->files[figure], file);
    } else if (figure == BEYOND_SPEED) {
        write_beyond_speed(paper, file);
    } else if (figure == BEYOND_BANDWIDTH) {
        write_beyond_bandwidth(paper, file);
    } else if (figure == BEYOND_MAP) {
        write_beyond_map(paper, file);
    } else {
        write_traces(paper, figure, file);
    }
}
