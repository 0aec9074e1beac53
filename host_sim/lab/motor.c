#include "host_sim/lab/motor.h"

#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/lab/names.h"
#include "host_sim/lab/scenario_parts.h"

#define PI     3.14159265358979323846
#define KRPM   (1000.0 * PI / 30.0) /* [rad/s] */
#define SQRT_2 1.4142135623730951
#define SQRT_3 1.7320508075688772
#define BLOCK_MEAN                                                                                           \
    (3.0 * SQRT_3 / PI) /* [-] of the EMF between two lines over 60 degrees, per peak of a phase */

#define FLUX_AGREES                                                                                          \
    0.05 /* [-] largest difference between two values of psi_f that count as the same: data sheets round     \
            them */
#define TORQUE_MORE    1.1  /* [-] rated torque over Kt I, which no motor without reluctance torque exceeds */
#define TORQUE_LESS    0.6  /* [-] below this ratio more than the iron loss at speed is missing */
#define FRICTION_SHARE 0.01 /* [-] of the rated torque, where none is given */
#define SPEED_UP_TIME  0.2  /* [s] to the top speed at rated torque, where no inertia is given */
#define LINK_SHARE     0.5  /* [-] of the link that a phase gets at the top speed */
#define SPEED_REACHED  0.9  /* [-] of the speed at which the rated current needs that voltage */
#define SPEED_USUAL    3000.0 /* [r/min] assumed rated speed if neither rated speed nor link is given */

static const scenario_place_t nowhere = {0u, 0u};

static const struct {
    const char *name;
    motor_quantity_t quantity;
    double factor, min, max;
    const char *unit, *text;
} keys[MOTOR_KEY_COUNT] = {
#define KEY_ROW(key, quantity, factor, unit, min, max, text) {#key, quantity, factor, min, max, unit, text},
    MOTOR_KEYS(KEY_ROW)
#undef KEY_ROW
};

const char *motor_key_name(motor_key_t key)
{
    return keys[key].name;
}

const char *motor_key_unit(motor_key_t key)
{
    return keys[key].unit;
}

/* The kind of value of the key: "3 Arms" is a value of a key for rms values only. */
static const char *read_as(motor_key_t key)
{
    const bool rms = strstr(keys[key].name, "_rms") != NULL;
    const bool peak = strstr(keys[key].name, "_peak") != NULL;
    return rms || peak ? units_variety(keys[key].unit, rms ? "rms" : "peak") : keys[key].unit;
}

const char *motor_key_text(motor_key_t key)
{
    return keys[key].text;
}

/* ---- the keys as they are written ---- */

static bool find_key(const char *name, motor_key_t *key)
{
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (strcmp(keys[n].name, name) == 0) {
            *key = (motor_key_t)n;
            return true;
        }
    }
    return false;
}

/* The inductances of both axes belong to one quantity: `inductance` sets both. */
static motor_quantity_t family(motor_key_t key)
{
    return keys[key].quantity == MOTOR_INDUCTANCE_D ? MOTOR_INDUCTANCE_Q : keys[key].quantity;
}

static void forget_family(motor_sheet_t *sheet, motor_quantity_t quantity)
{
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        sheet->has[n] = sheet->has[n] && family((motor_key_t)n) != quantity;
    }
}

/* The key whose name with the unit behind it is this name, as in rated_speed_rpm; MOTOR_KEY_COUNT if there is
 * none. */
static size_t key_before_unit(const char *name)
{
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        const size_t length = strlen(keys[n].name);
        char one[64];
        double value;
        units_error_t why;
        if (strncmp(name, keys[n].name, length) == 0 && name[length] == '_') {
            snprintf(one, sizeof one, "1 %s", name + length + 1u);
            if (units_read(one, read_as((motor_key_t)n), &value, &why)) {
                return n;
            }
        }
    }
    return MOTOR_KEY_COUNT;
}

static bool unknown_key(const char *name, scenario_place_t place, scenario_error_t *error)
{
    const size_t bare = key_before_unit(name);
    if (bare != MOTOR_KEY_COUNT) {
        return scenario_fail(error, place, name,
                             "a motor has no such key; the unit belongs to the value: %s = \"NUMBER %s\"",
                             keys[bare].name, name + strlen(keys[bare].name) + 1u);
    }
    names_search_t search = names_search(name);
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        names_consider(&search, keys[n].name);
    }
    const char *near = names_found(&search);
    return scenario_fail(error, place, name, "a motor has no such key%s%s; docs/motors.md lists them",
                         near != NULL ? "; nearest: " : "", near != NULL ? near : "");
}

