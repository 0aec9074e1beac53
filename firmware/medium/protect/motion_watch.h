/* Motion watch: judges whether the shaft moves as the torque requires, and whether it
 * reaches its reference. Two laws.
 *
 * The load that explains the motion, in amperes of i_q, as in a disturbance observer,
 *
 *     i_L = LP(i_q) - (J/K_t) (omega - LP(omega))/tau          K_t = 1.5 p psi_f
 *
 * LP are sampled low-passes with the time constant tau. The bracket divided by tau, or more exactly by the
 * delay of the low-pass, is LP(domega/dt). If i_L exceeds MOTION_LOAD_MOST of the current limit and the shaft
 * accelerates against a large current, there is no such load: the torque has the wrong sign, and the drive
 * itself accelerates the shaft.
 *
 *     runaway     |i_L| > 1.3 i_max,  i_L i_q > 0,  |i_q| > 0.6 i_max,  |omega| grows, against i_q,
 *                 for MOTION_RUNAWAY_TIME, and beyond its largest amount before by a tenth
 *
 * An elastic shaft also accelerates against the current, but by less than this tenth, or the back-EMF
 * confirms the angle of the encoder meanwhile; the torque then has the commanded sign. A shaft that the
 * current has slowed down swings back to its previous speed. Therefore the stored largest speed decreases
 * with MOTION_SWING, half a period of 15 Hz, the lowest natural frequency that is expected.
 *
 * An impact on the shaft is no runaway. The acceleration in i_L is limited to 2 (K_t/J) i_max and decreases
 * to 0.3 (K_t/J) i_max within 1.9 tau, while a runaway must last for at least 2.2 tau. tau = max(5 ms, 5
 * (J/K_t) n/i_max), so that the noise n of the speed makes at most a fifth of i_max.
 *
 * Progress towards the reference: the current is at its limit, and the speed has approached its reference by
 * less than `progress` for this time:
 *
 *     stalled      for stall_time, and the shaft is at standstill
 *     speed error  for speed_error_time; or for MOTION_OVERRUN_TIME, while a load drives the shaft: it is
 *                  faster than the reference by a tenth, the current brakes at its limit, and the speed has
 *                  grown in this time by `progress`. The speed of an estimate that has just caught the
 *                  rotor still settles, and does not count for the same time after the catch
 *
 * motion_watch_step() every `every`-th T. Does not handle: loads beyond 1.3 times the
 * motor's limit, which accelerate the shaft; an assumed J of less than half of the true one
 * (detected later, by the encoder watch). */
#ifndef MEDIUM_PROTECT_MOTION_WATCH_H
#define MEDIUM_PROTECT_MOTION_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#define MOTION_LOAD_MOST    1.3f   /* [-] of the current limit */
#define MOTION_LOAD_HIT     2.0f   /* [-] of the current limit: acceleration is limited to this */
#define MOTION_PUSHES       0.6f   /* [-] of the current limit: a smaller current is ignored */
#define MOTION_TAU_MIN      5e-3f  /* [s] */
#define MOTION_TAU_NOISE    5.0f   /* [-] current limit divided by the noise of i_L */
#define MOTION_RUNAWAY_TIME 8e-3f  /* [s] for which it must last ... */
#define MOTION_SWING        33e-3f /* [s] in which the speed before a runaway fades */
#define MOTION_RUNAWAY_TAUS 2.2f   /* [-] ... and for this multiple of tau */
#define MOTION_AT_LIMIT     0.9f   /* [-] of the present limit: from here on the current is at its limit */
#define MOTION_OVERRUN      1.1f   /* [-] of the reference: a driven shaft beyond it overruns the brake ... */
#define MOTION_OVERRUN_TIME 50e-3f /* [s] ... and for this time */
#define MOTION_ASKED        0.05f  /* [-] of the reference: largest error of a speed at its reference */

