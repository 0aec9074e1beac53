/* The runs of an experiment and their results, as CSV and JSON. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/experiment_parts.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/paper_theory.h"
#include "host_sim/lab/times.h"

#define RPM            0.10471975511965977462 /* 2 pi/60 [rad/s] */
#define REFERENCES_MAX 8u

static double initial(const experiment_run_t *run, const char *row)
{
    return experiment_initial(run, rig_row_by_name(row));
}

/* ---- CSV ---- */

/* Writes a number; the cell stays empty if a lost run has no such number. */
static void write_number(FILE *file, double number)
{
    fputc(',', file);
    if (isfinite(number)) {
        fprintf(file, "%.5g", number);
    }
}

/* The commanded value in this period, in the reference's unit. */
static double asked(const experiment_t *experiment, const experiment_run_t *run, uint32_t period)
{
    const look_t *look = &experiment->reference;
    const scenario_t *scenario = run->scenario;
    double value = scenario_initial(scenario, look->row);
    for (uint32_t e = 1; e < scenario->event_count && scenario->events[e].period <= period; e++) {
        for (uint32_t n = 0; n < scenario->events[e].count; n++) {
            const scenario_setting_t *setting = &scenario->events[e].settings[n];
            value = setting->row == look->row ? setting->value : value;
        }
    }
    return value / look->scale;
}

/* Runs with different courses of the reference, distinguished by its value at the start. */
static size_t find_references(const experiment_t *experiment,
                              const experiment_run_t *references[REFERENCES_MAX])
{
    size_t count = 0;
    for (uint32_t n = 0; n < experiment->run_count && experiment->reference.row != NULL; n++) {
        bool known = false;
        for (size_t r = 0; r < count; r++) {
            known =
                known || asked(experiment, references[r], 0u) == asked(experiment, &experiment->runs[n], 0u);
        }
        if (!known && count < REFERENCES_MAX) {
            references[count++] = &experiment->runs[n];
        }
    }
    return count;
}

static void write_run_name(const experiment_run_t *run, FILE *file)
{
    fprintf(file, "%s%s%s", run->name, run->name[0] != '\0' && run->flavour[0] != '\0' ? "_" : "",
            run->flavour);
}

static size_t write_head(const experiment_t *experiment, const experiment_run_t *references[REFERENCES_MAX],
                         FILE *file)
{
    const size_t count = find_references(experiment, references);
    const look_t *reference = &experiment->reference;
    fprintf(file, "time[s]");
    for (size_t n = 0; n < count; n++) {
        if (count == 1u) {
            fprintf(file, ",%s[%s]", reference->name, reference->unit);
        } else {
            fprintf(file, ",%s_%g[%s]", reference->name, asked(experiment, references[n], 0u),
                    reference->unit);
        }
    }
    for (uint32_t n = 0; n < experiment->run_count; n++) {
        for (uint32_t c = 0; c < experiment->column_count; c++) {
            fputc(',', file);
            write_run_name(&experiment->runs[n], file);
            fprintf(file, "_%s[%s]", experiment->columns[c].name, experiment->columns[c].unit);
        }
    }
    fprintf(file, "\n");
    return count;
}

static void write_traces(const experiment_t *experiment, FILE *file)
{
    const experiment_run_t *references[REFERENCES_MAX];
    const size_t count = write_head(experiment, references, file);
    size_t rows = 0;
    for (uint32_t n = 0; n < experiment->run_count; n++) {
        rows = experiment->runs[n].rows > rows ? experiment->runs[n].rows : rows;
    }
    for (size_t row = 0; row < rows; row++) {
        char when[TIMES_TEXT_SIZE];
        const uint32_t period = (uint32_t)row * experiment->every;
        fprintf(file, "%s", times_text(when, period));
        for (size_t n = 0; n < count; n++) {
            fprintf(file, ",%g", asked(experiment, references[n], period));
        }
        for (uint32_t n = 0; n < experiment->run_count; n++) {
            const experiment_run_t *run = &experiment->runs[n];
            for (uint32_t c = 0; c < experiment->column_count; c++) {
                write_number(file, row < run->rows ? (double)run->trace[row * experiment->column_count + c]
                                                   : (double)NAN);
            }
        }
        fprintf(file, "\n");
    }
}

