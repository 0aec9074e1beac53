/* Recordings: the rows of a tap as CSV, MAT v5 and MDF 4, the edges of the bridge as VCD; each with what it
 * takes to run it again (table hash, commit, seed, scenario, parameter set).
 *
 * While the ring turns, the sinks only copy slots into memory; recorder_close formats and writes. Bytes
 * depend on what was recorded and on nothing else: no wall clock, no locale, no libm, no compression.
 *
 * Files are written as NAME.csv.partial and renamed to NAME.csv once the disk has taken all of it; what keeps
 * the ending .partial is incomplete. They are created by recorder_open, so that a folder that takes none
 * stops a run before it begins, and locked until they have their names: a second recording of that name is
 * refused meanwhile, by whichever program.
 *
 * CSV: `# key: value` lines, then `time[s],i_q[A],...`, then one line a sample. Floats have the fewest digits
 * that read back to the same float, also by way of double (nan, inf, -inf: any NaN comes back as a NaN);
 * integers and enumerations are integers. Time is that at which the period begins (host_sim/lab/times.h
 * tells its decimals); `period` is its length. What a run's author noted (recorder_note) stands as `# key
 * name: text`, what happened and what was judged. The scenario's lines are those with the key `text`.
 * Characters that would break a comment line are written as \xNN, a backslash as two; data needs neither.
 *
 * MAT: `time` (double, [s]), a column for each row (single, int32, uint32) under its name, and the struct
 * `meta`: format, program, commit, tables, scenario, title, seed, every, period, ended, text, units.NAME,
 * choices.NAME, values.NAME, value_units.NAME, notes (a line each, `key name: text`). A dot in a name is an
 * underscore here, a character beyond 16 bits is U+FFFD. Each variable is read back and compared before the
 * file gets its name.
 *
 * VCD: timescale 1 ns. A tick of 20/3 ns is rounded by at most 1/3 ns, so tick = round(0.15 x time) is exact.
 * Wires upper_a lower_a upper_b lower_b upper_c lower_c (1 = the switch is commanded on; x until the first
 * RIG_EDGE_GATES), isr, adc_start (marked by a pulse of RECORDER_ADC_TICKS), trip. Changes within one tick
 * show their outcome. Only the switched fidelity has edges.
 *
 * MDF: version 4.10, file NAME.mf4, one group of channels, uncompressed: the master `time` (double, [s]),
 * then a channel for each row (32-bit float, int, uint) under its name of CSV, with its unit and text; the
 * names of an enumeration's numbers are a conversion from value to text. The file's comment contains what the
 * head of CSV does. The measurement begins at the clock's zero.
 *
 * A row whose name two tables have is called table.row in CSV and MDF. Going back in time (rig_load of an
 * earlier state) takes back what was recorded after it. Not handled: gaps; every recording is one run. */
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
#define RECORDER_SAMPLED (RECORDER_CSV | RECORDER_MAT | RECORDER_MDF) /* those that hold rows of a tap */

/* The formats that a text names, "csv,mdf"; 0: a word that names none, or no word. */
uint32_t recorder_formats(const char *text);

/* Ending of the file in the n-th format, without dot. */
const char *recorder_ending(uint32_t n);

/* [octets] 1 GiB holds 20 million samples of 12 rows, and keeps every variable of MAT v5 below its 2 GiB. */
#define RECORDER_MEMORY_MIN (UINT32_C(4) << 20)
#define RECORDER_MEMORY_MAX (UINT32_C(1) << 30)

#define RECORDER_ADC_TICKS UINT64_C(30) /* [1/150 MHz] */

/* A setting of the run: any row that decided its course. */
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
    uint32_t count;      /* [-] 1..RIG_TAP_MAX; 0 if only VCD is wanted */
    uint32_t every;      /* [periods] from sample to sample, >= 1: the same as in rig_tap */
    uint32_t periods;    /* [periods] planned; 0: not known */
    uint32_t memory;     /* [octets] RECORDER_MEMORY_MIN..RECORDER_MEMORY_MAX; 0: the most */
    uint32_t isr_ticks;  /* [1/150 MHz] that an interrupt shall be shown to take, >= 1 for VCD: the simulated
                            one takes none */
    recorder_meta_t meta;
} recorder_options_t;

typedef struct {
    char text[1024]; /* one line, no full stop */
    bool io;         /* a file could not be written; else an option is wrong */
} recorder_error_t;

typedef struct recorder recorder_t;

/* Copies all it is given and creates the files. NULL, and no file left behind: an option out of its range, an
 * unknown or repeated row, a file that cannot be made, a plan that does not fit into the memory; `error` says
 * which. */
recorder_t *recorder_open(const recorder_options_t *options, recorder_error_t *error);

/* The sinks; context is the recorder. recorder_sink is a rig_sink_t: it copies count + 1 words. recorder_edge
 * is an rig_edge_sink_t. When the memory is used up they count what is lost, and recorder_close says so. */
void recorder_sink(void *recorder, uint32_t period, const uint32_t *slots, uint32_t count);
void recorder_edge(void *recorder, uint64_t tick, uint32_t what, uint32_t value);

/* One more line about the run, in the order of the calls: RECORDER_EVENT with its time for a name, what was
 * set; RECORDER_VERDICT with how it was judged for a name, the sentence. The texts are copied, and are one
 * line each. false: no memory. */
#define RECORDER_EVENT   "event"
#define RECORDER_VERDICT "verdict"
bool recorder_note(recorder_t *recorder, const char *key, const char *name, const char *text);

/* Samples recorded so far. */
uint64_t recorder_samples(const recorder_t *recorder);

/* Writes everything out and frees the recorder. `ended` says in the files how the run came to its end
 * ("complete", "interrupted"). false: something is missing, `error` says what and how the file is called; the
 * other files are good. About 0.4 us a sample of 12 rows for CSV. */
bool recorder_close(recorder_t *recorder, const char *ended, recorder_error_t *error);

/* Frees the recorder and removes its files. NULL is fine. */
void recorder_abandon(recorder_t *recorder);

#endif
