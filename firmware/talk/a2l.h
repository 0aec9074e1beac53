/* The description of the tables for calibration tools: an ASAP2 file (A2L 1.6). Each row is a MEASUREMENT, or
 * a CHARACTERISTIC where it can be set, with unit, limits, text and named values; its address is 4 x id, its
 * address extension that of its table. How the drive is reached, and what it samples, is IF_DATA XCP. */
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
    uint32_t hash; /* over all tables: a file that does not fit to a drive is known by it */
    a2l_line_t line;
    xcp_segment_t segment; /* of the parameters */
} a2l_t;

/* Where a part of the file begins, so that who reads on need not begin at its beginning. All zero: there. */
typedef struct {
    uint32_t part;
    uint32_t at; /* [characters] */
} a2l_place_t;

/* The file up to the end of the window, which decides what of it is kept; text->at says behind that how far
 * it came: to the file's end, if the window goes on behind it. `place` is that of the window's part
 * afterwards. */
void a2l_write(const a2l_t *a2l, a2l_place_t *place, text_t *text);

/* Its identification: "lagless-" and eight hex digits. */
void a2l_epk(uint32_t hash, text_t *text);

#endif
