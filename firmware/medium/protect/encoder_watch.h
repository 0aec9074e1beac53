/* Encoder watch: does the encoder say what the back-EMF says? The mean EMF of a window, that of
 * voltages and currents alone (winding.h),
 *
 *     <e> = (sum(u) - R n (i_0 + i_n)/2)/n - L (i_n - i_0)/T_j,    T_j = n T
 *
 * is looked at in the frame of the encoder's angle in its middle, where that of a rotor which is where the
 * encoder puts it stands on the q axis with psi_f omega:
 *
 *     e = (0, psi_f omega)          healthy, in both directions
 *     e off the q axis by delta     an angle that is wrong by delta: offset, a coupling that has slipped
 *     e turns at omega_emf - omega  wrong lines or pole pairs, lines lost, an encoder that stands
 *     omega_emf against omega       phases or tracks swapped: the encoder counts the other way round
 *     e = 0 at a speed              an encoder that turns without the rotor
 *
 * Judged at each window's end, e being its own where that is beyond noise, else the mean of the last two:
 * noise of the current is in it through its ends alone.
 *
 *     mismatch    e_q sign(omega) < 0.8 |e|    while |e| > psi_f omega_least    37 degrees, or it turns
 *                 |e| < psi_f |omega|/4        while |omega| > omega_least
 *     direction   the same, and LP(omega + (e_last x e)/(|e_last||e| T_j)), the EMF's speed, is against omega
 *                 with half of it at least
 *
 * A sign must last until the EMF that it rests on, or that is missing, has made ENCODER_WATCH_TIME psi_f
 * omega_least of volt seconds, and three judgements at least: the larger the EMF, the less an error of the
 * voltage can do. A judgement without the sign halves them. While the EMF is doubtful, for a wire or a
 * current sensor may be wrong, or what it has beside psi_f omega lies along the axis of one phase, as that of
 * an open wire or switch does, and stays there within 6 degrees and what noise turns it, the judgement waits
 * for ENCODER_WATCH_WAIT in all until a judgement without the sign: what it has seen stays. Below omega_least
 * the EMF is not judged: there it drowns in dead time and R i, and in a winding of large inductance in the
 * noise of the current: where three standard deviations of the mean of two windows, 3 sqrt(2) L n_i/(2 T_j),
 * are more than psi_f omega_least, they take its place (docs/theory.md, 28). An angle that moves from one
 * period to the next by more than 0.5 rad and two counts beside what the speed explains is no rotor at all:
 * reported in the same period. While hardly a current flows, offsets of the sensors may make the dead time's
 * voltage the opposite of what is configured: then only twice as large an EMF is judged.
 *
 * encoder_watch_add() every T, encoder_watch_step() every n-th, where encoder_watch_rest() is called too.
 * Does not handle: an encoder whose angle is wrong by less than 37 degrees; direction above 1/T_j = 1250
 * rad/s with 8 periods of 0.1 ms, where it is a mismatch. */
#ifndef MEDIUM_PROTECT_ENCODER_WATCH_H
#define MEDIUM_PROTECT_ENCODER_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "math/frames.h"
#include "math/winding.h"

#define ENCODER_WATCH_AXIS   0.8f  /* [-] cosine of the largest angle between EMF and q axis */
#define ENCODER_WATCH_GONE   0.25f /* [-] of psi_f |omega|: less is no EMF */
#define ENCODER_WATCH_ALONE  5.0f  /* [-] of psi_f omega_least: an EMF that noise does not make in a window */
#define ENCODER_WATCH_SIGNS  2.0f  /* [-] psi_f omega_least, where the signs of the currents are in doubt */
#define ENCODER_WATCH_LEAP   0.5f  /* [rad] electrical, that no rotor moves in a period beside its speed */
#define ENCODER_WATCH_CUTOFF 500.0f /* [rad/s] of the low-pass */
#define ENCODER_WATCH_TIME   8e-3f  /* [s] that a sign must last at psi_f omega_least */
#define ENCODER_WATCH_LEAST  3u     /* judgements, at any EMF [-] */
#define ENCODER_WATCH_SETTLE 6e-3f  /* [s] after a rest: current sensors that are wrong are told first */
#define ENCODER_WATCH_WAIT   0.5f   /* [s] within which a wire or a sensor that is wrong is told by itself */

/* What has been noticed: bits. */
#define ENCODER_WATCH_MISMATCH  UINT32_C(1)
#define ENCODER_WATCH_DIRECTION UINT32_C(2)
#define ENCODER_WATCH_JUMP      UINT32_C(4) /* of the fast task, by encoder_jumped() */

