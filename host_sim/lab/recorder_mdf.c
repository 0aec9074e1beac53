/* Samples as MDF 4.10 (ASAM), one group of channels without compression.
 *
 * A file is a chain of blocks: identifier, length, links (addresses of other blocks in the file), data. All
 * but the samples is made in memory, where a link can be set as soon as its block has an address; the samples
 * follow as the last block. Numbers are little endian on every machine. The start of the measurement
 * is 0, because no octet may depend on the clock.
 *
 * The comment of the head (XML) has the title, the properties of the run, its settings as a tree, its notes,
 * a line each, and the scenario's text. A channel has name, unit and text of its row; the master is `time`.
 * The names of an enumeration's numbers are a conversion. */
#include "host_sim/lab/recorder_parts.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/times.h"
#include "host_sim/lab/xml.h"

#define LINK      8u  /* [octets] */
#define HEAD      24u /* [octets] identifier, 4 reserved, length, number of links */
#define LENGTH_AT 8u  /* [octets] place of the length in a block */
#define VERSION   410u

/* Positions of the links that are set, in their blocks. */
enum { HD_GROUP = 0, HD_HISTORY = 1, HD_COMMENT = 5, HD_LINKS };
enum { FH_COMMENT = 1, FH_LINKS };
enum { DG_CHANNELS = 1, DG_DATA = 2, DG_LINKS = 4 };
enum { CG_CHANNEL = 1, CG_NAME = 2, CG_LINKS = 6 };
enum { CN_NEXT = 0, CN_NAME = 2, CN_CONVERSION = 4, CN_UNIT = 6, CN_COMMENT = 7, CN_LINKS };
enum { CC_TEXTS = 4 }; /* first of the links: one for each choice, and one for all other numbers */

/* Sizes of the data that follow the links [octets]. */
enum { HD_DATA = 32, FH_DATA = 16, DG_DATA_SIZE = 8, CG_DATA = 32, CN_DATA = 72, CC_DATA = 24 };

enum { MASTER = 2, TIME = 1 };                           /* type and synchronisation of a channel */
enum { WHOLE_UNSIGNED = 0, WHOLE_SIGNED = 2, REAL = 4 }; /* kinds of its data, little endian */
enum { VALUE_TO_TEXT = 7 };                              /* type of a conversion */

/* The part before the samples. */
typedef struct {
    unsigned char *octets;
    size_t used, room; /* [octets] */
    bool failed;       /* true: there was no memory, and the octets are incomplete */
} image_t;

/* Appends zeros and returns their position. */
static size_t grow(image_t *image, size_t octets)
{
    const size_t at = image->used;
    if (!image->failed && at + octets > image->room) {
        const size_t room = 2u * image->room + octets + 4096u;
        unsigned char *more = realloc(image->octets, room);
        image->failed = more == NULL;
        if (more != NULL) {
            image->octets = more;
            image->room = room;
        }
    }
    if (image->failed) {
        return 0;
    }
    memset(image->octets + at, 0, octets);
    image->used = at + octets;
    return at;
}

static void put(image_t *image, size_t at, uint64_t value, size_t octets)
{
    for (size_t n = 0; n < octets && !image->failed; n++) {
        image->octets[at + n] = (unsigned char)(value >> 8u * n);
    }
}

