/* First-order low-pass filter, exact for an input that is held over the period (zero-order hold):
 *
 *     y += alpha (x - y),   alpha = 1 - exp(-cutoff period)
 *
 * One step per sample time `period`. A sample that comes in acts at once: the step response is 1 -
 * exp(-cutoff n period) after n steps, and a ramp of slope s is followed s (1/alpha - 1) period late. Does
 * not handle non-finite input. */
#ifndef MATH_FILTER_H
#define MATH_FILTER_H

typedef struct {
    /* coefficient, from lowpass_init */
    float alpha; /* share of a new sample [-], 0..1 */
    /* state */
    float value; /* output [unit of the input] */
} lowpass_t;

/* Coefficient from `cutoff` [rad/s] and `period` [s]; output 0. cutoff * period in [0, 80]: 0 holds the
 * output for ever, more than 80 passes the input through. */
void lowpass_init(lowpass_t *filter, float cutoff, float period);

/* The coefficient alone; the output goes on from where it is. */
void lowpass_retune(lowpass_t *filter, float cutoff, float period);

/* As if the input had been `value` for ever. */
static inline void lowpass_reset(lowpass_t *filter, float value)
{
    filter->value = value;
}

/* One sample in, the filtered value out, in the unit of the input. One multiplication. */
static inline float lowpass_step(lowpass_t *filter, float input)
{
    filter->value += filter->alpha * (input - filter->value);
    return filter->value;
}

#endif
