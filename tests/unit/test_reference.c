#include "fast/reference/reference.h"

#include "tests/unit/compare.h"

/* References in the rotor's frame, from the setpoints of windows of eight periods. The values are powers
 * of two where the sums must be exact. */
#define W 8

static reference_t reference;
static reference_tuning_t tuning;
static setpoint_t setpoint;
static demand_t demand;

void setUp(void)
{
    tuning = (reference_tuning_t){.flux_linkage = 0.25f,
                                  .pole_pairs_inverse = 0.25f,
                                  .periods = (float)W,
                                  .per_period = 1.0f / (float)W};
    memset(&reference, 0x55, sizeof reference);
    reference_init(&reference);
    memset(&setpoint, 0, sizeof setpoint);
    setpoint.source = (int32_t)SOURCE_ENCODER;
    setpoint.change = (int32_t)FRAME_ANEW;
}

/* Begins a window whose setpoint reaches this i_q (at speed zero) at the end of the window, less a part in
 * proportion to the speed. */
static void begin(float standing, float stiffness)
{
    setpoint.current.q = standing;
    setpoint.stiffness = stiffness;
    reference_take(&reference, &tuning, &setpoint);
    setpoint.change = (int32_t)FRAME_GOES_ON;
}

/* The i_q of a period at this mechanical speed [rad/s]. */
static float i_q(float omega_m)
{
    const frame_t rotor = {0.0f, 4.0f * omega_m, {0.0f, 1.0f}};
    const reference_input_t input = {.encoder = &rotor, .omega_m = omega_m, .estimating = 1u};
    reference_step(&reference, &tuning, &setpoint, &input, &demand);
    return demand.current.q;
}

static void test_reference_reaches_the_setpoint_on_a_line_and_stays_there(void)
{
    begin(0.0f, 0.0f);
    (void)i_q(0.0f);
    begin(4.0f, 0.0f);
    for (int n = 1; n <= W; n++) {
        TEST_ASSERT_EQUAL_FLOAT(0.5f * (float)n, i_q(0.0f));
    }
    TEST_ASSERT_EQUAL_FLOAT(4.0f, i_q(0.0f));
}

/* Control leaves the encoder, and the loop is locked to its angle in this period. The current control moves
 * its integral only where the origin of the EMF changes: here it has to be that of the encoder, which is fed
 * forward with the flux of the tuning, a share of psi_f for a light rotor. */
static void test_the_emf_of_the_period_in_which_the_loop_is_locked_is_that_of_the_encoder(void)
{
    const frame_t rotor = {0.5f, 64.0f, {0.0f, 1.0f}};
    const position_t encoder = {0.5f, 64.0f};
    const estimate_t estimate = {.frame = rotor};
    const reference_input_t input = {
        .encoder = &rotor, .position = &encoder, .estimate = &estimate, .omega_m = 16.0f, .estimating = 1u};
    setpoint.models.flux_linkage = 0.375f;
    begin(1.0f, 0.0f);
    reference_step(&reference, &tuning, &setpoint, &input, &demand);
    TEST_ASSERT_EQUAL_INT32(EMF_MODEL, demand.origin);
    TEST_ASSERT_EQUAL_FLOAT(16.0f, demand.emf.q);
    setpoint.source = (int32_t)SOURCE_ESTIMATE;
    setpoint.lock = (int32_t)LOCK_TO_ENCODER;
    begin(1.0f, 0.0f);
    reference_step(&reference, &tuning, &setpoint, &input, &demand);
    TEST_ASSERT_EQUAL_UINT32(1u, reference.locking);
    TEST_ASSERT_EQUAL_INT32(EMF_MODEL, demand.origin);
    TEST_ASSERT_EQUAL_FLOAT(16.0f, demand.emf.q);
}

/* The proportional part does not wait for a window: a change of the speed changes i_q in the same period. */
static void test_i_q_falls_with_the_speed_in_the_same_period(void)
{
    static const float speeds[] = {16.0f, 16.5f, 20.0f, 12.0f, -4.0f, 16.0f};
    begin(9.0f, 0.5f);
    for (unsigned n = 0; n < sizeof speeds / sizeof speeds[0]; n++) {
        TEST_ASSERT_EQUAL_FLOAT(9.0f - 0.5f * speeds[n], i_q(speeds[n]));
    }
}

/* At 16 rad/s the setpoints are those of a requested current, of the speed control with two stiffnesses,
 * and of a requested current again. Each window starts from the present i_q and ends at its setpoint. */
static void test_i_q_goes_on_where_the_stiffness_changes(void)
{
    static const struct {
        float standing, stiffness;
    } windows[] = {{3.0f, 0.0f}, {12.0f, 0.5f}, {6.0f, 0.25f}, {8.0f, 0.25f}, {1.0f, 0.0f}};
    begin(3.0f, 0.0f);
    float before = i_q(16.0f);
    for (unsigned n = 0; n < sizeof windows / sizeof windows[0]; n++) {
        const float end = windows[n].standing - 16.0f * windows[n].stiffness;
        begin(windows[n].standing, windows[n].stiffness);
        for (int k = 1; k <= W; k++) {
            TEST_ASSERT_EQUAL_FLOAT(before + (end - before) * (float)k / (float)W, i_q(16.0f));
        }
        before = end;
    }
}

static void test_no_current_is_left_after_the_bridge_was_off(void)
{
    begin(9.0f, 0.5f);
    (void)i_q(16.0f);
    reference_rest(&reference, (int32_t)SOURCE_ENCODER);
    begin(4.0f, 0.0f);
    TEST_ASSERT_EQUAL_FLOAT(0.5f, i_q(16.0f));
}

/* After the encoder has failed the drive uses the tracking loop that runs in parallel, or a catch at the
 * previous speed. */
static void test_an_encoder_that_fails_is_left_to_the_estimate_or_to_a_catch(void)
{
    reference_leave_encoder(&reference, true, 77.0f, 400u);
    TEST_ASSERT_EQUAL_INT32(SOURCE_ESTIMATE, reference.source);
    TEST_ASSERT_EQUAL_UINT32(1u, reference.tracking);
    reference_leave_encoder(&reference, false, 77.0f, 400u);
    TEST_ASSERT_EQUAL_INT32(SOURCE_CATCH, reference.source);
    TEST_ASSERT_EQUAL_UINT32(0u, reference.tracking);
    TEST_ASSERT_EQUAL_INT32(CATCH_GOES_ON, reference.outcome);
    TEST_ASSERT_EQUAL_FLOAT(77.0f, reference.catching.omega_e);
}
