/* Data and functions that the sources of the recorder share. */
#ifndef HOST_SIM_LAB_RECORDER_PARTS_H
#define HOST_SIM_LAB_RECORDER_PARTS_H

#include <stdio.h>

#include "contract/table.h"
#include "host_sim/lab/recorder.h"
#include "host_sim/rig/rig.h"

#define RECORDER_NAME_SIZE 128u

/* ---- records of one size, in chunks ---- */

typedef struct {
    char **chunks;
    uint32_t chunk_count;   /* [-] in use */
    uint32_t chunk_room;    /* [-] of the array */
    uint32_t record_octets; /* [octets] */
    uint32_t chunk_records; /* [-] */
    char *next;             /* place of the next record */
    uint32_t left;          /* [-] records that still fit into the last chunk */
} recorder_store_t;

static inline uint64_t recorder_store_count(const recorder_store_t *store)
{
    return (uint64_t)store->chunk_count * store->chunk_records - store->left;
}

static inline const void *recorder_store_at(const recorder_store_t *store, uint64_t n)
{
    return store->chunks[n / store->chunk_records] + n % store->chunk_records * store->record_octets;
}

/* ---- the recorder ---- */

/* An edge as stored: tick << 16 | what << 8 | value. */
typedef uint64_t recorder_edge_t;

typedef struct {
    const table_row_t *row;
    char name[RECORDER_NAME_SIZE]; /* "i_q", or "plant.inertia" where two tables have the name */
} recorder_column_t;

typedef struct {
    uint32_t format;    /* [-] one of RECORDER_CSV, ...; 0: none */
    char *path;         /* final */
    char *partial_path; /* while it is written */
    FILE *file;         /* open from the beginning; for MAT only to reserve the name */
    int claim;          /* holds the partial file's lock until it has its final name; -1: none */
} recorder_file_t;

/* A recorder_value_t with its own texts. */
typedef struct {
    char *name;
    char *unit;
    double value; /* [unit] */
} recorder_setting_t;

typedef struct {
    const char *key; /* text of the caller, which must remain valid */
    char *name;
    char *text;
} recorder_line_t;

struct recorder {
    recorder_store_t rows;          /* period, then a slot for each column */
    recorder_store_t edges;         /* recorder_edge_t */
    uint32_t memory_left;           /* [octets] */
    uint32_t last_period;           /* [periods] of the last sample, stored or lost; valid if there is one */
    uint64_t last_tick;             /* [1/150 MHz] of the last edge, stored or lost; valid if there is one */
    uint64_t lost_rows, lost_edges; /* [-] lost because the memory was full */
    uint32_t first_lost_period;     /* [periods] */
    uint64_t first_lost_tick;       /* [1/150 MHz] */

    recorder_column_t columns[RIG_TAP_MAX];
    uint32_t column_count; /* [-] */
    uint32_t every;        /* [periods] */
    uint32_t isr_ticks;    /* [1/150 MHz] */
    recorder_file_t files[RECORDER_FORMATS];
    uint32_t tables_hash; /* [-] */
    char *program, *commit, *scenario, *scenario_text, *title;
    const char *ended;
    uint64_t seed; /* [-] */
    recorder_setting_t *values;
    uint32_t value_count; /* [-] */
    recorder_line_t *notes;
    uint32_t note_count; /* [-] */
};

/* ---- text: recorder_text.c ---- */

#define RECORDER_NUMBER_SIZE 24u

/* Each function writes a number to `to` (at least RECORDER_NUMBER_SIZE octets, without closing 0) and returns
 * its length. Floats have the fewest digits that give the same float when they are read. */
size_t recorder_float_text(char *to, uint32_t bits);
size_t recorder_uint_text(char *to, uint64_t value);
size_t recorder_int_text(char *to, int32_t value);
size_t recorder_slot_text(char *to, slot_kind_t kind, uint32_t slot);
size_t recorder_value_text(char *to,
                           double value); /* a whole number below 2^53 exactly, others as the nearest float */

/* Reads the next character of a UTF-8 text that has not ended. Octets that are not a character give
 * RECORDER_NO_CHARACTER. */
#define RECORDER_NO_CHARACTER UINT32_C(0xFFFD)
uint32_t recorder_utf8(const char **text);
/* Writes a character as UTF-8 without closing 0. Returns its length. */
size_t recorder_utf8_text(char to[4], uint32_t code);

/* A file with a buffer; the first error is stored. */
#define RECORDER_BUFFER 65536u
typedef struct {
    FILE *file;
    size_t used; /* [octets] of the buffer */
    int error;   /* errno of the first write that failed; 0: none */
    char buffer[RECORDER_BUFFER];
} recorder_out_t;

/* Room for this number of octets (at most RECORDER_BUFFER) in the buffer; the caller writes and adds to
 * `used`. */
char *recorder_out_room(recorder_out_t *out, size_t octets);
void recorder_out_flush(recorder_out_t *out);
void recorder_out_text(recorder_out_t *out, const char *text);
/* In `also`: every octet that is no printable ASCII. */
#define RECORDER_ALL_BUT_ASCII "\x80"

/* Writes a text as one line of comment: control characters and those in `also` as \xNN, a backslash as \\. */
void recorder_out_escaped(recorder_out_t *out, const char *text, size_t length, const char *also);
/* Writes all data about the run, with `prefix` before each line. */
void recorder_out_meta(recorder_out_t *out, const recorder_t *recorder, const char *prefix, const char *also);

/* ---- formats: each writes the whole file and returns 0, or the errno of the error ---- */

int recorder_csv_write(const recorder_t *recorder, recorder_out_t *out);
int recorder_vcd_write(const recorder_t *recorder, recorder_out_t *out);
int recorder_mdf_write(const recorder_t *recorder, recorder_out_t *out);
bool recorder_mat_write(const recorder_t *recorder, const char *path, recorder_error_t *error);

#endif
