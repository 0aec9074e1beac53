/* The store of parameters on a flash with damaged content. Every value of the loaded set is in the range
 * of its parameter, and a set that is saved afterwards is loaded the next time. usage: fuzz_store SEED
 * SECONDS */
#include "fuzz.h"

#include "settings/params.h"
#include "talk/store.h"

#define PAGE 2048u /* [words] */

static uint16_t pages[STORE_PAGES][PAGE];

static uint16_t word(uint32_t page, uint32_t at)
{
    fuzz_expect(page < STORE_PAGES && at < PAGE, "read beyond the flash");
    return pages[page][at];
}

static bool erase(uint32_t page)
{
    fuzz_expect(page < STORE_PAGES, "erased beyond the flash");
    memset(pages[page], 0xFF, sizeof pages[page]);
    return true;
}

static bool program(uint32_t page, uint32_t at, const uint16_t *words, uint32_t count)
{
    fuzz_expect(page < STORE_PAGES && at <= PAGE && count <= PAGE - at, "written beyond the flash");
    bool taken = true;
    for (uint32_t n = 0; n < count; n++) {
        pages[page][at + n] = (uint16_t)(pages[page][at + n] & words[n]);
        taken = taken && pages[page][at + n] == words[n];
    }
    return taken;
}

static const store_flash_t flash = {word, erase, program, PAGE};

static params_t any_set(void)
{
    params_t set;
    params_defaults(&set);
    for (uint32_t n = fuzz_below(6u); n > 0u; n--) {
        const table_row_t *row = &params_table.rows[fuzz_below(params_table.count)];
        if (row->kind == SLOT_FLOAT) {
            table_set(row, &set, table_max(row));
        } else {
            table_set_whole(row, &set, table_whole_max(row));
        }
        fuzz_expect(table_holds(row, &set), row->name);
    }
    return set;
}

static void damage(void)
{
    for (uint32_t n = fuzz_below(12u); n > 0u; n--) {
        uint16_t *at = &pages[fuzz_below(STORE_PAGES)][fuzz_below(fuzz_below(2u) == 0u ? 32u : PAGE)];
        switch (fuzz_below(4u)) {
        case 0:
            *at = (uint16_t)fuzz_bits();
            break;
        case 1:
            *at = (uint16_t)(*at ^ (1u << fuzz_below(16u)));
            break;
        case 2:
            *at = 0xFFFFu;
            break;
        default:
            memmove(pages[fuzz_below(STORE_PAGES)], pages[fuzz_below(STORE_PAGES)], 2u * fuzz_below(PAGE));
            break;
        }
    }
}

static void accepts(const params_t *set)
{
    for (uint32_t n = 0; n < params_table.count; n++) {
        const table_row_t *row = &params_table.rows[n];
        fuzz_expect(table_holds(row, set), row->name);
    }
}

static void turn(void)
{
    memset(pages, fuzz_below(4u) == 0u ? 0 : 0xFF, sizeof pages);
    for (uint32_t n = fuzz_below(8u); n > 0u; n--) {
        const params_t set = any_set();
        (void)store_save(&flash, &params_table, &set);
    }
    damage();
    params_t loaded;
    store_told_t told;
    (void)store_load(&flash, &params_table, &loaded, &told);
    accepts(&loaded);
    const params_t set = any_set();
    if (store_save(&flash, &params_table, &set)) {
        const store_found_t found = store_load(&flash, &params_table, &loaded, &told);
        fuzz_expect(found == STORE_LOADED || found == STORE_CORRUPT, "a set that was saved is not found");
        fuzz_expect(found == STORE_CORRUPT || memcmp(&set, &loaded, sizeof set) == 0,
                    "another set was loaded");
    }
}

int main(int argc, char **argv)
{
    return fuzz_run(argc, argv, turn);
}
