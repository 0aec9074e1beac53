/* Each signal has the value that its text describes. The simulation runs through states and modes. Every row
 * of every period is recorded together with the truth of the plant, the gate edges and the settings, and each
 * row must have the value that follows from these and from other rows by physics or algebra. The tests do not
 * read the variables in which the drive keeps a value.
 *
 * The test also proves that wrong wiring is detected: if any two rows are exchanged, any row is replaced
 * by another, or any row is a period old, some check fails. */
#include <complex.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "estimator/pll.h"
#include "host_sim/rig/rig_tables.h"
#include "settings/reasons.h"
#include "tests/rig/run.h"

#define PI 3.14159265358979323846
#define J  ((double complex)I)

#define ROWS(X)                                                                                              \
    X(period)                                                                                                \
    X(state)                                                                                                 \
    X(fault_reason)                                                                                          \
    X(refusal)                                                                                               \
    X(fault_period)                                                                                          \
    X(faults_later)                                                                                          \
    X(faults_later_2)                                                                                        \
    X(warnings_2)                                                                                            \
    X(fault_present)                                                                                         \
    X(faults_seen)                                                                                           \
    X(warnings)                                                                                              \
    X(manoeuvre)                                                                                             \
    X(start_try)                                                                                             \
    X(lock_losses)                                                                                           \
    X(i_a)                                                                                                   \
    X(i_b)                                                                                                   \
    X(i_c)                                                                                                   \
    X(i_alpha)                                                                                               \
    X(i_beta)                                                                                                \
    X(i_d)                                                                                                   \
    X(i_q)                                                                                                   \
    X(i_d_ref)                                                                                               \
    X(i_q_ref)                                                                                               \
    X(u_d_ref)                                                                                               \
    X(u_q_ref)                                                                                               \
    X(u_d)                                                                                                   \
    X(u_q)                                                                                                   \
    X(u_dc)                                                                                                  \
    X(duty_a)                                                                                                \
    X(duty_b)                                                                                                \
    X(duty_c)                                                                                                \
    X(theta_e)                                                                                               \
    X(omega_e)                                                                                               \
    X(omega_m)                                                                                               \
    X(omega_m_ref)                                                                                           \
    X(frame_theta_e)                                                                                         \
    X(encoder_count)                                                                                         \
    X(offset_a)                                                                                              \
    X(offset_b)                                                                                              \
    X(offset_c)                                                                                              \
    X(sink_temperature)                                                                                      \
    X(motor_temperature)                                                                                     \
    X(sample_flags)                                                                                          \
    X(fast_cycles)                                                                                           \
    X(fast_cycles_max)                                                                                       \
    X(medium_cycles)                                                                                         \
    X(medium_cycles_max)                                                                                     \
    X(theta_hat)                                                                                             \
    X(omega_hat)                                                                                             \
    X(omega_smooth)                                                                                          \
    X(estimator_invalid)                                                                                     \
    X(e_hat_alpha)                                                                                           \
    X(e_hat_beta)                                                                                            \
    X(e_alpha)                                                                                               \
    X(e_beta)                                                                                                \
    X(e_amplitude)                                                                                           \
    X(k_f_alpha)                                                                                             \
    X(k_f_beta)                                                                                              \
    X(k_f)                                                                                                   \
    X(i_err_alpha)                                                                                           \
    X(i_err_beta)                                                                                            \
    X(detector)                                                                                              \
    X(psi_f_hat)                                                                                             \
    X(inductance_hat)                                                                                        \
    X(resistance_hat)                                                                                        \
    X(inductance_confidence)                                                                                 \
    X(theta_sigma)                                                                                           \
    X(inertia_hat)                                                                                           \
    X(u_alpha)                                                                                               \
    X(u_beta)                                                                                                \
    X(dead_time_hat)                                                                                         \
    X(emf_shape_d_hat)                                                                                       \
    X(emf_shape_q_hat)                                                                                       \
    X(leg_voltage_alpha_hat)                                                                                 \
    X(leg_voltage_beta_hat)                                                                                  \
    X(leg_resistance_alpha_hat)                                                                              \
    X(leg_resistance_beta_hat)                                                                               \
    X(trim_alpha)                                                                                            \
    X(trim_beta)                                                                                             \
    X(encoder_theta_e)                                                                                       \
    X(encoder_omega_e)                                                                                       \
    X(motor_heat)                                                                                            \
    X(module_heat)                                                                                           \
    X(i_q_lower)                                                                                             \
    X(i_q_upper)                                                                                             \
    X(dc_swing)                                                                                              \
    X(coasting)                                                                                              \
    X(outputs)                                                                                               \
    X(chopper_heat)                                                                                          \
    X(brake_state)                                                                                           \
    X(supply_current)                                                                                        \
    X(speed_calm)                                                                                            \
    X(torque_current)                                                                                        \
    X(field_weakened)                                                                                        \
    X(observer_gain_used)                                                                                    \
    X(observer_slope_used)                                                                                   \
    X(pll_bandwidth_used)                                                                                    \
    X(feedforward_cutoff_used)                                                                               \
    X(handover_speed_used)                                                                                   \
    X(voltage_trim)                                                                                          \
    X(commission_state)                                                                                      \
    X(commission_reason)                                                                                     \
    X(commission_detail)                                                                                     \
    X(commission_angle)                                                                                      \
    X(commission_largest)                                                                                    \
    X(commission_noise)                                                                                      \
    X(commission_inductance_pulse)                                                                           \
    X(commission_resistance)                                                                                 \
    X(commission_resistance_spread)                                                                          \
    X(commission_dead_voltage)                                                                               \
    X(commission_current_hold)                                                                               \
    X(commission_current_zone)                                                                               \
    X(commission_inductance_d)                                                                               \
    X(commission_inductance_q)                                                                               \
    X(commission_saturation_current)                                                                         \
    X(commission_loop_gain)                                                                                  \
    X(commission_flux_first)                                                                                 \
    X(commission_inertia_first)                                                                              \
    X(commission_flux_linkage)                                                                               \
    X(commission_flux_scatter)                                                                               \
    X(commission_inertia)                                                                                    \
    X(commission_inertia_scatter)                                                                            \
    X(commission_point_x)                                                                                    \
    X(commission_point_y)                                                                                    \
    X(commission_friction_coulomb)                                                                           \
    X(commission_friction_viscous)

