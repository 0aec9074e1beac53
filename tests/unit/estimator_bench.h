/* Common code of the tests of the estimator: machines, parameters, and a bench in which the adaptation runs
 * with the estimator as it does in the drive.
 *
 * The whole estimator runs in open loop on exact data of a turning machine (estimator_oracle.h). It is judged
 * by the true angle: error = theta_hat - theta in mrad.
 *
 * The error of the float arithmetic: a current of 4.55 A is rounded by 2.4e-7 A, and the observer's own
 * current by as much. L/T turns this into a voltage, 125 V/A 5e-7 A = 6e-5 V, compared with 7.7 V or more
 * (the paper's machine at 100 r/min): 0.01 mrad. For the other machines L i_q/(T psi_f omega) is at most
 * ten times that of the paper's: 0.1 mrad per sample, which the PLL averages. lag_emf adds 1e-5 rad, and
 * the PLL 1e-5 rad (test_pll.c). FLOAT_MEAN and FLOAT_PEAK are the sums. */
#ifndef TESTS_UNIT_ESTIMATOR_BENCH_H
#define TESTS_UNIT_ESTIMATOR_BENCH_H

#include <string.h>

#include "estimator/estimator.h"
#include "medium/adapt/flux.h"
#include "tests/oracle/estimator_oracle.h"
#include "tests/oracle/pll_oracle.h"
#include "tests/oracle/smo_oracle.h"
#include "tests/unit/machines.h"
#include "tests/unit/sweep.h"

#define T          1e-4
#define PSI        0.183
#define RATED      4.55 /* [A] i_q of the paper's machine at 5 N m */
#define FLOAT_MEAN 0.03 /* [mrad] */
#define FLOAT_PEAK 0.1  /* [mrad] */

static estimator_t est;
static flux_t flux;

void setUp(void)
{
    memset(&est, 0, sizeof est);
}

static inline void tune(estimator_params_t *params, double bandwidth, double cutoff)
{
    TEST_ASSERT_TRUE(pll_design(&params->pll, (float)bandwidth, 1.0f, (float)cutoff, (float)T));
}

/* The default estimator: vector sigmoid by the rule (docs/theory.md, 3), exact lag compensation, EMF
 * filter of 2000 rad/s, PLL 200 / 50. */
static inline estimator_params_t params_of(int machine)
{
    estimator_params_t params = {.smo = observer_of(machine, 2000.0f),
                                 .lag = LAG_EXACT,
                                 .pll = {.amplitude_floor = (float)(11.0 * MACHINES[machine].flux_linkage)},
                                 .flux_linkage = (float)MACHINES[machine].flux_linkage};
    tune(&params, 200.0, 50.0);
    return params;
}

/* The paper's observer: sigmoid per axis, k_s 200 V, slope 1, no filter. */
static inline estimator_params_t paper_params(lag_mode_t lag)
{
    estimator_params_t params = params_of(0);
    params.smo = PAPER;
    params.lag = lag;
    return params;
}

static inline estimator_oracle_case_t rig_of(int machine, double omega, double current_q)
{
    estimator_oracle_case_t rig = {.resistance = MACHINES[machine].resistance,
                                   .inductance = MACHINES[machine].inductance,
                                   .flux_linkage = MACHINES[machine].flux_linkage,
                                   .period = T,
                                   .theta_start = 0.3,
                                   .omega_start = omega,
                                   .current_q = current_q};
    return rig;
}

static inline estimator_oracle_sample_t sample_of(const estimator_oracle_case_t *rig, long k)
{
    estimator_oracle_sample_t sample;
    estimator_oracle_sample(rig, k, &sample);
    return sample;
}

static inline flux_params_t flux_params_of(const estimator_params_t *params)
{
    return (flux_params_t){.flux_linkage = params->flux_linkage,
                           .adaptation = params->flux_adaptation,
                           .period = params->smo.period};
}

static inline void init(const estimator_params_t *params)
{
    const flux_params_t flux_params = flux_params_of(params);
    flux_tuning_t flux_tuning;
    estimator_init(&est, params);
    flux_prepare(&flux_tuning, &flux_params);
    flux = (flux_t){0};
    flux_take(&flux, &flux_tuning);
    flux_reset(&flux, 0.0f);
}

/* Takes over these parameters. They are checked first, because a failed assert of the firmware would end
 * the program. */
static inline void retune(const estimator_params_t *params)
{
    params_error_t why;
    TEST_ASSERT_TRUE(estimator_params_check(params, &why));
    const flux_params_t flux_params = flux_params_of(params);
    estimator_tuning_t tuning;
    flux_tuning_t flux_tuning;
    estimator_prepare(&tuning, params);
    estimator_take(&est, &tuning);
    flux_prepare(&flux_tuning, &flux_params);
    flux_take(&flux, &flux_tuning);
    estimator_set_flux(&est, flux.flux_linkage, flux.speed_per_volt);
}

/* A step of the estimator and the adaptation, in the order of the drive. */
static inline position_t stepped(ab_t voltage, ab_t current)
{
    const position_t position = estimator_step(&est, voltage, current);
    const estimate_t *seen = &est.estimate;
    if (flux.tuning.share > 0.0f && seen->coasted == 0u) {
        flux_step(&flux, seen->amplitude, seen->omega_smooth, seen->detector);
        estimator_set_flux(&est, flux.flux_linkage, flux.speed_per_volt);
    }
    return position;
}