static bool take_value(motor_sheet_t *sheet, motor_key_t key, double value, scenario_place_t place,
                       scenario_error_t *error)
{
    if (!scenario_in_range(value, keys[key].min, keys[key].max, keys[key].unit, place, keys[key].name,
                           error)) {
        return false;
    }
    sheet->has[key] = true;
    sheet->value[key] = value;
    sheet->place[key] = place;
    return true;
}

static bool take_text(const toml_entry_t *entry, char *to, size_t size, scenario_error_t *error)
{
    const scenario_place_t place = {entry->line, entry->column};
    if (entry->type != TOML_TEXT || strlen(entry->text) != entry->text_octets) {
        return scenario_fail(error, place, entry->key, "it is %s; accepted: text",
                             toml_type_text(entry->type));
    }
    if (entry->text_octets >= size) {
        return scenario_fail(error, place, entry->key, "it is too long; accepted: up to %zu octets",
                             size - 1u);
    }
    snprintf(to, size, "%s", entry->text);
    for (char *c = to; *c != '\0'; c++) {
        *c = (unsigned char)*c < 0x20u || *c == 0x7F ? ' ' : *c;
    }
    return true;
}

static bool take_entry(const toml_entry_t *entry, motor_key_t key, motor_sheet_t *sheet,
                       scenario_error_t *error)
{
    const scenario_place_t place = {entry->line, entry->column};
    double value = entry->number;
    units_error_t why;
    if (entry->type == TOML_TEXT) {
        if (!units_read(entry->text, read_as(key), &value, &why)) {
            return scenario_fail(error, place, entry->key, "%s", why.text);
        }
    } else if (entry->type != TOML_INTEGER && entry->type != TOML_FLOAT) {
        return scenario_fail(error, place, entry->key, "it is %s; accepted: a number, or text with a unit",
                             toml_type_text(entry->type));
    }
    return take_value(sheet, key, value, place, error);
}

static bool is_among(const char *name, const char *names)
{
    const size_t length = strlen(name);
    for (const char *at = names; *at != '\0';) {
        const size_t size = strcspn(at, "|");
        if (size == length && strncmp(at, name, size) == 0) {
            return true;
        }
        at += size + (at[size] == '|' ? 1u : 0u);
    }
    return false;
}

bool motor_read_table(const toml_file_t *file, const toml_entry_t *table, const char *others,
                      motor_sheet_t *sheet, scenario_error_t *error)
{
    const uint32_t at = (uint32_t)(table - file->entries);
    motor_sheet_t given = {.name = ""};
    for (uint32_t n = at + 1u; n < table->end; n = file->entries[n].end) {
        const toml_entry_t *entry = &file->entries[n];
        motor_key_t key;
        if (is_among(entry->key, others) || strcmp(entry->key, "schema") == 0) {
            continue;
        }
        if (strcmp(entry->key, "title") == 0) {
            if (!take_text(entry, sheet->title, sizeof sheet->title, error)) {
                return false;
            }
        } else if (strcmp(entry->key, "source") == 0) {
            if (!take_text(entry, sheet->source, sizeof sheet->source, error)) {
                return false;
            }
        } else if (!find_key(entry->key, &key)) {
            return unknown_key(entry->key, (scenario_place_t){entry->line, entry->column}, error);
        } else if (!take_entry(entry, key, &given, error)) {
            return false;
        }
    }
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (given.has[n]) {
            forget_family(sheet, family((motor_key_t)n));
        }
    }
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (given.has[n]) {
            sheet->has[n] = true;
            sheet->value[n] = given.value[n];
            sheet->place[n] = given.place[n];
        }
    }
    sheet->whole = (scenario_place_t){table->line, table->column};
    return true;
}

static bool in_file(bool good, const char *path, scenario_error_t *error)
{
    if (!good) {
        snprintf(error->file, sizeof error->file, "%s", path);
    }
    return good;
}