enum {
#define ROW_PLACE(name) R_##name,
    ROWS(ROW_PLACE)
#undef ROW_PLACE
        ROW_COUNT
};

static const char *const row_names[ROW_COUNT] = {
#define ROW_NAME(name) #name,
    ROWS(ROW_NAME)
#undef ROW_NAME
};

/* ---- the record ---- */

typedef struct {
    double row[ROW_COUNT]; /* [unit of the row] */
    double steps;          /* [periods] that the simulation has run, including this one */
    double true_i[3];      /* [A] */
    double true_theta_e, true_omega_e, true_u_dc, theta_hat_err;
    double on[3]; /* [-] share of this period for which the upper switch of each leg was on */
} sample_t;

/* Values that are constant during a part of the run (a stretch). */
typedef struct {
    const char *name;
    uint32_t first, end;                  /* first index and index after the last in the record */
    double state, refusal, fault_reason;  /* [-] */
    double fault_period, faults_later;    /* [periods], [-] */
    double fault_present, faults_seen;    /* [-] */
    double warnings, warnings_2;          /* [-] */
    double derated;                       /* [A] by which a warm sink reduces the limit */
    double manoeuvre, start_try, losses;  /* [-] */
    double flags, invalid;                /* [-] */
    double i_d_ref, i_q_ref, omega_m_ref; /* [A], [rad/s]; NAN: the speed itself */
    bool forced;                          /* the frame of the control is not that of the rotor */
    bool bridge, sensorless, cut;         /* cut: the link is too low for the requested voltage */
    bool settled;                         /* flux linkage and trim have converged */
} stretch_t;

#define LENGTH    200u /* [periods] of a stretch */
#define STRETCHES 6u
/* [A] Drift of sensor a since its calibration, below MEASURE_MOVED. */
#define EXTRA      (0.003 * (double)DRIVE_CURRENT_RANGE)
#define FLUX       0.183
#define ENCODER_N  10000.0
#define POLE_PAIRS 4.0
#define ADAPTED    10.0 /* [s] */

static sample_t record[STRETCHES * LENGTH];
#define DROP   1e-4 /* [V] */
#define LIMIT  4.0  /* [A] */
#define LONGER 1.2  /* [-] factor by which each task takes longer once */

/* The sink is 9 K below its limit, which reduces the current limit by a tenth of three quarters.
 * WARM_IN() has the bits of both rows in a word. */
#define WARM_IN(word)                                                                                        \
    ((FAULT_WORD(FAULT_SINK_WARM) == (word) ? (double)FAULT_BIT(FAULT_SINK_WARM) : 0.0) +                    \
     (FAULT_WORD(FAULT_DERATING) == (word) ? (double)FAULT_BIT(FAULT_DERATING) : 0.0))

static stretch_t stretches[STRETCHES];
static double settings_period, settings_resistance, settings_device, settings_inductance, settings_inertia,
    settings_gain, settings_slope, settings_kp, settings_mean_share, settings_encoder, settings_zero[3],
    settings_dead, settings_lines;

/* ---- the run ---- */

static rig_t *rig;

typedef struct {
    uint64_t since[3];
    uint64_t total[3]; /* [ticks] on-time until `since` */
    uint32_t level;
} gates_t;

static gates_t gates;

static void on_gates(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    gates_t *g = context;
    if (what != RIG_EDGE_GATES) {
        return;
    }
    for (uint32_t n = 0; n < 3u; n++) {
        g->total[n] += (g->level >> (2u * n) & 1u) != 0u ? tick - g->since[n] : 0u;
        g->since[n] = tick;
    }
    g->level = value;
}

static uint64_t on_until(uint32_t leg, uint64_t tick)
{
    return gates.total[leg] + ((gates.level >> (2u * leg) & 1u) != 0u ? tick - gates.since[leg] : 0u);
}

static void write_down(sample_t *to)
{
    uint64_t before[3];
    char name[40];
    for (uint32_t n = 0; n < 3u; n++) {
        before[n] = on_until(n, RIG_PERIOD_TICKS * rig_period(rig));
    }
    rig_step(rig);
    for (uint32_t n = 0; n < 3u; n++) {
        to->on[n] = (double)(on_until(n, RIG_PERIOD_TICKS * rig_period(rig)) - before[n]) / RIG_PERIOD_TICKS;
    }
    for (uint32_t n = 0; n < ROW_COUNT; n++) {
        snprintf(name, sizeof name, "signals.%s", row_names[n]);
        to->row[n] = rig_value(rig, name);
    }
    to->steps = rig_period(rig);
    to->true_i[0] = rig_value(rig, "true_i_a");
    to->true_i[1] = rig_value(rig, "true_i_b");
    to->true_i[2] = rig_value(rig, "true_i_c");
    to->true_theta_e = rig_value(rig, "true_theta_e");
    to->true_omega_e = rig_value(rig, "true_omega_e");
    to->true_u_dc = rig_value(rig, "true_u_dc");
    to->theta_hat_err = rig_value(rig, "theta_hat_err");
}

static void stretch(uint32_t n, const stretch_t *what)
{
    stretches[n] = *what;
    stretches[n].first = n * LENGTH;
    stretches[n].end = (n + 1u) * LENGTH;
    for (uint32_t k = stretches[n].first; k < stretches[n].end; k++) {
        write_down(&record[k]);
    }
}

