/* The store on a flash of the test, whose power fails after any number of elementary operations.
 * Programming a word is one operation; an erase first clears each word to zero and then sets each to ones.
 * The word that is being changed at the failure gets some of its bits, and nothing happens afterwards
 * until the power returns. */
#include "talk/store.h"

#include "tests/unit/random_sets.h"
#include "tests/unit/sweep.h"

#define PAGE 2048u /* [words] eight sets of parameters */
/* a power failure is tested after every EVERY-th operation; on the host after each. */
#define EVERY (SWEEP == 1 ? 1u : SWEEP < 1000 ? 149u : 499u)
#define BITS  (SWEEP > 1 ? 5u : 1u) /* every BITS-th bit of a word is tested */
#define NEVER UINT32_C(0xFFFFFFFF)
#define WORDS store_record_words(params_table.count) /* [words] of a stored set */
#define FIT   (PAGE / WORDS)                         /* sets in a page */

/* ---- the flash ---- */

typedef struct {
    uint16_t page[STORE_PAGES][PAGE];
} content_t;

static content_t content;
static uint32_t left;       /* number of operations until the power fails */
static uint32_t operations; /* number of operations since the start of a test */
static bool broken;         /* the flash accepts no data */
static store_flash_t flash;

static uint16_t word(uint32_t page, uint32_t at)
{
    return content.page[page][at];
}

/* Programs a word, which is one operation. In the last word before the power failure only some of the bits
 * are programmed, and in later words none. */
static void change(uint16_t *to, uint16_t value)
{
    operations++;
    if (left == 0u) {
        return;
    }
    left -= left == NEVER ? 0u : 1u;
    if (left == 0u) {
        const uint16_t some = (uint16_t)(random_bits() & 0xFFFFu);
        *to = (uint16_t)((*to & ~some) | (value & some));
        return;
    }
    *to = value;
}

static bool erase(uint32_t page)
{
    if (broken) {
        return false;
    }
    for (uint32_t n = 0; n < flash.words; n++) {
        change(&content.page[page][n], 0u);
    }
    for (uint32_t n = 0; n < flash.words; n++) {
        change(&content.page[page][n], 0xFFFFu);
    }
    return left != 0u;
}

static bool program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count)
{
    bool taken = !broken;
    for (uint32_t n = 0; n < count && taken; n++) {
        uint16_t *to = &content.page[page][at + n];
        TEST_ASSERT_TRUE(at + n < flash.words);
        change(to, (uint16_t)(*to & words[n]));
        taken = *to == words[n];
    }
    return taken;
}

static void size_of_page(uint32_t words)
{
    flash = (store_flash_t){word, erase, program, words};
    memset(&content, 0xFF, sizeof content);
}

void setUp(void)
{
    noise = 2463534242u;
    left = NEVER;
    operations = 0u;
    broken = false;
    size_of_page(PAGE);
}

/* ---- sets ---- */

static params_t defaults(void)
{
    params_t set;
    params_defaults(&set);
    return set;
}

static store_found_t load(params_t *set)
{
    store_told_t told;
    const store_found_t found = store_load(&flash, &params_table, set, &told);
    TEST_ASSERT_EQUAL_UINT32(0u, told.unknown);
    TEST_ASSERT_EQUAL_UINT32(0u, told.defaulted);
    return found;
}

static bool save(const params_t *set)
{
    return store_save(&flash, &params_table, set);
}

static params_t save_random(void)
{
    const params_t set = random_set();
    TEST_ASSERT_TRUE(save(&set));
    return set;
}

static void expect_stored(const params_t *set)
{
    params_t found;
    TEST_ASSERT_EQUAL_UINT32(STORE_LOADED, load(&found));
    TEST_ASSERT_TRUE(equal(set, &found));
}

static void save_and_expect_it(void)
{
    const params_t set = save_random();
    expect_stored(&set);
}

static void expect_defaults(store_found_t what)
{
    params_t found;
    const params_t usual = defaults();
    TEST_ASSERT_EQUAL_UINT32(what, load(&found));
    TEST_ASSERT_TRUE(equal(&usual, &found));
}

/* ---- saving ---- */

