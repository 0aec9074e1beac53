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
 * multiplications, inline because a C28x passes structs through memory. */
#ifndef MATH_FRAMES_H
#define MATH_FRAMES_H

#define FRAMES_ONE_THIRD       0.333333333f
#define FRAMES_ONE_OVER_SQRT_3 0.577350269f
#define FRAMES_HALF_OF_SQRT_3  0.866025404f

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

/* A turning frame at one instant: what current control, modulation and signals work in, wherever it comes
 * from. */
typedef struct {
    float theta_e;       /* [rad] electrical, [-pi, pi) */
    float omega_e;       /* [rad/s] electrical */
    rotation_t rotation; /* by theta_e [-] */
} frame_t;

/* Phases to the stationary frame; whatever the three have in common disappears. */
static inline ab_t frames_clarke(abc_t phases)
{
    ab_t stationary;
    /* Differences first: what is common to the three cancels without rounding. */
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

/* Stationary frame to the frame turned by `angle`. */
static inline dq_t frames_park(ab_t stationary, rotation_t angle)
{
    dq_t rotor;
    rotor.d = stationary.alpha * angle.cos + stationary.beta * angle.sin;
    rotor.q = stationary.beta * angle.cos - stationary.alpha * angle.sin;
    return rotor;
}

/* Frame turned by `angle` to the stationary frame. */
static inline ab_t frames_inverse_park(dq_t rotor, rotation_t angle)
{
    ab_t stationary;
    stationary.alpha = rotor.d * angle.cos - rotor.q * angle.sin;
    stationary.beta = rotor.d * angle.sin + rotor.q * angle.cos;
    return stationary;
}

/* By how much `to` is turned from `from`. */
static inline rotation_t frames_between(rotation_t from, rotation_t to)
{
    rotation_t turn;
    turn.sin = to.sin * from.cos - to.cos * from.sin;
    turn.cos = to.cos * from.cos + to.sin * from.sin;
    return turn;
}

#endif