/* The shaft, the limit and the trip are the same on every board. */
static void run_all(void)
{
    rig = rig_create(71);
    TEST_ASSERT_NOT_NULL(rig);
    run_paper_drive(rig);
    run_ideal(rig); /* so that the voltage follows from duties and link */
    run_parameter(rig, "params.device_drop", DROP);
    run_put(rig, "sensors", 0.0);
    run_put(rig, "fidelity", 0.0);
    run_put(rig, "current_offset_a", 0.11);
    run_put(rig, "current_offset_b", -0.07);
    run_put(rig, "current_offset_c", 0.05);
    run_put(rig, "plant.sink_temperature", 41.0);
    run_put(rig, "plant.motor_temperature", 57.0);
    run_put(rig, "current_limit", LIMIT);
    run_put(rig, "motor_time_constant", 0.0); /* tests/rig/protect_link.grid tests the thermal model */
    run_put(rig, "module_time_constant", 0.0);
    /* a switching function in each axis, which gives three different gains. */
    run_put(rig, "observer_switching", 1.0);
    run_put(rig, "offset_trim", 0.1);
    run_put(rig, "inductance_adaptation", 0.0); /* so that i_d is the requested one */
    run_put(rig, "field_weakening", 0.0);
    run_put(rig, "compensation_gain", 0.0);
    run_parameter(rig, "motor_flux_linkage", 1.04 * FLUX);
    run_to_ready_at(rig, 500.0);
    rig_watch_edges(rig, on_gates, &gates);
    run_put(rig, "interrupt_time", LONGER);
    rig_run(rig, 2u * DRIVE_WINDOW);
    run_put(rig, "interrupt_time", 1.0);
    run_put(rig, "medium_time", LONGER);
    rig_run(rig, 2u * DRIVE_WINDOW);
    run_put(rig, "medium_time", 1.0);
    settings_zero[0] = 0.11;
    settings_zero[1] = -0.07;
    settings_zero[2] = BOARD_CURRENT_SENSORS == 3 ? 0.05 : -(0.11 - 0.07);
    run_put(rig, "current_offset_a", 0.11 + EXTRA);
    run_put(rig, "current_offset_c", 0.05 - EXTRA);

    /* The power module pulls its fault line, and until it releases the line the value does not apply. */
    run_put(rig, "force_fault", 1.0);
    run_on(rig, 500.0);
    rig_run(rig, 50);
    stretch(0, &(stretch_t){.name = "refused", .state = 1.0, .refusal = REASON_FAULT_PRESENT, .flags = 3.0});

    /* Without the encoder and with a start_speed above this speed, the forced frame rotates as fast as the
     * driven shaft, and so does the estimate. */
    run_put(rig, "shaft_locked_speed", 120.0 * RPM);
    run_put(rig, "shaft_locked", 1.0);
    run_put(rig, "speed_request", 120.0 * RPM);
    run_put(rig, "handover_speed", 20.0);
    run_put(rig, "start_speed", 19.0);
    run_parameter(rig, "position_source", 1.0);
    run_put(rig, "force_fault", 0.0);
    run_seconds(rig, 6.0);
    stretch(1, &(stretch_t){.name = "forced",
                            .state = 3.0,
                            .manoeuvre = MANOEUVRE_FORCED,
                            .start_try = 1.0,
                            .omega_m_ref = 120.0 * RPM,
                            .bridge = true,
                            .forced = true,
                            .sensorless = true});

    /* The motor accelerates on the encoder with the torque at its limit, and the estimate is reported as
     * too slow. */
    run_put(rig, "handover_speed", 0.0);
    run_put(rig, "start_speed", 8.0);
    run_parameter(rig, "position_source", 0.0);
    run_put(rig, "shaft_locked_speed", 500.0 * RPM);
    run_put(rig, "speed_request", 500.0 * RPM);
    run_seconds(rig, 0.5);
    run_put(rig, "shaft_locked", 0.0);
    run_seconds(rig, 0.3);
    run_put(rig, "i_d_request", -0.7);
    run_parameter(rig, "estimate_speed_min", 200.0);
    run_put(rig, "speed_request", 1200.0 * RPM);
    run_seconds(rig, 0.2);
    stretch(2, &(stretch_t){.name = "accelerating",
                            .state = 3.0,
                            .manoeuvre = MANOEUVRE_RUN,
                            .start_try = 1.0,
                            .invalid = 8.0,
                            .i_d_ref = -0.7,
                            .i_q_ref = 4.0,
                            .omega_m_ref = 1200.0 * RPM,
                            .bridge = true});

    /* The control of the currents uses the estimate, while the shaft is held so that there is enough time.
     * The lock is lost once. */
    run_put(rig, "estimate_speed_min", 3.0);
    run_put(rig, "sink_temperature_max", 50.0);
    run_parameter(rig, "flux_adaptation", 2.0);
    run_put(rig, "mode", 1.0);
    run_put(rig, "i_d_request", 1.5);
    run_put(rig, "i_q_request", 3.25);
    run_put(rig, "shaft_locked_speed", rig_value(rig, "true_omega_m"));
    run_put(rig, "shaft_locked", 1.0);
    for (double speed = rig_value(rig, "true_omega_m"); speed < 1400.0 * RPM; speed += 0.5) {
        run_put(rig, "shaft_locked_speed", speed);
        run_seconds(rig, 2e-3);
    }
    run_parameter(rig, "position_source", 1.0);
    run_seconds(rig, 0.5);
    run_put(rig, "estimate_jump", 3.0);
    run_seconds(rig, ADAPTED);
    stretch(3, &(stretch_t){.name = "currents",
                            .state = 3.0,
                            .manoeuvre = MANOEUVRE_RUN,
                            .losses = 1.0,
                            .i_d_ref = 1.5,
                            .i_q_ref = 3.25,
                            .omega_m_ref = (double)NAN,
                            .bridge = true,
                            .sensorless = true,
                            .warnings = DRIVE_SINK_SENSOR ? WARM_IN(0u) : 0.0,
                            .warnings_2 = DRIVE_SINK_SENSOR ? WARM_IN(1u) : 0.0,
                            .derated = DRIVE_SINK_SENSOR ? 0.75 * 0.1 * LIMIT : 0.0,
                            .settled = true});

    /* The link is too low for these currents. */
    run_put(rig, "sink_temperature_max", 80.0);
    run_put(rig, "current_judged", 0.0); /* the speed of the shaft jumps */
    run_parameter(rig, "position_source", 0.0);
    run_put(rig, "dc_voltage", 1.02 * rig_value(rig, "dc_undervoltage"));
    run_put(rig, "shaft_locked_speed", 1500.0 * RPM);
    run_seconds(rig, 0.2);
    stretch(4, &(stretch_t){.name = "low link",
                            .state = 3.0,
                            .manoeuvre = MANOEUVRE_RUN,
                            .losses = 1.0,
                            .i_d_ref = 1.5,
                            .i_q_ref = 3.25,
                            .omega_m_ref = (double)NAN,
                            .bridge = true,
                            .cut = true});

    /* A sensor is at the end of its range, and while the drive is off the link is too high. */
    run_put(rig, "stuck_current_a", 4095.0);
    rig_run(rig, 3);
    run_put(rig, "stuck_current_a", -1.0);
    const double stopped = rig_period(rig);
    run_put(rig, "dc_voltage", 5.0 + rig_value(rig, "dc_overvoltage"));
    rig_run(rig, 10);
    /* This reset is too early, because the voltage is still too high. The reset is not repeated. */
    run_put(rig, "fault_reset", 1.0);
    rig_run(rig, 1);
    run_put(rig, "dc_voltage", 200.0);
    run_put(rig, "shaft_locked_speed", 400.0 * RPM);
    run_seconds(rig, 0.1);
    stretch(5, &(stretch_t){.name = "fault",
                            .state = 5.0,
                            .losses = 1.0,
                            .refusal = REASON_FAULT_LATCHED,
                            .fault_reason = REASON_BAD_SAMPLE,
                            .fault_period = stopped,
                            .faults_later = 8.0, /* bit 3 is the fourth row of the fault table */
                            .fault_present = REASON_DC_OVERVOLTAGE,
                            .faults_seen = 1.0,
                            .flags = 1.0});

    settings_period = RIG_PERIOD_SECONDS;
    settings_resistance = rig_value(rig, "motor_resistance");
    settings_device = rig_value(rig, "params.device_resistance");
    settings_inductance = rig_value(rig, "motor_inductance_q");
    settings_inertia = rig_value(rig, "motor_inertia");
    settings_gain = rig_value(rig, "observer_gain_used");
    settings_slope = rig_value(rig, "observer_slope_used");
    settings_encoder = rig_value(rig, "encoder_bandwidth");
    settings_dead = rig_value(rig, "dead_time");
    settings_lines = rig_value(rig, "params.encoder_lines");
    settings_mean_share = 1.0 - exp(-(double)SMO_GAIN_CUTOFF * RIG_PERIOD_SECONDS);
    pll_params_t pll = {.period = (float)RIG_PERIOD_SECONDS};
    TEST_ASSERT_TRUE(pll_design(&pll, 200.0f, /* by the rule four times the smallest bandwidth, 50 rad/s */
                                (float)rig_value(rig, "pll_damping"), 50.0f, (float)RIG_PERIOD_SECONDS));
    settings_kp = (double)pll.kp;
    rig_free(rig);
}