static inline position_t step(const estimator_oracle_case_t *rig, long k)
{
    const estimator_oracle_sample_t now = sample_of(rig, k);
    return stepped(as_float(now.voltage), as_float(now.current));
}

static inline double error_of(const estimator_oracle_case_t *rig, long k, position_t position)
{
    return 1e3 * circle((double)position.theta_e - sample_of(rig, k).theta);
}

/* Starts the estimator at the true state at t_k, except for these errors [rad], [rad/s]. */
static inline void reset_near(const estimator_oracle_case_t *rig, long k, double theta, double omega)
{
    const estimator_oracle_sample_t now = sample_of(rig, k);
    position_t start = {(float)circle(now.theta + theta), (float)(now.omega + omega)};
    estimator_reset(&est, start, as_float(now.current));
    flux_reset(&flux, start.omega_e);
}

typedef struct {
    double mean, sd, peak; /* [mrad] */
    double speed;          /* mean error [rad/s] */
} deviation_t;

/* Runs the steps from `from` on; the result is that of the last `count` of them. */
static inline deviation_t deviation(const estimator_oracle_case_t *rig, long from, long settle, long count)
{
    deviation_t d = {0.0, 0.0, 0.0, 0.0};
    double squares = 0.0;
    for (long k = from; k < from + settle + count; k++) {
        const estimator_oracle_sample_t now = sample_of(rig, k);
        position_t position = stepped(as_float(now.voltage), as_float(now.current));
        if (k >= from + settle) {
            double error = 1e3 * circle((double)position.theta_e - now.theta);
            d.mean += error;
            squares += error * error;
            d.peak = fmax(d.peak, fabs(error));
            d.speed += (double)position.omega_e - now.omega;
        }
    }
    d.mean /= (double)count;
    d.speed /= (double)count;
    d.sd = sqrt(fmax(0.0, squares / (double)count - d.mean * d.mean));
    return d;
}

/* Runs this number of steps from the true state at t_0, except for this angle error [rad]. */
static inline void run_near(const estimator_params_t *params, const estimator_oracle_case_t *rig,
                            double theta, long count)
{
    init(params);
    reset_near(rig, 0, theta, 0.0);
    (void)deviation(rig, 1, count, 0);
}

/* The estimator settles at a constant speed, from an angle error of 0.1 rad. After 0.5 s the slower mode
 * of the loop (omega_c = 50 rad/s) has decayed to exp(-25), the mean of k_f to exp(-50). The following 0.6
 * s are whole turns at 100, 500, 1000 and 1500 r/min. */
static inline deviation_t settled(const estimator_params_t *params, const estimator_oracle_case_t *rig)
{
    init(params);
    reset_near(rig, 0, 0.1, 0.0);
    return deviation(rig, 1, 5000, 6000);
}

#define RAMP       565.0 /* [rad/s^2] causes a lag of 0.355 rad at ki 1624 */
#define RAMP_START 2000L
#define RAMP_STEPS 10000L

typedef struct {
    double steady; /* [mrad] mean over the last 0.1 s of the ramp */
    double peak;   /* [mrad] peak from the start of the ramp to its end */
} ramp_t;

/* A machine that accelerates from `omega` in a ramp. Its current makes the torque of the acceleration; the
 * EMF does not depend on it. */
static inline estimator_oracle_case_t ramp_rig(double omega, double acceleration)
{
    estimator_oracle_case_t rig = rig_of(0, omega, 0.0);
    rig.acceleration = acceleration;
    rig.ramp_start = RAMP_START * T;
    rig.ramp_end = (RAMP_START + RAMP_STEPS) * T;
    rig.current_torque = 1.0 / 69.0;
    return rig;
}

static inline ramp_t ramp_from(const estimator_oracle_case_t *rig, long from)
{
    ramp_t result = {0.0, 0.0};
    (void)deviation(rig, from, RAMP_START - from, 0);
    result.peak = deviation(rig, RAMP_START, 0, RAMP_STEPS - 1000).peak;
    deviation_t end = deviation(rig, RAMP_START + RAMP_STEPS - 1000, 0, 1000);
    result.peak = fmax(result.peak, end.peak);
    result.steady = end.mean;
    return result;
}

static inline ramp_t ramp(const estimator_params_t *params, const estimator_oracle_case_t *rig)
{
    init(params);
    reset_near(rig, 0, 0.0, 0.0);
    return ramp_from(rig, 1);
}

static inline estimator_params_t any_params(int n)
{
    estimator_params_t params = params_of(0);
    params.smo.slope = 0.99f;
    params.smo.switching = (smo_switching_t)(n % 3);
    params.lag = (lag_mode_t)(n / 3 % 4);
    params.smo.emf_cutoff = n / 12 % 2 ? 2000.0f : 0.0f;
    tune(&params, 200.0, n / 24 % 2 ? 50.0 : 0.0);
    params.flux_adaptation = 5.0f;
    params.torque_feedforward = n / 24 % 2 ? 69.0f : 0.0f;
    params.validity = (validity_params_t){0.5f, 1.5f, 0.01f, 0.5f, 0.01f, 5.0f, 0.01f, 60.0f, 900.0f, 0.01f};
    params.validity.speed_max = 900.0f;
    return params;
}

#endif