static void test_nothing_stored_gives_defaults_and_random_sets_survive(void)
{
    expect_defaults(STORE_EMPTY);
    const uint32_t sets = 10000u / SWEEP_LONG;
    for (uint32_t n = 0; n < sets; n++) {
        save_and_expect_it();
    }
    TEST_ASSERT_TRUE(operations >= sets * WORDS); /* every value has been written */
}

/* The words include those with all bits set and with none: neither the check nor the erased state is
 * confused with a value. */
static void test_any_bits_of_a_value_are_kept(void)
{
    typedef struct {
        uint32_t a, b;
    } pair_t;
    static const table_row_t rows[] = {
        {65535u, SLOT_UINT, TABLE_OFF, offsetof(pair_t, a), "a", "-", "", "", 0, 0, 0, {0, 0, INT32_MAX}},
        {1u, SLOT_UINT, TABLE_OFF, offsetof(pair_t, b), "b", "-", "", "", 0, 0, 0, {0, 0, INT32_MAX}},
    };
    static const table_t table = {"pair", rows, 2u};
    const pair_t set = {UINT32_C(0x7FFFFFFF), UINT32_C(0)};
    pair_t found;
    store_told_t told;
    TEST_ASSERT_TRUE(store_save(&flash, &table, &set));
    TEST_ASSERT_EQUAL_UINT32(STORE_LOADED, store_load(&flash, &table, &found, &told));
    TEST_ASSERT_EQUAL_HEX32(set.a, found.a);
    TEST_ASSERT_EQUAL_HEX32(set.b, found.b);
}

static void test_a_page_is_filled_before_the_other_is_erased(void)
{
    for (uint32_t n = 0; n < FIT; n++) {
        save_random();
    }
    TEST_ASSERT_EQUAL_UINT32(FIT * WORDS, operations);
    save_random();
    TEST_ASSERT_EQUAL_UINT32((FIT + 1u) * WORDS + 2u * PAGE, operations);
}

static void test_a_page_too_small_is_refused(void)
{
    size_of_page(WORDS - 1u);
    const params_t set = random_set();
    TEST_ASSERT_FALSE(save(&set));
    expect_defaults(STORE_EMPTY);
    size_of_page(WORDS);
    save_and_expect_it();
    save_and_expect_it();
}

static void test_memory_that_takes_nothing_leaves_the_set_before(void)
{
    const params_t before = save_random();
    const params_t set = random_set();
    broken = true;
    TEST_ASSERT_FALSE(save(&set));
    expect_stored(&before);
}

/* A word does not accept its bits: the record is written into the other page. */
static void test_a_word_that_cannot_be_programmed_is_left_behind(void)
{
    save_random();
    const params_t set = random_set();
    for (uint32_t at = 0; at < WORDS; at += SWEEP_FEW) {
        size_of_page(PAGE);
        save_random();
        content.page[0][WORDS + at] = 0u;
        TEST_ASSERT_TRUE(save(&set));
        expect_stored(&set);
        TEST_ASSERT_EQUAL_HEX16(STORE_MAGIC, content.page[1][0]);
    }
}

/* ---- cuts of the power ---- */

/* Saves `next` over `before` with a power failure after each number of operations. Each time one of the
 * two sets is found, never a corrupt store, and the next set can be saved. Returns the number of
 * operations of the save. */
static uint32_t cut_everywhere(const params_t *before, bool is_empty)
{
    static content_t at_first;
    const params_t next = random_set();
    const params_t third = random_set();
    at_first = content;
    for (uint32_t cut = 1;; cut += EVERY) {
        params_t found;
        content = at_first;
        left = cut;
        operations = 0u;
        const bool said = save(&next);
        const bool through = left != 0u;
        left = NEVER;
        const store_found_t what = load(&found);
        const bool is_old = equal(before, &found);
        TEST_ASSERT_TRUE(is_old || equal(&next, &found));
        TEST_ASSERT_EQUAL_UINT32(is_old && is_empty ? STORE_EMPTY : STORE_LOADED, what);
        TEST_ASSERT_TRUE(!is_old || !said);
        if (through) {
            TEST_ASSERT_FALSE(is_old);
            return operations;
        }
        TEST_ASSERT_TRUE(save(&third));
        expect_stored(&third);
    }
}

