/* Encoder watch: compares the encoder's angle with the back-EMF. The mean EMF of a window, from voltages
 * and currents alone (winding.h),
 *
 *     <e> = (sum(u) - R n (i_0 + i_n)/2)/n - L_q (i_n - i_0)/T_j + (s_n - s_0)/T_j,    T_j = n T
 *
 * with s = ((L_q - L_d) i_d - j (L_q(i_q) - L_q) i_q) e^(j theta) at the encoder's angle theta for a salient
 * rotor whose q axis saturates, is transformed to the frame of the encoder's angle in its middle. If the
 * encoder is right, it lies on the q axis with the length psi_f omega:
 *
 *     e = (0, psi_f omega)          healthy, in both directions
 *     e off the q axis by delta     an angle that is wrong by delta: offset, a coupling that has slipped
 *     e turns at omega_emf - omega  wrong lines or pole pairs, lost lines, an encoder that does not turn
 *     omega_emf against omega       swapped phases or tracks: the encoder counts the other way round
 *     e = 0 at a speed              an encoder that turns without the rotor
 *
 * If the rotor turns by more than 3.5 rad in a window, the mean says little about its direction: e is then
 * the EMF of the observer at the end of the window. At such a speed noise is small beside it.
 *
 * The judgement is made at the end of each window. e is the value of the window if it is above the noise.
 * Otherwise e is the mean of the last two windows, in which only the noise of the two ends remains. If this
 * noise exceeds psi_f omega_least, e is a low-pass of the windows with the share 1/4.
 *
 *     mismatch    e_q sign(omega) < 0.8 |e|    while |e| > psi_f omega_least    37 degrees, or it turns
 *                 |e| < psi_f |omega|/4        while |omega| > omega_least
 *                 |e| > 3 psi_f |omega|        while |e| > psi_f omega_least    the rotor turns faster
 *                 and |e - psi_f omega| > psi_f omega_least   a smaller difference may be a voltage error
 *     direction   the same, and LP(omega + (e_last x e)/(|e_last||e| T_j)), the EMF's speed, is against omega
 *                 with at least half of its amount
 *
 * A sign must last for at least three judgements, and until the integral of the wrong or missing EMF reaches
 * psi_f omega_least ENCODER_WATCH_TIME. A larger EMF reaches this sooner, because voltage errors have less
 * effect on it. A judgement whose EMF is only too long counts half, because the EMF of exchanged current
 * sensors grows along the q axis until the current trips; the sign of a speed near zero has no meaning then.
 * A judgement without the sign halves the integral. The EMF is doubtful while a wire or a
 * current sensor may be wrong. The judgement is then postponed until one without the sign, by
 * ENCODER_WATCH_WAIT in total, and the integral keeps its value.
 *
 * The difference to psi_f omega is also doubtful while it lies along the axis of one phase and stays there,
 * like that of an open wire or switch: the voltage of that phase does not reach the winding, and no current
 * flows in this phase. An encoder that counts the other way round makes such a difference with any current.
 * An unknown EMF of the rotor leaves the axis when the rotor turns. In a single window the noise of the
 * currents may turn the difference by more than the angle between two axes. This noise has opposite signs in
 * consecutive windows. Therefore, with small currents, the mean difference of the windows with the sign is
 * used. If it stays on the axis for ENCODER_WATCH_WAIT, the wire or the switch is reported. If the motor's
 * currents are small for the range of the sensors, the currents do not show this fault.
 *
 *     wire        the same sign, all the time along the axis of one phase
 *
 * Below omega_least the EMF is not judged, because the errors by dead time and R i are larger, and with a
 * large inductance also the noise of the current: the limit is then three standard deviations of the
 * low-pass, 0.8 L n_i/T_j, if these are more than psi_f omega_least (docs/theory.md, 28). In each period the
 * angle is compared with the angle expected from the speed. A difference of more than 0.5 rad plus two counts
 * is reported in the same period, unless the EMF shows that the rotor brakes. While nearly no current flows,
 * offsets of the sensors may reverse the sign of the compensated dead-time voltage; the least EMF that is
 * judged is then twice as large. A sign below it does not count, but neither is it a judgement without the
 * sign: integral and postponed judgements keep their values.
 *
 * encoder_watch_add() every T, encoder_watch_step() every n-th, where encoder_watch_rest() is called too.
 * Does not handle: an encoder whose angle is wrong by less than 37 degrees; a wrong direction above 1/T_j,
 * 1250 rad/s with 8 periods of 0.1 ms, which is reported as a mismatch. */
#ifndef MEDIUM_PROTECT_ENCODER_WATCH_H
#define MEDIUM_PROTECT_ENCODER_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "math/winding.h"

