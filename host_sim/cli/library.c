/* The scenarios that come with the program, and `lagless scenarios`. */
#include "host_sim/cli/library.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/board.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/cli/streams.h"
#include "host_sim/lab/boards.h"
#include "host_sim/lab/inputs.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/motor.h"
#include "host_sim/lab/names.h"
#include "host_sim/lab/toml_reader.h"

static const char *library(void)
{
    const char *folder = getenv("LAGLESS_SCENARIOS");
    return folder != NULL && folder[0] != '\0' ? folder : LAGLESS_SCENARIOS;
}

static int is_scenario(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name);
    return length > 5 && strcmp(entry->d_name + length - 5, ".toml") == 0;
}

/* "load_step" means the library's file; a text with a slash or an ending is a path. */
static bool scenario_path(char path[PATH_SIZE], const char *command, const char *name)
{
    char file[PATH_SIZE];
    if (strchr(name, '/') != NULL || strchr(name, '.') != NULL || access(name, F_OK) == 0) {
        return snprintf(path, PATH_SIZE, "%s", name) < PATH_SIZE;
    }
    snprintf(file, sizeof file, "%.200s.toml", name);
    if (!output_path(path, library(), file)) {
        return false;
    }
    if (access(path, F_OK) == 0) {
        return true;
    }
    names_search_t search = names_search(name);
    struct dirent **entries = NULL;
    const int count = scandir(library(), &entries, is_scenario, alphasort);
    for (int n = 0; n < count; n++) {
        entries[n]->d_name[strlen(entries[n]->d_name) - 5] = '\0';
        names_consider(&search, entries[n]->d_name);
        free(entries[n]);
    }
    free(entries);
    fprintf(stderr, "lagless %s: %s: neither a file nor a scenario of the library", command, name);
    output_suggest(stderr, names_found(&search));
    fprintf(stderr, names_found(&search) == NULL ? "; `lagless scenarios` lists them\n" : "\n");
    return false;
}

static void say(const char *command, const char *with, const scenario_error_t *error)
{
    char text[1200];
    streams_at(error->file, error->place.line, error->place.column, error->name);
    fprintf(stderr, "lagless %s: %s%s\n", command, with, scenario_error_text(error, text, sizeof text));
}

void library_say(const char *command, const scenario_error_t *error)
{
    say(command, "", error);
}

void library_hand_over(const char *command, const scenario_error_t *error, const char *text, size_t octets)
{
    char why[BOARD_WHY_SIZE];
    if (error->board[0] != '\0' && !board_of_scenario(error->board, text, octets, why) && why[0] != '\0') {
        fprintf(stderr, "lagless %s: %s: board %s: %s\n", command, error->file, error->board, why);
    }
}

static scenario_t *read_stdin(const char *command, scenario_error_t *error)
{
    char *text = malloc(TOML_OCTETS_MAX + 1u); /* one more octet shows that it is too long */
    const size_t octets = text != NULL ? fread(text, 1, TOML_OCTETS_MAX + 1u, stdin) : 0u;
    inputs_note_descriptor(STDIN_FILENO);
    scenario_t *scenario = scenario_read_text_to_mend("stdin", text != NULL ? text : "", octets, error);
    if (scenario == NULL) {
        library_hand_over(command, error, text, octets);
    }
    free(text);
    return scenario;
}

static bool override(scenario_t *scenario, const char *command, const arguments_scenario_t *of)
{
    scenario_error_t error;
    for (size_t n = 0; n < of->set_count; n++) {
        if (!scenario_override(scenario, of->sets[n], &error)) {
            fprintf(stderr, "lagless %s: --set %s: %s\n", command, of->sets[n], error.message);
            return false;
        }
    }
    if (!scenario_check(scenario, &error)) {
        say(command, of->set_count > 0u ? "with --set: " : "", &error);
        return false;
    }
    return true;
}

void library_say_motor(const char *command, const char *path)
{
    motor_sheet_t sheet;
    scenario_error_t ignored;
    if (!motor_read_file(path, &sheet, &ignored) ||
        sheet.whole.line > 1u) { /* a [motor] follows in the file */
        return;
    }
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (sheet.has[n]) {
            fprintf(stderr,
                    "lagless %s: %s is a motor: `lagless tune %s --write my.toml` writes a scenario for it\n",
                    command, path, path);
            return;
        }
    }
}

scenario_t *library_read(const char *command, const arguments_scenario_t *of)
{
    char path[PATH_SIZE];
    scenario_error_t error;
    const bool from_stdin = strcmp(of->scenario, "-") == 0;
    if (!from_stdin && !scenario_path(path, command, of->scenario)) {
        return NULL;
    }
    scenario_t *scenario = from_stdin ? read_stdin(command, &error) : scenario_read_to_mend(path, &error);
    if (scenario == NULL && !from_stdin) {
        library_hand_over(command, &error, NULL, 0u);
    }
    if (scenario == NULL) {
        library_say(command, &error);
        if (!from_stdin) {
            library_say_motor(command, path);
        }
        return NULL;
    }
    if (!override(scenario, command, of)) {
        scenario_free(scenario);
        return NULL;
    }
    char hurried[BOARDS_TEXT_SIZE];
    if (boards_present() != NULL && boards_hurried(hurried, boards_present())[0] != '\0') {
        fprintf(stderr, "warning: %s\n", hurried);
    }
    if (scenario->unsuited[0] != '\0') {
        fprintf(stderr, "warning: %s\n", scenario->unsuited);
    }
    return scenario;
}

int command_scenarios(int argc, char **argv)
{
    bool json;
    if (!arguments_json(argc, argv, "Lists the scenarios that `lagless run` accepts by name.", &json)) {
        return EXIT_USAGE;
    }
    struct dirent **entries = NULL;
    const int count = scandir(library(), &entries, is_scenario, alphasort);
    if (count < 0) {
        fprintf(stderr,
                "lagless scenarios: cannot read the folder %s; LAGLESS_SCENARIOS may name another one\n",
                library());
        return EXIT_INTERNAL;
    }
    int exit_code = EXIT_DONE;
    printf(json ? "{\"scenarios\": [" : "");
    for (int n = 0; n < count; n++) {
        char path[PATH_SIZE];
        char text[1200];
        scenario_error_t error;
        scenario_t *scenario =
            output_path(path, library(), entries[n]->d_name) ? scenario_read(path, &error) : NULL;
        entries[n]->d_name[strlen(entries[n]->d_name) - 5] = '\0';
        if (scenario == NULL) {
            fprintf(stderr, "lagless scenarios: %s\n", scenario_error_text(&error, text, sizeof text));
            exit_code = EXIT_USAGE;
        } else if (json) {
            printf("%s\n  {\"name\": \"%s\", \"duration_s\": %.9g, \"title\": ", n == 0 ? "" : ",",
                   entries[n]->d_name, scenario->duration);
            json_text(stdout, scenario->title);
            printf("}");
        } else {
            printf("%-36s %6.2f s  %s\n", entries[n]->d_name, scenario->duration, scenario->title);
        }
        scenario_free(scenario);
        free(entries[n]);
    }
    free(entries);
    printf(json ? "\n]}\n" : "");
    return exit_code;
}