bool motor_read_file(const char *path, motor_sheet_t *sheet, scenario_error_t *error)
{
    toml_error_t why;
    toml_file_t *file = toml_read(path, &why);
    *sheet = (motor_sheet_t){.name = ""};
    scenario_file_name(path, sheet->name, sizeof sheet->name);
    if (file == NULL) {
        return in_file(
            scenario_fail(error, (scenario_place_t){why.line, why.column}, why.name, "%s", why.message), path,
            error);
    }
    /* A file with a [motor] section, like a scenario, is accepted as well. */
    const toml_entry_t *table = &file->entries[0];
    const char *others = "";
    for (uint32_t n = 1; n < file->entries[0].end; n = file->entries[n].end) {
        if (strcmp(file->entries[n].key, "motor") == 0 && file->entries[n].type == TOML_TABLE) {
            table = &file->entries[n];
            others = "name|file";
        }
    }
    const bool good = in_file(motor_read_table(file, table, others, sheet, error), path, error);
    toml_free(file);
    return good;
}

static void append(char *text, size_t size, const char *what)
{
    const size_t used = strlen(text);
    snprintf(text + used, size - used, "%s%s", used > 0u ? ", " : "", what);
}

/* ---- the library ---- */

const char *motor_library_folder(void)
{
    const char *folder = getenv("LAGLESS_MOTORS");
    return folder != NULL && folder[0] != '\0' ? folder : LAGLESS_MOTORS;
}

static int is_motor(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name);
    return length > 5u && strcmp(entry->d_name + length - 5u, ".toml") == 0;
}

int motor_library(char ***names)
{
    struct dirent **entries = NULL;
    const int count = scandir(motor_library_folder(), &entries, is_motor, alphasort);
    *names = count > 0 ? calloc((size_t)count, sizeof **names) : NULL;
    for (int n = 0; n < count; n++) {
        entries[n]->d_name[strlen(entries[n]->d_name) - 5u] = '\0';
        if (*names != NULL) {
            (*names)[n] = strdup(entries[n]->d_name);
        }
        free(entries[n]);
    }
    free(entries);
    return count > 0 && *names == NULL ? -1 : count;
}

bool motor_read_library(const char *name, motor_sheet_t *sheet, scenario_error_t *error)
{
    char path[4096];
    const int length = snprintf(path, sizeof path, "%s/%s.toml", motor_library_folder(), name);
    if (name[0] != '\0' && strchr(name, '/') == NULL && length > 0 && (size_t)length < sizeof path &&
        access(path, F_OK) == 0) {
        return motor_read_file(path, sheet, error);
    }
    names_search_t search = names_search(name);
    char part[256] = ""; /* motors whose names contain the given name */
    char **names;
    const int count = motor_library(&names);
    for (int n = 0; n < count; n++) {
        names_consider(&search, names[n]);
        if (name[0] != '\0' && strcasestr(names[n], name) != NULL) {
            append(part, sizeof part, names[n]);
        }
        free(names[n]);
    }
    free(names);
    const char *near = part[0] != '\0' ? part : names_found(&search);
    return in_file(scenario_fail(error, nowhere, name,
                                 "no motor of the library%s%s; `lagless motors` lists them",
                                 near != NULL ? "; nearest: " : "", near != NULL ? near : ""),
                   "motor", error);
}

bool motor_read(const char *what, motor_sheet_t *sheet, scenario_error_t *error)
{
    const size_t length = strlen(what);
    const bool path = strchr(what, '/') != NULL || (length > 5u && strcmp(what + length - 5u, ".toml") == 0);
    return path ? motor_read_file(what, sheet, error) : motor_read_library(what, sheet, error);
}

