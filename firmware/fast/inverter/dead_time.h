/* Voltage that the inverter loses by dead time, switching delays and device drops.
 *
 *     DV = (sat(i'/zone) + sat(i"/zone))/2 (T_e/T_s u_dc + drop)   per leg,
 *     T_e = dead_time + turn_on_delay - turn_off_delay
 *
 * DV is the mean of commanded minus actual pole voltage, positive in the direction of the current; i', i" are
 * the currents of the leg at its two edges (fast/inverter/edges.h), drop = (V_ce + V_f)/2 is the mean of the
 * on-state drops of transistor and diode at zero current (their slope, some 20 mohm, is part of the winding's
 * resistance). sat is linear within +-zone, where the capacitance of the node makes the sign uncertain. With
 * all three signs certain the vector has the length 4/3 DV. Derivation: docs/theory.md, 12, which neglects
 * terms below 0.1 V that depend on the duty.
 *
 * No state. Does not handle: differences between the legs, the temperature of the devices. */
#ifndef FAST_INVERTER_DEAD_TIME_H
#define FAST_INVERTER_DEAD_TIME_H

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    float dead_time;      /* between the two gates of a leg [s] */
    float turn_on_delay;  /* gate command to current on [s] */
    float turn_off_delay; /* gate command to current off [s] */
    float drop;           /* (V_ce + V_f)/2 at zero current [V] */
    float current_zone;   /* half width of the linear zone [A]; 0: step at zero */
    float period;         /* T_s [s] */
} dead_time_params_t;

typedef struct {
    float volt_per_volt; /* T_e/T_s [-] */
    float drop;          /* [V] */
    float per_zone;      /* 1/zone [1/A] */
} dead_time_tuning_t;

/* Computes the coefficients; the model has no state. Two divisions. */
dead_time_tuning_t dead_time_prepare(const dead_time_params_t *params);

/* Voltage [V] that a leg whose sign is certain loses, with the dead time `effective`, T_e/T [-], at the DC
 * link `u_dc` [V]. */
static inline float dead_time_leg(const dead_time_tuning_t *dead_time, float effective, float u_dc)
{
    return effective * u_dc + dead_time->drop;
}

/* Twice x, limited to +-2. */
static inline float dead_time_passage(float x)
{
    return bounds_magnitude(x + 1.0f) - bounds_magnitude(x - 1.0f);
}

/* Twice the signs of the currents of the three legs [-2 to 2], linear within the zone. */
static inline abc_t dead_time_signs(const dead_time_tuning_t *dead_time, ab_t current)
{
    const float per_zone = dead_time->per_zone;
    const abc_t over = frames_inverse_clarke((ab_t){per_zone * current.alpha, per_zone * current.beta});
    return (abc_t){dead_time_passage(over.a), dead_time_passage(over.b), dead_time_passage(over.c)};
}

/* Mean lost voltage [V] in the stationary frame for these signs, if a leg whose sign is certain loses `leg`
 * [V].
 */
static inline ab_t dead_time_voltage(abc_t signs, float leg)
{
    const ab_t vector = frames_clarke(signs);
    return (ab_t){leg * vector.alpha, leg * vector.beta};
}

#endif
