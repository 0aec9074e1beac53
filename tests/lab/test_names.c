/* Suggestions for misspelt names. */
#include <stdint.h>
#include <string.h>

#include "host_sim/lab/names.h"
#include "host_sim/rig/rig.h"
#include "unity.h"

static void test_distances(void)
{
    TEST_ASSERT_EQUAL_UINT(0, names_distance("inertia", "inertia"));
    TEST_ASSERT_EQUAL_UINT(0, names_distance("Inertia", "iNERTIA"));
    TEST_ASSERT_EQUAL_UINT(1, names_distance("inertia", "inerta"));   /* one letter is missing */
    TEST_ASSERT_EQUAL_UINT(1, names_distance("inertia", "inertiia")); /* one letter too many */
    TEST_ASSERT_EQUAL_UINT(1, names_distance("inertia", "inartia"));  /* one wrong letter */
    TEST_ASSERT_EQUAL_UINT(1, names_distance("inertia", "inetria"));  /* two letters swapped */
    TEST_ASSERT_EQUAL_UINT(3, names_distance("kitten", "sitting"));
    /* By optimal string alignment; without its restriction it would be 2. */
    TEST_ASSERT_EQUAL_UINT(3, names_distance("ca", "abc"));
    TEST_ASSERT_EQUAL_UINT(7, names_distance("", "inertia"));
    TEST_ASSERT_EQUAL_UINT(0, names_distance("", ""));
    TEST_ASSERT_EQUAL_UINT(3, names_distance("i_q", "v_d_")); /* two wrong letters and one too many */
}

static void test_names_that_are_too_long_are_near_to_nothing(void)
{
    char longest[NAMES_LENGTH_MAX + 1u];
    char longer[NAMES_LENGTH_MAX + 2u];
    memset(longest, 'a', sizeof longest);
    memset(longer, 'a', sizeof longer);
    longest[NAMES_LENGTH_MAX] = '\0';
    longer[NAMES_LENGTH_MAX + 1u] = '\0';
    TEST_ASSERT_TRUE(names_distance(longest, "a") == NAMES_LENGTH_MAX - 1u);
    TEST_ASSERT_TRUE(names_distance(longer, longest) == SIZE_MAX);
    names_search_t search = names_search(longer);
    names_consider(&search, longest);
    TEST_ASSERT_NULL(names_found(&search));
    search = names_search(longest);
    names_consider(&search, longer);
    TEST_ASSERT_NULL(names_found(&search));
}

static void expect_nearest(const char *expected, const char *name)
{
    names_search_t search = names_search(name);
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        names_consider_table(&search, rig_table(t));
    }
    if (expected == NULL) {
        TEST_ASSERT_NULL_MESSAGE(names_found(&search), name);
    } else {
        TEST_ASSERT_EQUAL_STRING(expected, names_found(&search));
    }
}

static void test_slips_and_parts_of_a_name_find_the_row_that_was_meant_and_others_nothing(void)
{
    static const char *const rows[][2] = {
        {"motor_resistance", "moter_resistence"},
        {"load_torque", "laod_torqe"},
        {"speed_request", "SPEED_REQUEST"},
        {"inertia", "inertai"},
        {"dead_time", "deadtime"},
        {"true_omega_m", "true_omga_m"},
        {"load_kind", "load"}, /* load_kind and load_torque begin with it: the first one is suggested */
        {"shaft_locked", "locked"},
        {"calibration_periods", "calibration"},
        {NULL, "xyzzy_frobnicate"},
        {NULL, ""},
        {NULL, "_____________"},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        expect_nearest(rows[n][0], rows[n][1]);
    }
}

static void test_a_third_of_the_longer_name_is_near_and_more_is_not(void)
{
    names_search_t search = names_search("abcdef");
    names_consider(&search, "abcXYZ"); /* 3 of 6 letters differ */
    TEST_ASSERT_NULL(names_found(&search));
    names_consider(&search, "abcdXY"); /* 2 of 6 letters differ */
    TEST_ASSERT_EQUAL_STRING("abcdXY", names_found(&search));
    /* 3 of 9 letters differ, but the distance is larger than that of the name found before. */
    names_consider(&search, "abcdefghi");
    TEST_ASSERT_EQUAL_STRING("abcdXY", names_found(&search));
    search = names_search("abcdef");
    names_consider(&search, "abcdefghi");
    TEST_ASSERT_EQUAL_STRING("abcdefghi", names_found(&search));
}

static void test_choices(void)
{
    names_search_t search = names_search("quickstop");
    names_consider_choices(&search, "off|on|quick_stop");
    TEST_ASSERT_EQUAL_STRING("quick_stop", names_found(&search));
    search = names_search("of");
    names_consider_choices(&search, "off|on|quick_stop");
    TEST_ASSERT_EQUAL_STRING("off", names_found(&search));
    search = names_search("of");
    names_consider_choices(&search, "");
    TEST_ASSERT_NULL(names_found(&search));
}