bool motor_override(motor_sheet_t *sheet, const char *assignment, scenario_error_t *error)
{
    char name[NAMES_LENGTH_MAX + 1u];
    const char *equals = strchr(assignment, '=');
    motor_key_t key;
    units_error_t why;
    units_error_t ignored;
    double value = 0.0;
    snprintf(error->file, sizeof error->file, "--set %.200s", assignment);
    if (equals == NULL || equals == assignment || (size_t)(equals - assignment) >= sizeof name) {
        return scenario_fail(error, nowhere, "--set", "accepted: KEY=VALUE, such as inertia=\"2 kg cm^2\"");
    }
    snprintf(name, sizeof name, "%.*s", (int)(equals - assignment), assignment);
    if (!find_key(name, &key)) {
        return unknown_key(name, nowhere, error);
    }
    if (!units_read(equals + 1, "-", &value, &ignored) &&
        !units_read(equals + 1, read_as(key), &value, &why)) {
        return scenario_fail(error, nowhere, name, "%s", why.text);
    }
    const motor_quantity_t quantity = family(key);
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        /* L_d and L_q do not exclude each other */
        const bool axis = quantity == MOTOR_INDUCTANCE_Q &&
                          (key == MOTOR_KEY_inductance_d || key == MOTOR_KEY_inductance_q) &&
                          (n == MOTOR_KEY_inductance_d || n == MOTOR_KEY_inductance_q);
        sheet->has[n] = sheet->has[n] && (family((motor_key_t)n) != quantity || axis);
    }
    return take_value(sheet, key, value, nowhere, error);
}

/* ---- interpretation ---- */

static void note(motor_t *motor, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void note(motor_t *motor, const char *format, ...)
{
    if (motor->note_count == MOTOR_NOTES) {
        return;
    }
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(motor->notes[motor->note_count++], MOTOR_NOTE_SIZE, format, arguments);
    va_end(arguments);
}

/* psi_f [Wb] that a key of the flux means. */
static double flux_of(motor_key_t key, double value, double pole_pairs)
{
    switch (key) {
    case MOTOR_KEY_flux_linkage:
        return value;
    case MOTOR_KEY_flux_volts_per_hertz:
        return value / (2.0 * PI);
    case MOTOR_KEY_ke_line_peak:
        return value / (SQRT_3 * KRPM * pole_pairs);
    case MOTOR_KEY_ke_line_rms:
        return SQRT_2 * value / (SQRT_3 * KRPM * pole_pairs);
    case MOTOR_KEY_ke_phase_peak:
        return value / (KRPM * pole_pairs);
    case MOTOR_KEY_ke_phase_rms:
        return SQRT_2 * value / (KRPM * pole_pairs);
    case MOTOR_KEY_kt_rms:
        return value / (1.5 * SQRT_2 * pole_pairs);
    case MOTOR_KEY_kt_peak:
        return value / (1.5 * pole_pairs);
    case MOTOR_KEY_kt_block:
        return value / (BLOCK_MEAN * pole_pairs);
    default: /* MOTOR_KEY_speed_constant_block */
        return 30.0 / (PI * value) / (BLOCK_MEAN * pole_pairs);
    }
}

/* The names of a quantity, "resistance or resistance_line". */
static void name_family(motor_quantity_t quantity, char *to, size_t size)
{
    to[0] = '\0';
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (keys[n].quantity == quantity) {
            const size_t used = strlen(to);
            snprintf(to + used, size - used, "%s%s", used > 0u ? " or " : "", keys[n].name);
        }
    }
}

/* Every quantity except the flux has only one key. */
static bool said_once(const motor_sheet_t *sheet, scenario_error_t *error)
{
    const bool both = sheet->has[MOTOR_KEY_inductance] || sheet->has[MOTOR_KEY_inductance_line];
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        for (size_t m = 0; m < n; m++) {
            const bool same = keys[n].quantity == keys[m].quantity ||
                              (both && family((motor_key_t)n) == family((motor_key_t)m));
            if (sheet->has[n] && sheet->has[m] && same && keys[n].quantity != MOTOR_FLUX) {
                return scenario_fail(error, sheet->place[n], keys[n].name,
                                     "%s gives the same quantity; accepted: one of the two", keys[m].name);
            }
        }
    }
    return true;
}

