/* Converts between values and text with a unit: "1500 r/min", "3 us", "250 mA", "30 deg".
 *
 * A text is NUMBER UNIT, the space between them optional. Each table unit has its list of accepted spellings;
 * a spelling is the table unit times a power of ten, a factor, or both (x = number 10^power factor). The
 * conversion is exact: the power of ten is added to the exponent of the decimal number before it is converted
 * to binary, so that "3 us" is the double nearest to 0.000003. A factor (2 pi/60) adds one rounding. The bits
 * are the same on every machine and in every locale.
 *
 * A speed in r/min is a mechanical one, and so is an acceleration in r/min/s: those spellings are accepted
 * only for rows whose text contains "mechanical". Hz, which means 2 pi rad/s, is accepted only for the other
 * rows (a filter, an electrical speed).
 *
 * Spellings copied from data sheets in PDF are accepted: both characters for micro, the middle dot, N.m and
 * kg-cm2, superscripts, RPM, the ohm sign and omega, no-break spaces. One table has them all (units.c).
 *
 * Does not handle: scales with an offset (K, degF), products or powers of a unit beyond those listed. */
#ifndef HOST_SIM_LAB_UNITS_H
#define HOST_SIM_LAB_UNITS_H

#include <stdbool.h>
#include <stddef.h>

#include "contract/table.h"

/* Table units of mechanical speeds and accelerations; everywhere else they read "rad/s" and "rad/s^2". */
#define UNITS_SPEED        "rad/s mechanical"
#define UNITS_ACCELERATION "rad/s^2 mechanical"

#define UNITS_TEXT_SIZE 96u /* [chars] largest output of units_text, with its closing 0 */

typedef struct {
    char text[320]; /* one line: what was given, what is accepted */
} units_error_t;

/* The list of spellings of a row: its unit, UNITS_SPEED or UNITS_ACCELERATION. */
const char *units_of_row(const table_row_t *row);

/* Converts `text` to a number [unit]. false: the text is wrong; `why` has the message, and *value is
 * unchanged. Units without a list are accepted as they are spelled. Numbers outside the range of double are
 * refused. */
bool units_read(const char *text, const char *unit, double *value, units_error_t *why);

/* The unit of a key for the rms or the peak value ("rms", "peak"). It has the spellings of the unit and
 * special ones such as "3 Arms". Without special spellings it is the unit itself. */
const char *units_variety(const char *unit, const char *which);

/* Writes a value with a suitable unit and prefix ("1500 r/min", "2.5 us", "12.3 mrad") and six digits;
 * returns `to`. A value that is not finite is written as such. */
const char *units_text(char to[UNITS_TEXT_SIZE], double value, const char *unit);

/* A range: "0 to 2100 r/min". Both ends are in one unit, unless the lower end would then need an exponent:
 * "10 uH to 1 H". If a program reads the ends again, they are in the range. Returns `to`. */
const char *units_range_text(char to[UNITS_TEXT_SIZE], double min, double max, const char *unit);

/* Value of a row: the name of a choice, or units_text in the row's unit. */
const char *units_row_text(char to[UNITS_TEXT_SIZE], double value, const table_row_t *row);

#endif
