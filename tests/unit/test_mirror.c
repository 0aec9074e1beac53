/* The mirror of a memory on a slow bus, with the store above it. The memory of the test takes one octet at
 * a time, and its power fails after any number of them: the octet that is being written then gets some of
 * its bits. A memory with pages keeps the octets of a transfer until its end and then writes them in any
 * order. */
#include "talk/mirror.h"

#include "tests/unit/random_sets.h"
#include "tests/unit/sweep.h"

#define WORDS  ((store_record_words(params_table.count) + 3u) / 4u * 4u) /* [words] of a record in a page */
#define MOST   512u                                                      /* [words] largest page */
#define STRIDE 1024u
/* a power failure is tested after every EVERY-th octet; on the host after each. */
#define EVERY (SWEEP == 1 ? 1u : SWEEP < 1000 ? 149u : 499u)
#define NEVER UINT32_C(0xFFFFFFFF)

typedef struct {
    uint16_t word[STORE_PAGES * STRIDE];
} content_t;

static content_t content;
static uint32_t left;       /* number of octets until the power fails */
static uint32_t operations; /* number of octets since the start of a test */
static uint32_t now;        /* [ticks] advances by one with each reading */
/* Number of polls that a memory with pages refuses after a write; 0: a memory without pages. */
static uint32_t slow;
static uint32_t refuses; /* number of polls that it still refuses */
static bool absent, silent, broken;
static uint32_t aborts;
static uint32_t at_read;
static bool reading, addressed;
static uint32_t unproven; /* number of words that were written and not read since */
static uint32_t written;  /* number of words in the last transfer */

static mirror_t mirror;
static uint16_t pages[STORE_PAGES * MOST];

/* Writes one octet of the memory: an octet before the power failure gets all bits, the last one some, and
 * later ones none. */
static void change(uint32_t octet, uint16_t value)
{
    uint16_t *to = &content.word[octet / 2u];
    const uint16_t mask = octet % 2u == 0u ? 0x00FFu : 0xFF00u;
    operations++;
    if (left == 0u || broken) {
        return;
    }
    left -= left == NEVER ? 0u : 1u;
    const uint16_t bits = (uint16_t)(left == 0u ? mask & random_bits() : mask);
    *to = (uint16_t)((*to & ~bits) | (value & bits));
}

static void bus_write(uint32_t at, const uint16_t *words, uint32_t count)
{
    const uint32_t turn = slow > 0u ? random_bits() % (2u * count) : 0u;
    TEST_ASSERT_TRUE(count >= 1u && at % MIRROR_GROUP + count <= MIRROR_GROUP);
    TEST_ASSERT_EQUAL_UINT32(0u, unproven);
    reading = false;
    addressed = !absent && refuses == 0u;
    for (uint32_t n = 0; n < 2u * count && addressed; n++) {
        const uint32_t octet = (n + turn) % (2u * count);
        change(2u * at + octet, words[octet / 2u]);
    }
    written = count;
    unproven = addressed ? count : 0u;
}

static void bus_read(uint32_t at)
{
    TEST_ASSERT_EQUAL_UINT32(0u, at % MIRROR_GROUP);
    reading = true;
    addressed = !absent && refuses == 0u;
    at_read = at;
}

static mirror_reply_t poll(uint16_t words[MIRROR_GROUP])
{
    if (silent) {
        return MIRROR_BUSY;
    }
    if (!addressed) {
        refuses -= refuses > 0u ? 1u : 0u;
        return MIRROR_REFUSED;
    }
    if (!reading) {
        refuses = slow;
        return MIRROR_DONE;
    }
    for (uint32_t n = 0; n < MIRROR_GROUP; n++) {
        words[n] = content.word[at_read + n];
    }
    unproven = 0u;
    return MIRROR_DONE;
}

static void give_up(void)
{
    aborts++;
}

static uint32_t ticks(void)
{
    return now++;
}

static mirror_bus_t bus = {bus_write, bus_read, poll, give_up, ticks, 100u, 20u, 0u, STRIDE};

/* ---- the store on top of the mirror ---- */

static uint16_t word(uint32_t page, uint32_t at)
{
    return pages[page * bus.words + at];
}

static bool erase(uint32_t page)
{
    return mirror_erase(&mirror, &bus, pages, page);
}

static bool program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count)
{
    return mirror_program(&mirror, &bus, pages, page, at, words, count);
}

static store_flash_t flash = {word, erase, program, 0u};

static void finish(void)
{
    uint32_t steps = 0u;
    while (mirror_step(&mirror, &bus, pages)) {
        steps++;
        TEST_ASSERT_TRUE(steps < 100000u);
    }
}

/* Fills the mirror as at a start. */
static void fill(void)
{
    unproven = 0u;
    refuses = 0u;
    memset(pages, 0, sizeof pages);
    mirror_begin(&mirror);
    finish();
}

void setUp(void)
{
    TEST_ASSERT_TRUE(WORDS <= MOST);
    bus.words = WORDS;
    flash.words = WORDS;
    noise = 2463534242u;
    left = NEVER;
    operations = 0u;
    slow = 0u;
    absent = false;
    silent = false;
    broken = false;
    aborts = 0u;
    now = 0xFFFFFF00u; /* close to the end of its range */
    memset(&content, 0xFF, sizeof content);
    fill();
}

static params_t save_random(void)
{
    const params_t set = random_set();
    TEST_ASSERT_TRUE(store_save(&flash, &params_table, &set));
    finish();
    return set;
}

