/* Tables: the one interface for all external access (CLI, recorder, scenarios, debugger, docs).
 *
 * A row describes one 32-bit slot of a struct: permanent id (ids are appended and never used again), name, SI
 * unit, kind, default, range, text. Ids are unique over all tables: parameters 1..999, requests 1000..1999,
 * signals 2000..2999; the host simulation uses 3000 and up. Look-ups are linear and for the background, not
 * for the interrupt. */
#ifndef CONTRACT_TABLE_H
#define CONTRACT_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
    SLOT_FLOAT,
    SLOT_INT,
    SLOT_UINT,
    SLOT_ENUM, /* int32_t with named values */
    SLOT_KINDS
} slot_kind_t;

typedef enum {
    TABLE_READ, /* displayed, never written by a client */
    TABLE_LIVE, /* may change while the bridge is on */
    TABLE_OFF   /* may change only while the bridge is off */
} table_access_t;

typedef struct {
    int32_t initial, min, max;
} table_whole_t;

typedef struct {
    uint32_t id;
    slot_kind_t kind;
    table_access_t access;
    size_t offset;       /* [chars of the target] of the slot in its struct */
    const char *name;    /* as in C, scenarios and recordings */
    const char *unit;    /* SI; "-" for pure numbers */
    const char *text;    /* one line */
    const char *choices; /* SLOT_ENUM: names of the values from 0 up, "off|on"; else "" */
    /* Default and accepted range, both ends included; TABLE_READ: all 0. The range of a SLOT_ENUM is its
     * choices. */
    float initial, min, max; /* [unit] of a SLOT_FLOAT */
    table_whole_t whole;     /* [unit] of every other kind */
} table_row_t;

/* The one line of a row; a build for a target with little memory leaves it out. */
#ifdef TABLE_WITHOUT_TEXTS
#define TABLE_TEXT(text) ""
#else
#define TABLE_TEXT(text) text
#endif

typedef struct {
    const char *name;
    const table_row_t *rows;
    uint32_t count;
} table_t;

const table_row_t *table_by_id(const table_t *table, uint32_t id);        /* NULL if there is none */
const table_row_t *table_by_name(const table_t *table, const char *name); /* NULL if there is none */

/* The value of the slot as a number, and the inverse; writing stores without a check. As a float, of any
 * kind: integers are rounded to nearest, and those beyond +-2^24 lose their last bits. Whole, of any kind but
 * SLOT_FLOAT: exact. Bits: unchanged. */
float table_get(const table_row_t *row, const void *base);
void table_set(const table_row_t *row, void *base, float value);
int64_t table_whole(const table_row_t *row, const void *base);
void table_set_whole(const table_row_t *row, void *base, int64_t value);
uint32_t table_bits(const table_row_t *row, const void *base);
void table_set_bits(const table_row_t *row, void *base, uint32_t bits);

/* The number that these bits represent in the row's kind, as a float like that of table_get(). */
float table_value_of_bits(const table_row_t *row, uint32_t bits);

/* Ends of the accepted range, of any kind. As a float the end of a whole row is exact up to +-2^24. */
float table_min(const table_row_t *row);
float table_max(const table_row_t *row);
int32_t table_whole_max(const table_row_t *row); /* of a SLOT_ENUM row the number of its last choice */

/* true: the value is finite, whole if the kind requires it, and in the row's range. The second function is
 * for every kind but SLOT_FLOAT, and exact. */
bool table_accepts(const table_row_t *row, float value);
bool table_accepts_whole(const table_row_t *row, int64_t value);
bool table_accepts_bits(const table_row_t *row,
                        uint32_t bits); /* the same for a value in the form of a slot */

/* true: the slot holds a value that its row accepts. */
bool table_holds(const table_row_t *row, const void *base);

/* Sets the slot to its default; the second function does this for every slot of the struct. */
void table_default(const table_row_t *row, void *base);
void table_defaults(const table_t *table, void *base);

/* Number of a named value of a SLOT_ENUM row; -1 if the name is none of its choices. */
int32_t table_choice(const table_row_t *row, const char *name);

/* FNV-1a over ids, names, units, kinds and choices of all rows: for two programs with the same hash an id has
 * the same meaning. */
uint32_t table_hash(const table_t *table, uint32_t seed);

#endif
