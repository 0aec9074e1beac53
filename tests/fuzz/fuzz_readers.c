/* The readers of text with damaged files: scenarios, motors, experiments, values with units, --set. A
 * changed file is either read or refused with one line that contains a name; it has no other effect (the
 * sanitizers check this). usage: fuzz_readers SEED SECONDS FOLDER... */
#include <dirent.h>

#include "fuzz.h"
#include "host_sim/lab/experiment.h"
#include "host_sim/lab/motor.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/units.h"

static fuzz_file_t files[FUZZ_FILES];
static uint32_t file_count;

static void load(const char *folder)
{
    DIR *directory = opendir(folder);
    fuzz_expect(directory != NULL, folder);
    for (struct dirent *entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        char path[1024];
        if (strstr(entry->d_name, ".toml") == NULL || file_count == FUZZ_FILES) {
            continue;
        }
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        FILE *stream = fopen(path, "rb");
        files[file_count].text = malloc(FUZZ_OCTETS);
        fuzz_expect(stream != NULL && files[file_count].text != NULL, path);
        files[file_count].octets = fread(files[file_count].text, 1, FUZZ_OCTETS, stream);
        fclose(stream);
        file_count++;
    }
    closedir(directory);
}

/* A refusal is one line that contains a name. */
static void judge(const scenario_error_t *error)
{
    char text[1200];
    scenario_error_text(error, text, sizeof text);
    fuzz_expect(error->message[0] != '\0' && error->name[0] != '\0', "a refusal without name or message");
    fuzz_expect(strchr(text, '\n') == NULL, "a refusal of several lines");
}

static void read_scenario(const char *text, size_t octets)
{
    scenario_error_t error;
    char assignment[80];
    scenario_t *scenario = scenario_read_text_to_mend("fuzz", text, octets, &error);
    if (scenario == NULL) {
        judge(&error);
        return;
    }
    const size_t at = fuzz_below((uint32_t)octets);
    snprintf(assignment, sizeof assignment, "%.*s", (int)(octets - at < 79u ? octets - at : 79u), text + at);
    if (!scenario_override(scenario, assignment, &error)) {
        fuzz_expect(error.message[0] != '\0', "an override that is refused without a message");
    }
    if (!scenario_check(scenario, &error)) {
        judge(&error);
    }
    scenario_free(scenario);
}

static void read_file(const char *text, size_t octets)
{
    static const char path[] = "fuzz_readers.toml";
    scenario_error_t error;
    motor_sheet_t sheet;
    motor_t motor;
    FILE *file = fopen(path, "wb");
    fuzz_expect(file != NULL && fwrite(text, 1, octets, file) == octets && fclose(file) == 0, "cannot write");
    if (!motor_read_file(path, &sheet, &error) || !motor_make(&sheet, &motor, &error)) {
        judge(&error);
    }
    experiment_t *experiment = experiment_read(path, &error);
    if (experiment == NULL) {
        judge(&error);
    }
    experiment_free(experiment);
}

static void read_value(const char *text, size_t octets)
{
    static const char *const units[] = {"-", "s",  "rad/s", UNITS_SPEED, "A",      "V",    "ohm",
                                        "H", "Wb", "N m",   "kg m^2",    "V/krpm", "degC", "x"};
    char part[64];
    double value = 0.0;
    units_error_t why;
    const size_t at = fuzz_below((uint32_t)octets);
    snprintf(part, sizeof part, "%.*s", (int)(octets - at < 63u ? octets - at : 63u), text + at);
    if (!units_read(part, units[fuzz_below(sizeof units / sizeof units[0])], &value, &why)) {
        fuzz_expect(why.text[0] != '\0', "a value that is refused without a message");
    }
}

static void turn(void)
{
    static char text[FUZZ_OCTETS + 1024u];
    const fuzz_file_t *file = &files[fuzz_below(file_count)];
    const fuzz_file_t *other = &files[fuzz_below(file_count)];
    memcpy(text, file->text, file->octets);
    const size_t octets = fuzz_mutate(text, file->octets, sizeof text, other->text, other->octets);
    read_scenario(text, octets);
    if (fuzz_below(8u) == 0u) { /* less often than the others, since a file on the disk takes time */
        read_file(text, octets);
    }
    read_value(text, octets);
}

int main(int argc, char **argv)
{
    for (int n = 3; n < argc; n++) {
        load(argv[n]);
    }
    fuzz_expect(file_count > 0u, "no files");
    const int code = fuzz_run(argc, argv, turn);
    for (uint32_t n = 0; n < file_count; n++) {
        free(files[n].text);
    }
    return code;
}
