/* What was run and what came of it, as one JSON object. */
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/json.h"
#include "host_sim/lab/paper_parts.h"

static void key(FILE *file, const char *before, const char *name)
{
    fprintf(file, "%s\"%s\": ", before, name);
}

static void text_of(FILE *file, const char *name, const char *text)
{
    key(file, ", ", name);
    json_text(file, text);
}

static void number_of(FILE *file, const char *name, double number)
{
    key(file, ", ", name);
    json_number(file, number);
}

static void flag_of(FILE *file, const char *name, bool flag)
{
    key(file, ", ", name);
    fputs(flag ? "true" : "false", file);
}

/* ---- what all runs share ---- */

static void write_condition(FILE *file, const char *before, const char *name, double value)
{
    const table_row_t *row = rig_row_by_name(name);
    fputs(before, file);
    fputs("{\"name\": ", file);
    json_text(file, row->name);
    number_of(file, "value", value);
    text_of(file, "unit", row->unit);
    text_of(file, "text", row->text);
    fputc('}', file);
}

/* Of numbers; what is chosen is told by each run. */
static void write_settings(FILE *file, const char *before, const setting_t *settings, size_t count)
{
    for (size_t n = 0; n < count; n++) {
        if (rig_row_by_name(settings[n].row)->kind == SLOT_FLOAT) {
            write_condition(file, before, settings[n].row, settings[n].value);
        }
    }
}

static void write_conditions(FILE *file)
{
    static const char *const plant[] = {"plant.pole_pairs",   "plant.resistance", "plant.inductance_d",
                                        "plant.inductance_q", "plant.dc_voltage", "plant.igbt_voltage",
                                        "plant.diode_voltage"};
    const setting_t machine[] = {
        {"plant.flux_linkage", paper_machine.flux_linkage},
        {"plant.inertia", paper_machine.inertia},
        {"plant.friction_coulomb", paper_machine.friction},
        {"params.current_limit", paper_machine.current_limit},
    };
    const char *before = "[";
    for (size_t n = 0; n < sizeof plant / sizeof plant[0]; n++) {
        write_condition(file, before, plant[n], rig_initial(rig_row_by_name(plant[n])));
        before = ",\n  ";
    }
    for (size_t n = 0; n < sizeof machine / sizeof machine[0]; n++) {
        write_condition(file, before, machine[n].row, machine[n].value);
    }
    write_settings(file, before, paper_drive, paper_drive_count);
    write_settings(file, before, paper_common, paper_common_count);
    fputc(']', file);
}

/* ---- figures ---- */

static void write_event(FILE *file, const char *before, const event_t *event)
{
    char text[40];
    snprintf(text, sizeof text, "%g r/min", event->speed);
    fprintf(file, "%s{\"time\": %g", before, event->time);
    text_of(file, "text", text);
    fputc('}', file);
}

/* Those of its first run: all have the same. */
static void write_events(const paper_t *paper, size_t figure, FILE *file)
{
    fputc('[', file);
    for (size_t n = 0; n < paper->result_count; n++) {
        if (paper_of_figure(&paper->results[n], figure)) {
            const course_t course = paper_course(&paper->results[n].run);
            for (size_t e = 0; e < course.event_count; e++) {
                write_event(file, e == 0 ? "" : ", ", &course.events[e]);
            }
            break;
        }
    }
    fputc(']', file);
}

static void write_run(const result_t *result, FILE *file)
{
    const run_t *run = &result->run;
    double kp = (double)NAN;
    double ki = (double)NAN;
    char condition[640];
    (void)paper_loop(run->bandwidth, run->omega_c, &kp, &ki);
    paper_describe(condition, sizeof condition, run, result->real);
    fputs("{\"name\": ", file);
    json_text(file, run->name);
    text_of(file, "flavour", result->real ? "real" : "ideal");
    number_of(file, "bandwidth", run->bandwidth);
    number_of(file, "omega_c", run->omega_c);
    number_of(file, "kp", kp);
    number_of(file, "ki", ki);
    number_of(file, "load", run->load);
    number_of(file, "gain", run->gain);
    number_of(file, "omega_s", run->omega_s);
    text_of(file, "switching", paper_switching_names[run->switching]);
    text_of(file, "lag", paper_lag_names[run->lag]);
    flag_of(file, "encoder", false);
    flag_of(file, "lost", result->lost);
    text_of(file, "condition", condition);
    fputc('}', file);
}