/* Loads the set as after a start. */
static store_found_t load(params_t *set)
{
    store_told_t told;
    fill();
    TEST_ASSERT_EQUAL_UINT32(MIRROR_GOOD, mirror.error);
    return store_load(&flash, &params_table, set, &told);
}

static void expect_stored(const params_t *set)
{
    params_t found;
    TEST_ASSERT_EQUAL_UINT32(STORE_LOADED, load(&found));
    TEST_ASSERT_TRUE(equal(set, &found));
}

/* ---- good memories ---- */

static void test_random_sets_survive_in_memories_with_pages_and_without(void)
{
    params_t set;
    TEST_ASSERT_EQUAL_UINT32(STORE_EMPTY, load(&set));
    for (uint32_t n = 0; n < 10000u / SWEEP_LONG; n++) {
        slow = n % 3u * 4u;
        set = save_random();
        TEST_ASSERT_FALSE(mirror_busy(&mirror));
        expect_stored(&set);
    }
}

static void test_the_last_word_is_written_alone_and_after_all_others_were_read_back(void)
{
    (void)save_random();
    TEST_ASSERT_EQUAL_UINT32(1u, written);
    TEST_ASSERT_EQUAL_HEX16(STORE_COMMIT, content.word[store_record_words(params_table.count) - 1u]);
}

static void test_erasing_leaves_what_is_blank_alone(void)
{
    (void)save_random();
    (void)save_random();
    TEST_ASSERT_TRUE(store_erase(&flash));
    finish();
    operations = 0u;
    TEST_ASSERT_TRUE(store_erase(&flash));
    finish();
    TEST_ASSERT_EQUAL_UINT32(0u, operations);
    for (uint32_t n = 0; n < sizeof content.word / sizeof content.word[0]; n++) {
        TEST_ASSERT_EQUAL_HEX16(0xFFFFu, content.word[n]);
    }
}

/* ---- power ---- */

/* The power fails after every octet of a save: the old set or the new one must be found, and a later save
 * must be found too. */
static void cut_everywhere(uint32_t refusals, uint32_t sets)
{
    params_t old = {0};
    slow = refusals;
    for (uint32_t n = 0; n < sets; n++) {
        old = save_random();
    }
    const content_t before = content;
    uint32_t kept = 0u;
    for (uint32_t cut = 0;; cut += EVERY) {
        params_t found;
        content = before;
        fill();
        left = cut;
        const params_t set = save_random();
        const bool over = left != 0u;
        left = NEVER;
        const store_found_t what = load(&found);
        TEST_ASSERT_EQUAL_UINT32(sets == 0u && !equal(&set, &found) ? STORE_EMPTY : STORE_LOADED, what);
        kept += sets != 0u && equal(&old, &found) ? 1u : 0u;
        TEST_ASSERT_TRUE(equal(&set, &found) || sets == 0u || equal(&old, &found));
        if (over) {
            TEST_ASSERT_TRUE(equal(&set, &found));
            break;
        }
        const params_t next = save_random();
        expect_stored(&next);
    }
    TEST_ASSERT_TRUE(sets == 0u || kept > 0u);
}

static void test_a_cut_at_any_octet_leaves_the_old_set_or_the_new_one(void)
{
    cut_everywhere(0u, 2u);
    cut_everywhere(3u, 3u);
}

static void test_a_cut_of_the_first_saves_leaves_nothing_or_the_set(void)
{
    cut_everywhere(0u, 0u);
    cut_everywhere(3u, 1u);
}

/* ---- bad memories ---- */

static void expect_error(mirror_error_t error)
{
    const params_t set = random_set();
    TEST_ASSERT_EQUAL_UINT32(error, mirror.error);
    TEST_ASSERT_FALSE(mirror_busy(&mirror));
    TEST_ASSERT_FALSE(store_save(&flash, &params_table, &set));
    TEST_ASSERT_FALSE(store_erase(&flash));
}

static void test_no_answer_at_the_address_is_an_error_within_its_time(void)
{
    absent = true;
    const uint32_t begin = now;
    fill();
    expect_error(MIRROR_NO_ANSWER);
    TEST_ASSERT_TRUE(now - begin > 100u && now - begin < 110u);
}

static void test_transfers_that_never_end_are_given_up(void)
{
    silent = true;
    const uint32_t begin = now;
    fill();
    expect_error(MIRROR_BUS_STUCK);
    TEST_ASSERT_TRUE(now - begin < 140u);
    TEST_ASSERT_TRUE(aborts >= 5u);
}

static void test_a_memory_that_keeps_what_it_had_is_found_and_its_set_stays(void)
{
    const params_t old = save_random();
    broken = true;
    (void)save_random();
    expect_error(MIRROR_NOT_TAKEN);
    TEST_ASSERT_TRUE(operations > 0u);
    broken = false;
    expect_stored(&old);
}

/* The memory answers again before the time-out: no octet is lost. */
static void test_a_memory_may_be_away_for_a_while(void)
{
    const params_t set = random_set();
    TEST_ASSERT_TRUE(store_save(&flash, &params_table, &set));
    for (uint32_t n = 0; mirror_busy(&mirror); n++) {
        absent = n % 60u > 40u;
        (void)mirror_step(&mirror, &bus, pages);
        unproven = absent ? 0u : unproven;
    }
    absent = false;
    expect_stored(&set);
}