static void write_table(const experiment_t *experiment, FILE *file)
{
    static const statistic_t shown[] = {STATISTIC_MEAN, STATISTIC_SD, STATISTIC_MIN, STATISTIC_MAX};
    fprintf(file, "run[text],flavour[text],lost[-]");
    for (uint32_t m = 0; m < experiment->measure_count; m++) {
        for (size_t s = 0; s < sizeof shown / sizeof shown[0]; s++) {
            fprintf(file, ",%s_%s[%s]", experiment->measures[m].look.name, statistic_text(shown[s]),
                    experiment->measures[m].look.unit);
        }
    }
    fprintf(file, "\n");
    for (size_t n = 0; n < experiment_run_count(experiment); n++) {
        const experiment_run_t *run = &experiment->runs[n];
        fprintf(file, "%s,%s,%d", run->name, run->flavour, run->lost);
        for (uint32_t m = 0; m < experiment->measure_count; m++) {
            for (size_t s = 0; s < sizeof shown / sizeof shown[0]; s++) {
                write_number(file, tally_value(&run->tallies[m], shown[s]));
            }
        }
        fprintf(file, "\n");
    }
}

/* A line of the table: at these points, those of other sweeps being the first. */
static void write_line(const experiment_t *experiment, const uint32_t *point, FILE *file)
{
    for (uint32_t n = 0; n < experiment->cell_count; n++) {
        const cell_t *cell = &experiment->cells[n];
        fprintf(file, "%s", n > 0u ? "," : "");
        if (cell->value == NULL) {
            fprintf(file, "%s", experiment->sweeps[cell->sweep].points[point[cell->sweep]].name);
            continue;
        }
        value_t value = {.experiment = experiment, .point = point, .own = (double)NAN};
        const double number = experiment_evaluate(&value, cell->value);
        if (isfinite(number)) {
            fprintf(file, "%.5g", number);
        }
    }
    fprintf(file, "\n");
}

static void write_own_table(const experiment_t *experiment, FILE *file)
{
    uint32_t lines = 0;
    uint32_t point[SWEEPS_MAX] = {0};
    for (uint32_t n = 0; n < experiment->cell_count; n++) {
        fprintf(file, "%s%s[%s]", n > 0u ? "," : "", experiment->cells[n].name, experiment->cells[n].unit);
    }
    fprintf(file, "\n");
    for (uint32_t s = 0; s < experiment->sweep_count; s++) {
        lines |= experiment->lines[s] ? UINT32_C(1) << s : 0u;
    }
    do {
        if (experiment_run_at(experiment, point) != NULL) {
            write_line(experiment, point, file);
        }
    } while (experiment_next(experiment, lines, point));
}

void experiment_write_csv(const experiment_t *experiment, FILE *file)
{
    if (experiment->curve != NULL) {
        experiment->curve->write(file);
    } else if (experiment->column_count > 0u) {
        write_traces(experiment, file);
    } else if (experiment->cell_count > 0u) {
        write_own_table(experiment, file);
    } else {
        write_table(experiment, file);
    }
}

/* ---- JSON ---- */

static void key(FILE *file, const char *name)
{
    fprintf(file, ", \"%s\": ", name);
}

