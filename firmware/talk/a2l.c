#include "talk/a2l.h"

#include "contract/line.h"

#define LARGEST "3.4028235e38"

static void number(text_t *text, uint32_t value)
{
    text_put_octet(text, ' ');
    text_whole(text, (int64_t)value);
}

static void address(text_t *text, uint32_t value)
{
    text_put(text, " 0x");
    text_hex(text, value, 8u);
}

void a2l_epk(uint32_t hash, text_t *text)
{
    text_put(text, "lagless-");
    text_hex(text, hash, 8u);
}

/* ---- rows ---- */

/* Lower and upper limit; a read-only value has the limits of its type. */
static void limits(const table_row_t *row, text_t *text)
{
    const bool shown = row->access == TABLE_READ;
    text_put_octet(text, ' ');
    if (row->kind == SLOT_FLOAT && shown) {
        text_put(text, "-" LARGEST " " LARGEST);
    } else if (row->kind == SLOT_FLOAT) {
        text_float(text, row->min);
        text_put_octet(text, ' ');
        text_float(text, row->max);
    } else if (line_has_codes(row)) {
        text_put(text, "0 4294967295");
    } else if (row->kind == SLOT_ENUM) {
        text_put(text, "0 ");
        text_whole(text, table_whole_max(row));
    } else if (shown) {
        text_put(text, row->kind == SLOT_UINT ? "0 4294967295" : "-2147483648 2147483647");
    } else {
        text_whole(text, row->whole.min);
        text_put_octet(text, ' ');
        text_whole(text, row->whole.max);
    }
}

/* The conversion of named values, and its table. */
static void conversion(const table_row_t *row, text_t *text)
{
    text_put(text, "    /begin COMPU_METHOD CM.");
    text_put(text, row->name);
    text_put(text, " \"\" TAB_VERB \"%.0\" \"\" COMPU_TAB_REF CT.");
    text_put(text, row->name);
    text_put(text, " /end COMPU_METHOD\n    /begin COMPU_VTAB CT.");
    text_put(text, row->name);
    text_put(text, " \"\" TAB_VERB");
    number(text, (uint32_t)table_whole_max(row) + 1u);
    uint32_t value = 0u;
    number(text, line_bits(row, value));
    text_put(text, " \"");
    for (const char *c = row->choices; *c != '\0'; c++) {
        if (*c == '|') {
            value++;
            text_put_octet(text, '"');
            number(text, line_bits(row, value));
            text_put(text, " \"");
        } else {
            text_put_octet(text, (uint16_t)*c);
        }
    }
    text_put(text, "\" /end COMPU_VTAB\n");
}

static const char *type_of(const table_row_t *row)
{
    return row->kind == SLOT_FLOAT                         ? "FLOAT32_IEEE"
           : row->kind == SLOT_UINT || line_has_codes(row) ? "ULONG"
                                                           : "SLONG";
}

static void method(const table_row_t *row, text_t *text)
{
    if (row->kind == SLOT_ENUM) {
        text_put(text, " CM.");
        text_put(text, row->name);
    } else {
        text_put(text, " NO_COMPU_METHOD");
    }
}

static void describe(const table_row_t *row, uint32_t extension, text_t *text)
{
    const bool shown = row->access == TABLE_READ;
    const char *object = shown ? "MEASUREMENT" : "CHARACTERISTIC";
    if (row->kind == SLOT_ENUM) {
        conversion(row, text);
    }
    text_put(text, "    /begin ");
    text_put(text, object);
    text_put_octet(text, ' ');
    text_put(text, row->name);
    text_put_octet(text, ' ');
    text_quoted(text, row->text);
    if (shown) {
        text_put_octet(text, ' ');
        text_put(text, type_of(row));
        method(row, text);
        text_put(text, " 0 0");
        limits(row, text);
        text_put(text, " ECU_ADDRESS");
        address(text, 4u * row->id);
    } else {
        text_put(text, " VALUE");
        address(text, 4u * row->id);
        text_put(text, " RL.");
        text_put(text, type_of(row));
        text_put(text, " 0");
        method(row, text);
        limits(row, text);
    }
    text_put(text, " ECU_ADDRESS_EXTENSION");
    number(text, extension);
    text_put(text, " PHYS_UNIT ");
    text_quoted(text, row->unit);
    text_put(text, " /end ");
    text_put(text, object);
    text_put_octet(text, '\n');
}