/* ---- the checks ---- */

/* The column of the record from which each row is read: its own column or a wrong one, which the check
 * must detect. */
static uint32_t wired[ROW_COUNT];
static uint32_t late[ROW_COUNT]; /* [periods] by which the row is old */

static double at(uint32_t k, uint32_t row)
{
    return record[k - (k < late[row] ? k : late[row])].row[wired[row]];
}

#define V(name) at(k, R_##name)

static double wrapped(double angle)
{
    return remainder(angle, 2.0 * PI);
}

static double complex pair(uint32_t k, uint32_t re, uint32_t im)
{
    return at(k, re) + J * at(k, im);
}

static double complex clarke(double a, double b, double c)
{
    return (2.0 * a - b - c) / 3.0 + J * (b - c) / sqrt(3.0);
}

static double complex duty_vector(uint32_t k)
{
    return clarke(V(duty_a), V(duty_b), V(duty_c));
}

static const char *wrong; /* the check that failed; NULL if none */
static uint32_t wrong_at;
static double wrong_is, wrong_expected;

static bool near_to(uint32_t k, const char *name, double expected, double is, double tolerance)
{
    if (fabs(is - expected) <= tolerance) {
        return true;
    }
    wrong = name;
    wrong_at = k;
    wrong_is = is;
    wrong_expected = expected;
    return false;
}

