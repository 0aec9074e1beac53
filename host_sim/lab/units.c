#include "host_sim/lab/units.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI_180 0.017453292519943295 /* [rad/deg] */
#define PI_30  0.10471975511965977  /* [rad/s per r/min] */
#define TWO_PI 6.283185307179586    /* [rad] */
#define DIGITS 400u                 /* [-] longest number that is read */

typedef enum {
    SILENT, /* understood */
    NAMED,  /* and named in error messages */
    WRITTEN /* and used by units_text */
} role_t;

/* One accepted spelling, as `canonical` leaves it: ASCII, no ^, u for micro, ohm, deg, a space for any sign
 * of multiplication. A space in a spelling matches any number of spaces, including none. */
typedef struct {
    const char *unit; /* of the table */
    const char *spelling;
    int power;     /* [-] of ten */
    double factor; /* [unit per spelling, without the power of ten] */
    role_t role;
} spelling_t;

#define LBF_IN 0.1129848290276167 /* [N m] 4.4482216152605 N x 0.0254 m */
#define KRPM   104.71975511965978 /* [V/krpm per V s/rad] */

static const spelling_t spellings[] = {
    {"-", "", 0, 1.0, WRITTEN},
    {"-", "%", -2, 1.0, NAMED},

    {"s", "s", 0, 1.0, WRITTEN},
    {"s", "ms", -3, 1.0, WRITTEN},
    {"s", "us", -6, 1.0, WRITTEN},
    {"s", "ns", -9, 1.0, WRITTEN},
    {"s", "min", 0, 60.0, NAMED},
    {"s", "sec", 0, 1.0, SILENT},
    {"s", "msec", -3, 1.0, SILENT},

    {UNITS_SPEED, "rad/s", 0, 1.0, NAMED},
    {UNITS_SPEED, "r/min", 0, PI_30, WRITTEN},
    {UNITS_SPEED, "deg/s", 0, PI_180, NAMED},
    {UNITS_SPEED, "rpm", 0, PI_30, NAMED},
    {UNITS_SPEED, "1/min", 0, PI_30, SILENT},
    {UNITS_SPEED, "min-1", 0, PI_30, SILENT},
    {UNITS_SPEED, "rev/min", 0, PI_30, SILENT},
    {UNITS_SPEED, "U/min", 0, PI_30, SILENT},
    {UNITS_SPEED, "krpm", 3, PI_30, SILENT},
    {UNITS_SPEED, "mrad/s", -3, 1.0, SILENT},
    {UNITS_SPEED, "rad s-1", 0, 1.0, SILENT},

    {UNITS_ACCELERATION, "rad/s^2", 0, 1.0, WRITTEN},
    {UNITS_ACCELERATION, "r/min/s", 0, PI_30, NAMED},
    {UNITS_ACCELERATION, "deg/s^2", 0, PI_180, SILENT},
    {UNITS_ACCELERATION, "rpm/s", 0, PI_30, NAMED},
    {UNITS_ACCELERATION, "rad s-2", 0, 1.0, SILENT},

    {"rad/s", "rad/s", 0, 1.0, WRITTEN},
    {"rad/s", "krad/s", 3, 1.0, NAMED},
    {"rad/s", "Hz", 0, TWO_PI, NAMED},
    {"rad/s", "kHz", 3, TWO_PI, NAMED},
    {"rad/s", "deg/s", 0, PI_180, SILENT},
    {"rad/s", "mrad/s", -3, 1.0, SILENT},
    {"rad/s", "rad s-1", 0, 1.0, SILENT},

    {"rad", "rad", 0, 1.0, WRITTEN},
    {"rad", "mrad", -3, 1.0, WRITTEN},
    {"rad", "deg", 0, PI_180, NAMED},
    {"rad", "urad", -6, 1.0, SILENT},

    {"A", "A", 0, 1.0, WRITTEN},
    {"A", "mA", -3, 1.0, WRITTEN},
    {"A", "kA", 3, 1.0, NAMED},
    {"A", "uA", -6, 1.0, SILENT},
    {"A rms", "A rms", 0, 1.0, SILENT},
    {"A rms", "A (rms)", 0, 1.0, SILENT},
    {"A rms", "A_rms", 0, 1.0, SILENT},
    {"A rms", "A RMS", 0, 1.0, SILENT},
    {"A rms", "A eff", 0, 1.0, SILENT},
    {"A peak", "A peak", 0, 1.0, SILENT},
    {"A peak", "A (peak)", 0, 1.0, SILENT},
    {"A peak", "A_peak", 0, 1.0, SILENT},
    {"A peak", "A pk", 0, 1.0, SILENT},
    {"A peak", "A 0 p", 0, 1.0, SILENT},

    {"V", "V", 0, 1.0, WRITTEN},
    {"V", "mV", -3, 1.0, WRITTEN},
    {"V", "kV", 3, 1.0, NAMED},
    {"V", "uV", -6, 1.0, SILENT},
    {"V", "V dc", 0, 1.0, SILENT},
    {"V", "V DC", 0, 1.0, SILENT},

    {"ohm", "ohm", 0, 1.0, WRITTEN},
    {"ohm", "mohm", -3, 1.0, WRITTEN},
    {"ohm", "kohm", 3, 1.0, NAMED},

    {"H", "H", 0, 1.0, WRITTEN},
    {"H", "mH", -3, 1.0, WRITTEN},
    {"H", "uH", -6, 1.0, WRITTEN},

    {"F", "F", 0, 1.0, WRITTEN},
    {"F", "mF", -3, 1.0, WRITTEN},
    {"F", "uF", -6, 1.0, WRITTEN},
    {"F", "nF", -9, 1.0, SILENT},

    {"Wb", "Wb", 0, 1.0, WRITTEN},
    {"Wb", "mWb", -3, 1.0, WRITTEN},
    {"Wb", "V s", 0, 1.0, SILENT},
    {"Wb", "mV s", -3, 1.0, SILENT},
    {"Wb", "V s/rad", 0, 1.0, SILENT},

    {"N m", "N m", 0, 1.0, WRITTEN},
    {"N m", "mN m", -3, 1.0, WRITTEN},
    {"N m", "kN m", 3, 1.0, NAMED},
    {"N m", "N cm", -2, 1.0, SILENT},
    {"N m", "lb in", 0, LBF_IN, SILENT},
    {"N m", "lbf in", 0, LBF_IN, SILENT},
    {"N m", "oz in", 0, LBF_IN / 16.0, SILENT},
    {"N m", "ozf in", 0, LBF_IN / 16.0, SILENT},

    {"kg m^2", "kg m^2", 0, 1.0, WRITTEN},
    {"kg m^2", "kg cm^2", -4, 1.0, NAMED},
    {"kg m^2", "g cm^2", -7, 1.0, NAMED},
    {"kg m^2", "g m^2", -3, 1.0, SILENT},
    {"kg m^2", "kg mm^2", -6, 1.0, SILENT},
    {"kg m^2", "N m s^2", 0, 1.0, SILENT},
    {"kg m^2", "oz in s^2", 0, LBF_IN / 16.0, SILENT},
    {"kg m^2", "lb in s^2", 0, LBF_IN, SILENT},

    {"N m s/rad", "N m s/rad", 0, 1.0, WRITTEN},
    {"N m s/rad", "mN m s/rad", -3, 1.0, WRITTEN},
    {"N m s/rad", "N m s", 0, 1.0, SILENT},
    {"N m s/rad", "mN m s", -3, 1.0, SILENT},
    {"N m s/rad", "N m/(rad/s)", 0, 1.0, SILENT},
    {"N m s/rad", "N m/rad/s", 0, 1.0, SILENT},
    {"N m s/rad", "N m/krpm", -3, 1.0 / PI_30, SILENT},
    {"N m s/rad", "mN m/krpm", -6, 1.0 / PI_30, SILENT},

    {"A s/rad", "A s/rad", 0, 1.0, WRITTEN},
    {"A s/rad", "mA s/rad", -3, 1.0, WRITTEN},
    {"A s/rad", "A/(rad/s)", 0, 1.0, SILENT},

    {"A/rad", "A/rad", 0, 1.0, WRITTEN},
    {"A/rad", "mA/rad", -3, 1.0, WRITTEN},

    {"N m/A", "N m/A", 0, 1.0, WRITTEN},
    {"N m/A", "mN m/A", -3, 1.0, WRITTEN},
    {"N m/A", "lb in/A", 0, LBF_IN, SILENT},
    {"N m/A", "oz in/A", 0, LBF_IN / 16.0, SILENT},
    {"N m/A rms", "N m/A rms", 0, 1.0, SILENT},
    {"N m/A rms", "mN m/A rms", -3, 1.0, SILENT},
    {"N m/A peak", "N m/A peak", 0, 1.0, SILENT},
    {"N m/A peak", "N m/A pk", 0, 1.0, SILENT},

    {"V/krpm", "V/krpm", 0, 1.0, WRITTEN},
    {"V/krpm", "mV/rpm", 0, 1.0, NAMED},
    {"V/krpm", "V/(1000 r/min)", 0, 1.0, SILENT},
    {"V/krpm", "V/1000 r/min", 0, 1.0, SILENT},
    {"V/krpm", "V/(1000 rpm)", 0, 1.0, SILENT},
    {"V/krpm", "V/1000 rpm", 0, 1.0, SILENT},
    {"V/krpm", "V/1000 min-1", 0, 1.0, SILENT},
    {"V/krpm", "V/(1000 min-1)", 0, 1.0, SILENT},
    {"V/krpm", "V/1000 1/min", 0, 1.0, SILENT},
    {"V/krpm", "V/kr/min", 0, 1.0, SILENT},
    {"V/krpm", "mV/r/min", 0, 1.0, SILENT},
    {"V/krpm", "mV/(r/min)", 0, 1.0, SILENT},
    {"V/krpm", "mV/min-1", 0, 1.0, SILENT},
    {"V/krpm", "mV min", 0, 1.0, SILENT},
    {"V/krpm", "V/rpm", 3, 1.0, SILENT},
    {"V/krpm", "V s/rad", 0, KRPM, SILENT},
    {"V/krpm", "V/(rad/s)", 0, KRPM, SILENT},
    {"V/krpm", "V/rad/s", 0, KRPM, SILENT},
    {"V/krpm", "mV s/rad", -3, KRPM, SILENT},
    {"V/krpm rms", "V rms/krpm", 0, 1.0, SILENT},
    {"V/krpm rms", "V rms/1000 r/min", 0, 1.0, SILENT},
    {"V/krpm rms", "V rms/1000 rpm", 0, 1.0, SILENT},
    {"V/krpm rms", "V rms/1000 min-1", 0, 1.0, SILENT},
    {"V/krpm peak", "V peak/krpm", 0, 1.0, SILENT},
    {"V/krpm peak", "V pk/krpm", 0, 1.0, SILENT},
    {"V/krpm peak", "V peak/1000 rpm", 0, 1.0, SILENT},
    {"V/krpm peak", "V pk/1000 rpm", 0, 1.0, SILENT},

    {"V/Hz", "V/Hz", 0, 1.0, WRITTEN},
    {"V/Hz", "mV/Hz", -3, 1.0, NAMED},
    {"V/Hz", "V s", 0, 1.0, SILENT},

    {"rpm/V", "rpm/V", 0, 1.0, WRITTEN},
    {"rpm/V", "r/min/V", 0, 1.0, NAMED},
    {"rpm/V", "min-1/V", 0, 1.0, SILENT},
    {"rpm/V", "1/min/V", 0, 1.0, SILENT},
    {"rpm/V", "(r/min)/V", 0, 1.0, SILENT},

    {"degC", "degC", 0, 1.0, WRITTEN},
    {"degC", "deg C", 0, 1.0, SILENT},
};
#define SPELLINGS (sizeof spellings / sizeof spellings[0])

