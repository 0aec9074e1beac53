/* Functions for tests in closed loop, which bring a simulation to a speed and measure the error of the
 * estimated angle over a time. */
#ifndef TESTS_RIG_RUN_H
#define TESTS_RIG_RUN_H

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "drive/drive.h"
#include "host_sim/rig/rig.h"
#include "tests/rig/seed.h"
#include "unity.h"

#define RPM (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */

/* ---- the board ---- */

/* Shafts, loads and times of these tests were chosen for the paper's motor and a current limit of 10 A. On
 * a board with another limit the current that a test needs is multiplied by this share [-], which is 1 if
 * the board allows 10 A. */
#define RUN_LIMIT_SHARE (BOARD_CURRENT_LIMIT_MA / 10000.0)

/* Torque of the paper's motor [N m] at this number of amperes. */
#define RUN_TORQUE(current) (1.5 * 4.0 * 0.183 * (current))

/* Prints the measured values, and returns the line, which is the message of the next checks.
 */
__attribute__((format(printf, 1, 2))) static inline const char *run_say(const char *format, ...)
{
    static char text[240];
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text, sizeof text, format, values);
    va_end(values);
    printf("%s\n", text);
    return text;
}

static inline void run_put(rig_t *rig, const char *name, double value)
{
    if (!rig_put(rig, name, value)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
}

/* Sets several rows given as text, such as "sensors=1 current_noise=0". */
static inline void run_puts(rig_t *rig, const char *text)
{
    char name[40];
    double value;
    for (int length; sscanf(text, " %39[^=]=%lf%n", name, &value, &length) == 2; text += length) {
        run_put(rig, name, value);
    }
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", text, "accepted: rows as NAME=VALUE, separated by blanks");
}

/* From now on this function receives these rows in every period. */
#define RUN_TAP_MOST 20u
static inline void run_tap(rig_t *rig, const char *const names[], uint32_t count,
                           void (*take)(void *context, uint32_t period, const uint32_t *slots,
                                        uint32_t count),
                           void *context)
{
    uint32_t ids[RUN_TAP_MOST];
    TEST_ASSERT_TRUE(count <= RUN_TAP_MOST);
    for (uint32_t n = 0; n < count; n++) {
        ids[n] = rig_row_by_name(names[n])->id;
    }
    TEST_ASSERT_TRUE(rig_tap(rig, ids, count, 1u, take, context));
}

static inline void run_seconds(rig_t *rig, double seconds)
{
    rig_run(rig, (uint32_t)(seconds / RIG_PERIOD_SECONDS + 0.5));
}

static inline void run_parameter(rig_t *rig, const char *name, double value)
{
    run_put(rig, name, value);
    if (!rig_apply(rig)) {
        TEST_FAIL_MESSAGE(rig_error(rig));
    }
}

/* Multiplies a row by this factor; a parameter is staged. */
static inline void run_times(rig_t *rig, const char *name, double factor)
{
    run_put(rig, name, factor * rig_value(rig, name));
}

/* The drive of the paper, to which the numbers of the tests belong. It uses the encoder; its speed control
 * is the PI control of the paper's figures; it learns no parameter of motor and inverter; and it has no
 * i_d (which matters only without the encoder). These parameters are applied; parameters that scale the
 * gains must follow. */
static inline void run_paper_drive(rig_t *rig)
{
    run_puts(rig, "position_source=0 speed_kp=0.5 speed_ki=2.5 speed_setpoint_weight=1 "
                  "inductance_adaptation=0 dead_time_adaptation=0 inertia_adaptation=0 "
                  "torque_feedforward=0");
    run_parameter(rig, "low_speed_current", 0.0);
}

/* A shaft in proportion to the torque that the current limit of the board gives. If the loads are
 * multiplied by RUN_LIMIT_SHARE too, all accelerations are those of 10 A, and so are every speed, time and
 * angle of a test. The parameters are staged; the gains of the speed control are scaled from the active
 * ones. */
static inline void run_shaft_of_board(rig_t *rig)
{
    static const char *const rows[] = {"inertia", "friction_coulomb", "motor_inertia", "speed_kp",
                                       "speed_ki"};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        run_times(rig, rows[n], RUN_LIMIT_SHARE);
    }
}

/* From power-on to ready. The offsets are measured with the actual currents of the plant. */
static inline void run_to_ready(rig_t *rig)
{
    rig_run(rig, seed_phase());
    run_seconds(rig, 0.06);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "state"));
}

