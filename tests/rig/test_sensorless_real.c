/* The estimate closes the loop on the real inverter: dead time, delays and drops of the module, 12-bit ADC,
 * 10 mA of noise, 30 mA offset and 0.2 % gain error that calibration left. Speeds are no whole number of
 * samples per turn. */
#include "tests/rig/run.h"

void setUp(void)
{
}

void tearDown(void)
{
}

#define AVERAGED 1.0
#define SWITCHED 0.0
#define RATED    5.0 /* [N m] */

typedef struct {
    const char *name;
    double value;
} change_t;

/* Running at this speed and load; the load is put on where the speed control can hold it. */
static rig_t *running(double fidelity, const change_t *changes, size_t count, double rpm, double load)
{
    const double rpm_loading = copysign(fmax(fabs(rpm), 300.0), rpm);
    rig_t *rig = rig_create(7);
    TEST_ASSERT_NOT_NULL(rig);
    run_put(rig, "fidelity", fidelity);
    for (size_t n = 0; n < count; n++) {
        run_put(rig, changes[n].name, changes[n].value);
    }
    run_parameter(rig, "position_source", 1.0);
    run_to_ready_at(rig, rpm_loading);
    run_real(rig);
    run_on(rig, rpm_loading);
    run_seconds(rig, 0.5);
    run_load(rig, load, 1.5);
    for (int32_t n = 1; n <= 50; n++) {
        run_put(rig, "speed_request", (rpm_loading + (rpm - rpm_loading) * n / 50.0) * RPM);
        run_seconds(rig, 0.04);
    }
    run_seconds(rig, 1.5);
    return rig;
}

static run_error_t measure(const char *what, double fidelity, const change_t *changes, size_t count, double rpm,
                           double load, double seconds)
{
    rig_t *rig = running(fidelity, changes, count, rpm, load);
    const run_error_t err = run_error(rig, seconds);
    printf("%s, %s, %.0f r/min, %g N m: mean %.2f, SD %.2f, peak %.2f mrad, speed %.1f r/min\n", what,
           fidelity == SWITCHED ? "switched" : "averaged", rpm, load, err.mean, err.sd, err.peak,
           err.speed_mean);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs(rpm), rpm, err.speed_mean);
    TEST_ASSERT_TRUE(err.peak < 1000.0); /* locked: never on the way to another pole */
    rig_free(rig);
    return err;
}