static bool all_known(const motor_t *motor, const motor_sheet_t *sheet, scenario_error_t *error)
{
    static const motor_quantity_t needed[] = {MOTOR_POLE_PAIRS, MOTOR_RESISTANCE, MOTOR_INDUCTANCE_D,
                                              MOTOR_INDUCTANCE_Q, MOTOR_CURRENT};
    char missing[480] = "";
    for (size_t n = 0; n < sizeof needed / sizeof needed[0]; n++) {
        char names[160];
        if (motor->has[needed[n]]) {
            continue;
        }
        name_family(needed[n], names, sizeof names);
        const bool axis_too = motor->has[MOTOR_INDUCTANCE_D] || motor->has[MOTOR_INDUCTANCE_Q];
        if (needed[n] == MOTOR_INDUCTANCE_D) {
            append(missing, sizeof missing,
                   axis_too ? "inductance_d" : "inductance or inductance_line (or inductance_d and _q)");
        } else if (needed[n] == MOTOR_INDUCTANCE_Q) {
            if (axis_too) {
                append(missing, sizeof missing, "inductance_q");
            }
        } else {
            append(missing, sizeof missing, names);
        }
    }
    bool flux = false;
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        flux = flux || (sheet->has[n] && keys[n].quantity == MOTOR_FLUX);
    }
    if (!flux) {
        append(missing, sizeof missing, "flux_linkage, a ke_... or a kt_...");
    }
    return missing[0] == '\0' || scenario_fail(error, sheet->whole, "motor", "missing: %s", missing);
}

/* The first given key is used; the others are compared with it. */
static void make_flux(const motor_sheet_t *sheet, motor_t *motor)
{
    const double p = motor->value[MOTOR_POLE_PAIRS];
    motor_key_t first = MOTOR_KEY_COUNT;
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (!sheet->has[n] || keys[n].quantity != MOTOR_FLUX) {
            continue;
        }
        const double flux = flux_of((motor_key_t)n, sheet->value[n], p);
        if (first == MOTOR_KEY_COUNT) {
            first = (motor_key_t)n;
            motor->value[MOTOR_FLUX] = flux;
            motor->has[MOTOR_FLUX] = true;
            continue;
        }
        const double off = flux / motor->value[MOTOR_FLUX] - 1.0;
        if (fabs(off) > FLUX_AGREES) {
            char a[UNITS_TEXT_SIZE];
            char b[UNITS_TEXT_SIZE];
            note(motor,
                 "%s = %s is a flux linkage of %.4g mWb, %s = %s one of %.4g mWb, %.0f %% %s; %s is used",
                 keys[first].name, units_text(a, sheet->value[first], keys[first].unit),
                 1e3 * motor->value[MOTOR_FLUX], keys[n].name, units_text(b, sheet->value[n], keys[n].unit),
                 1e3 * flux, fabs(100.0 * off), off > 0.0 ? "more" : "less", keys[first].name);
        }
    }
}

static void make_torque(motor_t *motor)
{
    const double able = motor_torque_constant(motor) * motor->value[MOTOR_CURRENT];
    if (!motor->has[MOTOR_TORQUE]) {
        motor->value[MOTOR_TORQUE] = able;
        return;
    }
    const double share = motor->value[MOTOR_TORQUE] / able;
    if (share > TORQUE_MORE || share < TORQUE_LESS) {
        char given[UNITS_TEXT_SIZE];
        char made[UNITS_TEXT_SIZE];
        note(motor, "rated_torque = %s, but the rated current, %.4g A peak, makes 1.5 p psi_f I = %s: %s",
             units_text(given, motor->value[MOTOR_TORQUE], "N m"), motor->value[MOTOR_CURRENT],
             units_text(made, able, "N m"),
             share > 1.0
                 ? "peak and rms values may be confused, or the rating includes reluctance torque, which the "
                   "drive does not use"
                 : "peak and rms values may be confused, or the rating is for a high speed with iron losses");
    }
}

/* Rated speed; if it is not given, 0.9 of the speed at which (omega L_q I)^2 + (omega psi_f + R I)^2 is the
 * square of the voltage [rad/s]. */
static double top_speed(const motor_t *motor)
{
    const double *value = motor->value;
    if (motor->has[MOTOR_SPEED]) {
        return value[MOTOR_SPEED];
    }
    const double u = LINK_SHARE * value[MOTOR_LINK];
    const double drop = value[MOTOR_RESISTANCE] * value[MOTOR_CURRENT];
    if (!motor->has[MOTOR_LINK] || u <= drop) {
        return SPEED_USUAL * PI / 30.0;
    }
    const double across = value[MOTOR_INDUCTANCE_Q] * value[MOTOR_CURRENT];
    const double flux = value[MOTOR_FLUX];
    const double a = across * across + flux * flux;
    const double b = flux * drop;
    const double omega = (sqrt(b * b + a * (u * u - drop * drop)) - b) / a;
    return SPEED_REACHED * omega / value[MOTOR_POLE_PAIRS];
}