static uint64_t double_bits(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* ---- blocks ---- */

/* A block of zeros with its head; its address. */
static size_t block(image_t *image, const char *name, size_t links, size_t data)
{
    const size_t length = HEAD + LINK * links + data;
    const size_t at = grow(image, length);
    for (size_t n = 0; n < 4u; n++) {
        put(image, at + n, n < 2u ? '#' : (unsigned char)name[n - 2u], 1);
    }
    put(image, at + LENGTH_AT, length, 8);
    put(image, at + 16u, links, 8);
    return at;
}

static void link_to(image_t *image, size_t at, size_t link, size_t target)
{
    put(image, at + HEAD + LINK * link, target, 8);
}

/* Place of an octet of the data. */
static size_t data_at(size_t at, size_t links, size_t offset)
{
    return at + HEAD + LINK * links + offset;
}

/* The last block, to which text was added, gets its length; it ends with a 0, at a multiple of 8. */
static void close_text(image_t *image, size_t at)
{
    (void)grow(image, 8u - image->used % 8u);
    put(image, at + LENGTH_AT, image->used - at, 8);
}

/* ---- text ---- */

/* Adds UTF-8 that XML accepts: invalid characters become U+FFFD, markup becomes an entity, a control
 * character \xNN. */
static void add_text(image_t *image, const char *text, bool xml)
{
    while (*text != '\0') {
        char part[8];
        const uint32_t code = recorder_utf8(&text);
        size_t length;
        const char *entity = xml ? xml_entity(code) : NULL;
        if (entity != NULL) {
            length = (size_t)snprintf(part, sizeof part, "%s", entity);
        } else if (code == 0x7Fu || (code < 0x20u && code != '\n' && code != '\t')) {
            length = (size_t)snprintf(part, sizeof part, "\\x%02x", (unsigned)code);
        } else {
            length = recorder_utf8_text(part, code);
        }
        const size_t at = grow(image, length);
        for (size_t n = 0; n < length; n++) {
            put(image, at + n, (unsigned char)part[n], 1);
        }
    }
}

static void add_plain(image_t *image, const char *markup)
{
    add_text(image, markup, false);
}

static size_t text_block(image_t *image, const char *text)
{
    const size_t at = block(image, "TX", 0, 0);
    add_text(image, text, false);
    close_text(image, at);
    return at;
}

/* <e name="NAME" unit="UNIT">, for a text and </e>; a unit of NULL is left out. */
static void begin_entry(image_t *image, const char *name, const char *unit)
{
    add_plain(image, "<e name=\"");
    add_text(image, name, true);
    if (unit != NULL) {
        add_plain(image, "\" unit=\"");
        add_text(image, unit, true);
    }
    add_plain(image, "\">");
}

static void add_entry(image_t *image, const char *name, const char *unit, const char *text)
{
    begin_entry(image, name, unit);
    add_text(image, text, true);
    add_plain(image, "</e>\n");
}

static void add_settings(image_t *image, const recorder_t *recorder)
{
    add_plain(image, "<tree name=\"settings\">\n");
    for (uint32_t n = 0; n < recorder->value_count; n++) {
        char text[RECORDER_NUMBER_SIZE + 1u];
        text[recorder_value_text(text, recorder->values[n].value)] = '\0';
        add_entry(image, recorder->values[n].name, recorder->values[n].unit, text);
    }
    add_plain(image, "</tree>\n");
}

static void add_notes(image_t *image, const recorder_t *recorder)
{
    begin_entry(image, "notes", NULL);
    for (uint32_t n = 0; n < recorder->note_count; n++) {
        const recorder_line_t *note = &recorder->notes[n];
        add_text(image, note->key, true);
        add_plain(image, " ");
        add_text(image, note->name, true);
        add_plain(image, ": ");
        add_text(image, note->text, true);
        add_plain(image, "\n");
    }
    add_plain(image, "</e>\n");
}

static size_t head_comment(image_t *image, const recorder_t *recorder)
{
    char text[TIMES_TEXT_SIZE + RECORDER_NUMBER_SIZE];
    const size_t at = block(image, "MD", 0, 0);
    add_plain(image, "<HDcomment xmlns=\"http://www.asam.net/mdf/v4\">\n<TX>");
    add_text(image, recorder->title, true);
    add_plain(image, "</TX>\n<common_properties>\n");
    add_entry(image, "program", NULL, recorder->program);
    add_entry(image, "commit", NULL, recorder->commit);
    snprintf(text, sizeof text, "0x%08x", (unsigned)recorder->tables_hash);
    add_entry(image, "tables", NULL, text);
    add_entry(image, "scenario", NULL, recorder->scenario);
    text[recorder_uint_text(text, recorder->seed)] = '\0';
    add_entry(image, "seed", NULL, text);
    text[recorder_uint_text(text, recorder->every)] = '\0';
    add_entry(image, "every", NULL, text);
    times_period_text(text, RIG_PERIOD_TICKS);
    add_entry(image, "period", "s", text);
    add_entry(image, "ended", NULL, recorder->ended);
    add_settings(image, recorder);
    add_notes(image, recorder);
    add_entry(image, "text", NULL, recorder->scenario_text);
    add_plain(image, "</common_properties>\n</HDcomment>\n");
    close_text(image, at);
    return at;
}

/* The program that wrote the file: the format requires it. */
static size_t history(image_t *image, const recorder_t *recorder)
{
    const size_t at = block(image, "FH", FH_LINKS, FH_DATA);
    const size_t comment = block(image, "MD", 0, 0);
    add_plain(
        image,
        "<FHcomment xmlns=\"http://www.asam.net/mdf/v4\">\n<TX>recording</TX>\n<tool_id>lagless</tool_id>\n"
        "<tool_vendor>lagless</tool_vendor>\n<tool_version>");
    add_text(image, recorder->program, true);
    add_plain(image, "</tool_version>\n</FHcomment>\n");
    close_text(image, comment);
    link_to(image, at, FH_COMMENT, comment);
    return at;
}

/* ---- channels ---- */

/* The names of the numbers 0, 1, ... of an enumeration. */
static size_t choices_conversion(image_t *image, const char *choices)
{
    uint32_t count = 1;
    for (const char *c = choices; *c != '\0'; c++) {
        count += *c == '|' ? 1u : 0u;
    }
    const uint32_t links = CC_TEXTS + count + 1u;
    const size_t at = block(image, "CC", links, CC_DATA + 8u * (size_t)count);
    const size_t data = data_at(at, links, 0);
    put(image, data, VALUE_TO_TEXT, 1);
    put(image, data + 4u, count + 1u, 2); /* links to texts */
    put(image, data + 6u, count, 2);
    for (uint32_t n = 0; n < count; n++) {
        char name[RECORDER_NAME_SIZE];
        const size_t length = strcspn(choices, "|");
        snprintf(name, sizeof name, "%.*s", (int)length, choices);
        choices += length + (choices[length] == '|' ? 1u : 0u);
        put(image, data + CC_DATA + 8u * (size_t)n, double_bits((double)n), 8);
        link_to(image, at, CC_TEXTS + n, text_block(image, name));
    }
    return at;
}

/* Type and synchronisation stay 0 for all but the master. */
static size_t channel(image_t *image, const char *name, const char *unit, uint32_t offset, uint32_t bits)
{
    const size_t at = block(image, "CN", CN_LINKS, CN_DATA);
    link_to(image, at, CN_NAME, text_block(image, name));
    link_to(image, at, CN_UNIT, text_block(image, unit));
    put(image, data_at(at, CN_LINKS, 4), offset, 4);
    put(image, data_at(at, CN_LINKS, 8), bits, 4);
    return at;
}

static size_t time_channel(image_t *image)
{
    const size_t at = channel(image, "time", "s", 0, 64);
    put(image, data_at(at, CN_LINKS, 0), MASTER, 1);
    put(image, data_at(at, CN_LINKS, 1), TIME, 1);
    put(image, data_at(at, CN_LINKS, 2), REAL, 1);
    return at;
}

static size_t row_channel(image_t *image, const recorder_column_t *column, uint32_t offset)
{
    const table_row_t *row = column->row;
    const size_t at = channel(image, column->name, row->unit, offset, 32);
    link_to(image, at, CN_COMMENT, text_block(image, row->text));
    put(image, data_at(at, CN_LINKS, 2),
        row->kind == SLOT_FLOAT  ? REAL
        : row->kind == SLOT_UINT ? WHOLE_UNSIGNED
                                 : WHOLE_SIGNED,
        1);
    if (row->kind == SLOT_ENUM) {
        link_to(image, at, CN_CONVERSION, choices_conversion(image, row->choices));
    }
    return at;
}

/* The group with all its channels; its links to data stay open. */
static size_t group(image_t *image, const recorder_t *recorder)
{
    const size_t channels = block(image, "CG", CG_LINKS, CG_DATA);
    put(image, data_at(channels, CG_LINKS, 8), recorder_store_count(&recorder->rows), 8);
    put(image, data_at(channels, CG_LINKS, 24), 8u + 4u * (uint64_t)recorder->column_count, 4);
    link_to(image, channels, CG_NAME, text_block(image, "period"));
    size_t last = time_channel(image);
    link_to(image, channels, CG_CHANNEL, last);
    for (uint32_t c = 0; c < recorder->column_count; c++) {
        const size_t next = row_channel(image, &recorder->columns[c], 8u + 4u * c);
        link_to(image, last, CN_NEXT, next);
        last = next;
    }
    const size_t at = block(image, "DG", DG_LINKS, DG_DATA_SIZE);
    link_to(image, at, DG_CHANNELS, channels);
    return at;
}

/* Everything before the samples, the head of their block included. */
static void build(image_t *image, const recorder_t *recorder)
{
    static const char identification[] = "MDF     4.10    lagless";
    const size_t start = grow(image, 64);
    for (size_t n = 0; n < sizeof identification; n++) { /* with its 0 */
        put(image, start + n, (unsigned char)identification[n], 1);
    }
    put(image, start + 28u, VERSION, 2);
    const size_t head =
        block(image, "HD", HD_LINKS, HD_DATA); /* the format requires this block before the samples */
    link_to(image, head, HD_COMMENT, head_comment(image, recorder));
    link_to(image, head, HD_HISTORY, history(image, recorder));
    const size_t data_group = group(image, recorder);
    link_to(image, head, HD_GROUP, data_group);
    const size_t data = block(image, "DT", 0, 0);
    const uint64_t octets =
        recorder_store_count(&recorder->rows) * (8u + 4u * (uint64_t)recorder->column_count);
    put(image, data + LENGTH_AT, HEAD + octets, 8);
    link_to(image, data_group, DG_DATA, data);
}

/* ---- the file ---- */

static void put_record(recorder_out_t *out, const uint32_t *sample, uint32_t columns)
{
    const size_t octets = 8u + 4u * (size_t)columns;
    unsigned char *to = (unsigned char *)recorder_out_room(out, octets);
    const uint64_t time = double_bits(times_seconds(sample[0], RIG_PERIOD_TICKS));
    for (uint32_t n = 0; n < 8u; n++) {
        *to++ = (unsigned char)(time >> 8u * n);
    }
    for (uint32_t c = 1; c <= columns; c++) {
        for (uint32_t n = 0; n < 4u; n++) {
            *to++ = (unsigned char)(sample[c] >> 8u * n);
        }
    }
    out->used += octets;
}

int recorder_mdf_write(const recorder_t *recorder, recorder_out_t *out)
{
    image_t image = {.octets = NULL};
    build(&image, recorder);
    for (size_t n = 0; n < image.used && !image.failed; n++) {
        *recorder_out_room(out, 1) = (char)image.octets[n];
        out->used++;
    }
    const bool failed = image.failed;
    free(image.octets);
    if (failed) {
        return ENOMEM;
    }
    const uint64_t count = recorder_store_count(&recorder->rows);
    for (uint64_t n = 0; n < count && out->error == 0; n++) {
        put_record(out, recorder_store_at(&recorder->rows, n), recorder->column_count);
    }
    recorder_out_flush(out);
    return out->error;
}
