/* The control uses the estimate on the real inverter: dead time, delays and drops of the module, 12-bit
 * ADC, 10 mA of noise, and 30 mA of offset and 0.2 % of gain error that remain after the calibration. No
 * speed has a whole number of samples per turn. */
#include "tests/rig/run.h"

#define AVERAGED 1.0
#define SWITCHED 0.0
#define RATED    5.0 /* [N m] */

/* Where the estimated speed is noisy, the speed control needs a reserve of torque above the load. With 10
 * A it is 4.7 N m above the rated torque and friction; where the limit is lower, the load is reduced in
 * proportion. */
#define LOAD_WITH_ROOM (RUN_LIMIT_SHARE * RATED)

typedef struct {
    const char *name;
    double value;
} change_t;

static void expect_at_most(double limit, double value, const char *what)
{
    char message[120];
    snprintf(message, sizeof message, "%s: %.2f mrad, limit %.2f", what, value, limit);
    TEST_ASSERT_TRUE_MESSAGE(fabs(value) <= limit, message);
}

/* The limits of a point, with 0 N m and under load [mrad]. Each is the mean plus four standard deviations
 * of a magnitude, or four rms if that is larger, over 24 seeds in both directions, and over both
 * fidelities if a test has both. It is at least 1.3 times the largest value on both boards.
 * Peaks have a longer tail: at 50 r/min without load 60 runs have 10.6 +- 1.4 mrad, two of them 15.4 and
 * 17.0 mrad; at 100 r/min under load 100 runs have 5.7 +- 1.2 mrad, one of them 16.4 mrad. */
typedef struct {
    double rpm;
    double mean[2], sd[2], peak[2];
} limits_t;

/* A drive at these speeds: speed control and i_d of the paper or of the default drive, and the changed
 * rows. */
typedef struct {
    const char *name;
    bool paper;
    change_t changes[3];
    uint32_t fidelities; /* 1: averaged; 2: averaged and switched */
    double load, seconds;
    limits_t points[5]; /* as many points as are used, up to the one with 0 r/min */
} drive_case_t;

/* Tests one point: the drive runs at this speed and load, which is put on where the speed control can hold
 * it. */
static void expect_limits(const drive_case_t *drive, const limits_t *limits, double fidelity,
                          double direction, bool loaded)
{
    const double rpm = direction * limits->rpm, load = loaded ? drive->load : 0.0;
    rig_t *rig = run_rig(7);
    run_put(rig, "fidelity", fidelity);
    if (drive->paper) {
        run_paper_drive(rig);
    }
    for (size_t n = 0; n < 3u && drive->changes[n].name != NULL; n++) {
        run_put(rig, drive->changes[n].name, drive->changes[n].value);
    }
    run_parameter(rig, "position_source", 1.0);
    run_real_under_load(rig, rpm, copysign(fmax(fabs(rpm), 300.0), rpm), load);
    run_seconds(rig, 1.5);
    const run_error_t err = run_error(rig, drive->seconds);
    printf("%s, %s, %.0f r/min, %g N m: mean %.2f, SD %.2f, peak %.2f mrad, speed %.1f r/min\n", drive->name,
           fidelity == SWITCHED ? "switched" : "averaged", rpm, load, err.mean, err.sd, err.peak,
           err.speed_mean);
    run_expect_no_fault(rig);
    TEST_ASSERT_DOUBLE_WITHIN(0.02 * fabs(rpm), rpm, err.speed_mean);
    expect_at_most(limits->mean[loaded], err.mean, loaded ? "mean, loaded" : "mean, no load");
    expect_at_most(limits->sd[loaded], err.sd, loaded ? "SD, loaded" : "SD, no load");
    expect_at_most(limits->peak[loaded], err.peak, loaded ? "peak, loaded" : "peak, no load");
    rig_free(rig);
}

/* ---- all points run, and docs/accuracy.md has these numbers ---- */

/* The requirements at 100 r/min are a mean of 5 mrad and an SD of 10 mrad; from 300 r/min on both are 4
 * mrad without load (docs/theory.md, 21) and 1.5 mrad under 5 N m. The drive is better than that. At 50
 * r/min, where the estimate is used although by the rule a forced frame would rotate, the limits are an SD
 * of 8 mrad and peaks of 40 mrad. Without load the drops leave 0.2 to 0.37 mrad, because their sign
 * follows the current in the whole period; without drops 0.01 mrad is left at 1013 r/min. */
