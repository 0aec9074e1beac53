#include "talk/store.h"

#include "math/crc.h"

#define BLANK 0xFFFFu

/* Places in a header [words]. */
#define AT_MAGIC   0u
#define AT_VERSION 1u
#define AT_COUNT   2u
#define AT_SERIAL  3u
#define AT_HASH    5u
#define AT_CHECK   7u

/* The state of a page, from its records. */
typedef struct {
    uint32_t page;
    uint32_t end;    /* [words] after the last record */
    uint32_t serial; /* the largest of all headers, committed or not; 0: no record */
    uint32_t last;   /* [words] where the last committed record begins, */
    uint32_t newest; /* and its serial; 0: no record */
    uint32_t count;  /* [-] its pairs */
    bool good;       /* it agrees with its checksum */
    bool blank;      /* the whole page */
    bool clean;      /* nothing after `end` except an unfinished header */
} page_t;

static uint32_t long_at(const store_flash_t *flash, uint32_t page, uint32_t at)
{
    return (uint32_t)flash->word(page, at) | (uint32_t)flash->word(page, at + 1u) << 16;
}

static bool is_blank(const store_flash_t *flash, uint32_t page, uint32_t from, uint32_t to)
{
    for (uint32_t at = from; at < to; at++) {
        if (flash->word(page, at) != BLANK) {
            return false;
        }
    }
    return true;
}

static uint32_t crc_of(const store_flash_t *flash, uint32_t page, uint32_t from, uint32_t count)
{
    uint32_t crc = CRC_BEGIN;
    for (uint32_t n = 0; n < count; n++) {
        crc = crc_add(crc, flash->word(page, from + n));
    }
    return crc_end(crc);
}

/* True if a record begins here, committed or not, that ends within the page. */
static bool is_header(const store_flash_t *flash, uint32_t page, uint32_t at)
{
    return at + STORE_HEADER <= flash->words && flash->word(page, at + AT_MAGIC) == STORE_MAGIC &&
           (crc_of(flash, page, at, AT_CHECK) & 0xFFFFu) == flash->word(page, at + AT_CHECK) &&
           at + store_record_words(flash->word(page, at + AT_COUNT)) <= flash->words;
}

static bool is_good(const store_flash_t *flash, const page_t *page)
{
    const uint32_t words = STORE_HEADER + STORE_PAIR * page->count;
    return flash->word(page->page, page->last + AT_VERSION) == STORE_VERSION &&
           crc_of(flash, page->page, page->last, words) == long_at(flash, page->page, page->last + words);
}

/* Reads the page record by record. */
static page_t read_page(const store_flash_t *flash, uint32_t number)
{
    page_t page = {.page = number};
    while (is_header(flash, number, page.end)) {
        const uint32_t count = flash->word(number, page.end + AT_COUNT);
        const uint32_t words = store_record_words(count);
        const uint32_t serial = long_at(flash, number, page.end + AT_SERIAL);
        page.serial = serial > page.serial ? serial : page.serial;
        if (flash->word(number, page.end + words - 1u) == STORE_COMMIT) {
            page.last = page.end;
            page.newest = serial;
            page.count = count;
        }
        page.end += words;
    }
    page.good = page.newest != 0u && is_good(flash, &page);
    page.clean = is_blank(flash, number, page.end + STORE_HEADER, flash->words);
    page.blank = page.clean && page.end == 0u && is_blank(flash, number, 0u, STORE_HEADER);
    return page;
}

/* Reads both pages; the one whose last record is in use comes first. */
static void look_at_both(const store_flash_t *flash, page_t pages[STORE_PAGES])
{
    const page_t first = read_page(flash, 0u);
    const page_t second = read_page(flash, 1u);
    const bool in_order = first.newest >= second.newest;
    pages[0] = in_order ? first : second;
    pages[1] = in_order ? second : first;
}

/* True if a page has no committed record, but contents that a power failure cannot cause while the other page
 * is unchanged. */
static bool is_junk(const page_t *page)
{
    return page->newest == 0u && !page->clean;
}

/* True if the page begins like a record of which one word of the header is wrong, or if a header is
 * anywhere in it. */
static bool has_trace(const store_flash_t *flash, uint32_t number)
{
    const uint32_t words = store_record_words(flash->word(number, AT_COUNT));
    const bool ends = words <= flash->words && flash->word(number, AT_VERSION) == STORE_VERSION &&
                      flash->word(number, words - 1u) == STORE_COMMIT;
    bool trace = ends || flash->word(number, AT_MAGIC) == STORE_MAGIC;
    for (uint32_t at = 1u; at < flash->words && !trace; at++) {
        trace = is_header(flash, number, at);
    }
    return trace;
}

static store_found_t found(const store_flash_t *flash, const page_t pages[STORE_PAGES])
{
    if (pages[0].newest != 0u) {
        return pages[0].good && pages[0].clean ? STORE_LOADED : STORE_CORRUPT;
    }
    const bool junk = (is_junk(&pages[0]) && (pages[1].blank || is_junk(&pages[1]))) ||
                      (is_junk(&pages[1]) && pages[0].blank);
    if (!junk) {
        return STORE_EMPTY;
    }
    return has_trace(flash, 0u) || has_trace(flash, 1u) ? STORE_CORRUPT : STORE_FOREIGN;
}

