/* The estimator alone: records its inputs in a run, repeats the same steps, and disturbs its angle. */
#include <math.h>

#include "host_sim/rig/rig_parts.h"

#ifdef LAGLESS_ESTIMATOR_FIXED

#include "math/trig_q.h"

void rig_turn_estimate(chosen_t *est, float jump)
{
    const double turn = 6.283185307179586;
    const uint32_t counts = (uint32_t)(int64_t)((double)jump * (4294967296.0 / turn));
    pll_q_t *pll = &est->q.pll;
    pll->theta_e += counts;
    pll->rotation = trig_rotation_q(pll->theta_e);
    pll->emf = frames_park_q((ab_q_t){pll->emf.d, pll->emf.q}, trig_rotation_q(counts));
}

#else

#include "math/trig.h"

void rig_turn_estimate(chosen_t *est, float jump)
{
    pll_t *pll = &est->tracker.pll;
    pll->theta_e = angle_wrap(pll->theta_e + jump);
    pll->rotation = trig_turn(pll->theta_e);
    pll->emf = frames_park((ab_t){pll->emf.d, pll->emf.q}, trig_turn(angle_wrap(jump)));
}

#endif

typedef struct {
    ab_t voltage;                             /* [V] */
    ab_t current;                             /* [A] */
    float load, flux_linkage, speed_per_volt; /* [A], [Wb], [rad/s/V] with which it is stepped */
} estimator_input_t;

typedef struct {
    chosen_t start;
    estimator_input_t inputs[RIG_ESTIMATOR_STEPS];
} estimator_record_t;

size_t rig_estimator_size(void)
{
    return sizeof(estimator_record_t);
}

void rig_estimator_record(rig_t *rig, void *record)
{
    estimator_record_t *to = record;
    const drive_t *drive = &rig->state.app.drive;
    rig_run(rig, 2u * DRIVE_WINDOW + 1u); /* takes an offered tuning if there is one */
    to->start = drive->fast.estimator;
    for (uint32_t n = 0; n < RIG_ESTIMATOR_STEPS; n++) {
        const setpoint_t *setpoint =
            &drive->setpoints[drive->acting]; /* the last period of a window ends with another one */
        estimator_input_t *input = &to->inputs[n];
        *input = (estimator_input_t){.flux_linkage = setpoint->models.flux_linkage,
                                     .speed_per_volt = setpoint->models.speed_per_volt};
        rig_step(rig);
        input->voltage = drive->fast.acted.voltage;
        input->current = drive->fast.measure.measured.current;
        input->load = drive->fast.load_current;
    }
}

typedef position_t (*step_t)(chosen_t *est, const estimator_input_t *input);

/* A step, with the values of motor and load that the drive passes to it. */
static position_t estimator_alone(chosen_t *est, const estimator_input_t *input)
{
    chosen_set_load(est, input->load);
    chosen_set_flux(est, input->flux_linkage, input->speed_per_volt);
    return chosen_step(est, input->voltage, input->current);
}

static position_t empty_step(chosen_t *est, const estimator_input_t *input)
{
    (void)est;
    (void)input;
    return (position_t){0.0f, 0.0f};
}

__attribute__((noinline)) float rig_estimator_replay(const void *record, bool empty)
{
    const estimator_record_t *from = record;
    const volatile step_t step = empty ? empty_step : estimator_alone;
    chosen_t est = from->start;
    position_t position = {0.0f, 0.0f};
    for (uint32_t n = 0; n < RIG_ESTIMATOR_STEPS; n++) {
        position = step(&est, &from->inputs[n]);
    }
    return position.theta_e;
}

/* The smallest of several times: the others contain the time of other processes. */
static double replay_seconds(const void *record, bool empty)
{
    double least = HUGE_VAL;
    for (uint32_t n = 0; n < 5u; n++) {
        const double start = rig_clock_seconds();
        (void)rig_estimator_replay(record, empty);
        least = fmin(least, rig_clock_seconds() - start);
    }
    return least;
}

double rig_estimator_seconds(const void *record)
{
    return (replay_seconds(record, false) - replay_seconds(record, true)) / RIG_ESTIMATOR_STEPS;
}