#define EXPECT(name, expected, tolerance)                                                                    \
    if (!near_to(k, #name, expected, V(name), tolerance)) {                                                  \
        return false;                                                                                        \
    }
#define EXPECT_OF(text, is, expected, tolerance)                                                             \
    if (!near_to(k, text, expected, is, tolerance)) {                                                        \
        return false;                                                                                        \
    }

/* The states of the drive, and what it reads from the sensors. The tolerance of each is a code of the ADC. */
static bool sensors_and_states(const stretch_t *s, uint32_t k)
{
    const sample_t *sample = &record[k];
    EXPECT(period, sample->steps, 0.0)
    EXPECT(state, s->state, 0.0)
    EXPECT(refusal, s->refusal, 0.0)
    EXPECT(fault_reason, s->fault_reason, 0.0)
    EXPECT(fault_period, s->fault_period, 0.0)
    EXPECT(faults_later, s->faults_later, 0.0)
    EXPECT(faults_later_2, 0.0, 0.0)
    EXPECT(warnings_2, s->warnings_2, 0.0)
    EXPECT(i_q_lower, s->derated - LIMIT, 0.005 * LIMIT) /* 0.05 K of the sink */
    EXPECT(i_q_upper, LIMIT - s->derated, 0.005 * LIMIT)
    EXPECT(motor_heat, 0.0, 0.0)
    EXPECT(module_heat, 0.0, 0.0)
    EXPECT(dc_swing, 0.0, 0.0)
    EXPECT(coasting, 0.0, 0.0)
    EXPECT(outputs, 0.0, 0.0) /* tests/cases/chopper.grid, tests/rig/test_brake.c */
    EXPECT(chopper_heat, 0.0, 0.0)
    EXPECT(brake_state, 0.0, 0.0)
    EXPECT(supply_current, 0.0, 0.0) /* tests/cases/supply_current.grid */
    /* This run requests no step of commissioning; tests/lab/test_commission.c runs them. */
    EXPECT(commission_state, 0.0, 0.0)
    EXPECT(commission_reason, 0.0, 0.0)
    EXPECT(commission_detail, 0.0, 0.0)
    EXPECT(commission_angle, 0.0, 0.0)
    EXPECT(commission_largest, 0.0, 0.0)
    EXPECT(commission_noise, 0.0, 0.0)
    EXPECT(commission_inductance_pulse, 0.0, 0.0)
    EXPECT(commission_resistance, 0.0, 0.0)
    EXPECT(commission_resistance_spread, 0.0, 0.0)
    EXPECT(commission_dead_voltage, 0.0, 0.0)
    EXPECT(commission_current_hold, 0.0, 0.0)
    EXPECT(commission_current_zone, 0.0, 0.0)
    EXPECT(commission_inductance_d, 0.0, 0.0)
    EXPECT(commission_inductance_q, 0.0, 0.0)
    EXPECT(commission_saturation_current, 0.0, 0.0)
    EXPECT(commission_loop_gain, 0.0, 0.0)
    EXPECT(commission_flux_first, 0.0, 0.0)
    EXPECT(commission_inertia_first, 0.0, 0.0)
    EXPECT(commission_flux_linkage, 0.0, 0.0)
    EXPECT(commission_flux_scatter, 0.0, 0.0)
    EXPECT(commission_inertia, 0.0, 0.0)
    EXPECT(commission_inertia_scatter, 0.0, 0.0)
    EXPECT(commission_point_x, 0.0, 0.0)
    EXPECT(commission_point_y, 0.0, 0.0)
    EXPECT(commission_friction_coulomb, 0.0, 0.0)
    EXPECT(commission_friction_viscous, 0.0, 0.0)
    EXPECT(speed_calm, 1.0, 0.0) /* nothing oscillates */
    /* The gain follows from the rules of docs/theory.md, 3, 7 and 23, for the default motor with the flux
     * configured as above. */
    const double gain = 1.25 * 1.04 * FLUX * POLE_PAIRS * 220.0;
    const double dead =
        (double)(BOARD_SECONDS(BOARD_DEAD_TIME_NS) * BOARD_VOLTS(BOARD_OVERVOLTAGE_MV) / DRIVE_PERIOD);
    const double handover = fmin(1.15 * fmax(dead, 0.95 * LIMIT) / (1.04 * FLUX * POLE_PAIRS), 0.3 * 220.0);
    EXPECT(observer_gain_used, gain, 1e-3)
    EXPECT(observer_slope_used, 1.6 * 12.5e-3 / (gain * (double)DRIVE_PERIOD), 1e-4)
    EXPECT(pll_bandwidth_used, 200.0, 0.0)
    EXPECT(feedforward_cutoff_used, 50.0, 0.0)
    EXPECT(handover_speed_used, s == &stretches[1] ? 20.0 : handover, 1e-3)
    EXPECT(fault_present, s->fault_present, 0.0)
    EXPECT(faults_seen, s->faults_seen, 0.0)
    EXPECT(sample_flags, s->flags, 0.0)
    /* The medium task ends before a second interrupt comes. */
    EXPECT(fast_cycles, RIG_INTERRUPT_CYCLES, 2.0)
    EXPECT(fast_cycles_max, LONGER * RIG_INTERRUPT_CYCLES, 2.0)
    EXPECT(medium_cycles, RIG_MEDIUM_CYCLES + RIG_INTERRUPT_CYCLES, 2.0)
    EXPECT(medium_cycles_max, LONGER * RIG_MEDIUM_CYCLES + RIG_INTERRUPT_CYCLES, 2.0)
    EXPECT(warnings, s->warnings, 0.0)
    EXPECT(manoeuvre, s->manoeuvre, 0.0)
    EXPECT(start_try, s->start_try, 0.0)
    EXPECT(lock_losses, s->losses, 0.0)
    EXPECT(inductance_confidence, 0.0, 0.0)
    EXPECT(emf_shape_d_hat, 0.0, 0.0)
    EXPECT(emf_shape_q_hat, 0.0, 0.0)
    EXPECT(leg_voltage_alpha_hat, 0.0, 0.0)
    EXPECT(leg_voltage_beta_hat, 0.0, 0.0)
    EXPECT(leg_resistance_alpha_hat, 0.0, 0.0)
    EXPECT(leg_resistance_beta_hat, 0.0, 0.0)
    EXPECT(field_weakened, 0.0, 0.0) /* tests/cases/field_weakening.py tests both */
    EXPECT(voltage_trim, 0.0, 0.0)
    if (s->bridge) {
        EXPECT(estimator_invalid, s->invalid, 0.0)
    }
    const double sink = DRIVE_SINK_SENSOR ? 41.0 : (double)DRIVE_NO_TEMPERATURE;
    const double motor = DRIVE_MOTOR_SENSOR ? 57.0 : (double)DRIVE_NO_TEMPERATURE;
    EXPECT(sink_temperature, sink, 0.05)
    EXPECT(motor_temperature, motor, 0.05)
    EXPECT(u_dc, sample->true_u_dc, 1.01 * (double)BOARD_DC_PER_CODE)
    const double code = 1.01 * (double)BOARD_CURRENT_PER_CODE;
    EXPECT(i_a, sample->true_i[0] + EXTRA, code)
    EXPECT(i_b, sample->true_i[1], code)
    EXPECT(i_c, sample->true_i[2] - EXTRA, 2.0 * code)
    EXPECT(offset_a, settings_zero[0], code)
    EXPECT(offset_b, settings_zero[1], code)
    EXPECT(offset_c, settings_zero[2], 2.0 * code)

    const double step = 2.0 * PI * POLE_PAIRS / ENCODER_N;
    EXPECT(encoder_theta_e, wrapped((V(encoder_count) + 0.5) * step), 2e-6)
    EXPECT_OF("encoder_count", wrapped(V(encoder_theta_e) - sample->true_theta_e), 0.0, 0.6 * step)
    /* The lag is the acceleration divided by half the bandwidth; noise is 0.75 bandwidth times half a step
     * (encoder.h). */
    EXPECT(encoder_omega_e, sample->true_omega_e, 2.5)
    return true;
}

/* Currents and voltages in their frames. The precision of a float is 24 bits. */
static bool frames(const stretch_t *s, uint32_t k)
{
    const double complex abc = clarke(V(i_a), V(i_b), V(i_c));
    const double complex ab = pair(k, R_i_alpha, R_i_beta);
    /* The active trim is that of the window before the last; the first period of the last window shows it. */
    const uint32_t ago = DRIVE_WINDOW + ((uint32_t)record[k].row[R_period] - 1u) % DRIVE_WINDOW;
    const bool is_seen = k >= s->first + ago;
    const double complex trim_before = pair(is_seen ? k - ago : k, R_trim_alpha, R_trim_beta);
    const double moved = is_seen ? 1e-5 : 0.01;
    EXPECT(i_alpha, creal(abc - trim_before), moved)
    EXPECT(i_beta, cimag(abc - trim_before), moved)
    const double complex dq = ab * cexp(-J * V(frame_theta_e));
    EXPECT(i_d, creal(dq), 1e-4)
    EXPECT(i_q, cimag(dq), 1e-4)
    /* after a loss the speed contains the proportional part of the loop */
    EXPECT(omega_m, (s->sensorless && s->losses == 0.0 ? V(omega_smooth) : V(omega_e)) / POLE_PAIRS, 1e-4)
    if (!s->bridge) {
        EXPECT(theta_e, V(encoder_theta_e), 0.0)
        EXPECT(omega_e, V(encoder_omega_e), 0.0)
        EXPECT(frame_theta_e, V(theta_e), 0.0)
        EXPECT(duty_a, 0.5, 0.0)
        EXPECT(duty_b, 0.5, 0.0)
        EXPECT(duty_c, 0.5, 0.0)
        EXPECT(i_d_ref, 0.0, 0.0)
        EXPECT(i_q_ref, 0.0, 0.0)
        EXPECT(torque_current, 0.0, 0.0)
        EXPECT(omega_m_ref, 0.0, 0.0)
        return true;
    }
    EXPECT(theta_e, s->sensorless ? V(theta_hat) : V(encoder_theta_e), 0.0)
    EXPECT(omega_e, s->sensorless ? V(omega_hat) : V(encoder_omega_e), 0.0)
    if (!s->forced) {
        EXPECT(frame_theta_e, V(theta_e), 0.0)
        EXPECT(i_d_ref, (double)(float)s->i_d_ref, 0.0)
        EXPECT(i_q_ref, (double)(float)s->i_q_ref, 0.0)
        EXPECT(torque_current, (double)(float)s->i_q_ref, 0.0) /* for a round rotor it is i_q */
    }
    if (s->forced) {
        EXPECT(omega_m_ref, s->omega_m_ref, 0.01)
    } else if (isnan(s->omega_m_ref)) {
        /* The medium task knows it from the end of the window before the last on. */
        if (k % LENGTH > ago) {
            EXPECT(omega_m_ref, at(k - ago - 1u, R_omega_m), 0.0)
        }
    } else {
        EXPECT(omega_m_ref, (double)(float)s->omega_m_ref, 0.0)
    }
    /* The inverter has no losses, so that the voltage follows from duties and link; duties are whole
     * counts. */
    const double complex u = duty_vector(k) * V(u_dc);
    const double turning = s->forced ? POLE_PAIRS * V(omega_m_ref) : V(omega_e);
    const double complex u_dq = u * cexp(-J * (V(frame_theta_e) + 1.5 * settings_period * turning));
    const double count = 1.5 * V(u_dc) / BOARD_PERIOD_COUNT;
    EXPECT(u_d, creal(u_dq), count)
    EXPECT(u_q, cimag(u_dq), count)
    if (s->cut) {
        /* A voltage vector that is limited keeps its direction. */
        const double complex u_ref = pair(k, R_u_d_ref, R_u_q_ref);
        EXPECT_OF("u_ref", cabs(u_ref) > cabs(u_dq) + 1.0, 1.0, 0.0)
        EXPECT_OF("u_ref", carg(u_ref / u_dq), 0.0, count / cabs(u_dq))
    } else {
        EXPECT(u_d_ref, V(u_d), 0.0)
        EXPECT(u_q_ref, V(u_q), 0.0)
    }
    return true;
}

/* Values that follow from the periods before. */
static bool in_time(const stretch_t *s, uint32_t k)
{
    /* The speed of the encoder follows its angle (encoder.h): the error that has changed the speed, and
     * the next error. */
    const double r = 1.0 - exp(-settings_encoder * settings_period);
    const double per_speed = settings_period / (r * r);
    const double error = (at(k - 1u, R_encoder_omega_e) - at(k - 2u, R_encoder_omega_e)) * per_speed;
    const double next = wrapped(V(encoder_theta_e) - at(k - 1u, R_encoder_theta_e)) + error -
                        settings_period * at(k - 1u, R_encoder_omega_e) - r * (2.0 - r) * error;
    EXPECT_OF("encoder_omega_e", (V(encoder_omega_e) - at(k - 1u, R_encoder_omega_e)) * per_speed, next, 5e-6)
    if (!s->bridge) {
        return true;
    }
    /* The duties of k - 1 act in period k. The upper switch is on for its duty less the dead time; for a
     * pulse hardly longer than the dead time, one half may consist of dead time alone. */
    static const uint32_t duties[3] = {R_duty_a, R_duty_b, R_duty_c};
    for (uint32_t n = 0; n < 3u; n++) {
        const double duty = at(k - 1u, duties[n]);
        const double dead = settings_dead / settings_period;
        EXPECT_OF("duty", record[k].on[n],
                  duty > 4.0 * dead && at(k - 2u, duties[n]) > 4.0 * dead ? duty - dead : record[k].on[n],
                  2.0 / BOARD_PERIOD_COUNT)
    }
    if (s->forced) {
        EXPECT_OF("frame_theta_e", wrapped(V(frame_theta_e) - at(k - 1u, R_frame_theta_e)),
                  settings_period * POLE_PAIRS * at(k - 1u, R_omega_m_ref), 1e-6)
    }
    const double complex u = duty_vector(k - 2u) * 0.5 * (V(u_dc) + at(k - 1u, R_u_dc));
    EXPECT(u_alpha, creal(u), 1e-3)
    EXPECT(u_beta, cimag(u), 1e-3)

    /* The observer (5), from one period to the next, and its sigmoid (12) in each axis. */
    const double decay = exp(-settings_resistance * settings_period / settings_inductance);
    const double complex x = pair(k, R_i_err_alpha, R_i_err_beta);
    const double complex x_before = pair(k - 1u, R_i_err_alpha, R_i_err_beta);
    const double complex v_before = settings_gain * (at(k - 1u, R_k_f_alpha) * creal(x_before) +
                                                     J * at(k - 1u, R_k_f_beta) * cimag(x_before));
    const double complex hat =
        decay * (pair(k - 1u, R_i_alpha, R_i_beta) + x_before) +
        (1.0 - decay) / settings_resistance * (pair(k, R_u_alpha, R_u_beta) - v_before);
    const double complex predicted = hat - pair(k, R_i_alpha, R_i_beta);
    EXPECT(i_err_alpha, creal(predicted), 1e-4)
    EXPECT(i_err_beta, cimag(predicted), 1e-4)
    EXPECT_OF("k_f_alpha", V(k_f_alpha) * creal(x), tanh(0.5 * settings_slope * creal(x)), 1e-4)
    EXPECT_OF("k_f_beta", V(k_f_beta) * cimag(x), tanh(0.5 * settings_slope * cimag(x)), 1e-4)
    return true;
}

/* The estimate compared with the rotor. */
static bool estimate(const stretch_t *s, uint32_t k)
{
    const sample_t *sample = &record[k];
    if (!s->bridge) {
        return true;
    }
    EXPECT_OF("theta_hat", wrapped(V(theta_hat) - sample->true_theta_e), sample->theta_hat_err, 1e-6)
    EXPECT_OF("theta_hat", sample->theta_hat_err, 0.0, 0.15)
    /* A step of the ADC within a period corresponds to this voltage on L, which matters when the EMF is
     * small. */
    const double size = FLUX * sample->true_omega_e;
    const double step =
        s->forced ? settings_inductance * (double)BOARD_CURRENT_PER_CODE / settings_period : 0.0;
    EXPECT(omega_hat, sample->true_omega_e, 0.03 * sample->true_omega_e + settings_kp * step / size)
    /* The term of k_p; in this time the integrator has changed by its share of the detector, 0.3 % of the
     * term. */
    EXPECT_OF("omega_hat", V(omega_hat) - V(omega_smooth), settings_kp * V(detector),
              0.01 * settings_kp * fabs(V(detector)) + 2e-4)

    /* The voltage of the switching function is not filtered where the lag is compensated exactly. */
    EXPECT(e_hat_alpha, settings_gain * V(k_f_alpha) * V(i_err_alpha), 1e-3)
    EXPECT(e_hat_beta, settings_gain * V(k_f_beta) * V(i_err_beta), 1e-3)
    /* The inverter is ideal. The drive does not learn, and its model of the inverter is right except for
     * one voltage drop, which has an effect only here.
     */
    EXPECT(dead_time_hat, DROP, 1e-2 * DROP)
    /* The EMF of the rotor is j psi_f omega e^(j theta), except for the ripple that a sigmoid in each axis
     * makes. */
    const double complex e = J * size * cexp(J * sample->true_theta_e);
    EXPECT(e_alpha, creal(e), 0.06 * size + step)
    EXPECT(e_beta, cimag(e), 0.06 * size + step)
    EXPECT(e_amplitude, size, 0.06 * size + step)
    EXPECT(inductance_hat, settings_inductance, 0.0)
    EXPECT(resistance_hat, settings_resistance + settings_device, 1e-6)
    EXPECT(inertia_hat, settings_inertia, 0.0)
    if (s->settled) {
        EXPECT(psi_f_hat, FLUX, 0.01 * FLUX)
        const double complex off = clarke(EXTRA, 0.0, -EXTRA);
        EXPECT(trim_alpha, creal(off), 0.015)
        EXPECT(trim_beta, cimag(off), 0.015)
    }
    return true;
}

/* The components of a row in proportion to cos theta and to sin theta, fitted by least squares over a part
 * of the run. */
static double complex fitted(const stretch_t *s, uint32_t row)
{
    double cc = 0.0, cs = 0.0, ss = 0.0, ec = 0.0, es = 0.0;
    for (uint32_t k = s->first; k < s->end; k++) {
        const double c = cos(record[k].true_theta_e);
        const double sine = sin(record[k].true_theta_e);
        cc += c * c;
        cs += c * sine;
        ss += sine * sine;
        ec += at(k, row) * c;
        es += at(k, row) * sine;
    }
    const double determinant = cc * ss - cs * cs;
    return (ec * ss - es * cs) / determinant + J * (es * cc - ec * cs) / determinant;
}

/* The lag is compensated in each axis; at this speed it is at least 50 mrad. */
static bool without_lag(const stretch_t *s)
{
    const uint32_t k = s->first;
    if (s->settled) {
        const double size = FLUX * record[k].true_omega_e;
        EXPECT_OF("e_alpha", creal(fitted(s, R_e_alpha)) / size, 0.0, 0.015)
        EXPECT_OF("e_beta", cimag(fitted(s, R_e_beta)) / size, 0.0, 0.015)
    }
    return true;
}

/* k_f of the compensation is power-weighted over both axes: it is p/q of the low-passed p = sum of k_f x^2
 * and q = sum of x^2 (smo.h). Both low-passes take the share s of each sample, so that (1 - s) q(k-1)
 * (k_f(k) - k_f(k-1)) = s (p_k - k_f(k) q_k). There q(k-1), the mean square of the error, is almost
 * constant; it changes only by the ripple of the gain itself. */
static bool weighted_gain(const stretch_t *s)
{
    const double share = settings_mean_share;
    double mean = 0.0; /* q before the first sample is the mean over the whole stretch */
    double missed = 0.0;
    double moved = 0.0;
    for (uint32_t k = s->first; k < s->end; k++) {
        mean +=
            (V(i_err_alpha) * V(i_err_alpha) + V(i_err_beta) * V(i_err_beta)) / (double)(s->end - s->first);
    }
    for (uint32_t k = s->first; k < s->end && s->bridge; k++) {
        const double x2 = V(i_err_alpha) * V(i_err_alpha);
        const double y2 = V(i_err_beta) * V(i_err_beta);
        if (k > s->first) {
            const double left = (1.0 - share) * mean * (V(k_f) - at(k - 1u, R_k_f));
            const double right = share * (V(k_f_alpha) * x2 + V(k_f_beta) * y2 - V(k_f) * (x2 + y2));
            missed += (left - right) * (left - right);
            moved += right * right;
        }
        mean += share * (x2 + y2 - mean);
    }
    const uint32_t k = s->first;
    EXPECT_OF("k_f", s->bridge ? sqrt(missed / moved) : 0.0, 0.0, 0.15)
    return true;
}

/* The uncertainty of a steady loop from L, R and dead time that are not learnt (theory, 31), from the gain
 * of the sensors, and from the ripple of the switching function. */
static double uncertainty(uint32_t k)
{
    const double size = FLUX * record[k].true_omega_e;
    const double complex i = pair(k, R_i_alpha, R_i_beta) * cexp(-J * record[k].true_theta_e);
    const double leg = 4.0 / PI * settings_dead / settings_period * V(u_dc) * creal(i) / cabs(i);
    const double reactance = record[k].true_omega_e * settings_inductance * cimag(i);
    const double resistance = (settings_resistance + settings_device) * creal(i);
    return 0.1 * sqrt(leg * leg + reactance * reactance + resistance * resistance) / size;
}

/* The medium task computes it within the first period of the next window. */
static bool of_the_angle(const stretch_t *s, uint32_t k)
{
    if (!s->sensorless) {
        EXPECT(theta_sigma, 0.5 * PI * POLE_PAIRS / settings_lines / sqrt(12.0), 1e-8)
    } else {
        EXPECT(theta_sigma, uncertainty(k), 0.05 * uncertainty(k))
        if (k > s->first && V(theta_sigma) != at(k - 1u, R_theta_sigma)) {
            EXPECT_OF("theta_sigma", fmod(V(period), DRIVE_WINDOW), 0.0, 0.0)
        }
    }
    return true;
}

static bool all_right(void)
{
    wrong = NULL;
    for (uint32_t n = 0; n < STRETCHES; n++) {
        const stretch_t *s = &stretches[n];
        for (uint32_t k = s->first; k < s->end; k++) {
            if (!sensors_and_states(s, k) || !frames(s, k) || (k >= s->first + 2u && !in_time(s, k)) ||
                !estimate(s, k) || !of_the_angle(s, k)) {
                return false;
            }
        }
        if (!weighted_gain(s) || !without_lag(s)) {
            return false;
        }
    }
    return true;
}

static void wire_all(void)
{
    for (uint32_t n = 0; n < ROW_COUNT; n++) {
        wired[n] = n;
        late[n] = 0u;
    }
}

/* ---- tests ---- */

void setUp(void)
{
    wire_all();
}

/* A new row must be added to the list above, with a check. */
static void test_every_row_is_checked(void)
{
    const table_t *signals = NULL;
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        signals = strcmp(rig_table(n)->name, "signals") == 0 ? rig_table(n) : signals;
    }
    TEST_ASSERT_NOT_NULL(signals);
    TEST_ASSERT_EQUAL_UINT32(ROW_COUNT, signals->count);
    for (uint32_t n = 0; n < signals->count; n++) {
        uint32_t place = 0;
        while (place < ROW_COUNT && strcmp(row_names[place], signals->rows[n].name) != 0) {
            place++;
        }
        TEST_ASSERT_TRUE_MESSAGE(place < ROW_COUNT, signals->rows[n].name);
    }
}

