/* Inertia J of all that turns from what the speed gains while the motor pushes it, and the part of i_q that
 * only carries the load.
 *
 *     J domega_m/dt = K_t (i_q - i_L)      =>      domega/dt = K (i_q - i_L),    K = 1.5 p^2 psi_f/J
 *
 * While the reference of the speed stands, i_q is there for the load alone: i_L follows it within
 * 1/INERTIA_LOAD_CUTOFF. From the period in which the reference moves until the speed has arrived, i_L is
 * held: what i_q has beyond it accelerates. So i_q - i_L is the torque's share that the tracking loop may be
 * told of, and not the speed control's answer to a load; and its sum over the way is what J is learnt from.
 * Until the speed has once stood beside a reference that stands, after a start, nobody knows the load: i_L is
 * all of i_q, and no way begins. Nobody knows whether a load turns round with the speed: through zero the
 * loop is told of no torque beside a load that matters.
 *
 * The way ends when the speed has stood beside a reference that stands for INERTIA_TAIL. In this tail
 * i_q - i_L is the load that has been added on the way, c, beside what the speed still gains; on the way
 * itself it was c/2 in the mean. From both, with sums S and times t,
 *
 *     dw_way  = K (S_way  - c t_way/2)
 *     dw_tail = K (S_tail - c t_tail)
 *     J = 1.5 p^2 psi_f (S_way - r S_tail)/(dw_way - r dw_tail),     r = t_way/(2 t_tail)
 *
 * whatever R, L and dead time are; a wrong psi_f goes into J alone, K stays right. A way says something only
 * if all of it was sound, the speed gained INERTIA_SPEED_LEAST, i_q was large enough and the load moved by
 * little beside it. The learnt J is the median of what the last three said, which begin as the parameter: two
 * that agree are believed (docs/theory.md, 26).
 *
 * One step in every so-manieth T, from the means of these; one division at the end of a way. Does not handle:
 * a load that comes and goes again on the way; friction that turns round at zero speed, which is not sound.
 */
#ifndef MEDIUM_ADAPT_INERTIA_H
#define MEDIUM_ADAPT_INERTIA_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "medium/adapt/believed.h"

#define INERTIA_LOAD_CUTOFF  1000.0f /* [rad/s] of the low-pass to i_L */
#define INERTIA_ARRIVED      8.0f    /* [rad/s] electrical, from the reference */
#define INERTIA_TAIL         0.15f   /* [s] */
#define INERTIA_LONGEST      4.0f    /* [s] of a way with its tail */
#define INERTIA_SPEED_LEAST  60.0f   /* [rad/s] electrical */
#define INERTIA_TORQUE_LEAST 0.02f   /* [-] of the current limit: mean of i_q - i_L on the way */
#define INERTIA_LOAD_MOST    0.15f   /* [-] of that mean: the load that has been added */
#define INERTIA_RANGE        5.0f    /* [-] of the parameter, either way */

typedef struct {
    float from;         /* J of the parameters [kg m^2], above 0 */
    float inertia;      /* J, believed [kg m^2], above 0 */
    float flux_linkage; /* psi_f, believed [Wb], above 0 */
    float pole_pairs;   /* p [-] */
    float current_max;  /* limit of i_q [A] */
    float period;       /* from one step to the next [s] */
    bool on;
} inertia_params_t;

typedef struct {
    float from;          /* [kg m^2] */
    float impulse;       /* 1.5 p^2 psi_f T [kg m^2 rad/s per A and step], T being that of a step */
    float gain;          /* K T, likewise [rad/s per A and step] */
    float load_share;    /* of the low-pass to i_L [-] */
    float torque;        /* least mean of i_q - i_L [A] */
    float half_per_tail; /* r per step of a way [-] */
    uint32_t tail_steps; /* [-] */
    uint32_t most_steps; /* [-] of a way with its tail */
    uint32_t on;         /* [-] 1 */
} inertia_tuning_t;