static void test_cut_while_a_set_is_added_leaves_old_or_new(void)
{
    params_t before = defaults(); /* the first set: afterwards none or this set is stored */
    TEST_ASSERT_EQUAL_UINT32(WORDS, cut_everywhere(&before, true));
    size_of_page(PAGE);
    save_random();
    before = save_random();
    TEST_ASSERT_EQUAL_UINT32(WORDS, cut_everywhere(&before, false));
}

/* Saves as many sets as fit into a page; returns the last of them. */
static params_t fill(void)
{
    for (uint32_t n = 1; n < FIT; n++) {
        save_random();
    }
    return save_random();
}

static void test_cut_while_a_page_is_left_for_the_other_leaves_old_or_new(void)
{
    params_t before = fill();
    const uint32_t all = 2u * PAGE + WORDS;
    TEST_ASSERT_EQUAL_UINT32(all, cut_everywhere(&before, false)); /* into a page that was never used */
    size_of_page(PAGE);
    fill();
    before = fill();
    TEST_ASSERT_EQUAL_UINT32(all, cut_everywhere(&before, false)); /* into a page full of older sets */
}

static void test_cuts_in_a_row_leave_old_or_new(void)
{
    params_t before = defaults();
    bool is_empty = true;
    for (uint32_t n = 0; n < 20000u / SWEEP_LONG; n++) {
        const params_t next = random_set();
        params_t found;
        left = 1u + random_bits() % (n % 4u == 0u ? 3u * PAGE : 300u);
        (void)save(&next);
        left = NEVER;
        const store_found_t what = load(&found);
        const bool is_old = equal(&before, &found);
        TEST_ASSERT_TRUE(is_old || equal(&next, &found));
        is_empty = is_empty && is_old;
        TEST_ASSERT_EQUAL_UINT32(is_empty ? STORE_EMPTY : STORE_LOADED, what);
        before = found;
    }
}

/* ---- corrupt words ---- */

/* The effect of each wrong word in the last set, the third of its page. */
static void test_each_wrong_word_of_the_active_set_is_reported(void)
{
    save_random();
    const params_t before = save_random();
    const params_t set = save_random();
    for (uint32_t at = 2u * WORDS; at < 3u * WORDS; at += SWEEP_FEW) {
        const uint16_t right = content.page[0][at];
        for (uint32_t bit = 0; bit < 18u; bit += BITS) {
            const uint16_t wrong = (uint16_t)(bit < 16u ? right ^ (1u << bit) : bit == 16u ? 0u : 0xFFFFu);
            if (wrong == right) {
                continue;
            }
            content.page[0][at] = wrong;
            if (at == 3u * WORDS - 1u) { /* as a power failure leaves it */
                expect_stored(&before);
            } else {
                expect_defaults(STORE_CORRUPT);
            }
        }
        content.page[0][at] = right;
    }
    expect_stored(&set);
}

static void test_each_wrong_word_of_an_only_set_is_reported(void)
{
    save_random();
    for (uint32_t at = 0; at + 1u < WORDS; at += SWEEP_FEW) {
        content.page[0][at] ^= 0x0100u;
        expect_defaults(STORE_CORRUPT);
        content.page[0][at] ^= 0x0100u;
    }
}

/* The headers of older sets lead to the active set; their values do not matter. */
static void test_wrong_words_of_older_sets_are_reported_or_harmless(void)
{
    save_random();
    const params_t set = save_random();
    for (uint32_t at = 0; at < WORDS; at += SWEEP_FEW) {
        content.page[0][at] ^= 0x0010u;
        if (at < STORE_HEADER) {
            expect_defaults(STORE_CORRUPT);
        } else {
            expect_stored(&set);
        }
        content.page[0][at] ^= 0x0010u;
    }
}

static void test_a_wrong_page_beside_a_good_one_is_harmless(void)
{
    const params_t set = save_random();
    for (uint32_t n = 0; n < 200u; n += SWEEP_FEW) {
        for (uint32_t at = 0; at < PAGE; at++) {
            content.page[1][at] = (uint16_t)(random_bits() & 0xFFFFu);
        }
        expect_stored(&set);
    }
}