/* Turns the drive on with this speed reference. */
static inline void run_on(rig_t *rig, double rpm)
{
    run_put(rig, "speed_request", rpm * RPM);
    run_put(rig, "enable", 1.0);
}

/* A copy of the simulation in its present state, from which several runs can continue; the caller frees
 * it. */
static inline void *run_kept(rig_t *rig)
{
    void *const state = malloc(rig_state_size());
    TEST_ASSERT_NOT_NULL(state);
    rig_save(rig, state);
    return state;
}

static inline void run_back_to(rig_t *rig, const void *state)
{
    TEST_ASSERT_TRUE(rig_load(rig, state, rig_state_size()));
}

static inline void run_expect_no_fault(rig_t *rig)
{
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(3.0, rig_value(rig, "state"));
}

/* ---- sensorless ---- */

/* An inverter without dead time and drops, and exact sensors, in both plant and firmware. The dead band
 * delays one edge by the same time by which the turn-off delays the other. To be called before the state
 * ready. */
static inline void run_ideal(rig_t *rig)
{
    static const char *const none[] = {
        "igbt_voltage",         "igbt_resistance",         "diode_voltage", "diode_resistance",
        "plant.turn_on_delay",  "plant.current_zone",      "current_noise", "params.device_drop",
        "params.turn_on_delay", "params.device_resistance"};
    for (size_t n = 0; n < sizeof none / sizeof none[0]; n++) {
        run_put(rig, none[n], 0.0);
    }
    run_puts(rig, "sensors=1 params.current_zone=1e-3");
    run_put(rig, "dead_time_adaptation", 0.0); /* zero in both, so that learning could follow only noise */
    const double dead_time = rig_value(rig, "dead_time");
    run_put(rig, "plant.turn_off_delay", dead_time);
    run_parameter(rig, "params.turn_off_delay", dead_time);
}

/* The errors of the current sensors that remain after the calibration. The defaults have dead time, drops
 * and delays of the module, a 12-bit ADC and 10 mA of noise. Where phase c has no sensor, the offset of a
 * appears with the other sign in the calculated current c; a sensor of c gets this offset, so that the
 * vector has an error of (30, 17) mA on every board. To be called after the state ready. */
static inline void run_real(rig_t *rig)
{
    run_puts(rig, "current_offset_a=0.03 current_offset_c=-0.03 current_gain_error_b=0.002");
}

/* A motor, its load, and the largest requested speed. */
typedef struct {
    double pole_pairs, resistance, inductance, flux_linkage; /* [-], [ohm], [H], [Wb] */
    double inertia, friction;                                /* [kg m^2], [N m] */
    double speed;                                            /* [rad/s] mechanical */
    double bandwidth;                                        /* [rad/s] of the speed control */
} run_motor_t;

/* Sets the motor in plant and firmware, and the parameters by the project's rules: k_s = 1.75 e_max, slope
 * 1.6 L/(k_s T_s), a current error at 96 % of k_s. The caller sets the limits of current, voltage and
 * speed. To be called before the state ready; the parameters are staged. */
static inline void run_put_motor(rig_t *rig, const run_motor_t *m)
{
    const double gain = 1.75 * m->flux_linkage * m->pole_pairs * m->speed;
    const double slope = 1.6 * m->inductance / (gain * RIG_PERIOD_SECONDS);
    const double torque_per_ampere = 1.5 * m->pole_pairs * m->flux_linkage;
    const struct {
        const char *name;
        double value;
    } rows[] = {
        {"pole_pairs", m->pole_pairs},
        {"plant.resistance", m->resistance},
        {"plant.inductance_d", m->inductance},
        {"plant.inductance_q", m->inductance},
        {"plant.flux_linkage", m->flux_linkage},
        {"plant.inertia", m->inertia},
        {"friction_coulomb", m->friction},
        {"motor_pole_pairs", m->pole_pairs},
        {"motor_resistance", m->resistance},
        {"motor_inductance_d", m->inductance},
        {"motor_inductance_q", m->inductance},
        {"motor_flux_linkage", m->flux_linkage},
        {"motor_inertia", m->inertia},
        {"start_speed", 0.05 * m->speed},
        {"estimate_speed_min", 0.02 * m->speed},
        {"speed_kp", m->bandwidth * m->inertia / torque_per_ampere},
        {"speed_ki", 0.25 * m->bandwidth * m->bandwidth * m->inertia / torque_per_ampere},
        {"observer_gain", gain},
        {"observer_slope", slope},
        {"estimate_current_max", fmin(4.0 / slope, 100.0)},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        run_put(rig, rows[n].name, rows[n].value);
    }
}