/* Units with special spellings for mechanical quantities. */
static const struct {
    const char *unit; /* of the table, and in messages */
    const char *mechanical;
} by_text[] = {{"rad/s", UNITS_SPEED}, {"rad/s^2", UNITS_ACCELERATION}};
#define BY_TEXT (sizeof by_text / sizeof by_text[0])

/* Units of a motor's keys that state whether a value is rms or peak. They have the spellings
 * of their unit and further ones with the same meaning. */
static const struct {
    const char *variety, *unit;
} varieties[] = {
    {"A rms", "A"},         {"A peak", "A"},         {"V/krpm rms", "V/krpm"}, {"V/krpm peak", "V/krpm"},
    {"N m/A rms", "N m/A"}, {"N m/A peak", "N m/A"},
};
#define VARIETIES (sizeof varieties / sizeof varieties[0])

static const char *unit_of_variety(const char *unit)
{
    for (size_t n = 0; n < VARIETIES; n++) {
        if (strcmp(varieties[n].variety, unit) == 0) {
            return varieties[n].unit;
        }
    }
    return unit;
}

const char *units_variety(const char *unit, const char *which)
{
    for (size_t n = 0; n < VARIETIES; n++) {
        const size_t length = strlen(varieties[n].unit);
        if (strcmp(varieties[n].unit, unit) == 0 && varieties[n].variety[length] == ' ' &&
            strcmp(varieties[n].variety + length + 1u, which) == 0) {
            return varieties[n].variety;
        }
    }
    return unit;
}