/* Takes over one stored value; a value that the row cannot have is reported. */
static void take(const table_t *table, void *base, uint32_t id, uint32_t bits, store_told_t *told)
{
    const table_row_t *row = table_by_id(table, id);
    if (row == NULL) {
        told->unknown++;
        return;
    }
    if (!table_accepts_bits(row, bits)) {
        told->defaulted++;
        return;
    }
    table_set_bits(row, base, bits);
}

store_found_t store_load(const store_flash_t *flash, const table_t *table, void *base, store_told_t *told)
{
    page_t pages[STORE_PAGES];
    *told = (store_told_t){0u, 0u};
    table_defaults(table, base);
    look_at_both(flash, pages);
    const store_found_t what = found(flash, pages);
    if (what != STORE_LOADED) {
        return what;
    }
    const page_t *page = &pages[0];
    uint32_t at = page->last + STORE_HEADER;
    for (uint32_t n = 0; n < page->count; n++) {
        take(table, base, flash->word(page->page, at), long_at(flash, page->page, at + 1u), told);
        at += STORE_PAIR;
    }
    const bool same = long_at(flash, page->page, page->last + AT_HASH) == table_hash(table, 0u);
    return same && told->unknown == 0u && told->defaulted == 0u ? STORE_LOADED : STORE_MIGRATED;
}

/* The place of the next words of a record, and the checksum of the words before them. */
typedef struct {
    const store_flash_t *flash;
    uint32_t page;
    uint32_t at;
    uint32_t crc;
} pen_t;

static bool put(pen_t *pen, const uint16_t *words, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        pen->crc = crc_add(pen->crc, words[n]);
    }
    const uint32_t at = pen->at;
    pen->at += count;
    return pen->flash->program(pen->page, at, words, count);
}

static uint16_t low(uint32_t bits)
{
    return (uint16_t)(bits & 0xFFFFu);
}

static uint16_t high(uint32_t bits)
{
    return (uint16_t)(bits >> 16);
}

static bool put_header(pen_t *pen, const table_t *table, uint32_t serial)
{
    const uint32_t hash = table_hash(table, 0u);
    uint16_t header[STORE_HEADER] = {STORE_MAGIC,  STORE_VERSION, low(table->count), low(serial),
                                     high(serial), low(hash),     high(hash),        0u};
    uint32_t crc = CRC_BEGIN;
    for (uint32_t n = 0; n < AT_CHECK; n++) {
        crc = crc_add(crc, header[n]);
    }
    header[AT_CHECK] = low(crc_end(crc));
    return put(pen, header, STORE_HEADER);
}

static bool put_record(pen_t *pen, const table_t *table, const void *base, uint32_t serial)
{
    bool taken = put_header(pen, table, serial);
    for (uint32_t n = 0; n < table->count && taken; n++) {
        const uint32_t bits = table_bits(&table->rows[n], base);
        const uint16_t pair[STORE_PAIR] = {low(table->rows[n].id), low(bits), high(bits)};
        taken = put(pen, pair, STORE_PAIR);
    }
    const uint32_t crc = crc_end(pen->crc);
    const uint16_t check[] = {low(crc), high(crc)};
    const uint16_t commit = STORE_COMMIT;
    return taken && put(pen, check, 2u) && put(pen, &commit, 1u);
}

/* Writes after the last record of this page, if there is space; the record must then
 * be read back as the one in use. */
static bool append(const store_flash_t *flash, uint32_t number, const table_t *table, const void *base,
                   uint32_t serial)
{
    const page_t page = read_page(flash, number);
    const uint32_t end = page.end + store_record_words(table->count);
    if (!page.clean || end > flash->words || !is_blank(flash, number, page.end, end)) {
        return false;
    }
    pen_t pen = {flash, number, page.end, CRC_BEGIN};
    page_t pages[STORE_PAGES];
    if (!put_record(&pen, table, base, serial)) {
        return false;
    }
    look_at_both(flash, pages);
    return pages[0].newest == serial && found(flash, pages) == STORE_LOADED;
}

bool store_save(const store_flash_t *flash, const table_t *table, const void *base)
{
    page_t pages[STORE_PAGES];
    look_at_both(flash, pages);
    const uint32_t top = pages[0].serial > pages[1].serial ? pages[0].serial : pages[1].serial;
    const uint32_t other = pages[1].page;
    return append(flash, pages[0].page, table, base, top + 1u) ||
           (flash->erase(other) && append(flash, other, table, base, top + 2u));
}

store_found_t store_look(const store_flash_t *flash)
{
    page_t pages[STORE_PAGES];
    look_at_both(flash, pages);
    return found(flash, pages);
}

bool store_erase(const store_flash_t *flash)
{
    page_t pages[STORE_PAGES];
    look_at_both(flash, pages);
    return flash->erase(pages[1].page) && flash->erase(pages[0].page);
}
