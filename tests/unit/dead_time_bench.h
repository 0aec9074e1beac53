/* The bench of test_dead_time_learn.c and test_dead_time_chance.c. The input is the EMF of a turning rotor
 * plus the error of the three legs that a wrong assumed dead time causes, each with the sign of its current.
 */
#ifndef TESTS_UNIT_DEAD_TIME_BENCH_H
#define TESTS_UNIT_DEAD_TIME_BENCH_H

#include "medium/adapt/dead_time_learn.h"
#include "tests/unit/vectors.h"

#define PERIOD 1e-4
#define EVERY  4u
#define LINK   311.0
#define PSI    0.183
#define TRUE   0.023 /* T_e/T, true value */
#define BAND   0.025
#define RATE   4.0

static const dead_time_learn_params_t PARAMS = {
    .rate = (float)RATE,
    .effective = (float)(0.6 * TRUE),
    .band = (float)BAND,
    .flux_linkage = (float)PSI,
    .zone = 0.05f,
    .period = (float)PERIOD,
    .every = EVERY,
};

/* A rotor and its current. */
typedef struct {
    double omega;     /* [rad/s] electrical */
    double theta;     /* [rad] */
    double current;   /* [A] */
    double longer;    /* [-] by which the current is longer and shorter, six times per turn */
    double ahead;     /* [rad] by which the current leads the d axis */
    double fifth;     /* [-] fifth harmonic of the EMF */
    double seventh;   /* [-] seventh harmonic of the EMF */
    double dwells;    /* [rad] by which the direction of the current lags and leads six times per turn */
    double noise;     /* [A] noise of a sensor, which affects the assumed signs */
    double known;     /* [A] noise of a sensor as the calibration has measured it */
    double flux;      /* [-] of psi_f: the flux that the observer's model shows */
    double faster;    /* [rad/s] by which the rotor is faster than its reference, at the maximum of a swing */
    double swing;     /* [rad/s] frequency of this swing */
    double damps;     /* [rad] by which the direction of the current swings with the rotor's speed */
    double time;      /* [s] since the begin of the swing */
    uint32_t model;   /* [-] of the observer */
    bool forced;      /* the frame is forced */
    uint32_t periods; /* [periods] since the begin of the means */
    ab_t emf;         /* [V] sum for the mean of the EMF */
    ab_t mean;        /* [A] sum for the mean of the current */
    dead_time_learn_t learn;
} world_t;

static world_t world;

/* The values that the drive reports for a period. */
typedef struct {
    float omega_e, omega_e_ref; /* [rad/s] electrical */
    ab_t emf;                   /* [V] */
    ab_t current;               /* [A] */
    float link;                 /* [V] */
} period_t;

static inline void take(const dead_time_learn_params_t *params)
{
    const dead_time_learn_tuning_t tuning = dead_time_learn_prepare(params);
    dead_time_learn_take(&world.learn, &tuning);
}

static inline void world_begin(void)
{
    memset(&world, 0, sizeof world);
    take(&PARAMS);
    world.omega = 42.0;
    world.current = 3.0;
    world.ahead = 0.5 * PI;
    world.flux = 1.0;
}

/* The parameters have the true values. */
static inline void know(void)
{
    dead_time_learn_params_t params = PARAMS;
    params.effective = (float)TRUE;
    take(&params);
}

static inline double sign_of(double complex current, double axis)
{
    return creal(current * cexp(-J * axis)) < 0.0 ? -1.0 : 1.0;
}

/* The mean of the sign of a phase. Where the current of the phase crosses zero it has noise with the mean
 * square 0.625 s^2, or twice this in the phase that is the sum of two sensors. */
static inline double mean_sign_of(double complex current, int32_t phase)
{
    const double axis = 2.0 * PI / 3.0 * phase;
    const double spread = sqrt(2.0 * 0.625 * (phase == 2 ? 2.0 : 1.0)) * world.noise;
    return erf(creal(current * cexp(-J * axis)) / spread);
}

/* The three signs as a vector (amplitude-invariant), or their mean if the sensors have noise. */
static inline double complex signs_of(double complex current, bool noisy)
{
    double complex sum = 0.0;
    for (int32_t phase = 0; phase < 3; phase++) {
        const double axis = 2.0 * PI / 3.0 * phase;
        const double sign =
            noisy && world.noise > 0.0 ? mean_sign_of(current, phase) : sign_of(current, axis);
        sum += 2.0 / 3.0 * sign * cexp(J * axis);
    }
    return sum;
}

/* The next period of the machine, with the values that the drive would report. */
static inline period_t next(void)
{
    world.theta += world.omega * PERIOD;
    world.time += PERIOD;
    const double faster = world.faster * sin(world.swing * world.time);
    const double ahead =
        world.swing > 0.0 ? -world.faster / world.swing * cos(world.swing * world.time) : 0.0;
    const double along = world.theta + world.ahead + world.damps * sin(world.swing * world.time);
    const double dwelling = world.dwells * sin(6.0 * along);
    const double length = world.current * (1.0 + world.longer * cos(6.0 * along));
    const double complex current = length * cexp(J * (along - dwelling));
    const double complex lost = TRUE * LINK * signs_of(current, false);
    const double complex assumed = (double)world.learn.effective * LINK * signs_of(current, true);
    const double sixth = 6.0 * world.theta;
    const double d = -(world.fifth + world.seventh) * sin(sixth);
    const double q = 1.0 + (world.seventh - world.fifth) * cos(sixth);
    const double complex rotor =
        world.flux * PSI * (world.omega + faster) * (d + J * q) * cexp(J * (world.theta + ahead));
    return (period_t){
        .omega_e = (float)world.omega,
        .omega_e_ref = (float)world.omega,
        .emf = to_ab(rotor + lost - assumed),
        .current = to_ab(current),
        .link = (float)LINK,
    };
}

/* A period of the drive: it adds the period to the means. The learning makes its step with the last period of
 * the means. */
static inline void step(const period_t *input)
{
    const float share = 1.0f / (float)EVERY;
    world.periods++;
    world.emf = (ab_t){world.emf.alpha + share * input->emf.alpha, world.emf.beta + share * input->emf.beta};
    world.mean = (ab_t){world.mean.alpha + share * input->current.alpha,
                        world.mean.beta + share * input->current.beta};
    if (world.periods % EVERY == 0u) {
        const dead_time_learn_input_t means = {
            .emf = world.emf,
            .current = world.mean,
            .omega_e = input->omega_e,
            .omega_e_ref = input->omega_e_ref,
            .link = input->link,
            .noise = (float)(world.known * world.known),
            .model = world.model,
            .forced = world.forced,
        };
        dead_time_learn_step(&world.learn, &means);
        world.emf = (ab_t){0.0f, 0.0f};
        world.mean = world.emf;
    }
}

static inline double off(void)
{
    return (double)world.learn.effective / TRUE - 1.0;
}

/* The relative error of the learnt value, whether it is used or not. */
static inline double unlearnt(void)
{
    return (double)world.learn.learnt / TRUE - 1.0;
}

static inline void turn(double seconds)
{
    for (int32_t n = 0; n < (int32_t)(seconds / PERIOD + 0.5); n++) {
        const period_t input = next();
        step(&input);
    }
}

#endif
