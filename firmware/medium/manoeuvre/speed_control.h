/* Speed control: PI from mechanical speed error to torque-making current, one step per `period`.
 *
 *     i_q_ref = kp (b omega_ref - omega) + I, within +-current_limit
 *     dI/dt   = ki (omega_ref - omega)
 *
 * b, the weight of the reference in the proportional part, places the zero that a PI adds to the response to
 * a reference step: 1 is the paper's PI, which overshoots; with 0 (I-P) only the integral raises the torque,
 * and with sufficient damping there is no overshoot. The response to a disturbance of the shaft does not
 * depend on b. At the limit the integral follows the reference that would just reach the limit (math/pi.h):
 * ki T/(b kp) of the shortfall; but no faster than in 10 ms, because the limit cuts off noise on one side
 * only, and an integral that followed at once would decrease.
 *
 * The paper prints no units; k_p 0.5 A/(rad/s), k_i 2.5 A/rad, mechanical, +-10 A fit its figures
 * (docs/theory.md, 17). While the output is at its limit the integral is back-calculated (math/pi.h).
 *
 * The slow parts, the reference and I, may be computed less often and later than the rest: the task that has
 * the speed subtracts kp omega from speed_control_standing() in every period. A proportional part that is
 * late by a time t reduces the damping of a shaft that swings with omega_x by kp omega_x t of phase.
 *
 * Does not handle: sharing the limit with a d-axis current, ramps of the reference, electrical speeds
 * (divide by the pole pairs first). */
#ifndef MEDIUM_MANOEUVRE_SPEED_CONTROL_H
#define MEDIUM_MANOEUVRE_SPEED_CONTROL_H

#include "math/bounds.h"
#include "math/pi.h"

/* Shortest time in which the integral follows the part that the limit has cut off [s]. */
#define SPEED_CONTROL_BACK_TIME 10e-3f

typedef struct {
    float kp;            /* [A/(rad/s)], mechanical, >= 0 */
    float ki;            /* [A/rad], mechanical, >= 0 */
    float weight;        /* b of the reference in the proportional part [-], 0..1 */
    float current_limit; /* largest |i_q| reference [A], >= 0 */
    float period;        /* T [s] */
} speed_control_params_t;

typedef struct {
    float current_limit; /* [A] */
    float kick;          /* kp (1 - b): the part without the reference [A s/rad] */
    pi_tuning_t pi;
} speed_control_tuning_t;

typedef struct {
    float current_limit; /* of the tuning [A] */
    float kick;          /* of the tuning [A s/rad] */
    pi_t pi;             /* output and kick times reference [A], error [rad/s] mechanical */
} speed_control_t;

/* Computes the coefficients. One division. */
speed_control_tuning_t speed_control_prepare(const speed_control_params_t *params);

/* The same control, slower or stiffer: its bandwidth times `factor` [-], above 0, with the same damping. No
 * division. */
static inline speed_control_tuning_t speed_control_scaled(const speed_control_tuning_t *tuning, float factor)
{
    speed_control_tuning_t scaled = *tuning;
    scaled.kick *= factor;
    scaled.pi.kp *= factor;
    scaled.pi.ki_period *= factor * factor;
    scaled.pi.back_gain = bounds_less(factor * scaled.pi.back_gain, 1.0f);
    return scaled;
}

/* Takes these coefficients; integral 0. */
void speed_control_init(speed_control_t *control, const speed_control_tuning_t *tuning);

/* Takes over new coefficients. At this reference [rad/s] the next output for zero error is kept: the effect
 * of another k_p or weight is moved to the integral. A lower limit acts from the next step on. */
static inline void speed_control_take(speed_control_t *control, const speed_control_tuning_t *tuning,
                                      float omega_m_ref)
{
    control->pi.integral += (tuning->kick - control->kick) * omega_m_ref;
    control->current_limit = tuning->current_limit;
    control->kick = tuning->kick;
    pi_take(&control->pi, &tuning->pi);
}

/* Bumpless start: the next output for zero error at this speed reference
 * [rad/s] is `current` [A], limited. */
static inline void speed_control_reset(speed_control_t *control, float current, float omega_m_ref)
{
    pi_reset(&control->pi, current + control->kick * omega_m_ref);
}

/* i_q [A] of the next step at speed zero: the part that follows from the reference [rad/s] and the integral,
 * not limited. After subtraction of k_p times the speed it is the i_q of the next step. */
static inline float speed_control_standing(const speed_control_t *control, float omega_m_ref)
{
    return pi_output(&control->pi, omega_m_ref) - control->kick * omega_m_ref;
}

/* i_q reference [A] from `lower` to `upper` [A], both within +-current_limit, lower <= upper, from the
 * mechanical speeds [rad/s]. No division. */
static inline float speed_control_step(speed_control_t *control, float omega_m_ref, float omega_m,
                                       float lower, float upper)
{
    const float held_back = control->kick * omega_m_ref;
    return pi_step(&control->pi, omega_m_ref - omega_m, held_back + lower, held_back + upper) - held_back;
}

#endif
