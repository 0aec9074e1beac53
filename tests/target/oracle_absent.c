/* The oracles are C++ with Eigen and run on the host only. A test that needs one is left out on a target
 * and reports this. */
#include <unity.h>

#include "tests/oracle/estimator_oracle.h"
#include "tests/oracle/pll_oracle.h"
#include "tests/oracle/smo_oracle.h"

#define LEFT_OUT() TEST_IGNORE_MESSAGE("needs an oracle, which runs on the host only")

void estimator_oracle_sample(const estimator_oracle_case_t *rig, long k, estimator_oracle_sample_t *sample)
{
    (void)rig;
    (void)k;
    (void)sample;
    LEFT_OUT();
}
double pll_oracle_bandwidth(const pll_oracle_t *loop, int *crossings)
{
    (void)loop;
    (void)crossings;
    LEFT_OUT();
    return 0.0;
}
double pll_oracle_error_coefficient(const pll_oracle_t *loop, int n)
{
    (void)loop;
    (void)n;
    LEFT_OUT();
    return 0.0;
}
void pll_oracle_continuous(const pll_oracle_t *loop, int n, double scale, size_t count, double *error)
{
    (void)loop;
    (void)n;
    (void)scale;
    (void)count;
    (void)error;
    LEFT_OUT();
}
void pll_oracle_sampled(const pll_oracle_t *loop, const double *theta, const double *omega, size_t count,
                        double *error, double *frequency)
{
    (void)loop;
    (void)theta;
    (void)omega;
    (void)count;
    (void)error;
    (void)frequency;
    LEFT_OUT();
}
double pll_oracle_radius(const pll_oracle_t *loop)
{
    (void)loop;
    LEFT_OUT();
    return 0.0;
}
void smo_oracle_sample(const smo_oracle_case_t *rig, long k, smo_oracle_sample_t *sample)
{
    (void)rig;
    (void)k;
    (void)sample;
    LEFT_OUT();
}
smo_oracle_response_t smo_oracle_response(const smo_oracle_case_t *rig, const smo_oracle_observer_t *observer,
                                          double k_f)
{
    (void)rig;
    (void)observer;
    (void)k_f;
    LEFT_OUT();
    return (smo_oracle_response_t){0};
}
smo_oracle_run_t smo_oracle_run(const smo_oracle_case_t *rig, const smo_oracle_observer_t *observer,
                                smo_oracle_switching_t switching, long settle, long count)
{
    (void)rig;
    (void)observer;
    (void)switching;
    (void)settle;
    (void)count;
    LEFT_OUT();
    return (smo_oracle_run_t){0};
}