static const drive_case_t documented[] = {
    {"compensated",
     true,
     {{NULL, 0.0}},
     2u,
     RATED,
     2.0,
     {{100.0, {0.54, 3.0}, {1.42, 1.8}, {8.7, 22.0}},
      {313.0, {0.2, 1.3}, {0.72, 0.64}, {3.4, 4.5}},
      {503.0, {0.57, 1.55}, {0.85, 0.48}, {4.1, 3.2}},
      {1013.0, {0.61, 1.12}, {0.4, 0.36}, {1.98, 2.17}},
      {1490.0, {0.52, 1.0}, {0.34, 0.34}, {1.81, 2.3}}}},
    {"compensated",
     true,
     {{"start_speed", 6.0}, {"handover_speed", 6.0}, {"fallback_speed", 3.0}},
     2u,
     LOAD_WITH_ROOM,
     3.0,
     {{50.0, {1.05, 4.7}, {4.06, 7.2}, {19.0, 48.4}}}},
};

static void test_compensated_inverter(void)
{
    for (size_t n = 0; n < sizeof documented / sizeof documented[0]; n++) {
        for (uint32_t point = 0; point < 20u && documented[n].points[point / 4u].rpm != 0.0; point++) {
            expect_limits(&documented[n], &documented[n].points[point / 4u], SWITCHED,
                          point % 2u != 0u ? -1.0 : 1.0, point / 2u % 2u != 0u);
        }
    }
}

/* ---- with this program's own additions to the paper ---- */

/* Gains by rule, an i_d that keeps the currents out of the zone of the dead time, learnt inductance and
 * dead time. The loss of a leg is 2.3 us of the link voltage and 0.875 V; the drive is configured with
 * four fifths of both. The tests show the benefit of coasting through uncertain voltages and of trimming
 * the offsets; without them the loop also stays locked. An offset that is not trimmed appears as an EMF,
 * which the current control feeds forward: without load the angle ripples with it, at 503 r/min by 2.7
 * mrad instead of 0.6. */
#define WITHOUT(name, row)                                                                                   \
    {                                                                                                        \
        name, true, {{row, 0.0}}, 1u, RATED, 1.5, WITHOUT_EITHER                                             \
    }
#define WITHOUT_EITHER                                                                                       \
    {                                                                                                        \
        {100.0, {3.2, 4.9}, {6.3, 5.5}, {45.0, 45.0}}, {313.0, {1.65, 2.2}, {1.65, 0.95}, {8.5, 5.0}},       \
            {503.0, {0.64, 1.51}, {3.6, 1.18}, {8.8, 4.1}},                                                  \
            {1013.0, {0.55, 1.07}, {1.06, 0.64}, {3.0, 3.0}},                                                \
        {                                                                                                    \
            1490.0, {0.5, 0.93}, {0.57, 0.38},                                                               \
            {                                                                                                \
                2.1, 2.15                                                                                    \
            }                                                                                                \
        }                                                                                                    \
    }
static const drive_case_t drives[] = {
    {"default drive",
     false,
     {{NULL, 0.0}},
     2u,
     LOAD_WITH_ROOM,
     2.0,
     {{100.0, {3.56, 5.4}, {4.1, 2.94}, {19.8, 11.5}},
      {313.0, {0.38, 1.46}, {1.27, 0.8}, {6.0, 4.0}},
      {503.0, {1.8, 1.55}, {1.15, 0.66}, {5.6, 2.98}},
      {1013.0, {0.6, 0.91}, {0.4, 0.43}, {2.05, 2.1}},
      {1490.0, {0.53, 0.75}, {0.38, 0.45}, {1.98, 1.65}}}},
    {"dead time 20 % too small",
     true,
     {{"params.turn_on_delay", 0.24e-6}, {"params.device_drop", 0.7}},
     2u,
     LOAD_WITH_ROOM,
     3.0,
     {{100.0, {22.8, 23.4}, {23.8, 27.6}, {65.0, 81.0}}, {313.0, {7.4, 3.15}, {3.4, 3.5}, {18.8, 12.3}}}},
    WITHOUT("no coasting", "doubtful_current"),
    WITHOUT("no trim", "params.offset_trim"),
};

static void test_other_drives(void)
{
    for (size_t n = 0; n < sizeof drives / sizeof drives[0]; n++) {
        uint32_t speeds = 0u;
        while (speeds < 5u && drives[n].points[speeds].rpm != 0.0) {
            speeds++;
        }
        grid_t grid = grid_of(drives[n].name, 4u * drives[n].fidelities * speeds);
        for (uint32_t point; grid_next(&grid, &point);) {
            const double direction = grid_axis(&point, 2u) != 0u ? -1.0 : 1.0;
            const bool loaded = grid_axis(&point, 2u) != 0u;
            const double fidelity = grid_axis(&point, drives[n].fidelities) != 0u ? SWITCHED : AVERAGED;
            expect_limits(&drives[n], &drives[n].points[point], fidelity, direction, loaded);
        }
    }
}