/* Values that the plant needs and data sheets do not contain. An assumed inertia is that of a rotor with its
 * machine: too large a value is much less harmful than too small a one (docs/motors.md). */
static void make_shaft(motor_t *motor)
{
    char text[UNITS_TEXT_SIZE];
    const double torque = motor->value[MOTOR_TORQUE];
    if (!motor->has[MOTOR_INERTIA]) {
        const double speed = top_speed(motor);
        motor->value[MOTOR_INERTIA] = torque * SPEED_UP_TIME / speed;
        note(motor,
             "inertia is not given: %s is assumed, with which rated torque reaches %.0f r/min in %.2g s; "
             "the drive learns its own",
             units_text(text, motor->value[MOTOR_INERTIA], "kg m^2"), speed * 30.0 / PI, SPEED_UP_TIME);
    }
    if (!motor->has[MOTOR_COULOMB] && !motor->has[MOTOR_VISCOUS]) {
        motor->value[MOTOR_COULOMB] = FRICTION_SHARE * torque;
    }
}

static double in_si(const motor_sheet_t *sheet, size_t key)
{
    return keys[key].factor * sheet->value[key];
}

/* The value of a quantity by the last of its keys that the sheet has [SI]; NAN: none. */
static double given(const motor_sheet_t *sheet, motor_quantity_t quantity)
{
    double value = (double)NAN;
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (sheet->has[n] && keys[n].quantity == quantity) {
            value = in_si(sheet, n);
        }
    }
    return value;
}

double motor_given(const motor_sheet_t *sheet, motor_quantity_t quantity)
{
    const double pole_pairs = given(sheet, MOTOR_POLE_PAIRS);
    for (size_t n = 0; quantity == MOTOR_FLUX && n < MOTOR_KEY_COUNT; n++) {
        if (sheet->has[n] && keys[n].quantity == MOTOR_FLUX) {
            return flux_of((motor_key_t)n, sheet->value[n], pole_pairs);
        }
    }
    return quantity == MOTOR_FLUX ? (double)NAN : given(sheet, quantity);
}

bool motor_make(const motor_sheet_t *sheet, motor_t *motor, scenario_error_t *error)
{
    *motor = (motor_t){.note_count = 0u};
    snprintf(motor->name, sizeof motor->name, "%s", sheet->name);
    error->file[0] = '\0';
    if (!said_once(sheet, error)) {
        return false;
    }
    for (size_t n = 0; n < MOTOR_KEY_COUNT; n++) {
        if (sheet->has[n] && keys[n].quantity != MOTOR_FLUX) {
            motor->has[keys[n].quantity] = true;
            motor->value[keys[n].quantity] = in_si(sheet, n);
        }
    }
    if (sheet->has[MOTOR_KEY_inductance] || sheet->has[MOTOR_KEY_inductance_line]) {
        motor->has[MOTOR_INDUCTANCE_D] = true;
        motor->value[MOTOR_INDUCTANCE_D] = motor->value[MOTOR_INDUCTANCE_Q];
    }
    if (!all_known(motor, sheet, error)) {
        return false;
    }
    const double p = motor->value[MOTOR_POLE_PAIRS];
    if (p != floor(p)) {
        const motor_key_t key = sheet->has[MOTOR_KEY_poles] ? MOTOR_KEY_poles : MOTOR_KEY_pole_pairs;
        return scenario_fail(error, sheet->place[key], keys[key].name, "%g; accepted: %s", sheet->value[key],
                             key == MOTOR_KEY_poles ? "an even number" : "a whole number");
    }
    make_flux(sheet, motor);
    make_torque(motor);
    make_shaft(motor);
    return true;
}

double motor_torque_constant(const motor_t *motor)
{
    return 1.5 * motor->value[MOTOR_POLE_PAIRS] * motor->value[MOTOR_FLUX];
}

double motor_inertia(const motor_t *motor)
{
    return motor->value[MOTOR_INERTIA] + motor->value[MOTOR_LOAD_INERTIA];
}