static void write_runs(const paper_t *paper, size_t figure, FILE *file)
{
    const char *before = "\n    ";
    fputc('[', file);
    for (size_t n = 0; n < paper->result_count; n++) {
        if (paper_of_figure(&paper->results[n], figure)) {
            fputs(before, file);
            write_run(&paper->results[n], file);
            before = ",\n    ";
        }
    }
    fputc(']', file);
}

static void write_figure(const paper_t *paper, size_t figure, FILE *file)
{
    const paper_figure_t *about = &paper->about[figure];
    char csv[40];
    snprintf(csv, sizeof csv, "data/%s.csv", about->id);
    fputs("{\"id\": ", file);
    json_text(file, about->id);
    text_of(file, "title", about->title);
    text_of(file, "claim", about->claim);
    text_of(file, "paper", about->paper);
    text_of(file, "csv", csv);
    key(file, ",\n   ", "events");
    if (paper->files[figure] != NULL) {
        experiment_write_events(paper->files[figure], file);
    } else {
        write_events(paper, figure, file);
    }
    key(file, ",\n   ", "runs");
    if (paper->files[figure] != NULL) {
        experiment_write_runs(paper->files[figure], file);
    } else {
        write_runs(paper, figure, file);
    }
    fputc('}', file);
}

/* ---- rows ---- */

static void write_row(const paper_t *paper, const paper_row_t *row, FILE *file)
{
    fputs("{\"id\": ", file);
    json_text(file, row->id);
    text_of(file, "figure", paper->about[row->figure].id);
    text_of(file, "flavour", row->flavour);
    text_of(file, "claim", row->claim);
    number_of(file, "paper", row->paper);
    number_of(file, "expected", row->expected);
    number_of(file, "ours", row->ours);
    text_of(file, "unit", row->unit);
    number_of(file, "tolerance", row->tolerance);
    flag_of(file, "kind", row->kind);
    flag_of(file, "stopped", row->stopped);
    text_of(file, "verdict", paper_verdict_name(row->verdict));
    text_of(file, "because", row->because);
    text_of(file, "condition", row->condition);
    fputc('}', file);
}

void paper_write_manifest(const paper_t *paper, const char *commit, double seconds, FILE *file)
{
    const char *before = "\n  ";
    fputs("{\"commit\": ", file);
    json_text(file, commit);
    number_of(file, "seed", (double)paper->seed);
    number_of(file, "seconds", seconds);
    fputs(",\n \"flavours\": {", file);
    key(file, "", "ideal");
    json_text(file, "inverter and sensors without error, as the theory assumes; mean voltages over a period");
    text_of(file, "real",
            "2.5 us dead time, delays and drops, compensated; 12-bit ADC, noise 10 mA, offset 30 mA and gain "
            "error 0.2 % on sensor a; mean voltages over a period");
    text_of(file, "formula", "the paper's equations, in double precision; nothing is simulated");
    fputs("},\n \"conditions\": ", file);
    write_conditions(file);
    fputs(",\n \"figures\": [", file);
    for (size_t n = 0; n <= PAPER_OWN; n++) {
        if (paper->wanted[n]) {
            fputs(before, file);
            write_figure(paper, n, file);
            before = ",\n  ";
        }
    }
    fputs("],\n \"rows\": [", file);
    before = "\n  ";
    for (size_t n = 0; n < paper->row_count; n++) {
        fputs(before, file);
        write_row(paper, &paper->rows[n], file);
        before = ",\n  ";
    }
    fputs("]}\n", file);
}
