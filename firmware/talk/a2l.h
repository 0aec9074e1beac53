/* The description of the tables for calibration tools: an ASAP2 file (A2L 1.6). Each row is a
 * MEASUREMENT, or a CHARACTERISTIC if it can be set, with unit, limits, text and named values; its
 * address is 4 x id, its address extension that of its table. IF_DATA XCP describes the connection to the
 * drive and the signals that it samples. */
#ifndef TALK_A2L_H
#define TALK_A2L_H

#include <stdint.h>

#include "contract/table.h"
#include "talk/a2l_xcp.h"
#include "talk/text.h"

typedef struct {
    const table_t *table;
    uint32_t extension;
} a2l_table_t;

typedef struct {
    const a2l_table_t *tables;
    uint32_t count;
    uint32_t hash; /* over all tables: a drive with another hash needs another file */
    a2l_line_t line;
    xcp_segment_t segment; /* of the parameters */
} a2l_t;

/* The position where a part of the file begins. A later read can start there. All zero: the beginning. */
typedef struct {
    uint32_t part;
    uint32_t at; /* [characters] */
} a2l_place_t;

/* Writes the file up to the end of the window. Only the characters in the window are kept. After the call
 * text->at is the position reached: the end of the file if the window extends beyond it. `place` is then the
 * part of the file in which the window ends. */
void a2l_write(const a2l_t *a2l, a2l_place_t *place, text_t *text);

/* The identification of the file: "lagless-" and eight hex digits. */
void a2l_epk(uint32_t hash, text_t *text);

#endif
