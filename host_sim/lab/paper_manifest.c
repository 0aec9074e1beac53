/* The runs and their results, as one JSON object. */
#include <math.h>
#include <stdio.h>

#include "host_sim/lab/json.h"
#include "host_sim/lab/paper_drive.h"
#include "host_sim/lab/paper_parts.h"
#include "host_sim/lab/paper_theory.h"

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

/* ---- the settings that all runs have in common ---- */

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

/* Settings with numbers only; each run states its choices itself. */
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
        write_condition(file, before, plant[n], rig_initial_named(plant[n]));
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
        key(file, ",\n   ", "runs");
        experiment_write_runs(paper->files[figure], file);
    } else {
        fputs("[],\n   \"runs\": []", file);
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