#define ENCODER_WATCH_AXIS   0.8f  /* [-] cosine of the largest angle between EMF and q axis */
#define ENCODER_WATCH_GONE   0.25f /* [-] of psi_f |omega|: a smaller EMF counts as missing */
#define ENCODER_WATCH_LONGER 3.0f  /* [-] of psi_f |omega|: a longer EMF is that of a faster rotor */
#define ENCODER_WATCH_SPEED  0.6f  /* [-] of psi_f |omega|: least EMF of a rotor at that speed ... */
#define ENCODER_WATCH_TURNS  0.7f  /* [-] of |omega|: ... whose EMF turns more slowly, behind the low-pass */
#define ENCODER_WATCH_SIXTH  0.16666667f /* [-] of x^2 in the series of sin(x)/x */
#define ENCODER_WATCH_ALONE  5.0f        /* [-] of psi_f omega_least: EMF of a window above the noise */
#define ENCODER_WATCH_SIGNS  2.0f   /* [-] of psi_f omega_least, if the signs of the currents are uncertain */
#define ENCODER_WATCH_LEAP   0.5f   /* [rad] electrical: largest change per period beyond the speed */
#define ENCODER_WATCH_CUTOFF 500.0f /* [rad/s] of the low-pass */
#define ENCODER_WATCH_TIME   8e-3f  /* [s] for which a sign must last at psi_f omega_least */
#define ENCODER_WATCH_LEAST  3u     /* judgements, at any EMF [-] */
#define ENCODER_WATCH_SETTLE 6e-3f  /* [s] after a rest: wrong current sensors are reported first */
#define ENCODER_WATCH_WAIT   0.5f   /* [s] within which a wrong wire or sensor is reported itself */

/* The conditions: bits. */
#define ENCODER_WATCH_MISMATCH  UINT32_C(1)
#define ENCODER_WATCH_DIRECTION UINT32_C(2)
#define ENCODER_WATCH_JUMP      UINT32_C(4) /* from the fast task, by encoder_jumped() */
#define ENCODER_WATCH_WIRE      UINT32_C(8) /* the voltage of one phase does not reach the winding */

typedef struct {
    float resistance;   /* R [ohm] */
    float inductance;   /* L_q [H], > 0 */
    float saliency;     /* L_q - L_d [H] */
    float flux_linkage; /* psi_f [Wb], > 0 */
    float speed_least;  /* omega_least [rad/s] electrical, > 0 */
    float noise;        /* of a measured current, standard deviation [A], >= 0 */
    float doubtful;     /* length of a current whose phases may have any sign [A], >= 0 */
    float unseen;       /* below this length the currents do not show a broken wire [A], >= 0 */
    float step;         /* a count of the encoder [rad] electrical */
    float period;       /* T [s] */
    uint32_t every;     /* n, periods of a window [-] */
} encoder_watch_params_t;

typedef struct {
    float flux_linkage; /* psi_f [Wb] */
    float emf_least;    /* psi_f omega_least, or the noise limit [V] */
    float before;       /* share of the windows before this one in the EMF that is judged [-] */
    float doubtful;     /* square of the length of a current whose phases may have any sign [A^2] */
    float alone;        /* square of the EMF from which a single window is judged [V^2] */
    float noise;        /* square of three standard deviations of the EMF of a single window [V^2] */
    float unseen;       /* square of the same length [A^2] */
    float turn_noise; /* square of three standard deviations of the EMF's speed times its length [V^2/s^2] */
    float beside;     /* square of the part of a mean difference beside the axis of its phase [V^2] */
    float leap;       /* [rad] electrical; more than half a turn: not judged */
    float share;      /* of the low-pass [-] */
    winding_t winding;
    float periods;    /* n [-] */
    float volts;      /* L_q/T_j [V/A] */
    float salient;    /* (L_q - L_d)/T_j [V/A] */
    float middle;     /* -T_j/2 [s] */
    float rate;       /* 1/T_j [1/s] */
    float holds;      /* sum of EMFs, one per judgement, for which a sign must last [V] */
    uint32_t settles; /* windows after a rest without a judgement [-] */
    uint32_t waits;   /* judgements by which a doubtful EMF may postpone a result [-] */
} encoder_watch_tuning_t;

