/* A TOML file as a flat list in the order of the file; toml++ behind a C interface. It does not interpret
 * the keys.
 *
 * A table or array is followed by its entries, up to its `end`. Entry 0 is the table of the file itself. The
 * entries of a table are in the order of the file. A table that is filled at several places of the file has
 * the position of the first one.
 *
 * Limits: TOML_OCTETS_MAX octets, plain files only, UTF-8 (toml++ checks). For dates and times only the type
 * is returned. */
#ifndef HOST_SIM_LAB_TOML_READER_H
#define HOST_SIM_LAB_TOML_READER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TOML_OCTETS_MAX (UINT32_C(1) << 20) /* [octets] */
#define TOML_WHOLE_FILE "file"              /* the name in an error that concerns the whole file */

typedef enum {
    TOML_TABLE,
    TOML_ARRAY,
    TOML_TEXT,
    TOML_INTEGER,
    TOML_FLOAT,
    TOML_BOOL,
    TOML_TIME
} toml_type_t;

typedef struct {
    const char *key;      /* in its table; "" for elements of an array and entry 0 */
    const char *path;     /* from the top: "at[1].plant.load_torque" */
    const char *text;     /* TOML_TEXT: the value, up to its first NUL; else "" */
    uint64_t text_octets; /* [octets] of the value, including NUL characters */
    int64_t integer;      /* TOML_INTEGER, TOML_BOOL (0, 1) */
    double number;        /* TOML_FLOAT; TOML_INTEGER rounded to nearest */
    toml_type_t type;
    uint32_t parent; /* index of the table or array it belongs to; of entry 0: 0 */
    uint32_t end;  /* index of the first entry that does not belong to it: its next sibling, if it has one */
    uint32_t line; /* [1..] of the key; of elements of an array: of the value */
    uint32_t column; /* [1..] in code points */
} toml_entry_t;

typedef struct {
    toml_entry_t *entries;
    uint32_t count; /* [-] >= 1 */
    char *source;   /* the whole file, 0 at its end */
    size_t octets;  /* [octets] of the source */
} toml_file_t;

typedef struct {
    uint32_t line, column; /* [1..]; 0: the file as a whole */
    char name[64];         /* key on that line, "TOML" if there is none, "file" if it could not be read */
    char message[256];     /* one line */
} toml_error_t;

/* Reads a file and adds it to the inputs (host_sim/lab/inputs.h). NULL: `error` has the message. Free the
 * result with toml_free. */
toml_file_t *toml_read(const char *path, toml_error_t *error);

/* The same from memory; `octets` without a closing 0. */
toml_file_t *toml_read_text(const char *text, size_t octets, toml_error_t *error);

void toml_free(toml_file_t *file);

const char *toml_type_text(toml_type_t type); /* "a table" */

#ifdef __cplusplus
}
#endif

#endif
