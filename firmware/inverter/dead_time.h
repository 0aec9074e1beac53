/* What the inverter loses to dead time, switching delays and device drops, as a voltage to add before
 * modulation.
 *
 *     DV(i) = gain sat(i/zone) (T_e/T_s u_dc + drop)   per leg,   T_e = dead_time + turn_on_delay -
 * turn_off_delay
 *
 * DV is the mean of commanded minus actual pole voltage, positive along the current; drop = (V_ce + V_f)/2,
 * the mean of the on-state drops of transistor and diode at zero current (their slope, some 20 mohm, belongs
 * to the winding's resistance). sat runs linearly through zero within +-zone, where the node's capacitance
 * and the ripple blur the sign. With all three signs certain the vector has the length 4/3 DV. Derivation:
 * docs/theory.md, 12; neglected there: below 0.1 V that depend on the duty.
 *
 * Add it to the voltage before svpwm_modulate(), subtract it from the applied voltage to get what the motor
 * sees. Use the current expected in the middle of the period in which the duties act: the sampled sign is
 * late by up to 1.5 periods.
 *
 * No state. Does not handle: differences between the legs, the device's own temperature. */
#ifndef INVERTER_DEAD_TIME_H
#define INVERTER_DEAD_TIME_H

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    float dead_time;      /* between the two gates of a leg [s] */
    float turn_on_delay;  /* gate command to current on [s] */
    float turn_off_delay; /* gate command to current off [s] */
    float drop;           /* (V_ce + V_f)/2 at zero current [V] */
    float current_zone;   /* half width of the linear zone [A]; 0: hard sign */
    float gain;           /* share that is compensated [-]; 0: off; 0.8 to 0.9 never over-compensates */
    float period;         /* T_s [s] */
} dead_time_params_t;

typedef struct {
    float volt_per_volt; /* gain T_e/T_s [-] */
    float drop;          /* gain drop [V] */
    float zone;          /* [A] */
    float per_zone;      /* 1/zone [1/A] */
} dead_time_tuning_t;

/* Coefficients, which is all there is: no state. Two divisions. */
dead_time_tuning_t dead_time_prepare(const dead_time_params_t *params);

/* What a leg whose sign is certain loses [V] at the DC link `u_dc` [V]. */
static inline float dead_time_leg(const dead_time_tuning_t *dead_time, float u_dc)
{
    return dead_time->volt_per_volt * u_dc + dead_time->drop;
}

/* Mean voltage lost [V], stationary frame, for the `current` [A] and the DC link `u_dc` [V]. The currents are
 * cut to the zone and transformed; what comes out is stretched to volts. No division, six compares. */
static inline ab_t dead_time_voltage(const dead_time_tuning_t *dead_time, ab_t current, float u_dc)
{
    abc_t phases = frames_inverse_clarke(current);
    phases.a = bounds_clamp(phases.a, dead_time->zone);
    phases.b = bounds_clamp(phases.b, dead_time->zone);
    phases.c = bounds_clamp(phases.c, dead_time->zone);
    ab_t cut = frames_clarke(phases);
    float volt_per_ampere = dead_time_leg(dead_time, u_dc) * dead_time->per_zone;
    return (ab_t){volt_per_ampere * cut.alpha, volt_per_ampere * cut.beta};
}

#endif
