/* Motion watch: does the shaft move as the torque says, and does it come to where it is asked for? Two laws.
 *
 * The load that explains the motion, in amperes of i_q, as a disturbance observer has it,
 *
 *     i_L = LP(i_q) - (J/K_t) (omega - LP(omega))/tau          K_t = 1.5 p psi_f
 *
 * LP: low-passes with the time constant tau, sampled; the bracket over tau, exactly over the time that the
 * low-pass is behind, is LP(domega/dt). A load beyond
 * MOTION_LOAD_MOST of the current limit that takes the shaft against its current and away from standstill is
 * no load, if the current is large already: the torque has the wrong sign, the drive pushes what it means to
 * hold.
 *
 *     runaway     |i_L| > 1.3 i_max,  i_L i_q > 0,  |i_q| > 0.6 i_max,  |omega| grows, against i_q,
 *                 for MOTION_RUNAWAY_TIME, and meanwhile by a tenth of what it was at first
 *
 * A load on an elastic shaft swings back by less than that, or its back-EMF confirms the encoder's angle
 * meanwhile: then the torque has the sign that control gives it.
 *
 * A shaft that is hit is no runaway: its acceleration is held within 2 (K_t/J) i_max, from which it has come
 * down to 0.3 of that after 1.9 tau, and a runaway must last for 2.2 tau at least. tau is long enough that
 * the noise of the speed n makes no more than a fifth of i_max of it: tau = max(5 ms, 5 (J/K_t) n/i_max).
 *
 * The way to the reference: the current is at its limit, the speed is not where it is asked for, and has come
 * no nearer by more than `progress` since:
 *
 *     stalled      for stall_time, and the shaft stands
 *     speed error  for speed_error_time
 *
 * motion_watch_step() every `every`-th T. Does not handle: loads beyond 1.3 times what the motor can, which
 * run away with it; a J that is believed at less than half of what it is (seen later, by the encoder watch).
 */
#ifndef MEDIUM_PROTECT_MOTION_WATCH_H
#define MEDIUM_PROTECT_MOTION_WATCH_H

#include <stdbool.h>
#include <stdint.h>

#define MOTION_LOAD_MOST    1.3f  /* [-] of the current limit */
#define MOTION_LOAD_HIT     2.0f  /* [-] of the current limit: what the most acceleration is taken for */
#define MOTION_PUSHES       0.6f  /* [-] of the current limit: less is no push */
#define MOTION_TAU_MIN      5e-3f /* [s] */
#define MOTION_TAU_NOISE    5.0f  /* [-] limit of current over the noise of i_L */
#define MOTION_RUNAWAY_TIME 8e-3f /* [s] that it must last ... */
#define MOTION_RUNAWAY_TAUS 2.2f  /* [-] ... and for so many tau */
#define MOTION_AT_LIMIT     0.9f  /* [-] of the limit in force: the current is at it */
#define MOTION_ASKED        0.05f /* [-] of the reference: so far off it is not where it is asked for */

/* What has been noticed: bits. */
#define MOTION_RUNAWAY     UINT32_C(1)
#define MOTION_STALLED     UINT32_C(2)
#define MOTION_SPEED_ERROR UINT32_C(4)

typedef struct {
    float per_ampere;       /* K_t/J, mechanical [rad/s^2 per A], > 0 */
    float current_limit;    /* i_max [A], > 0 */
    float noise;            /* n of the speed, mechanical [rad/s] */
    float standing;         /* slower shafts stand, mechanical [rad/s] */
    float stall_time;       /* [s]; 0: not judged */
    float speed_error_time; /* [s]; 0: not judged */
    float period;           /* T [s] */
    uint32_t every;         /* periods of a judgement [-] */
} motion_watch_params_t;

typedef struct {
    float share;          /* of the low-passes [-] */
    float per_speed;      /* J/K_t over the time that the low-pass is behind [A s/rad] */
    float load_most;      /* [A] */
    float gained_most;    /* omega - LP(omega) at the most acceleration [rad/s] */
    float pushes;         /* [A] */
    float standing;       /* [rad/s] */
    float progress;       /* [rad/s] */
    uint32_t runaway;     /* judgements that it must last [-] */
    uint32_t stall;       /* likewise; 0: not judged */
    uint32_t speed_error; /* likewise; 0: not judged */
} motion_watch_tuning_t;

typedef struct {
    motion_watch_tuning_t tuning;
    float current;    /* LP(i_q) [A] */
    float omega;      /* LP(omega) [rad/s] */
    float load;       /* i_L [A] */
    float base;       /* speed in the direction of the reference from which it must come nearer [rad/s] */
    uint32_t settled; /* [-] 1: the low-passes have begun */
    float calm;       /* |omega| at the last judgement without a runaway [rad/s] */
    uint32_t away;    /* judgements that a runaway has lasted [-] */
    uint32_t stuck;   /* judgements at the limit that have brought nothing [-]; 0: none */
    uint32_t forward; /* [-] 1: the reference lies above the speed, of those */
} motion_watch_t;

/* What a judgement takes, all of t_k. */
typedef struct {
    float i_q;         /* in the frame in force [A] */
    float i_q_ref;     /* [A] */
    float limit;       /* of |i_q|, in force [A] */
    float omega_m;     /* of the shaft as it is believed, mechanical [rad/s] */
    float omega_m_ref; /* [rad/s] */
    bool believed;     /* the speed is that of a sensor: a runaway is judged ... */
    bool confirmed;    /* ... unless the back-EMF stands where that sensor puts the rotor */
    bool asked;        /* a speed is asked for, not a current */
} motion_watch_input_t;

/* Coefficients. Divisions and an exponential: for the background. */
motion_watch_tuning_t motion_watch_prepare(const motion_watch_params_t *params);

/* These coefficients; nothing seen. */
void motion_watch_init(motion_watch_t *watch, const motion_watch_tuning_t *tuning);

/* New coefficients; what is under way goes on. */
static inline void motion_watch_take(motion_watch_t *watch, const motion_watch_tuning_t *tuning)
{
    watch->tuning = *tuning;
}

/* Nobody drives the shaft. */
static inline void motion_watch_rest(motion_watch_t *watch)
{
    watch->settled = 0u;
    watch->away = 0u;
    watch->stuck = 0u;
}

/* A judgement: MOTION_... bits. No division. */
uint32_t motion_watch_step(motion_watch_t *watch, const motion_watch_input_t *input);

#endif