/* A group of a table's rows: those that can only be read, or those that can be set. */
static void group(const table_t *table, bool shown, text_t *text)
{
    uint32_t count = 0u;
    for (uint32_t n = 0; n < table->count; n++) {
        if ((table->rows[n].access == TABLE_READ) == shown) {
            if (count == 0u) {
                text_put(text, shown ? " /begin REF_MEASUREMENT" : " /begin REF_CHARACTERISTIC");
            }
            text_put(text, count % 8u == 0u ? "\n      " : " ");
            text_put(text, table->rows[n].name);
            count++;
        }
    }
    if (count != 0u) {
        text_put(text, shown ? " /end REF_MEASUREMENT" : " /end REF_CHARACTERISTIC");
    }
}

static void groups(const table_t *of, text_t *text)
{
    text_put(text, "    /begin GROUP ");
    text_put(text, of->name);
    text_put(text, " \"\" ROOT");
    group(of, false, text);
    group(of, true, text);
    text_put(text, " /end GROUP\n");
}

/* ---- the file ---- */

static void layout(const char *type, text_t *text)
{
    text_put(text, "    /begin RECORD_LAYOUT RL.");
    text_put(text, type);
    text_put(text, " FNC_VALUES 1 ");
    text_put(text, type);
    text_put(text, " COLUMN_DIR DIRECT /end RECORD_LAYOUT\n");
}

static void head(const a2l_t *a2l, text_t *text)
{
    text_put(text, "    /begin MOD_PAR \"\" ADDR_EPK 0x0 EPK \"");
    a2l_epk(a2l->hash, text);
    text_put(text, "\"\n");
    a2l_xcp_segment(&a2l->segment, text);
    text_put(text, "/end MOD_PAR\n    /begin MOD_COMMON \"\" BYTE_ORDER MSB_LAST ALIGNMENT_BYTE 1 "
                   "ALIGNMENT_WORD 2 ALIGNMENT_LONG 4 ALIGNMENT_FLOAT32_IEEE 4 /end MOD_COMMON\n");
    layout("FLOAT32_IEEE", text);
    layout("SLONG", text);
    layout("ULONG", text);
}

#define PARTS_BEFORE 3u /* parts before the tables */

static void beginning(const a2l_t *a2l, uint32_t number, text_t *text)
{
    if (number == 0u) {
        text_put(text, "ASAP2_VERSION 1 61\n/begin PROJECT lagless \"\"\n"
                       "  /begin MODULE drive \"lagless drive\"\n");
        a2l_xcp_grammar(text);
    } else if (number == 1u) {
        head(a2l, text);
    } else {
        a2l_xcp(&a2l->line, text);
    }
}

/* The file's parts, in their order: the grammar, the head, the protocol, the rows of each table followed by
 * its group, the end. false: the part does not exist. */
static bool part(const a2l_t *a2l, uint32_t number, text_t *text)
{
    if (number < PARTS_BEFORE) {
        beginning(a2l, number, text);
        return true;
    }
    uint32_t first = PARTS_BEFORE;
    for (uint32_t n = 0; n < a2l->count; n++) {
        const table_t *of = a2l->tables[n].table;
        if (number < first + of->count) {
            describe(&of->rows[number - first], a2l->tables[n].extension, text);
            return true;
        }
        if (number == first + of->count) {
            groups(of, text);
            return true;
        }
        first += of->count + 1u;
    }
    if (number == first) {
        text_put(text, "  /end MODULE\n/end PROJECT\n");
    }
    return number == first;
}

void a2l_write(const a2l_t *a2l, a2l_place_t *place, text_t *text)
{
    if (place->at > text->from) {
        *place = (a2l_place_t){0u, 0u};
    }
    uint32_t number = place->part;
    text->at = place->at;
    bool more = true;
    while (more && text->at < text->to) {
        if (text->at <= text->from) {
            *place = (a2l_place_t){number, text->at};
        }
        more = part(a2l, number, text);
        number++;
    }
}