/* The conditions: bits. */
#define MOTION_RUNAWAY     UINT32_C(1)
#define MOTION_STALLED     UINT32_C(2)
#define MOTION_SPEED_ERROR UINT32_C(4)

typedef struct {
    float per_ampere;       /* K_t/J, mechanical [rad/s^2 per A], > 0 */
    float current_limit;    /* i_max [A], > 0 */
    float noise;            /* n of the speed, mechanical [rad/s] */
    float standing;         /* below this mechanical speed the shaft counts as standing [rad/s] */
    float stall_time;       /* [s]; 0: not judged */
    float speed_error_time; /* [s]; 0: not judged */
    float period;           /* T [s] */
    uint32_t every;         /* periods of a judgement [-] */
} motion_watch_params_t;

typedef struct {
    float share;          /* of the low-passes [-] */
    float per_speed;      /* J/K_t divided by the delay of the low-pass [A s/rad] */
    float load_most;      /* [A] */
    float gained_most;    /* omega - LP(omega) at the largest acceleration [rad/s] */
    float pushes;         /* [A] */
    float forgets;        /* of the largest speed before a runaway [-] */
    float standing;       /* [rad/s] */
    float progress;       /* [rad/s] */
    uint32_t runaway;     /* judgements for which it must last [-] */
    uint32_t stall;       /* the same for a stall; 0: not judged */
    uint32_t speed_error; /* the same for a speed error; 0: not judged */
    uint32_t overrun;     /* the same for a shaft that overruns its brake */
} motion_watch_tuning_t;

typedef struct {
    motion_watch_tuning_t tuning;
    float current;    /* LP(i_q) [A] */
    float omega;      /* LP(omega) [rad/s] */
    float load;       /* i_L [A] */
    float base;       /* speed in the direction of the reference, from which the progress counts [rad/s] */
    uint32_t settled; /* [-] 1: the low-passes have started */
    float calm;       /* largest |omega| of the last judgements without a runaway, which fades [rad/s] */
    uint32_t away;    /* consecutive judgements with a runaway [-] */
    uint32_t stuck;   /* judgements at the limit without an approach [-]; 0: none */
    uint32_t forward; /* [-] 1: the reference was above the speed in these */
    float overrun;    /* |omega| at the first of the judgements with a brake overrun [rad/s] */
    uint32_t over;    /* consecutive judgements with a brake overrun [-] */
} motion_watch_t;

/* The inputs of a judgement, all of t_k. */
typedef struct {
    float i_q;         /* in the present frame [A] */
    float i_q_ref;     /* [A] */
    float limit;       /* present limit of |i_q| [A] */
    float omega_m;     /* assumed speed of the shaft, mechanical [rad/s] */
    float omega_m_ref; /* [rad/s] */
    bool measured;     /* the speed comes from a sensor: a runaway is judged ... */
    bool confirmed;    /* ... unless the back-EMF agrees with the angle of that sensor */
    uint32_t running;  /* judgements since control has used the source of this speed [-] */
    bool asked;        /* a speed is requested, not a current */
} motion_watch_input_t;

/* Computes the coefficients. Divisions and an exponential: for the background. */
motion_watch_tuning_t motion_watch_prepare(const motion_watch_params_t *params);

/* Takes these coefficients; nothing has been measured yet. */
void motion_watch_init(motion_watch_t *watch, const motion_watch_tuning_t *tuning);

/* Takes over new coefficients; the state is kept. */
static inline void motion_watch_take(motion_watch_t *watch, const motion_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* Resets the state, because the shaft is not driven. */
static inline void motion_watch_rest(motion_watch_t *watch)
{
    watch->settled = 0u;
    watch->calm = 0.0f;
    watch->away = 0u;
    watch->stuck = 0u;
    watch->over = 0u;
}

/* One judgement. Returns MOTION_... bits. No division. */
uint32_t motion_watch_step(motion_watch_t *watch, const motion_watch_input_t *input);

#endif
