/* Space-vector modulation: duties of the three legs from a voltage in the stationary frame, by min-max zero
 * sequence.
 *
 *     duty_x = middle + (v_x - (max(v) + min(v))/2) / u_dc,   middle = (duty_min + duty_max)/2
 *
 * The highest and the lowest leg lie symmetrically about the middle of the allowed range, which equals
 * space-vector modulation with equal zero vectors: linear up to (duty_max - duty_min) u_dc/sqrt(3) in every
 * direction (180 V at 311 V and 0..1), up to 2/sqrt(3) times that in the corners of the hexagon. A longer
 * vector keeps its direction and is cut at the hexagon's edge.
 *
 * No state; the duties act one period later (design: timing convention). Does not handle: overmodulation
 * beyond the hexagon, minimum pulses other than by duty_min and duty_max. */
#ifndef CONTROL_SVPWM_H
#define CONTROL_SVPWM_H

#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"

typedef struct {
    abc_t duty;   /* share of the period that each leg's upper switch is on [-] */
    ab_t voltage; /* mean voltage of exactly these duties at this u_dc, ideal inverter [V] */
    uint32_t cut; /* [-] 0: that is the one asked for; 1: it may be cut */
} svpwm_t;

/* The way of a voltage that does not fit or is none, and of an odd DC link: for svpwm_modulate(). */
svpwm_t svpwm_closely(ab_t voltage, float u_dc, float duty_min, float duty_max);

/* The DC link of the short way, 0.5 to 999.5 V [V]. */
#define SVPWM_U_DC_MIDDLE 500.0f
#define SVPWM_U_DC_HALF   499.5f

/* Share of the range that a vector on the short way may take: its rounding then stays inside. */
#define SVPWM_ROOM 0.999999f

/* Duties for `voltage` [V] at the DC link `u_dc` [V], each within [duty_min, duty_max] (0 <= duty_min <=
 * duty_max <= 1). Where nothing sensible can be made (u_dc <= 0 or below 1e-37 V, any of the three not
 * finite or beyond 1e30 V): all duties 0.5, which is no voltage, and says so. One division; two more when the
 * vector is cut. */
static inline svpwm_t svpwm_modulate(ab_t voltage, float u_dc, float duty_min, float duty_max)
{
    abc_t phases = frames_inverse_clarke(voltage);
    float highest = phases.a > phases.b ? phases.a : phases.b;
    float lowest = phases.a > phases.b ? phases.b : phases.a;
    highest = phases.c > highest ? phases.c : highest;
    lowest = phases.c < lowest ? phases.c : lowest;

    float room = SVPWM_ROOM * (duty_max - duty_min) * u_dc;
    if (!(highest - lowest <= room && bounds_within(u_dc - SVPWM_U_DC_MIDDLE, SVPWM_U_DC_HALF))) {
        return svpwm_closely(voltage, u_dc, duty_min, duty_max);
    }
    float per_volt = 1.0f / u_dc;
    float middle = 0.5f * (duty_min + duty_max) - 0.5f * (highest + lowest) * per_volt;
    svpwm_t result = {
        {middle + phases.a * per_volt, middle + phases.b * per_volt, middle + phases.c * per_volt},
        voltage,
        UINT32_C(0)};
    return result;
}

#endif