typedef struct {
    encoder_watch_tuning_t tuning;
    ab_t voltage;        /* sum in this window [V] */
    ab_t current;        /* at the beginning [A] */
    ab_t apart;          /* flux of saliency and saturation at the beginning, over T_j [V] */
    dq_t last;           /* <e> of the last window [V] */
    dq_t judged;         /* e of the last judgement [V] */
    float speed;         /* speed of the encoder, low-passed like e [rad/s] */
    float omega_emf;     /* LP of the EMF's speed, positive in the direction of the encoder [rad/s] */
    float held;          /* sum of EMFs of the present sign [V] */
    uint32_t count;      /* judgements with the sign, in halves [-] */
    uint32_t windows;    /* since a rest [-], up to the number that a judgement needs */
    uint32_t waited;     /* postponed judgements [-]; each one without the sign halves them */
    ab_t off;            /* EMF less the rotor's, mean of the wrong windows in succession [V] */
    ab_t line;           /* mean over some wrong windows of its square, at twice its angle [V^2] */
    float square;        /* mean of its square [V^2] */
    ab_t axis;           /* the same when it first lay along the axis of a phase [V] */
    uint32_t wrong;      /* largest number of windows in this mean [-] */
    uint32_t along;      /* number of windows on one axis minus number of windows beside it [-] */
    uint32_t of_a_phase; /* 1: the EMF of the last window is wrong along the axis of one phase [-] */
    uint32_t elsewhere;  /* 1: the error of the EMF is large, and not along a phase axis [-] */
    uint32_t known;      /* 1: `last` is of a window in which the rotor was driven */
    uint32_t confirmed;  /* 1: it is above the noise and agrees with the encoder [-] */
} encoder_watch_t;

/* The inputs, all of t_k. */
typedef struct {
    ab_t current;       /* [A] */
    rotation_t encoder; /* the frame of the encoder's angle */
    float omega_e;      /* its speed, electrical [rad/s] */
    ab_t emf;           /* of the observer, with the lag compensated [V] */
    ab_t lacks;         /* requested minus measured current [A] */
    float excess;       /* L_q at the present i_q less that of the tuning [H]; 0 without saturation */
    bool doubtful;      /* true: the EMF is doubtful */
} encoder_watch_input_t;

/* Computes the coefficients. Divisions and an exponential: for the background. */
encoder_watch_tuning_t encoder_watch_prepare(const encoder_watch_params_t *params);

/* Takes these coefficients; nothing has been measured yet. */
void encoder_watch_init(encoder_watch_t *watch, const encoder_watch_tuning_t *tuning);

/* Takes over new coefficients; the state is kept. */
static inline void encoder_watch_take(encoder_watch_t *watch, const encoder_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* Ends a window that is not judged and resets the state; the next window begins here. */
static inline void encoder_watch_rest(encoder_watch_t *watch)
{
    watch->windows = 0u;
    watch->held = 0.0f;
    watch->count = 0u;
    watch->waited = 0u;
    watch->wrong = 0u;
    watch->along = 0u;
    watch->line = (ab_t){0.0f, 0.0f};
    watch->square = 0.0f;
    watch->of_a_phase = 0u;
    watch->elsewhere = 0u;
    watch->confirmed = 0u;
}

/* Ends a window that is not judged; the next window begins with this current [A]. */
static inline void encoder_watch_begin(encoder_watch_t *watch, ab_t current)
{
    watch->voltage = (ab_t){0.0f, 0.0f};
    watch->current = current;
}

/* Adds the voltage that was applied on [t_k-1, t_k), or its sum over a window [V]. */
static inline void encoder_watch_add(encoder_watch_t *watch, ab_t voltage)
{
    watch->voltage.alpha += voltage.alpha;
    watch->voltage.beta += voltage.beta;
}

/* The shaft is not driven: the EMF is no longer known. */
static inline void encoder_watch_forget(encoder_watch_t *watch)
{
    encoder_watch_rest(watch);
    watch->known = 0u;
}

/* True if the rotor cannot have this speed [rad/s] electrical: the EMF of the last complete window is too
 * small for it and does not turn as fast. The speed is then an error of the encoder. The EMF is a mean over
 * the window: if it turns by 2x in the window, the factor of its length is sin(x)/x >= 1 - x^2/6. */
static inline bool encoder_watch_denies(const encoder_watch_t *watch, float omega_e)
{
    const dq_t emf = watch->last;
    const float x = watch->tuning.middle * omega_e;
    const float mean = 1.0f - bounds_clamp(ENCODER_WATCH_SIXTH * x * x, 1.0f);
    const float least = ENCODER_WATCH_SPEED * mean * watch->tuning.flux_linkage * omega_e;
    return watch->known != 0u && emf.d * emf.d + emf.q * emf.q < least * least &&
           watch->omega_emf < ENCODER_WATCH_TURNS * bounds_magnitude(omega_e);
}

/* The end of a window: ENCODER_WATCH_... bits, 0 or one of them. No division. */
uint32_t encoder_watch_step(encoder_watch_t *watch, const encoder_watch_input_t *input);

#endif