/* From power-on to ready with a rotor that turns at this speed. Friction is switched on only afterwards, so
 * that the speed is constant. */
static inline void run_to_ready_at(rig_t *rig, double rpm)
{
    const double friction = rig_value(rig, "friction_coulomb");
    run_put(rig, "friction_coulomb", 0.0);
    rig_set_motion(rig, 0.0, rpm * RPM);
    run_to_ready(rig);
    run_put(rig, "friction_coulomb", friction);
}

/* The load is applied or removed as a ramp of this number of seconds, because a step would stop the rotor at
 * low speed. */
static inline void run_load(rig_t *rig, double torque, double seconds)
{
    const double before = rig_value(rig, "load_torque");
    for (int32_t n = 1; n <= 50; n++) {
        run_put(rig, "load_torque", before + (torque - before) * n / 50.0);
        run_seconds(rig, seconds / 50.0);
    }
}

/* The speed reference moves linearly [r/min]. */
static inline void run_speed(rig_t *rig, double from, double to, double seconds)
{
    for (int32_t n = 1; n <= 50; n++) {
        run_put(rig, "speed_request", (from + (to - from) * n / 50.0) * RPM);
        run_seconds(rig, seconds / 50.0);
    }
}

/* The error theta_hat - true theta_e over a time [mrad electrical], and the mean speed [r/min]. */
typedef struct {
    double mean, sd, peak, speed_mean;
} run_error_t;

typedef struct {
    double sum, square, peak, speed; /* [rad], [rad^2], [rad], [rad/s] */
    uint32_t count;                  /* [-] */
} run_sums_t;

static inline void run_sum(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    run_sums_t *sums = context;
    float value[2];
    (void)period;
    memcpy(value, slots, count * sizeof value[0]);
    const double err = (double)value[0];
    sums->sum += err;
    sums->square += err * err;
    sums->peak = fmax(sums->peak, fabs(err));
    sums->speed += (double)value[1];
    sums->count++;
}

static inline run_error_t run_error(rig_t *rig, double seconds)
{
    const uint32_t ids[] = {rig_row_by_name("theta_hat_err")->id, rig_row_by_name("true_omega_m")->id};
    run_sums_t sums = {0};
    TEST_ASSERT_TRUE(rig_tap(rig, ids, 2u, 1u, run_sum, &sums));
    run_seconds(rig, seconds);
    TEST_ASSERT_TRUE(rig_tap(rig, NULL, 0u, 1u, NULL, NULL));
    const double mean = sums.sum / sums.count;
    return (run_error_t){
        .mean = 1e3 * mean,
        .sd = 1e3 * sqrt(fmax(0.0, sums.square / sums.count - mean * mean)),
        .peak = 1e3 * sums.peak,
        .speed_mean = sums.speed / sums.count / RPM,
    };
}

/* Brings a drive on the real inverter from power-on to this speed and load. The load is put on at a speed
 * at which the speed control can hold it; the reference then moves to the final speed within two seconds. */
static inline void run_real_under_load(rig_t *rig, double rpm, double rpm_loading, double load)
{
    run_to_ready_at(rig, rpm_loading);
    run_real(rig);
    run_on(rig, rpm_loading);
    run_seconds(rig, 0.5);
    run_load(rig, load, 1.5);
    run_speed(rig, rpm_loading, rpm, 2.0);
}

/* The voltage that a leg loses by the parameters of the plant [V]. */
static inline double run_leg_loss(rig_t *rig)
{
    const double effective = rig_value(rig, "dead_time") + rig_value(rig, "plant.turn_on_delay") -
                             rig_value(rig, "plant.turn_off_delay");
    const double drop = 0.5 * (rig_value(rig, "igbt_voltage") + rig_value(rig, "diode_voltage"));
    return effective / RIG_PERIOD_SECONDS * rig_value(rig, "u_dc") + drop;
}

/* The learnt loss of a leg divided by the true one [-]. */
static inline double run_learnt_loss(rig_t *rig)
{
    return rig_value(rig, "dead_time_hat") / run_leg_loss(rig);
}

#endif
