/* The model of the power stage in both directions: duties from a required voltage, and the applied voltage
 * from duties. The same model holds for both: dead time, drops and the resolution of the compare registers.
 *
 *     required u, current then --> inverter_make: u + loss --> svpwm --> whole counts: duties of k
 *     duties of k-2, current, u_dc --> inverter_acted: the voltage on the winding in [t_k-1, t_k)
 *
 * Timing: the duties of step k act in [t_k+1, t_k+2); inverter_acted() of step k therefore uses those of step
 * k-2, with the mean of the currents and of the DC link at t_k-1 and t_k. Does not handle: differences
 * between the legs. */
#ifndef FAST_INVERTER_INVERTER_H
#define FAST_INVERTER_INVERTER_H

#include <stdbool.h>
#include <stdint.h>

#include "fast/inverter/dead_time.h"
#include "fast/inverter/edges.h"
#include "fast/inverter/svpwm.h"
#include "math/frames.h"

typedef struct {
    dead_time_params_t dead_time;
    float compensated;        /* share of the loss that the duties compensate [-]; 0: none */
    float inductance;         /* of the winding [H], > 0 */
    bool sampled_upper;       /* the currents are sampled while the upper switches are on */
    float duty_min, duty_max; /* [-] smallest and largest duty of a leg */
    float duty_counts;        /* [-] steps of a duty from 0 to 1 */
    bool over_modulation;     /* up to six-step */
} inverter_params_t;

typedef struct {
    dead_time_tuning_t lost; /* full loss of the inverter, independent of the compensated share */
    edges_tuning_t edges;
    svpwm_tuning_t modulation;
    float half_gain;   /* half of the share that is compensated [-] */
    float duty_counts; /* [-] */
    float per_count;   /* 1/duty_counts [-] */
} inverter_tuning_t;

typedef struct {
    edges_t signs;      /* of the loss in the last period */
    abc_t duty_prev[2]; /* duties of one and two steps ago [-] */
    ab_t current_prev;  /* one period ago [A] */
    float u_dc_prev;    /* one period ago [V] */
} inverter_t;

typedef struct {
    abc_t duty;   /* [-] in whole counts */
    ab_t missing; /* applied minus required voltage, where the DC link is too low [V] */
    bool cut;     /* a part of the voltage is missing */
} inverter_made_t;

typedef struct {
    ab_t voltage; /* on the winding in [t_k-1, t_k) [V] */
    ab_t current; /* mean in the same time [A] */
    float link;   /* mean of the DC link in the same time [V] */
    float leg;    /* loss of a leg whose sign is certain [V] */
} inverter_acted_t;

/* Computes the coefficients. Five divisions. */
inverter_tuning_t inverter_prepare(const inverter_params_t *params);

/* No voltage has acted yet. */
void inverter_init(inverter_t *inverter);

/* The nearest duty that the compare registers can hold, so that the observer uses the voltage that acts. */
static inline float inverter_whole_counts(const inverter_tuning_t *tuning, float duty)
{
    return (float)(int32_t)(duty * tuning->duty_counts + 0.5f) * tuning->per_count;
}

/* Duties for the required voltage `wanted` [V] on the winding at the DC link `u_dc` [V]. A leg whose
 * sign is certain loses `leg` [V]. `current` [A] is the one expected in the middle of the period in which the
 * duties act, because its sign determines the loss of each leg. The current reference is the best estimate: a
 * sampled current has the wrong sign near its zero crossings. Both edges of a leg are assumed to occur at
 * this current; inverter_acted() accounts for the difference. One division, two at the voltage limit. */
static inline inverter_made_t inverter_make(const inverter_tuning_t *tuning, ab_t wanted, ab_t current,
                                            float leg, float u_dc)
{
    const abc_t signs = dead_time_signs(&tuning->lost, current);
    const ab_t lost = dead_time_voltage(signs, tuning->half_gain * leg);
    const ab_t asked = {wanted.alpha + lost.alpha, wanted.beta + lost.beta};
    const svpwm_t modulated = svpwm_modulate(&tuning->modulation, asked, u_dc);
    return (inverter_made_t){
        {inverter_whole_counts(tuning, modulated.duty.a), inverter_whole_counts(tuning, modulated.duty.b),
         inverter_whole_counts(tuning, modulated.duty.c)},
        {modulated.voltage.alpha - asked.alpha, modulated.voltage.beta - asked.beta},
        modulated.cut,
    };
}

/* The voltage that acted in the last period, from the current [A] and the DC link [V] at t_k and the speed
 * [rad/s] at which the voltage turns. `effective`: learnt T_e/T_s [-], `per_zone`: one over the zone at the
 * edges [1/A] (medium/adapt/leg_zone.h). No division. */
static inline inverter_acted_t inverter_acted(inverter_t *inverter, const inverter_tuning_t *tuning,
                                              float effective, float per_zone, ab_t current, float omega_e,
                                              float u_dc)
{
    const ab_t last = inverter->current_prev;
    const float link = 0.5f * (u_dc + inverter->u_dc_prev);
    const ab_t middle = {0.5f * (current.alpha + last.alpha), 0.5f * (current.beta + last.beta)};
    const ab_t change = {current.alpha - last.alpha, current.beta - last.beta};
    const abc_t duty = inverter->duty_prev[1];
    inverter->signs = edges_signs(&tuning->edges, &inverter->signs, per_zone, duty, middle, change, effective,
                                  omega_e, link);
    const float leg = dead_time_leg(&tuning->lost, effective, link);
    const edges_t *signs = &inverter->signs;
    const float part = 0.125f * tuning->edges.way * leg; /* of 4 times the signs at two edges */
    const abc_t poles = {link * duty.a - part * (signs->first.a + signs->second.a),
                         link * duty.b - part * (signs->first.b + signs->second.b),
                         link * duty.c - part * (signs->first.c + signs->second.c)};
    return (inverter_acted_t){frames_clarke(poles), middle, link, leg};
}

/* The end of a period: stores its duties, its current [A] and its DC link [V] for the next periods. */
static inline void inverter_remember(inverter_t *inverter, const abc_t *duty, ab_t current, float u_dc)
{
    inverter->duty_prev[1] = inverter->duty_prev[0];
    inverter->duty_prev[0] = *duty;
    inverter->current_prev = current;
    inverter->u_dc_prev = u_dc;
}

#endif