static void test_every_row_has_the_value_of_its_text(void)
{
    char message[160] = "";
    if (!all_right()) {
        const uint32_t n = wrong_at / LENGTH;
        snprintf(message, sizeof message, "%s in \"%s\", period %u of it: %.9g instead of %.9g", wrong,
                 stretches[n].name, (unsigned)(wrong_at - stretches[n].first), wrong_is, wrong_expected);
    }
    TEST_ASSERT_NULL_MESSAGE(wrong, message);
}

/* Rows that do not change in this run: a confidence in a value that is not learnt; rows of the fault table
 * that are not provoked; a thermal model that is off; a stiff link; a field that is not weakened; a
 * commissioning that is not requested. Without sensors of temperature their warnings do not change either. */
static bool empty(uint32_t row)
{
    return row == R_inductance_confidence || row == R_emf_shape_d_hat || row == R_emf_shape_q_hat ||
           row == R_leg_voltage_alpha_hat || row == R_leg_voltage_beta_hat ||
           row == R_leg_resistance_alpha_hat || row == R_leg_resistance_beta_hat || row == R_field_weakened ||
           row == R_voltage_trim || row == R_faults_later_2 || row == R_warnings_2 || row == R_motor_heat ||
           row == R_module_heat || row == R_dc_swing || row == R_coasting || row == R_outputs ||
           row == R_chopper_heat || row == R_brake_state || row == R_supply_current ||
           (row >= R_commission_state && row <= R_commission_friction_viscous) ||
           (row == R_warnings && !DRIVE_SINK_SENSOR);
}