#define UNIT_OCTETS 96u /* of a unit that is read */

/* Characters of data sheets in place of ASCII, as copied from PDF files. */
static const struct {
    const char *from, *to;
} characters[] = {
    {"\xC2\xB5", "u"},
    {"\xCE\xBC", "u"}, /* micro sign, mu */
    {"\xC2\xB7", " "},
    {"\xE2\x8B\x85", " "}, /* middle dot, dot operator */
    {"\xE2\x80\xA2", " "},
    {"\xC3\x97", " "}, /* bullet, times */
    {"*", " "},
    {"^", ""},
    {"\xC2\xB2", "2"},
    {"\xC2\xB9", "1"}, /* superscripts */
    {"\xE2\x81\xBB", "-"},
    {"\xE2\x88\x92", "-"}, /* superscript minus, minus sign */
    {"\xE2\x80\x90", "-"},
    {"\xE2\x80\x93", "-"}, /* hyphen, dash */
    {"\xCE\xA9", "ohm"},
    {"\xE2\x84\xA6", "ohm"}, /* omega, ohm sign */
    {"\xC2\xB0", "deg"},
    {"\xC2\xA0", " "}, /* degree, no-break space */
    {"\xE2\x80\x89", " "},
    {"\xE2\x80\xAF", " "}, /* thin spaces */
    {"Ohms", "ohm"},
    {"ohms", "ohm"},
    {"Ohm", "ohm"},
    {"OHM", "ohm"},
    {"RPM", "rpm"},
    {"Rpm", "rpm"},
};

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/* One way to write a unit; "" if it is too long for any. */
static const char *canonical(const char *text, char to[UNIT_OCTETS])
{
    size_t used = 0;
    while (*text != '\0' && used < UNIT_OCTETS - 4u) {
        const char *with = NULL;
        for (size_t n = 0; n < sizeof characters / sizeof characters[0] && with == NULL; n++) {
            const size_t length = strlen(characters[n].from);
            if (strncmp(text, characters[n].from, length) == 0) {
                with = characters[n].to;
                text += length;
            }
        }
        if (with != NULL) {
            used += (size_t)snprintf(to + used, UNIT_OCTETS - used, "%s", with);
            continue;
        }
        /* N.m, kg-cm2: between two letters they multiply */
        const bool joins = (*text == '.' || *text == '-') && used > 0u && is_letter(to[used - 1u]);
        const char next = joins && is_letter(text[1]) ? ' ' : *text;
        while (next == '/' && used > 0u && to[used - 1u] == ' ') {
            used--;
        }
        if (next != ' ' || used == 0u || to[used - 1u] != '/') {
            to[used++] = next;
        }
        text++;
    }
    to[*text == '\0' ? used : 0u] = '\0';
    return to;
}

