/* Reactions that do not wait for a setpoint: the rows of the fault table with the rate EACH, a step of the
 * encoder's angle, a current sensor whose value does not change. The tests of each period are inline. */
#ifndef FAST_FAST_TRIPS_H
#define FAST_FAST_TRIPS_H

#include <stddef.h>

#include "fast/fast_parts.h"
#include "guard/guard_quantities.h"

/* The reaction to an angle of the encoder that has moved faster than any rotor can, while control uses the
 * encoder. Either the row of the fault table opens the bridge, and the result is its ENCODER_WATCH_... bits,
 * or control leaves the encoder in this period. */
uint32_t fast_watch_jump(fast_t *fast, fast_orders_t orders);

/* Judges the rows of the fault table that have the rate EACH. It is called in the periods in which one of
 * them holds or has held. */
void fast_judge_trips(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples,
                      uint32_t encoder_wrong);

/* Judges a current sensor whose value does not change while control requires another current. The medium task
 * would detect it too late. */
void fast_judge_still(fast_t *fast, fast_orders_t orders);

/* Finds whether a sample shows that the gates are on and the charging has ended. */
static inline void fast_find_gates_on(fast_bridge_t *bridge, uint32_t flags)
{
    if (bridge->runs == 0u && bridge->on >= FAST_ON && bridge->charging == 0u &&
        (flags & DRIVE_SAMPLE_TRIPPED) == 0u) {
        bridge->runs = 1u;
    }
}

/* The GUARD_... bits that decide which fast rows count. The rows for a bridge that is on count from the first
 * sample that shows the gates on, independent of the medium task. The sequence detects gates that never come
 * on. */
static inline uint32_t fast_moments(const fast_bridge_t *bridge, const setpoint_t *setpoint)
{
    return bridge->runs == 0u || bridge->open != 0u ? GUARD_ALWAYS : setpoint->moments;
}

static inline guard_input_t fast_trip_input(const fast_t *fast, const setpoint_t *setpoint,
                                            uint32_t encoder_wrong)
{
    return (guard_input_t){
        .measured = &fast->measure.measured,
        .omega_m = fast->omega_m,
        .encoder_wrong = encoder_wrong,
        .medium_late = fast->given.overdue,
        .now = fast_moments(&fast->bridge, setpoint),
        .found = NULL,
    };
}

/* Evaluates the rows of the fault table of each period. true: control has left the encoder. */
static inline bool fast_trip(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples)
{
    const fast_tuning_t *tuning = orders.tuning;
    uint32_t encoder_wrong = 0u;
    bool left = false;
    if (fast->reference.source == (int32_t)SOURCE_ENCODER) {
        encoder_wrong = fast_watch_jump(fast, orders);
        left = fast->reference.source != (int32_t)SOURCE_ENCODER;
    }
    fast_find_gates_on(&fast->bridge, fast->measure.measured.flags);
    const guard_input_t input = fast_trip_input(fast, orders.setpoint, encoder_wrong);
    if (!guard_is_calm(&fast->trips, &tuning->guard, &input, FAULT_EACH)) {
        fast_judge_trips(
            fast, orders, samples,
            encoder_wrong); /* the input is built again, because a variable would be stored in each period */
    }
    if (still_watch_count(&fast->still_watch, &tuning->still_watch, samples->i_a, samples->i_b,
                          samples->i_c) &&
        (fast_moments(&fast->bridge, orders.setpoint) & GUARD_RUNNING) != 0u) {
        fast_judge_still(fast, orders);
    }
    still_watch_remember(&fast->still_watch, &fast->acted.voltage);
    return left;
}

#endif
