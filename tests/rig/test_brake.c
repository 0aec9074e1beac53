/* A hoist with its holding brake in closed loop. The load of 100 % (7.7 N m, 7 A, the continuous current)
 * is active and has no friction, on a light shaft. The measured result is the angle by which the load
 * turns. */
#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "tests/rig/run.h"

#define TURN    (2.0 * 3.14159265358979323846)
#define DEGREE  (TURN / 360.0)
#define LOAD    7.7   /* [N m] load of 100 % */
#define HOLDS   30.0  /* [N m] torque that the brake holds */
#define RELEASE 60e-3 /* [s] release time of the brake */
#define APPLY   40e-3 /* [s] apply time of the brake */
#define SLIP    5.0   /* [deg] largest allowed angle of slip */
#define ANGLES  24u

/* The values of a period, and the times at which the brake began to hold and the bridge opened. */
static struct {
    double lowest, highest; /* [rad] lowest and highest angle of the shaft */
    uint32_t held;          /* [periods] time at which the brake began to hold; 0: it does not hold */
    uint32_t opened;        /* [periods] time at which the bridge opened */
    uint32_t released;      /* [periods] for which the brake output was on before the torque was present */
} seen;

static rig_t *rig;

static bool bridge_on(void)
{
    return rig_state(rig)->plant.on != 0u;
}

static void watch(double seconds)
{
    const plant_t *plant = &rig_state(rig)->plant;
    memset(&seen, 0, sizeof seen);
    plant_truth_t truth;
    plant_truth(plant, &truth);
    seen.lowest = seen.highest = truth.theta_m;
    bool on = false;
    for (uint32_t n = 1; n <= (uint32_t)(seconds / RIG_PERIOD_SECONDS + 0.5); n++) {
        rig_step(rig);
        plant_truth(plant, &truth);
        seen.lowest = fmin(seen.lowest, truth.theta_m);
        seen.highest = fmax(seen.highest, truth.theta_m);
        on |= bridge_on();
        seen.held = plant->holds != 0u && seen.held == 0u ? n : plant->holds != 0u ? seen.held : 0u;
        seen.opened = on && drive_bridge_on(&rig_state(rig)->app.drive) ? n + 1u : seen.opened;
        if (plant->released != 0u && plant->holds != 0u && fabs(truth.torque - LOAD) > 0.1 * LOAD) {
            seen.released++;
        }
    }
}

static void hoist(double theta_m, double preload)
{
    rig = run_rig(1u);
    run_puts(rig, "position_source=0 params.motor_inertia=0.02 inertia=0.02 friction_coulomb=0 load_kind=1");
    run_puts(rig, "holding_brake=1 brake_release_time=0.06 brake_apply_time=0.04");
    run_put(rig, "holding_torque", HOLDS);
    run_put(rig, "holding_release_time", RELEASE);
    run_put(rig, "holding_apply_time", APPLY);
    run_put(rig, "plant.load_torque", LOAD);
    run_parameter(rig, "brake_preload", preload);
    rig_set_motion(rig, theta_m, 0.0);
    run_seconds(rig, 0.3);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
}

void tearDown(void)
{
    rig_free(rig);
    rig = NULL;
}

static void test_a_hoist_starts_from_each_angle_without_slipping(void)
{
    static const double shares[] = {1.0, 0.8, 0.0}; /* pre-torque divided by the load torque */
    double worst = 0.0;
    uint32_t good = 0u;
    for (uint32_t n = 0; n < 3u * ANGLES; n++) {
        const double from = TURN * (n % ANGLES) / ANGLES, share = shares[n / ANGLES];
        hoist(from, share * LOAD);
        run_on(rig, 0.0);
        watch(0.5);
        double slip = fmax(from - seen.lowest, seen.highest - from) / DEGREE;
        TEST_ASSERT_TRUE(seen.released == 0u || share < 1.0);
        TEST_ASSERT_EQUAL_DOUBLE(BRAKE_RELEASED, rig_value(rig, "brake_state"));
        run_on(rig, 100.0); /* upwards; the load must not sink first */
        watch(0.5);
        slip = fmax(slip, (from - seen.lowest) / DEGREE);
        TEST_ASSERT_TRUE(seen.highest > from + 0.3 * TURN);
        run_expect_no_fault(rig);
        worst = fmax(worst, slip);
        good += slip < SLIP ? 1u : 0u;
        rig_free(rig);
        rig = NULL;
    }
    const char *const where =
        run_say("%u of %u starts, largest slip %.3f degrees", (unsigned)good, 3u * ANGLES, worst);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(3u * ANGLES, good, where);
}

/* Off, quick stop, and a fault that stops the motor: the brake holds before the bridge opens. */
static void test_the_brake_holds_before_the_bridge_opens(void)
{
    static const struct {
        const char *row;
        double value;
    } stops[] = {{"enable", 0.0}, {"enable", 2.0}, {"enable_input", 1.0}};
    for (size_t n = 0; n < sizeof stops / sizeof stops[0]; n++) {
        hoist(1.0, LOAD);
        run_on(rig, 200.0);
        run_seconds(rig, 1.0);
        run_put(rig, stops[n].row, stops[n].value);
        watch(2.0);
        const char *const where = run_say("%s = %g: holds at %.1f ms, opens at %.1f ms", stops[n].row,
                                          stops[n].value, 0.1 * seen.held, 0.1 * seen.opened);
        TEST_ASSERT_TRUE_MESSAGE(seen.held != 0u && seen.opened != 0u, where);
        TEST_ASSERT_TRUE_MESSAGE(seen.held < seen.opened, where);
        TEST_ASSERT_FALSE(drive_bridge_on(&rig_state(rig)->app.drive));
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(n == 2u ? REASON_ENABLE_INPUT : REASON_NONE,
                                         rig_value(rig, "fault_reason"), where);
        watch(0.5); /* the brake alone holds the load */
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, seen.highest - seen.lowest);
        rig_free(rig);
        rig = NULL;
    }
}