static void write_event(const scenario_event_t *event, const char *before, FILE *file)
{
    char text[200] = "";
    for (uint32_t n = 0; n < event->count; n++) {
        const scenario_setting_t *setting = &event->settings[n];
        const size_t used = strlen(text);
        const char *comma = n > 0u ? ", " : "";
        if (setting->row == rig_row_by_name("speed_request")) {
            snprintf(text + used, sizeof text - used, "%s%g r/min", comma, setting->value / RPM);
        } else if (setting->row == rig_row_by_name("plant.load_torque")) {
            snprintf(text + used, sizeof text - used, "%s%g N m", comma, setting->value);
        } else if (setting->row == rig_row_by_name("params.lag_compensation")) {
            snprintf(text + used, sizeof text - used, "%scompensation %s", comma,
                     setting->value > 0.0 ? "on" : "off");
        } else {
            char value[UNITS_TEXT_SIZE];
            snprintf(text + used, sizeof text - used, "%s%s %s", comma, setting->row->name,
                     units_row_text(value, setting->value, setting->row));
        }
    }
    fprintf(file, "%s{\"time\": %g", before, event->time);
    key(file, "text");
    json_text(file, text);
    fputc('}', file);
}

void experiment_write_events(const experiment_t *experiment, FILE *file)
{
    const scenario_t *scenario = experiment->runs[0].scenario;
    fputc('[', file);
    for (uint32_t e = 1; e < scenario->event_count; e++) {
        write_event(&scenario->events[e], e > 1u ? ", " : "", file);
    }
    fputc(']', file);
}

/* Events are included as well, for example a compensation that is switched on. */
static double chosen(const experiment_run_t *run, const table_row_t *row)
{
    double value = scenario_initial(run->scenario, row);
    for (uint32_t e = 1; e < run->scenario->event_count; e++) {
        for (uint32_t n = 0; n < run->scenario->events[e].count; n++) {
            const scenario_setting_t *setting = &run->scenario->events[e].settings[n];
            value = setting->row == row && setting->value != 0.0 ? setting->value : value;
        }
    }
    return value;
}

static void write_choice(const experiment_run_t *run, const char *name, const char *of, FILE *file)
{
    char text[UNITS_TEXT_SIZE];
    const table_row_t *row = rig_row_by_name(of);
    key(file, name);
    json_text(file, units_row_text(text, chosen(run, row), row));
}

static void write_run(const experiment_t *experiment, const experiment_run_t *run, FILE *file)
{
    static const struct {
        const char *name, *row;
    } numbers[] = {{"bandwidth", "params.pll_bandwidth"},
                   {"omega_c", "params.feedforward_cutoff"},
                   {"kp", NULL},
                   {"ki", NULL},
                   {"load", "plant.load_torque"},
                   {"gain", "params.observer_gain"},
                   {"omega_s", "params.observer_emf_cutoff"}};
    double loop[2] = {(double)NAN, (double)NAN};
    size_t next = 0;
    char condition[TEXT_MAX];
    value_t value = {.experiment = experiment, .point = run->point, .own = (double)NAN};
    (void)paper_loop(initial(run, "params.pll_bandwidth"), initial(run, "params.feedforward_cutoff"),
                     &loop[0], &loop[1]);
    (void)experiment_text(&value, experiment->condition, condition, sizeof condition);
    fputs("{\"name\": ", file);
    json_text(file, run->name);
    key(file, "flavour");
    json_text(file, run->flavour);
    for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; n++) {
        key(file, numbers[n].name);
        json_number(file, numbers[n].row != NULL ? initial(run, numbers[n].row) : loop[next++]);
    }
    write_choice(run, "switching", "params.observer_switching", file);
    write_choice(run, "lag", "params.lag_compensation", file);
    key(file, "encoder");
    fputs(initial(run, "params.position_source") == 0.0 ? "true" : "false", file);
    key(file, "lost");
    fputs(run->lost ? "true" : "false", file);
    key(file, "condition");
    json_text(file, condition);
    fputc('}', file);
}

void experiment_write_runs(const experiment_t *experiment, FILE *file)
{
    fputc('[', file);
    for (size_t n = 0; n < experiment_run_count(experiment); n++) {
        fputs(n == 0u ? "\n    " : ",\n    ", file);
        write_run(experiment, &experiment->runs[n], file);
    }
    fputc(']', file);
}
