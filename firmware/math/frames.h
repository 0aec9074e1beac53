/* Reference frames: three phases, stationary frame, rotor frame; Clarke and Park transforms, amplitude
 * invariant.
 *
 *     alpha = (2a - b - c)/3      d =  alpha cos(theta) + beta sin(theta)
 *     beta  = (b - c)/sqrt(3)     q = -alpha sin(theta) + beta cos(theta)
 *
 * so that a = A cos(theta), b and c 120 and 240 degrees behind, becomes (alpha, beta) = A (cos(theta),
 * sin(theta)) and (d, q) = (A, 0). The d axis lies along the magnet's flux; a positive angle turns a to b to
 * c.
 *
 * Values only: no state, no sample time, any unit. Power is 3/2 (d d' + q q'). The zero sequence (a + b +
 * c)/3 is dropped on the way in and is 0 on the way out. All functions are straight lines of a few
 * multiplications. */
#ifndef MATH_FRAMES_H
#define MATH_FRAMES_H

/* Phase quantities, in the unit of what they hold. */
typedef struct {
    float a, b, c;
} abc_t;

/* Stationary frame, alpha along phase a. */
typedef struct {
    float alpha, beta;
} ab_t;

/* Rotor frame. */
typedef struct {
    float d, q;
} dq_t;

/* An angle as its sine and cosine [-]; made by trig_rotation(). */
typedef struct {
    float sin, cos;
} rotation_t;

/* Phases to the stationary frame; whatever the three have in common disappears. */
ab_t frames_clarke(abc_t phases);

/* The same from two sensors: c = -a - b, exact for a floating star point. */
ab_t frames_clarke_two(float a, float b);

/* Stationary frame to phases whose sum is zero. */
abc_t frames_inverse_clarke(ab_t stationary);

/* Stationary frame to the frame turned by `angle`. */
dq_t frames_park(ab_t stationary, rotation_t angle);

/* Frame turned by `angle` to the stationary frame. */
ab_t frames_inverse_park(dq_t rotor, rotation_t angle);

#endif
