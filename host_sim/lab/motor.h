/* A motor as its data sheet describes it, and the data that the drive and the plant need.
 *
 *   title = "Teknic M-2310P-LN-04K"     # one line
 *   source = "..."                      # where the numbers are from
 *   pole_pairs = 4
 *   resistance_line = "0.72 ohm"        # the name of each key defines the meaning of the number: MOTOR_KEYS
 *
 * Keys of one quantity exclude each other (`resistance` and `resistance_line`), except for those of the flux
 * linkage: the first of the list is used, and a contradiction of another one is reported with both
 * numbers. Star connection is assumed: between two lines R and L are twice those of a phase. A
 * winding in delta is described by its equivalent star; its data between lines are valid without a change.
 *
 *   psi_f = Ke/(sqrt 3 p 1000 pi/30)        Ke peak between lines, per 1000 r/min; phase: without sqrt 3
 *   psi_f = Kt/(1.5 p)                      Kt per ampere of the sine's peak; per ampere rms: /sqrt 2
 *   psi_f = Kt/(p 3 sqrt 3/pi)              per ampere through two phases, the mean of a block of 60 degrees:
 *                                           what makers of brushless DC motors print
 *   psi_f = (V/Hz)/(2 pi)                   peak of a phase per electrical hertz
 *
 * Does not handle: saturation along the magnets, iron loss, an EMF that is not a sine. */
#ifndef HOST_SIM_LAB_MOTOR_H
#define HOST_SIM_LAB_MOTOR_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/lab/scenario.h"
#include "host_sim/lab/toml_reader.h"
#include "host_sim/lab/units.h"

/* Quantities of a motor. */
typedef enum {
    MOTOR_POLE_PAIRS,
    MOTOR_RESISTANCE,
    MOTOR_INDUCTANCE_D,
    MOTOR_INDUCTANCE_Q,
    MOTOR_SATURATION,
    MOTOR_FLUX,
    MOTOR_CURRENT,
    MOTOR_SPEED,
    MOTOR_SPEED_MAX,
    MOTOR_TORQUE,
    MOTOR_LINK,
    MOTOR_INERTIA,
    MOTOR_LOAD_INERTIA,
    MOTOR_COULOMB,
    MOTOR_VISCOUS,
    MOTOR_TEMPERATURE,
    MOTOR_WARMING,
    MOTOR_LINES,
    MOTOR_QUANTITIES
} motor_quantity_t;

/* K(key, quantity, factor to its SI value (flux: times pole pairs), unit, smallest, largest, text) */
/* clang-format off */
#define MOTOR_KEYS(K) \
    K(pole_pairs,             MOTOR_POLE_PAIRS,   1.0,                 "-",         1.0,   64.0,  "pole pairs") \
    K(poles,                  MOTOR_POLE_PAIRS,   0.5,                 "-",         2.0,   128.0, "poles, twice the pole pairs") \
    K(resistance,             MOTOR_RESISTANCE,   1.0,                 "ohm",       1e-3,  100.0, "of a phase, warm if known") \
    K(resistance_line,        MOTOR_RESISTANCE,   0.5,                 "ohm",       2e-3,  200.0, "between two lines") \
    K(inductance_d,           MOTOR_INDUCTANCE_D, 1.0,                 "H",         1e-5,  1.0,   "of a phase, along the magnets") \
    K(inductance_q,           MOTOR_INDUCTANCE_Q, 1.0,                 "H",         1e-5,  1.0,   "of a phase, across them") \
    K(inductance,             MOTOR_INDUCTANCE_Q, 1.0,                 "H",         1e-5,  1.0,   "of a phase, both axes") \
    K(inductance_line,        MOTOR_INDUCTANCE_Q, 0.5,                 "H",         2e-5,  2.0,   "between two lines, both axes") \
    K(saturation_current,     MOTOR_SATURATION,   1.0,                 "A",         1.0,   1e4,   "peak current across the magnets at which saturation reduces the flux to 1/sqrt 2 of L_q i_q; inductance_q is then the value without current") \
    K(flux_linkage,           MOTOR_FLUX,         0.0,                 "Wb",        1e-4,  10.0,  "psi_f, peak of a phase") \
    K(flux_volts_per_hertz,   MOTOR_FLUX,         0.0,                 "V/Hz",      6e-4,  60.0,  "peak of a phase per electrical hertz") \
    K(ke_line_peak,           MOTOR_FLUX,         0.0,                 "V/krpm",    0.01,  1e4,   "EMF between lines, peak, per 1000 r/min") \
    K(ke_line_rms,            MOTOR_FLUX,         0.0,                 "V/krpm",    0.01,  1e4,   "EMF between lines, rms, per 1000 r/min") \
    K(ke_phase_peak,          MOTOR_FLUX,         0.0,                 "V/krpm",    0.01,  1e4,   "EMF of a phase, peak, per 1000 r/min") \
    K(ke_phase_rms,           MOTOR_FLUX,         0.0,                 "V/krpm",    0.01,  1e4,   "EMF of a phase, rms, per 1000 r/min") \
    K(kt_rms,                 MOTOR_FLUX,         0.0,                 "N m/A",     1e-4,  1e3,   "torque per ampere rms") \
    K(kt_peak,                MOTOR_FLUX,         0.0,                 "N m/A",     1e-4,  1e3,   "torque per ampere of the sine's peak") \
    K(kt_block,               MOTOR_FLUX,         0.0,                 "N m/A",     1e-4,  1e3,   "torque per ampere through two phases, block commutation") \
    K(speed_constant_block,   MOTOR_FLUX,         0.0,                 "rpm/V",     0.1,   1e5,   "speed per volt of direct voltage, block commutation") \
    K(rated_current_peak,     MOTOR_CURRENT,      1.0,                 "A",         0.1,   1e3,   "continuous, peak value of a phase") \
    K(rated_current_rms,      MOTOR_CURRENT,      1.4142135623730951,  "A",         0.1,   1e3,   "continuous, rms value of a phase") \
    K(rated_current_block,    MOTOR_CURRENT,      1.1026577908435842,  "A",         0.1,   1e3,   "continuous, through two phases, block commutation") \
    K(rated_speed,            MOTOR_SPEED,        1.0,                 UNITS_SPEED, 1.0,   7000.0, "mechanical, at rated torque") \
    K(max_speed,              MOTOR_SPEED_MAX,    1.0,                 UNITS_SPEED, 1.0,   10000.0, "mechanical, that the rotor withstands") \
    K(rated_torque,           MOTOR_TORQUE,       1.0,                 "N m",       1e-4,  1e3,   "continuous") \
    K(link_voltage,           MOTOR_LINK,         1.0,                 "V",         5.0,   1000.0, "DC link for which the winding is made") \
    K(inertia,                MOTOR_INERTIA,      1.0,                 "kg m^2",    1e-6,  1e3,   "of the rotor") \
    K(load_inertia,           MOTOR_LOAD_INERTIA, 1.0,                 "kg m^2",    0.0,   1e3,   "of the driven machine, at the motor's shaft") \
    K(friction_coulomb,       MOTOR_COULOMB,      1.0,                 "N m",       0.0,   1e3,   "dry friction") \
    K(friction_viscous,       MOTOR_VISCOUS,      1.0,                 "N m s/rad", 0.0,   1e2,   "friction that grows with speed") \
    K(max_temperature,        MOTOR_TEMPERATURE,  1.0,                 "degC",      40.0,  250.0, "of the winding") \
    K(thermal_time_constant,  MOTOR_WARMING,      1.0,                 "s",         0.1,   3600.0, "of the winding") \
    K(encoder_lines,          MOTOR_LINES,        1.0,                 "-",         16.0,  16384.0, "encoder lines per turn")
