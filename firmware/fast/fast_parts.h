/* Declarations that only the source files of fast.h use. */
#ifndef FAST_FAST_PARTS_H
#define FAST_FAST_PARTS_H

#include "fast/fast.h"

/* Updates the rotor's position and speed from the present source. The speed of a smooth setpoint is the
 * estimate without the proportional part of the loop, because the speed control would amplify the noise of
 * that part. */
static inline void fast_update_rotor(fast_t *fast, fast_orders_t orders)
{
    const estimate_t *estimate = &fast->estimator.estimate;
    float omega_e;
    if (reference_tracks(&fast->reference)) {
        fast->rotor = estimate->frame;
        omega_e = orders.setpoint->smooth != 0u ? estimate->omega_smooth : estimate->frame.omega_e;
    } else {
        fast->rotor = reference_rotor(&fast->reference, &fast->shaft.frame);
        omega_e = fast->rotor.omega_e;
    }
    fast->omega_m = omega_e * orders.tuning->limits.pole_pairs_inverse;
}

/* Begins the sums of a window. */
void fast_begin_sums(window_sums_t *sum);

/* A period with the bridge off. */
void fast_rest(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples);

/* Opens the bridge; `window` [windows] is the number of the window that contains the reason. */
void fast_open_bridge(fast_t *fast, uint32_t window);

/* The duties of an excitation, in place of current control. */
abc_t fast_excite(fast_t *fast, fast_orders_t orders);

#endif
