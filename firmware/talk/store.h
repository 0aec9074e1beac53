/* The store: sets of parameters in non-volatile memory. A power failure at any moment
 * leaves the old set or the new one.
 *
 * There are two pages of flash, each erased as a whole: erasing sets all bits to one, and programming changes
 * them to zero. A page is a log of records, written one after the other from its beginning:
 *
 *     header   magic, version, count, serial (2), hash of the table (2), check of these    8 words
 *     pairs    id, bits of the value (2: low word first)                                   3 words each
 *     check    CRC-32 of all words before it (2)                                           2 words
 *     commit   STORE_COMMIT                                                                1 word
 *
 * They are programmed in this order, so a record without its last word is invalid. The serial grows with
 * every record; the committed record with the largest serial is in use. A new record is written after it, or,
 * if there is no space, into the other page, which is erased first: the set in use is never changed.
 *
 * A power failure can leave the following contents: a record without commit, which is skipped; a header that
 * does not agree with its check and has nothing after it, in which case the next record is written into the
 * other page; a page that is partly erased, while the other one contains the set in use. All other errors are
 * not caused by a power failure and are reported as corrupt: a committed record that does not agree with its
 * check and would be in use; data after the last record of the page in use, which a damaged header can cause;
 * a damaged record without a set in the other page. One damage cannot be distinguished from a power failure:
 * that of the header of the first and only record of a page, while the other page still holds older records;
 * these are loaded then.
 *
 * Contents without any trace of a record were written by another program. They are reported as foreign, not
 * as corrupt, and stay until store_erase().
 *
 * A set is stored by ids, so that another version of the program can read it: see store_load(). */
#ifndef TALK_STORE_H
#define TALK_STORE_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/table.h"

#define STORE_PAGES   2u
#define STORE_MAGIC   0x4C47u
#define STORE_VERSION 1u
#define STORE_COMMIT  0x5A3Cu
#define STORE_HEADER  8u /* [words] */
#define STORE_PAIR    3u /* [words] */
#define STORE_END     3u /* [words] check and commit */

/* The memory; each call is like that of hal.h. */
typedef struct {
    uint16_t (*word)(uint32_t page, uint32_t at);
    bool (*erase)(uint32_t page);
    bool (*program)(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count);
    uint32_t words; /* [16-bit words] of a page */
} store_flash_t;

typedef enum {
    STORE_EMPTY,    /* nothing has ever been stored */
    STORE_LOADED,   /* the set in use, from an equivalent table */
    STORE_MIGRATED, /* the set in use, but from another table, or some of its values were not accepted */
    STORE_CORRUPT,  /* the stored data cannot be trusted */
    STORE_FOREIGN   /* the pages hold data of another program, and no set */
} store_found_t;

typedef struct {
    uint32_t unknown;   /* [-] stored rows that the table does not have: ignored */
    uint32_t defaulted; /* [-] stored values that their rows do not accept: replaced by their defaults */
} store_told_t;

/* Loads the set in use, row by row by their ids. Rows that are not stored get their defaults; without a set
 * these are all rows. Rules between rows are not checked. */
store_found_t store_load(const store_flash_t *flash, const table_t *table, void *base, store_told_t *told);

/* Stores all rows of a set and reads them back. false: the memory has not accepted them, or a page is too
 * small; the previous set stays in use. */
bool store_save(const store_flash_t *flash, const table_t *table, const void *base);

/* The content of the pages, without the comparison with a table: never STORE_MIGRATED. */
store_found_t store_look(const store_flash_t *flash);

/* Erases both pages, that of the set in use last: after a power failure in between no older set is in use.
 * false: the memory has refused. */
bool store_erase(const store_flash_t *flash);

/* Words of a record of this table. */
static inline uint32_t store_record_words(uint32_t rows)
{
    return STORE_HEADER + STORE_PAIR * rows + STORE_END;
}

#endif
