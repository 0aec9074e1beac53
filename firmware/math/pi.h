/* Proportional-integral controller with back-calculation against windup, one step per sample time `period`:
 *
 *     output    = kp e + I
 *     I(k+1)    = I(k) + ki T e + back_gain (applied - wanted)
 *
 * back_gain = ki T / kp: the error that would have given exactly the applied output is e' = e + (applied -
 * wanted)/kp (the conditioned reference), and the integral gets ki T e'. While the output is held at a limit
 * the integral approaches `limit - kp e` + kp e' with the pole 1 - back_gain. back_gain is therefore limited
 * to 1, with which the integral arrives in one step. A pure integrator (kp = 0) has no such e' and uses 1:
 * its integral never exceeds the limit. Without integral part (ki = 0) it is 0.
 *
 * Output and update are separate because the applied value is often known only later (modulation, another
 * axis). Inline, for the interrupt. Does not handle: bumpless change of kp while e is not zero. */
#ifndef MATH_PI_H
#define MATH_PI_H

/* U = unit of the output, E = unit of the error */
typedef struct {
    float kp;        /* [U/E] */
    float ki_period; /* ki T [U/E] */
    float back_gain; /* share of the shortfall that is added to the integral [-], 0..1 */
} pi_tuning_t;

typedef struct {
    pi_tuning_t tuning;
    float integral; /* I [U] */
} pi_t;

/* Coefficients from the gains `kp` >= 0 [U/E] and `ki` >= 0 [U/(E s)] and the sample time `period` > 0 [s].
 * One division. */
pi_tuning_t pi_prepare(float kp, float ki, float period);

/* Sets these coefficients; integral 0. */
void pi_init(pi_t *pi, const pi_tuning_t *tuning);

/* Sets new coefficients; the integral stays. */
static inline void pi_take(pi_t *pi, const pi_tuning_t *tuning)
{
    pi->tuning = *tuning;
}

/* Sets the integral: the next output for zero error is `integral` [U]. */
void pi_reset(pi_t *pi, float integral);

/* kp e + I [U] for this error [E], without a change of the state. One multiplication. */
static inline float pi_output(const pi_t *pi, float error)
{
    return pi->tuning.kp * error + pi->integral;
}

/* Integrates: `error` [E] of the last output, `shortfall` [U] = applied - wanted, 0 without a limit. Once per
 * period, after pi_output(). Two multiplications. */
static inline void pi_update(pi_t *pi, float error, float shortfall)
{
    pi->integral += pi->tuning.ki_period * error + pi->tuning.back_gain * shortfall;
}

/* Output and update with a limit: the output [U] within [lower, upper], lower <= upper, and the integral with
 * back-calculation. Three multiplications, two compares. */
static inline float pi_step(pi_t *pi, float error, float lower, float upper)
{
    float wanted = pi_output(pi, error);
    float applied = wanted < upper ? wanted : upper;
    applied = applied > lower ? applied : lower;
    pi_update(pi, error, applied - wanted);
    return applied;
}

#endif
