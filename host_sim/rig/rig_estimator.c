/* The estimator by itself: what it gets in a run, and the same steps once more. */
#include "host_sim/rig/rig_parts.h"

typedef struct {
    ab_t voltage; /* [V] */
    ab_t current; /* [A] */
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
    to->start = drive->estimator;
    for (uint32_t n = 0; n < RIG_ESTIMATOR_STEPS; n++) {
        rig_step(rig);
        to->inputs[n] = (estimator_input_t){drive->acted.voltage, drive->measure.measured.current};
    }
}

typedef position_t (*chosen_step_t)(chosen_t *est, ab_t voltage, ab_t current);

static position_t empty_step(chosen_t *est, ab_t voltage, ab_t current)
{
    (void)est;
    (void)voltage;
    (void)current;
    return (position_t){0.0f, 0.0f};
}

__attribute__((noinline)) float rig_estimator_replay(const void *record, bool empty)
{
    const estimator_record_t *from = record;
    const volatile chosen_step_t step = empty ? empty_step : chosen_step;
    chosen_t est = from->start;
    position_t position = {0.0f, 0.0f};
    for (uint32_t n = 0; n < RIG_ESTIMATOR_STEPS; n++) {
        position = step(&est, from->inputs[n].voltage, from->inputs[n].current);
    }
    return position.theta_e;
}

double rig_estimator_seconds(const void *record)
{
    double taken[2];
    for (int32_t empty = 0; empty < 2; empty++) {
        const double start = rig_clock_seconds();
        (void)rig_estimator_replay(record, empty != 0);
        taken[empty] = rig_clock_seconds() - start;
    }
    return (taken[0] - taken[1]) / RIG_ESTIMATOR_STEPS;
}