typedef struct {
    float resistance;   /* R [ohm] */
    float inductance;   /* L_q [H], > 0 */
    float flux_linkage; /* psi_f [Wb], > 0 */
    float speed_least;  /* omega_least [rad/s] electrical, > 0 */
    float noise;        /* of a measured current, standard deviation [A], >= 0 */
    float doubtful;     /* length of a current whose phases may have any sign [A], >= 0 */
    float step;         /* a count of the encoder [rad] electrical */
    float period;       /* T [s] */
    uint32_t every;     /* n, periods of a window [-] */
} encoder_watch_params_t;

typedef struct {
    float flux_linkage; /* psi_f [Wb] */
    float emf_least;    /* psi_f omega_least, or what noise does not make in the mean of two windows [V] */
    float doubtful;     /* square of the length of a current whose phases may have any sign [A^2] */
    float alone;        /* square of the EMF from which on a window is judged by itself [V^2] */
    float noise;        /* square of three standard deviations of the EMF of a window by itself [V^2] */
    float leap;         /* [rad] electrical; more than half a turn: not judged */
    float share;        /* of the low-pass [-] */
    winding_t winding;
    float periods;    /* n [-] */
    float volts;      /* L/T_j [V/A] */
    float middle;     /* -T_j/2 [s] */
    float rate;       /* 1/T_j [1/s] */
    float holds;      /* sum of EMFs, one a judgement, that a sign must last [V] */
    uint32_t settles; /* windows after a rest without a judgement [-] */
    uint32_t waits;   /* judgements that a doubtful EMF may put off [-] */
} encoder_watch_tuning_t;

typedef struct {
    encoder_watch_tuning_t tuning;
    ab_t voltage;        /* sum in this window [V] */
    ab_t current;        /* where it begins [A] */
    dq_t last;           /* <e> of the last window [V] */
    float omega_emf;     /* LP of the EMF's speed, positive where the encoder's sign is its own [rad/s] */
    float held;          /* sum of EMFs that a sign has lasted [V] */
    uint32_t count;      /* judgements that it has [-] */
    uint32_t windows;    /* since a rest [-], up to what a judgement needs */
    uint32_t waited;     /* judgements that were put off [-]; each without the sign halves them */
    ab_t off;            /* of the last look that was wrong: what its EMF has beside the rotor's [V] */
    uint32_t of_a_phase; /* 1: the last window's EMF is wrong along the axis of one phase [-] */
    uint32_t elsewhere;  /* 1: it is off by much, and that along none [-] */
    uint32_t confirmed;  /* 1: it is beyond noise and where the encoder puts the rotor [-] */
} encoder_watch_t;

/* What it takes, all of t_k. */
typedef struct {
    ab_t current;       /* [A] */
    rotation_t encoder; /* the frame of its angle */
    float omega_e;      /* its speed, electrical [rad/s] */
    bool doubtful;      /* is the EMF? */
} encoder_watch_input_t;

/* Coefficients. Divisions and an exponential: for the background. */
encoder_watch_tuning_t encoder_watch_prepare(const encoder_watch_params_t *params);

/* These coefficients; nothing seen. */
void encoder_watch_init(encoder_watch_t *watch, const encoder_watch_tuning_t *tuning);

/* New coefficients; what is under way goes on. */
static inline void encoder_watch_take(encoder_watch_t *watch, const encoder_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* At a window's end, where none is judged: the next begins here, with nothing seen. */
static inline void encoder_watch_rest(encoder_watch_t *watch)
{
    watch->windows = 0u;
    watch->held = 0.0f;
    watch->count = 0u;
    watch->waited = 0u;
    watch->of_a_phase = 0u;
    watch->elsewhere = 0u;
    watch->confirmed = 0u;
}

/* A window that nobody judges ends: the next begins with this current [A]. */
static inline void encoder_watch_begin(encoder_watch_t *watch, ab_t current)
{
    watch->voltage = (ab_t){0.0f, 0.0f};
    watch->current = current;
}

/* The voltage that acted on [t_k-1, t_k), or its sum over a window [V]. */
static inline void encoder_watch_add(encoder_watch_t *watch, ab_t voltage)
{
    watch->voltage.alpha += voltage.alpha;
    watch->voltage.beta += voltage.beta;
}

/* The end of a window: ENCODER_WATCH_... bits, 0 or one of them. No division. */
uint32_t encoder_watch_step(encoder_watch_t *watch, const encoder_watch_input_t *input);

#endif