/* Both sectors, or one of them, contain the data of another program. */
static void test_content_that_is_not_a_store_is_reported(void)
{
    for (uint32_t pages = 1; pages <= 3u; pages++) {
        size_of_page(PAGE);
        for (uint32_t at = 0; at < PAGE; at++) {
            content.page[0][at] = (uint16_t)((pages & 1u) != 0u ? random_bits() & 0xFFFFu : 0xFFFFu);
            content.page[1][at] = (uint16_t)((pages & 2u) != 0u ? random_bits() & 0xFFFFu : 0xFFFFu);
        }
        expect_defaults(STORE_FOREIGN);
        save_and_expect_it(); /* the data are gone after a set is stored */
    }
    size_of_page(PAGE);
    save_random();
    content.page[0][1] = STORE_VERSION + 1u; /* a format of another version */
    expect_defaults(STORE_CORRUPT);
}

/* A word of a set that is by chance at a place where no record begins does not count as a corrupt store. */
static void test_erasing_ends_what_another_program_has_left(void)
{
    for (uint32_t n = 0; n < 200u; n += SWEEP_FEW) {
        for (uint32_t at = 0; at < PAGE; at++) {
            content.page[0][at] = (uint16_t)(random_bits() & 0xFFFFu);
            content.page[1][at] = (uint16_t)(random_bits() & 0xFFFFu);
        }
        content.page[0][PAGE / 2u] = STORE_MAGIC;
        content.page[1][PAGE - 1u] = STORE_COMMIT;
        expect_defaults(STORE_FOREIGN);
        TEST_ASSERT_EQUAL_UINT32(STORE_FOREIGN, store_look(&flash));
        TEST_ASSERT_TRUE(store_erase(&flash));
        expect_defaults(STORE_EMPTY);
        const params_t set = save_random();
        expect_stored(&set);
    }
}

/* The power fails while a set in the first or second page is erased. Afterwards the set is still present,
 * or none is, or the store needs to be erased again. An older set never comes back. */
static void test_cut_while_a_set_is_erased_leaves_it_or_none(void)
{
    static content_t at_first;
    for (uint32_t pages = 1; pages <= 2u; pages++) {
        size_of_page(PAGE);
        params_t set = fill();
        set = pages == 2u ? save_random() : set;
        at_first = content;
        for (uint32_t cut = 1; cut <= 4u * PAGE; cut += 7u * EVERY) {
            params_t found;
            content = at_first;
            left = cut;
            (void)store_erase(&flash);
            left = NEVER;
            const store_found_t what = load(&found);
            TEST_ASSERT_TRUE(what == STORE_LOADED ? equal(&set, &found) : what != STORE_MIGRATED);
            TEST_ASSERT_TRUE(store_erase(&flash));
            expect_defaults(STORE_EMPTY);
        }
    }
}

/* The new set is active, although the corrupt store has a serial number, too. */
static void test_a_set_stored_over_a_corrupt_store_is_active(void)
{
    fill();
    fill();
    for (uint32_t page = 0; page < 2u; page++) {
        for (uint32_t at = STORE_HEADER; at < PAGE; at += 10u) {
            content.page[page][at] &= 0xF0F0u;
        }
    }
    expect_defaults(STORE_CORRUPT);
    save_and_expect_it();
    save_and_expect_it();
}

/* ---- another table ---- */

typedef struct {
    float gain, limit, delay;
    int32_t mode, tries;
} set_t;

#define SLOT(number, what, member, names)                                                                    \
    .id = number, .kind = what, .access = TABLE_LIVE, .offset = offsetof(set_t, member), .name = #member,    \
    .unit = "-", .text = "", .choices = names
#define OLD_FLOAT(id, name, a, b, c) SLOT(id, SLOT_FLOAT, name, ""), .initial = a, .min = b, .max = c
#define OLD_ENUM(id, name, choices)  SLOT(id, SLOT_ENUM, name, choices)
#define OLD_INT(id, name, a, b, c)   SLOT(id, SLOT_INT, name, ""), .whole = {a, b, c}

