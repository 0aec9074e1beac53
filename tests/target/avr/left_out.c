/* The tests that this target cannot run, each with file, name and reason. replay.c compares their subjects
 * with the host, bit for bit. CMakeLists.txt leaves out whole modules. */
#include <string.h>
#include <unity.h>

#define PRECISION "judges with a 64-bit double"

static const struct {
    const char *file, *name, *reason;
} left_out[] = {
    {"test_angle.c", "test_wraps_the_whole_range_into_one_turn", PRECISION},
    {"test_angle.c", "test_stays_strictly_inside_next_to_every_half_turn", PRECISION},
    {"test_angle.c", "test_floats_next_to_pi_go_to_the_other_side", PRECISION},
    {"test_exponential.c", "test_exponential_over_the_whole_range", PRECISION},
    {"test_dead_time.c", "test_is_the_sum_of_its_legs_in_and_out_of_the_zone", PRECISION},
    {"test_svpwm.c", "test_any_vector_is_made_or_cut_in_its_direction", PRECISION},
    {"test_svpwm.c", "test_voltage_is_a_share_of_the_request", PRECISION},
    {"test_inverter.c", "test_what_the_link_has_too_little_for_is_missing", PRECISION},
    {"test_offset_trim.c", "test_finds_the_constant_of_an_emf_that_turns_either_way", PRECISION},
    {"test_offset_trim.c", "test_broken_turns_leave_less_than_a_sample", PRECISION},
    {"test_offset_trim.c", "test_a_slow_window_is_a_whole_turn", PRECISION},
    {"test_offset_trim.c", "test_a_slow_or_changing_speed_is_left_alone", PRECISION},
    {"test_offset_trim.c", "test_a_small_current_is_left_alone", PRECISION},
    {"test_offset_trim.c", "test_each_component_stops_at_the_limit", PRECISION},
    {"test_offset_trim.c", "test_reset_takes_the_offset_and_forgets_the_window", PRECISION},
    {"test_encoder.c", "test_constant_speed_with_a_fraction_of_a_count_per_pole", PRECISION},
};

static const char *reason;

static void leave_out(void)
{
    TEST_IGNORE_MESSAGE(reason);
}

void run_test_or_leave_out(void (*test)(void), const char *name, int line)
{
    const char *slash = strrchr(Unity.TestFile, '/');
    const char *file = slash != NULL ? slash + 1 : Unity.TestFile;
    for (unsigned n = 0; n < sizeof left_out / sizeof left_out[0]; n++) {
        if (strcmp(left_out[n].file, file) == 0 && strcmp(left_out[n].name, name) == 0) {
            reason = left_out[n].reason;
            test = leave_out;
        }
    }
    UnityDefaultTestRun(test, name, line);
}