/* Two rows that are equal: both temperatures on a board without such sensors, and current and torque
 * current of a round rotor. */
static bool alike(uint32_t a, uint32_t b)
{
    const bool round = (a == R_i_q_ref && b == R_torque_current) || (a == R_torque_current && b == R_i_q_ref);
    const bool temperatures = (a == R_sink_temperature || a == R_motor_temperature) &&
                              (b == R_sink_temperature || b == R_motor_temperature);
    return round || (temperatures && !DRIVE_SINK_SENSOR && !DRIVE_MOTOR_SENSOR) || (empty(a) && empty(b));
}

static void test_any_two_rows_exchanged_are_found(void)
{
    TEST_ASSERT_TRUE(all_right());
    for (uint32_t a = 0; a < ROW_COUNT; a++) {
        for (uint32_t b = a + 1u; b < ROW_COUNT; b++) {
            char message[120];
            wire_all();
            wired[a] = b;
            wired[b] = a;
            snprintf(message, sizeof message, "%s and %s exchanged", row_names[a], row_names[b]);
            TEST_ASSERT_TRUE_MESSAGE(!all_right() || alike(a, b), message);
        }
    }
}

static void test_any_row_in_the_place_of_another_is_found(void)
{
    TEST_ASSERT_TRUE(all_right());
    for (uint32_t a = 0; a < ROW_COUNT; a++) {
        for (uint32_t b = 0; b < ROW_COUNT; b++) {
            char message[120];
            wire_all();
            wired[a] = b;
            snprintf(message, sizeof message, "%s shows %s", row_names[a], row_names[b]);
            TEST_ASSERT_TRUE_MESSAGE(a == b || !all_right() || alike(a, b), message);
        }
    }
}

static bool moves(uint32_t row)
{
    uint32_t moved = 0;
    for (uint32_t k = 1; k < STRETCHES * LENGTH; k++) {
        moved += record[k].row[row] != record[k - 1u].row[row];
    }
    return moved > STRETCHES;
}

static void test_any_row_that_is_a_period_old_is_found(void)
{
    uint32_t moving = 0;
    uint32_t shown = 0;
    TEST_ASSERT_TRUE(all_right());
    for (uint32_t n = 0; n < ROW_COUNT; n++) {
        wire_all();
        late[n] = 1u;
        moving += moves(n);
        shown += empty(n) ? 0u : 1u;
        TEST_ASSERT_TRUE_MESSAGE(!moves(n) || !all_right(), row_names[n]);
    }
    TEST_ASSERT_TRUE(moving > shown / 2u);
}

int main(void)
{
    UNITY_BEGIN();
    run_all();
    RUN_TEST(test_every_row_is_checked);
    RUN_TEST(test_every_row_has_the_value_of_its_text);
    RUN_TEST(test_any_two_rows_exchanged_are_found);
    RUN_TEST(test_any_row_in_the_place_of_another_is_found);
    RUN_TEST(test_any_row_that_is_a_period_old_is_found);
    return UNITY_END();
}
