/* The store: sets of parameters in memory that stays, so that a cut of the power at any moment leaves the set
 * before or the new one.
 *
 * Two pages of flash, each erased as a whole: then all its bits are ones, which programming turns into zeros.
 * A page is a log of records, one behind the other from its beginning:
 *
 *     header   magic, version, count, serial (2), hash of the table (2), check of these    8 words
 *     pairs    id, bits of the value (2: low word first)                                   3 words each
 *     check    CRC-32 of all words before it (2)                                           2 words
 *     commit   STORE_COMMIT                                                                1 word
 *
 * programmed in this order, so that a record without its last word is none. The serial grows with every
 * record; the committed one with the largest is in force. A new record goes behind it, and where there is no
 * room into the other page, which is erased first: the set in force is never touched.
 *
 * What a cut can leave, and what is made of it: a record without commit, which is skipped; a header that
 * does not agree with its check and nothing behind it, after which the other page is written; a page half
 * erased, while the other holds the set in force. Whatever else is found was not left by a cut, and is
 * reported as corrupt: a committed record that does not agree with its check and would be in force; something
 * behind the last record of the page in force, as a damaged header leaves it; content that is no record,
 * without a set in the other page. One damage looks like a cut: that of the header of the first and only
 * record of a page, while the other page still holds older ones; those are loaded then.
 *
 * A set is stored by ids, so that another program can read it: see store_load(). */
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

/* The memory, each call as that of hal.h. */
typedef struct {
    uint16_t (*word)(uint32_t page, uint32_t at);
    bool (*erase)(uint32_t page);
    bool (*program)(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count);
    uint32_t words; /* [16-bit words] of a page */
} store_flash_t;

typedef enum {
    STORE_EMPTY,    /* nothing was ever stored */
    STORE_LOADED,   /* the set in force, of a table that means the same */
    STORE_MIGRATED, /* the set in force, but of another table, or not all of its values could be taken */
    STORE_CORRUPT   /* what was stored cannot be trusted */
} store_found_t;

typedef struct {
    uint32_t unknown;   /* [-] stored rows that the table does not have: left out */
    uint32_t defaulted; /* [-] stored values that their rows do not accept: their defaults instead */
} store_told_t;

/* The set in force, row by row by their ids. Rows that are not stored, all of them where there is no set, get
 * their defaults. Judges no rule between rows. */
store_found_t store_load(const store_flash_t *flash, const table_t *table, void *base, store_told_t *told);

/* Stores all rows of a set, and reads them back. false: the memory did not take it, or a page is too small;
 * the set before is in force still. */
bool store_save(const store_flash_t *flash, const table_t *table, const void *base);

/* Words of a record of this table. */
static inline uint32_t store_record_words(uint32_t rows)
{
    return STORE_HEADER + STORE_PAIR * rows + STORE_END;
}

#endif
