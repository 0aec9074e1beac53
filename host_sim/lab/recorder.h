/* Recordings: the rows of a tap as CSV, MAT v5 and MDF 4, the edges of the bridge as VCD. Each file contains
 * the data for repeating the run (table hash, commit, seed, scenario, parameter set).
 *
 * During the simulation the sinks only copy slots into memory; recorder_close formats and writes them. The
 * bytes of a file depend only on the recorded values: not on clock, locale or libm, and there is no
 * compression.
 *
 * Files are written as NAME.csv.partial and renamed to NAME.csv when they are complete. A file with the
 * ending .partial is incomplete. recorder_open creates the files, so that a folder that cannot be written
 * stops a run before it begins. They are locked until they are renamed: until then no other program can
 * begin a recording with this name.
 *
 * CSV: `# key: value` lines, then `time[s],i_q[A],...`, then one line a sample. Floats have the fewest digits
 * that read back to the same float, also by way of double (nan, inf, -inf: any NaN comes back as a NaN);
 * integers and enumerations are integers. The time is the beginning of the period (decimals:
 * host_sim/lab/times.h); `period` is its length. Notes of the run (recorder_note), its events and verdicts,
 * are lines `# key name: text`. The lines of the scenario have the key `text`. In comment lines a control
 * character is written as \xNN and a backslash as two; data lines do not need this.
 *
 * MAT: `time` (double, [s]), a column for each row (single, int32, uint32) under its name, and the struct
 * `meta`: format, program, commit, tables, scenario, title, seed, every, period, ended, text, units.NAME,
 * choices.NAME, values.NAME, value_units.NAME, notes (a line each, `key name: text`). A dot in a name becomes
 * an underscore, and a character above 16 bits becomes U+FFFD. Each variable is read back and compared before
 * the file is renamed.
 *
 * VCD: timescale 1 ns. A tick of 20/3 ns is rounded by at most 1/3 ns, so tick = round(0.15 x time) is exact.
 * Wires upper_a lower_a upper_b lower_b upper_c lower_c (1 = the switch is commanded on; x until the first
 * RIG_EDGE_GATES), isr, adc_start (marked by a pulse of RECORDER_ADC_TICKS), trip. Several changes within one
 * tick are recorded as the last one. Only the switched fidelity has edges.
 *
 * MDF: version 4.10, file NAME.mf4, one group of channels, uncompressed: the master `time` (double, [s]),
 * then a channel for each row (32-bit float, int, uint) under its name of CSV, with its unit and text; the
 * names of an enumeration are a conversion from value to text. The comment of the file has the content of the
 * CSV head. The measurement begins at time zero of the clock.
 *
 * If two tables have a row of the same name, its column in CSV and MDF is table.row. A jump back in time
 * (rig_load of an earlier state) removes the samples after that time. Not handled: gaps; every recording is
 * one run. */
#ifndef HOST_SIM_LAB_RECORDER_H
#define HOST_SIM_LAB_RECORDER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/rig/rig.h"

#define RECORDER_CSV 1u
#define RECORDER_MAT 2u
#define RECORDER_VCD 4u
#define RECORDER_MDF 8u

#define RECORDER_FORMATS 4u                                           /* [-] each is 1u << n, n below this */
#define RECORDER_SAMPLED (RECORDER_CSV | RECORDER_MAT | RECORDER_MDF) /* formats with the rows of a tap */

/* The formats of a text such as "csv,mdf"; 0: the text has an unknown word or no word. */
uint32_t recorder_formats(const char *text);

/* Ending of the file in the n-th format, without dot. */
const char *recorder_ending(uint32_t n);

/* [octets] 1 GiB holds 20 million samples of 12 rows, and keeps every variable of MAT v5 below its 2 GiB. */
#define RECORDER_MEMORY_MIN (UINT32_C(4) << 20)
#define RECORDER_MEMORY_MAX (UINT32_C(1) << 30)

#define RECORDER_ADC_TICKS UINT64_C(30) /* [1/150 MHz] */

/* A setting of the run: the value of a row at t = 0. */
typedef struct {
    const char *name; /* unique, "motor_resistance" or "plant.inertia" */
    double value;     /* [unit] */
    const char *unit; /* SI */
} recorder_value_t;

typedef struct {
    const char *program;            /* name and version */
    const char *commit;             /* of the sources */
    const char *scenario;           /* name of its file; "" if there is none */
    const char *scenario_text;      /* the whole file; "" if there is none */
    const char *title;              /* one line */
    uint64_t seed;                  /* [-] */
    const recorder_value_t *values; /* at t = 0 */
    uint32_t value_count;           /* [-] */
} recorder_meta_t;

typedef struct {
    const char *folder;  /* exists; "" is the present one */
    const char *name;    /* of the files, without ending */
    uint32_t formats;    /* [-] RECORDER_CSV | ... */
    const uint32_t *ids; /* rows in the order of the columns: the same as in rig_tap */
    uint32_t count;      /* [-] 1..RIG_TAP_MAX; 0 for VCD alone */
    uint32_t every;      /* [periods] from sample to sample, >= 1: the same as in rig_tap */
    uint32_t periods;    /* [periods] planned; 0: not known */
    uint32_t memory;     /* [octets] RECORDER_MEMORY_MIN..RECORDER_MEMORY_MAX; 0: the most */
    uint32_t isr_ticks;  /* [1/150 MHz] displayed duration of an interrupt, >= 1 for VCD; the simulated
                            interrupt takes no time */
    recorder_meta_t meta;
} recorder_options_t;

typedef struct {
    char text[1024]; /* one line, no full stop */
    bool io;         /* true: a file could not be written; false: an option is wrong */
} recorder_error_t;

typedef struct recorder recorder_t;

/* Copies its arguments and creates the files. NULL, without any file: an option is out of its range, a row is
 * unknown or repeated, a file cannot be created, or the planned recording does not fit into the memory;
 * `error` has the message. */
recorder_t *recorder_open(const recorder_options_t *options, recorder_error_t *error);

/* The sinks; the context is the recorder. recorder_sink is a rig_sink_t and copies count + 1 words.
 * recorder_edge is a rig_edge_sink_t. When the memory is full they count the lost samples and edges, which
 * recorder_close reports. */
void recorder_sink(void *recorder, uint32_t period, const uint32_t *slots, uint32_t count);
void recorder_edge(void *recorder, uint64_t tick, uint32_t what, uint32_t value);

/* Adds a line about the run, in the order of the calls. For RECORDER_EVENT `name` is the time and `text` the
 * setting; for RECORDER_VERDICT `name` is the verdict and `text` the sentence. The texts are copied and have
 * one line each. false: there is no memory. */
#define RECORDER_EVENT   "event"
#define RECORDER_VERDICT "verdict"
bool recorder_note(recorder_t *recorder, const char *key, const char *name, const char *text);

/* Samples recorded so far. */
uint64_t recorder_samples(const recorder_t *recorder);

/* Writes all files and frees the recorder. `ended` is the end of the run in the files ("complete",
 * "interrupted"). false: a file is incomplete; `error` has its name and the cause, and the other files are
 * complete. About 0.4 us for a sample of 12 rows in CSV. */
bool recorder_close(recorder_t *recorder, const char *ended, recorder_error_t *error);

/* Frees the recorder and removes its files. The argument may be NULL. */
void recorder_abandon(recorder_t *recorder);

#endif
