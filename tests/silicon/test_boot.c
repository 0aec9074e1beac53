/* hal_boot() without changes. The linker of the host makes the symbols that the command file of the chip's
 * linker makes: the load and run addresses are the two arrays below, the number of words is BOOT_WORDS. */
#include "unity.h"
#include <string.h>

#include "hal/f28335/bus.h"
#include "hal/hal.h"

#define AROUND 8
#define LEFT   0xA5A5u
#define ROOM   (BOOT_WORDS + 2 * AROUND)

/* The code begins at the first word; the words after it have another content. */
uint16_t stand_in_flash[ROOM];
uint16_t stand_in_ram[ROOM];
uint16_t stand_in_stack[STACK_WORDS + AROUND];

void setUp(void)
{
    for (int32_t n = 0; n < ROOM; n++) {
        stand_in_flash[n] = (uint16_t)(0x1234 + 0x9E37 * n);
        stand_in_ram[n] = LEFT;
    }
    for (int32_t n = 0; n < STACK_WORDS + AROUND; n++) {
        stand_in_stack[n] = LEFT;
    }
}

static void test_the_code_is_where_it_runs_and_nothing_else_has_changed(void)
{
    uint16_t flash[ROOM];
    memcpy(flash, stand_in_flash, sizeof flash);
    hal_boot();
    TEST_ASSERT_EQUAL_HEX16_ARRAY(flash, stand_in_flash, ROOM);
    for (int32_t n = 0; n < ROOM; n++) {
        TEST_ASSERT_EQUAL_HEX16(n < BOOT_WORDS ? flash[n] : LEFT, stand_in_ram[n]);
    }
}

static void test_the_end_of_the_stack_is_painted_and_nothing_else_of_it(void)
{
    hal_boot();
    for (int32_t n = 0; n < STACK_WORDS + AROUND; n++) {
        const bool end = n < STACK_WORDS && n >= STACK_WORDS - (int32_t)BUS_STACK_END_WORDS;
        TEST_ASSERT_EQUAL_HEX16(end ? BUS_STACK_PAINT : LEFT, stand_in_stack[n]);
    }
}
