/* First-order low-pass filter, exact for an input that is held over the period (zero-order hold):
 *
 *     y += share (x - y),   share = 1 - exp(-cutoff period)
 *
 * One step per sample time `period`. An input sample acts at once: the step response is 1 - exp(-cutoff n
 * period) after n steps, and the output follows a ramp with a lag of (1/share - 1) periods. The caller stores
 * y in its state and the share in its tuning. Does not handle: non-finite input. */
#ifndef MATH_FILTER_H
#define MATH_FILTER_H

/* Share of a new sample [-], 0..1, from `cutoff` [rad/s] and `period` [s]. cutoff * period in [0, 80]: 0
 * holds the output permanently, more than 80 passes the input through. It runs in the background. */
float lowpass_share(float cutoff, float period);

/* The next output, in the unit of the input, from the last one. One multiplication. */
static inline float lowpass_step(float output, float share, float input)
{
    return output + share * (input - output);
}

#endif