/* clang-format on */

typedef enum {
#define MOTOR_KEY(key, quantity, factor, unit, min, max, text) MOTOR_KEY_##key,
    MOTOR_KEYS(MOTOR_KEY)
#undef MOTOR_KEY
        MOTOR_KEY_COUNT
} motor_key_t;

/* The keys of a data sheet, as they are written. */
typedef struct {
    char name[96];    /* of the library, or of the file */
    char title[200];  /* "" if there is none */
    char source[800]; /* "" if there is none */
    bool has[MOTOR_KEY_COUNT];
    double value[MOTOR_KEY_COUNT]; /* [unit of the key] */
    scenario_place_t place[MOTOR_KEY_COUNT];
    scenario_place_t whole; /* of the table that contains it */
} motor_sheet_t;

#define MOTOR_NOTES     8u
#define MOTOR_NOTE_SIZE 320u

/* The quantities that follow from the keys. */
typedef struct {
    char name[96];
    bool has[MOTOR_QUANTITIES];               /* false: not given; a required value is then assumed */
    double value[MOTOR_QUANTITIES];           /* [SI] per phase, amplitudes; MOTOR_CURRENT peak */
    char notes[MOTOR_NOTES][MOTOR_NOTE_SIZE]; /* contradictions and assumptions, one line each */
    uint32_t note_count;
} motor_t;

/* Reads the keys of a table into the sheet. A key replaces all other keys of its quantity. `others`
 * ("name|file") are further keys that are accepted and ignored. */
bool motor_read_table(const toml_file_t *file, const toml_entry_t *table, const char *others,
                      motor_sheet_t *sheet, scenario_error_t *error);

/* A motor's file. `error` names the file. */
bool motor_read_file(const char *path, motor_sheet_t *sheet, scenario_error_t *error);

/* A motor of the library by name; false: nearest names. */
bool motor_read_library(const char *name, motor_sheet_t *sheet, scenario_error_t *error);

/* "name" of the library, or a path (it has a slash or ends in .toml). */
bool motor_read(const char *what, motor_sheet_t *sheet, scenario_error_t *error);

/* Replaces a key of the sheet by "KEY=VALUE". */
bool motor_override(motor_sheet_t *sheet, const char *assignment, scenario_error_t *error);

/* Names in the library, alphabetically; the caller frees each and the list. -1: it cannot be read. */
int motor_library(char ***names);
const char *motor_library_folder(void);

/* From the sheet to the motor. false: required data are missing or contradictory (named in `error`); less
 * important points are reported in the motor's notes. Required are pole pairs, R, L, psi_f by one of its
 * names, and the rated current. If missing, assumed and reported are the inertia (rated torque brings it to
 * rated speed in 0.2 s) and the friction (a hundredth of the rated torque). */
bool motor_make(const motor_sheet_t *sheet, motor_t *motor, scenario_error_t *error);

/* The value of a quantity that the sheet has [SI]: by the last of its keys, of the flux by the first; NAN:
 * none. */
double motor_given(const motor_sheet_t *sheet, motor_quantity_t quantity);

/* Torque constant 1.5 p psi_f [N m/A]; inertia of everything that turns [kg m^2]. */
double motor_torque_constant(const motor_t *motor);
double motor_inertia(const motor_t *motor);

const char *motor_key_name(motor_key_t key);
const char *motor_key_unit(motor_key_t key);
const char *motor_key_text(motor_key_t key);

#endif