typedef struct {
    inertia_tuning_t tuning;
    learnt_value_t learnt; /* J [kg m^2] */
    float said[2];         /* by the last two ways [kg m^2] */
    float load;            /* i_L [A] */
    float share;           /* by which it follows next [-]: 1: it is not known yet */
    float omega_ref;       /* of the last step [rad/s], electrical */
    /* of the way */
    uint32_t under_way;  /* [-] 1 */
    uint32_t through;    /* [-] 1: it leads, or led, through zero speed */
    uint32_t sound;      /* [-] 1: nothing has spoilt it */
    uint32_t steps;      /* [-] since it began */
    uint32_t left;       /* [-] steps of its tail; 0: not arrived */
    float omega;         /* when it began [rad/s] */
    float omega_arrived; /* when the tail began [rad/s] */
    float sum;           /* sum(i_q - i_L) since it began [A] */
    float sum_arrived;   /* likewise, when the tail began [A] */
} inertia_t;

/* What the periods since the last step bring. */
typedef struct {
    float omega_ref; /* of the speed, now [rad/s], electrical */
    float omega;     /* of the rotor now, estimated, smooth [rad/s], electrical */
    float i_q;       /* mean in the rotor's frame, as a current of psi_f that makes the torque, finite [A] */
} inertia_input_t;

/* Coefficients. Divisions and an exponential: for the background. */
inertia_tuning_t inertia_prepare(const inertia_params_t *params);

/* These coefficients; nothing learnt. */
void inertia_init(inertia_t *x, const inertia_tuning_t *tuning);

/* The coefficients. What was learnt stays while the parameter that it began from is not changed and the
 * learning is on; else it starts from the parameter again. */
void inertia_take(inertia_t *x, const inertia_tuning_t *tuning);

/* A step without a rotor that is tracked: nothing is known of the load. */
static inline void inertia_rest(inertia_t *x)
{
    x->under_way = 0u;
    x->load = 0.0f;
    x->share = 1.0f;
}

/* A step of which a speed or current may not be believed, before it: what is under way says nothing. */
static inline void inertia_spoil(inertia_t *x)
{
    x->sound = 0u;
}

/* The two ends of a way, for inertia_step(). */
void inertia_begin(inertia_t *x, float omega);
void inertia_end(inertia_t *x, float omega);

/* One step with a rotor that is tracked. What the current answers to a reference that has moved since the
 * last one carries no load. */
static inline void inertia_step(inertia_t *x, const inertia_input_t *input)
{
    const bool moves = input->omega_ref != x->omega_ref;
    const float beyond = input->i_q - x->load;
    x->omega_ref = input->omega_ref;
    if (x->under_way == 0u) {
        if (!moves || x->share >= 1.0f) {
            x->load += x->share * beyond;
        }
        if (!moves && bounds_within(input->omega_ref - input->omega, INERTIA_ARRIVED)) {
            x->share = x->tuning.load_share;
        }
        if (moves && x->share < 1.0f) {
            inertia_begin(x, input->omega);
        }
        return;
    }
    x->through |= input->omega_ref * input->omega < 0.0f ? 1u : 0u;
    x->sum += beyond;
    x->steps++;
    if (moves || !bounds_within(input->omega_ref - input->omega, INERTIA_ARRIVED)) {
        x->left = 0u;
    } else if (x->left == 0u) {
        x->left = x->tuning.tail_steps;
        x->omega_arrived = input->omega;
        x->sum_arrived = x->sum;
    } else {
        x->left--;
        if (x->left == 0u) {
            inertia_end(x, input->omega);
        }
    }
}

/* The share with which an idea of the load follows i_q in each period: `follows` while the reference of the
 * speed stands, 0 on a way. All of i_q is load, 1, while none is known, and where the way leads through zero
 * with a load of `most` [A] or more. */
static inline float inertia_load_share(const inertia_t *x, float follows, float most)
{
    if (x->under_way != 0u) {
        return x->through != 0u && !bounds_within(x->load, most) ? 1.0f : 0.0f;
    }
    return x->share < 1.0f ? follows : 1.0f;
}

/* What the speed has gained on this way, and what K (i_q - i_L) says [rad/s], electrical: 0 on none. */
static inline float inertia_gained(const inertia_t *x, float omega)
{
    return x->under_way != 0u ? omega - x->omega : 0.0f;
}

static inline float inertia_foreseen(const inertia_t *x)
{
    return x->under_way != 0u ? x->tuning.gain * x->sum : 0.0f;
}

#endif