/* For a fault that opens the bridge at once, the brake holds after its apply time plus two periods for pin
 * and plant, or plus four windows if the medium task detects the fault. */
static void test_a_fault_sets_the_brake_at_once(void)
{
    static const struct {
        const char *row;
        double value;
    } faults[] = {{"plant.force_fault", 1.0},     {"stuck_current_a", 4095.0}, {"plant.encoder_offset", 0.4},
                  {"plant.encoder_stuck_a", 0.0}, {"open_phase_b", 1.0},       {"current_gain_error_a", -2.0},
                  {"open_switches", 1.0},         {"plant.dc_voltage", 100.0}, {"plant.dc_voltage", 420.0},
                  {"plant.encoder_slip", 1.0},    {"interrupt_time", 3.0},     {"medium_time", 30.0}};
    for (size_t n = 0; n < sizeof faults / sizeof faults[0]; n++) {
        hoist(0.0, LOAD);
        run_on(rig, 200.0);
        run_seconds(rig, 1.0);
        run_expect_no_fault(rig);
        run_put(rig, faults[n].row, faults[n].value);
        uint32_t off = 0u, holds = 0u;
        for (uint32_t k = 1; k <= 10000u && holds == 0u; k++) {
            rig_step(rig);
            off = off == 0u && rig_state(rig)->app.drive.state == (int32_t)DRIVE_FAULT ? k : off;
            holds = rig_state(rig)->plant.holds != 0u ? k : 0u;
        }
        const char *const where =
            run_say("%s = %g: fault %.0f after %.1f ms, the brake holds %.1f ms later", faults[n].row,
                    faults[n].value, rig_value(rig, "fault_reason"), 0.1 * off, 0.1 * holds - 0.1 * off);
        TEST_ASSERT_TRUE_MESSAGE(off != 0u && holds >= off, where);
        TEST_ASSERT_TRUE_MESSAGE(holds - off <= (uint32_t)(APPLY / RIG_PERIOD_SECONDS) + 3u, where);
        rig_free(rig);
        rig = NULL;
    }
}

/* The current limit does not permit the pre-torque: the brake stays set, and a fault reports this. */
static void test_without_the_torque_the_brake_stays_set(void)
{
    hoist(0.0, 15.0);
    run_on(rig, 0.0);
    watch(1.0);
    TEST_ASSERT_EQUAL_DOUBLE(REASON_BRAKE_TORQUE, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_UINT32(1u, seen.held);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.0, seen.highest - seen.lowest);
}

/* The pre-torque is wrong by a fifth of the load, or there is none, and the speed control takes over the
 * load. Until its integral has the missing torque dT, the shaft turns by dT/(K_t ki). By the rule ki is 10
 * A per 5 degrees for every speed control while the brake is released; a stiffer speed control keeps its
 * own ki. A heavier shaft needs the same ki. */
static void test_the_speed_control_replaces_a_wrong_pre_torque(void)
{
    static const double shares[] = {1.2, 0.8, 0.5, 0.0, 1.29};
    static const struct {
        double kp, ki, inertia; /* 0: values by the rules */
        double integral;        /* [A/rad] the ki that is active while the brake is released */
    } controls[] = {{3.0, 124.0, 0.02, 124.0},
                    {0.0, 0.0, 0.02, 10.0 / (5.0 * DEGREE)},
                    {0.0, 0.0, 0.06, 10.0 / (5.0 * DEGREE)},
                    {0.5, 2.5, 0.02, 10.0 / (5.0 * DEGREE)}};
    for (size_t c = 0; c < sizeof controls / sizeof controls[0]; c++) {
        for (size_t n = 0; n < sizeof shares / sizeof shares[0]; n++) {
            hoist(0.0, shares[n] * LOAD);
            run_put(rig, "inertia", controls[c].inertia);
            run_put(rig, "params.motor_inertia", controls[c].inertia);
            run_put(rig, "speed_kp", controls[c].kp);
            run_parameter(rig, "speed_ki", controls[c].ki);
            run_on(rig, 0.0);
            watch(1.0);
            const double slip = fmax(-seen.lowest, seen.highest) / DEGREE;
            const double expected =
                fabs(1.0 - shares[n]) * LOAD / (RUN_TORQUE(1.0) * controls[c].integral) / DEGREE;
            const char *const where =
                run_say("kp %g, J %g: pre-torque %.0f %% of the load: %.2f degrees, by the integral %.2f",
                        controls[c].kp, controls[c].inertia, 100.0 * shares[n], slip, expected);
            run_expect_no_fault(rig);
            TEST_ASSERT_TRUE_MESSAGE(slip < SLIP && slip > 0.8 * expected, where);
            rig_free(rig);
            rig = NULL;
        }
    }
}