static const table_row_t old_rows[] = {
    {OLD_FLOAT(1, gain, 1.0f, 0.0f, 10.0f)},
    {OLD_FLOAT(2, limit, 5.0f, 0.0f, 100.0f)},
    {OLD_ENUM(3, mode, "off|slow|fast")},
    {OLD_INT(4, tries, 3, 1, 50)},
};
static const table_t old_table = {"params", old_rows, 4u};

static store_told_t told;
static set_t migrated;

static void migrate(const set_t *old, const table_row_t *rows, uint32_t count)
{
    const table_t table = {"params", rows, count};
    size_of_page(PAGE);
    TEST_ASSERT_TRUE(store_save(&flash, &old_table, old));
    memset(&migrated, 0x55, sizeof migrated);
    TEST_ASSERT_EQUAL_UINT32(STORE_MIGRATED, store_load(&flash, &table, &migrated, &told));
}

/* Expected are a float, the mode, the tries, the number of values without a row, and the number of rows
 * without a valid value. */
static void expect_migrated(float gain, int32_t mode, int32_t tries, uint32_t unknown, uint32_t defaulted)
{
    TEST_ASSERT_EQUAL_FLOAT(gain, migrated.gain);
    TEST_ASSERT_EQUAL_INT32(mode, migrated.mode);
    TEST_ASSERT_EQUAL_INT32(tries, migrated.tries);
    TEST_ASSERT_EQUAL_UINT32(unknown, told.unknown);
    TEST_ASSERT_EQUAL_UINT32(defaulted, told.defaulted);
}

static const set_t filled = {.gain = 8.5f, .limit = 50.0f, .mode = 2, .tries = 49};

static void test_rows_that_are_new_or_gone_are_migrated_by_id(void)
{
    static const table_row_t rows[] = {
        {OLD_INT(4, tries, 7, 1, 50)},
        {OLD_FLOAT(9, delay, 0.25f, 0.0f, 1.0f)}, /* a new row */
        {OLD_FLOAT(1, gain, 2.0f, 0.0f, 10.0f)},
        {OLD_ENUM(3, mode, "off|slow|fast")}, /* the choice with number 2 is missing */
    };
    migrate(&filled, rows, 4u);
    expect_migrated(8.5f, 2, 49, 1u, 0u);
    TEST_ASSERT_EQUAL_FLOAT(0.25f, migrated.delay);
}

static void test_values_out_of_a_new_range_get_the_default(void)
{
    static const table_row_t rows[] = {{OLD_FLOAT(1, gain, 2.0f, 0.0f, 8.0f)},
                                       {OLD_FLOAT(2, limit, 6.0f, 0.0f, 50.0f)},
                                       {OLD_ENUM(3, mode, "off|slow")},
                                       {OLD_INT(4, tries, 5, 1, 40)}};
    migrate(&filled, rows, 4u);
    expect_migrated(2.0f, 0, 5, 0u, 3u);
    TEST_ASSERT_EQUAL_FLOAT(50.0f, migrated.limit);
}

/* The table is the same, but a value that was valid when it was stored is not a number, or is outside its
 * range, which has become narrower. */
static void test_a_table_that_means_the_same_is_still_judged(void)
{
    table_row_t rows[4];
    memcpy(rows, old_rows, sizeof rows);
    rows[1].max = 49.0f;
    const set_t old = {.gain = NAN, .limit = 50.0f, .mode = 0, .tries = 1};
    migrate(&old, rows, 4u);
    expect_migrated(1.0f, 0, 1, 0u, 2u);
    TEST_ASSERT_EQUAL_FLOAT(5.0f, migrated.limit);
}

static void test_the_older_set_is_untouched_by_the_migration(void)
{
    static const table_row_t rows[] = {{OLD_FLOAT(9, delay, 0.25f, 0.0f, 1.0f)}};
    migrate(&filled, rows, 1u);
    TEST_ASSERT_EQUAL_UINT32(4u, told.unknown);
    TEST_ASSERT_EQUAL_UINT32(STORE_LOADED, store_load(&flash, &old_table, &migrated, &told));
    expect_migrated(8.5f, 2, 49, 0u, 0u);
}