const char *units_of_row(const table_row_t *row)
{
    for (size_t n = 0; n < BY_TEXT; n++) {
        if (strcmp(row->unit, by_text[n].unit) == 0 && strstr(row->text, "mechanical") != NULL) {
            return by_text[n].mechanical;
        }
    }
    return row->unit;
}

/* The name of a unit in messages. */
static const char *plain(const char *unit)
{
    unit = unit_of_variety(unit);
    for (size_t n = 0; n < BY_TEXT; n++) {
        if (strcmp(unit, by_text[n].mechanical) == 0) {
            return by_text[n].unit;
        }
    }
    return unit;
}

static const char *skip_spaces(const char *text)
{
    while (*text == ' ' || *text == '\t') {
        text++;
    }
    return text;
}

/* True if this canonical text is that spelling. */
static bool spelled(const char *text, const char *spelling)
{
    text = skip_spaces(text);
    for (; *spelling != '\0'; spelling++) {
        if (*spelling == '^') {
            continue;
        }
        if (*spelling == ' ') {
            text = skip_spaces(text);
        } else if (*text == *spelling) {
            text++;
        } else {
            return false;
        }
    }
    return *skip_spaces(text) == '\0';
}

static bool refuse(units_error_t *why, const char *text, const char *what, const char *unit)
{
    size_t used = (size_t)snprintf(why->text, sizeof why->text, "\"%.60s\"%s %s; accepted: a number with ",
                                   text, strlen(text) > 60u ? "..." : "", what);
    const char *before = "";
    const char *of = unit_of_variety(unit);
    bool any = false;
    for (size_t n = 0; n < SPELLINGS && used < sizeof why->text; n++) {
        if (spellings[n].role != SILENT && strcmp(spellings[n].unit, of) == 0) {
            const char *spelling = spellings[n].spelling[0] == '\0' ? "no unit" : spellings[n].spelling;
            used += (size_t)snprintf(why->text + used, sizeof why->text - used, "%s%s", before, spelling);
            before = ", ";
            any = true;
        }
    }
    if (!any && used < sizeof why->text) {
        snprintf(why->text + used, sizeof why->text - used, "%s", unit);
    }
    return false;
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* A number without its point: digits times ten to the power. */
typedef struct {
    char digits[DIGITS + 1u]; /* sign first if there is one */
    size_t count;
    long power;
} number_t;

/* The number at the beginning of the text; NULL: there is none. Otherwise the text after the number. */
static const char *scan_number(const char *text, number_t *number)
{
    bool any = false;
    bool point = false;
    number->count = 0;
    number->power = 0;
    if (*text == '+' || *text == '-') {
        number->digits[number->count++] = *text++;
    }
    for (; is_digit(*text) || (*text == '.' && !point); text++) {
        if (*text == '.') {
            point = true;
            continue;
        }
        if (number->count >= DIGITS) {
            return NULL;
        }
        any = true;
        number->digits[number->count++] = *text;
        number->power -= point ? 1 : 0;
    }
    number->digits[number->count] = '\0';
    if (!any) {
        return NULL;
    }
    if (*text == 'e' || *text == 'E') {
        const char *end = text + 1;
        const bool negative = *end == '-';
        long exponent = 0;
        end += *end == '+' || *end == '-';
        if (is_digit(*end)) {
            for (; is_digit(*end); end++) {
                exponent = exponent < 100000 ? 10 * exponent + (*end - '0') : exponent;
            }
            number->power += negative ? -exponent : exponent;
            text = end;
        }
    }
    return text;
}

bool units_read(const char *text, const char *unit, double *value, units_error_t *why)
{
    number_t number;
    const char *rest = scan_number(skip_spaces(text), &number);
    if (rest == NULL) {
        return refuse(why, text, "does not begin with a number", unit);
    }
    const spelling_t own = {unit, unit, 0, 1.0, NAMED}; /* of a unit without a list */
    const spelling_t *found = NULL;
    bool listed = false;
    char canon[UNIT_OCTETS];
    (void)canonical(rest, canon);
    const char *of = unit_of_variety(unit);
    for (size_t n = 0; n < SPELLINGS && found == NULL && (canon[0] != '\0' || *rest == '\0'); n++) {
        if (strcmp(spellings[n].unit, unit) == 0 || strcmp(spellings[n].unit, of) == 0) {
            listed = true;
            found = spelled(canon, spellings[n].spelling) ? &spellings[n] : NULL;
        }
    }
    if (!listed && spelled(canon, unit)) {
        found = &own;
    }
    if (found == NULL) {
        char what[96];
        if (*skip_spaces(rest) == '\0') {
            snprintf(what, sizeof what, "has no unit");
        } else if (strcmp(unit, "-") == 0) {
            snprintf(what, sizeof what, "has a unit, but this is a pure number");
        } else {
            snprintf(what, sizeof what, "is not a quantity in %s", plain(unit));
        }
        return refuse(why, text, what, unit);
    }

    /* No point and no group separator, so that the locale has no effect; strtod rounds to nearest. */
    char digits[DIGITS + 32u];
    snprintf(digits, sizeof digits, "%se%ld", number.digits, number.power + found->power);
    const double result = strtod(digits, NULL) * found->factor;
    if (!isfinite(result)) {
        return refuse(why, text, "is too large", unit);
    }
    *value = result;
    return true;
}

static double power_of_ten(int power)
{
    static const double powers[] = {1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
    return powers[power < 0 ? -power : power];
}

/* Dividing by a whole power of ten rounds once. */
static double in_spelling(double value, const spelling_t *spelling)
{
    const double scaled =
        spelling->power < 0 ? value * power_of_ten(spelling->power) : value / power_of_ten(spelling->power);
    return scaled / spelling->factor;
}

/* The largest prefix that leaves a number of 1 or more; for 0 the table unit. NULL: the unit has
 * no list. */
static const spelling_t *best_spelling(double magnitude, const char *unit)
{
    const spelling_t *own = NULL;
    const spelling_t *best = NULL;
    for (size_t n = 0; n < SPELLINGS; n++) {
        const spelling_t *next = &spellings[n];
        if (next->role != WRITTEN || strcmp(next->unit, unit) != 0) {
            continue;
        }
        /* The lists begin with the table unit and continue with smaller units. A value slightly below 1 is
         * shown as 1. */
        if (best == NULL || in_spelling(magnitude, best) < 0.9999995) {
            best = next;
        }
        own = own != NULL ? own : next;
    }
    return best != NULL && in_spelling(magnitude, best) < 1e-3 ? own : best;
}

const char *units_text(char to[UNITS_TEXT_SIZE], double value, const char *unit)
{
    const spelling_t *spelling = isfinite(value) ? best_spelling(fabs(value), unit) : NULL;
    if (spelling == NULL) {
        snprintf(to, UNITS_TEXT_SIZE, "%.6g %.40s", value, plain(unit));
    } else {
        snprintf(to, UNITS_TEXT_SIZE, "%.6g%s%.40s", in_spelling(value, spelling),
                 spelling->spelling[0] == '\0' ? "" : " ", spelling->spelling);
    }
    return to;
}

/* One end of a range with at least six digits, and as many as it takes to be read as a value in the range: of
 * a 32-bit slot where the ends are such values. */
static void end_text(char to[UNITS_TEXT_SIZE], double end, double min, double max, const spelling_t *spelling)
{
    const bool slots = (double)(float)min == min && (double)(float)max == max;
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(to, UNITS_TEXT_SIZE, "%.*g", digits, in_spelling(end, spelling));
        char exact[UNITS_TEXT_SIZE + 16u];
        const char *power = strchr(to, 'e');
        const int shift = spelling->power + (power != NULL ? atoi(power + 1) : 0);
        snprintf(exact, sizeof exact, "%.*se%d", power != NULL ? (int)(power - to) : (int)strlen(to), to,
                 shift);
        const double read = strtod(exact, NULL) * spelling->factor;
        const double value = slots ? (double)(float)read : read;
        if (value >= min && value <= max) {
            break;
        }
    }
}

const char *units_range_text(char to[UNITS_TEXT_SIZE], double min, double max, const char *unit)
{
    static const spelling_t plainly = {"", "", 0, 1.0, WRITTEN};
    const spelling_t *best = best_spelling(fmax(fabs(min), fabs(max)), unit);
    const spelling_t *spelling = best != NULL ? best : &plainly;
    const char *name = best != NULL ? best->spelling : plain(unit);
    char ends[2][UNITS_TEXT_SIZE];
    end_text(ends[0], min, min, max, spelling);
    end_text(ends[1], max, min, max, spelling);
    const spelling_t *of_min = strchr(ends[0], 'e') != NULL ? best_spelling(fabs(min), unit) : spelling;
    const bool two_units =
        of_min != NULL && of_min != spelling; /* "10 uH to 1 H" instead of "1e-05 to 1 H" */
    if (two_units) {
        end_text(ends[0], min, min, max, of_min);
    }
    snprintf(to, UNITS_TEXT_SIZE, "%.20s%s%.8s to %.20s%s%.40s", ends[0], two_units ? " " : "",
             two_units ? of_min->spelling : "", ends[1], name[0] == '\0' ? "" : " ", name);
    return to;
}

const char *units_row_text(char to[UNITS_TEXT_SIZE], double value, const table_row_t *row)
{
    if (row->kind == SLOT_ENUM) {
        double number = 0.0;
        for (const char *choice = row->choices; choice != NULL; number += 1.0) {
            const char *bar = strchr(choice, '|');
            if (number == value) {
                const size_t length = bar != NULL ? (size_t)(bar - choice) : strlen(choice);
                snprintf(to, UNITS_TEXT_SIZE, "%.*s",
                         (int)(length < UNITS_TEXT_SIZE ? length : UNITS_TEXT_SIZE - 1u), choice);
                return to;
            }
            choice = bar != NULL ? bar + 1 : NULL;
        }
    }
    return units_text(to, value, row->kind == SLOT_ENUM ? "-" : units_of_row(row));
}
