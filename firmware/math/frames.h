/* Reference frames: three phases, stationary frame, rotor frame, with the amplitude-invariant transforms of
 * Clarke and Park.
 *
 *     alpha = (2a - b - c)/3      d =  alpha cos(theta) + beta sin(theta)
 *     beta  = (b - c)/sqrt(3)     q = -alpha sin(theta) + beta cos(theta)
 *
 * so that a = A cos(theta), b and c lagging by 120 and 240 degrees, becomes (alpha, beta) = A (cos(theta),
 * sin(theta)) and (d, q) = (A, 0). The d axis is along the flux of the magnet; a positive angle rotates a to
 * b to c.
 *
 * Values only: no state, no sample time, any unit. Power is 3/2 (d d' + q q'). The zero sequence (a + b +
 * c)/3 is removed by the transform and is 0 after the inverse. All functions are a few multiplications
 * without branches, inline because a C28x passes structs through memory. */
#ifndef MATH_FRAMES_H
#define MATH_FRAMES_H

#define FRAMES_ONE_THIRD       0.333333333f
#define FRAMES_ONE_OVER_SQRT_3 0.577350269f
#define FRAMES_SQRT_3          1.7320508f
#define FRAMES_HALF_OF_SQRT_3  0.866025404f

/* Phase quantities, in the unit of the quantity. */
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

/* A rotating frame at one time: the frame of current control, modulation and signals, from any source. */
typedef struct {
    float theta_e;       /* [rad] electrical, [-pi, pi) */
    float omega_e;       /* [rad/s] electrical */
    rotation_t rotation; /* rotation by theta_e [-] */
} frame_t;

/* Phases to the stationary frame; the common part of the three is removed. */
static inline ab_t frames_clarke(abc_t phases)
{
    ab_t stationary;
    /* Differences first: the common part of the three cancels without rounding. */
    stationary.alpha = ((phases.a - phases.b) + (phases.a - phases.c)) * FRAMES_ONE_THIRD;
    stationary.beta = (phases.b - phases.c) * FRAMES_ONE_OVER_SQRT_3;
    return stationary;
}

/* Stationary frame to phases whose sum is zero. */
static inline abc_t frames_inverse_clarke(ab_t stationary)
{
    float along = -0.5f * stationary.alpha;
    float across = FRAMES_HALF_OF_SQRT_3 * stationary.beta;
    abc_t phases;
    phases.a = stationary.alpha;
    phases.b = along + across;
    phases.c = along - across;
    return phases;
}

/* Stationary frame to the frame rotated by `angle`. */
static inline dq_t frames_park(ab_t stationary, rotation_t angle)
{
    dq_t rotor;
    rotor.d = stationary.alpha * angle.cos + stationary.beta * angle.sin;
    rotor.q = stationary.beta * angle.cos - stationary.alpha * angle.sin;
    return rotor;
}

/* Frame rotated by `angle` to the stationary frame. */
static inline ab_t frames_inverse_park(dq_t rotor, rotation_t angle)
{
    ab_t stationary;
    stationary.alpha = rotor.d * angle.cos - rotor.q * angle.sin;
    stationary.beta = rotor.d * angle.sin + rotor.q * angle.cos;
    return stationary;
}

/* Rotation of `to` relative to `from`. */
static inline rotation_t frames_between(rotation_t from, rotation_t to)
{
    rotation_t turn;
    turn.sin = to.sin * from.cos - to.cos * from.sin;
    turn.cos = to.cos * from.cos + to.sin * from.sin;
    return turn;
}

#endif
