/* Inertia J of all rotating parts from the speed that the motor gains under torque, and the part of
 * i_q that carries only the load.
 *
 *     J domega_m/dt = K_t (i_q - i_L)      =>      domega/dt = K (i_q - i_L),    K = 1.5 p^2 psi_f/J
 *
 * While the speed reference is constant, i_q carries only the load. Then i_L follows i_q within
 * 1/INERTIA_LOAD_CUTOFF. The names below call a change of the speed a "way". It begins in the period in which
 * the reference changes, and ends when the speed has arrived. During a way i_L is held, and i_q - i_L
 * accelerates the shaft. The tracking loop gets i_q - i_L as its torque, without the response of the speed
 * control to a load. J is learnt from the sum of i_q - i_L over the way.
 *
 * After a start the load is unknown until the speed has been near a constant reference once. Until then i_L
 * equals i_q, and no way begins. It is also unknown whether the load changes its sign with the speed.
 * Therefore the loop gets no torque at zero speed if the load is significant.
 *
 * The way ends when the speed has been near a constant reference for INERTIA_TAIL. In this tail i_q - i_L
 * consists of two parts: the load c that was added on the way, and the torque for the remaining change of the
 * speed. On the way itself the mean added load was c/2. With sums S and times t
 *
 *     dw_way  = K (S_way  - c t_way/2)
 *     dw_tail = K (S_tail - c t_tail)
 *     J = 1.5 p^2 psi_f (S_way - r S_tail)/(dw_way - r dw_tail),     r = t_way/(2 t_tail)
 *
 * for any R, L and dead time. A wrong psi_f affects only J; K remains right. A way has a result under four
 * conditions: all of its samples were valid, the speed changed by INERTIA_SPEED_LEAST or more, i_q was large
 * enough, and the load changed little compared with i_q - i_L. The learnt J is the median of three values, at
 * first all J of the parameters, then the last three results (docs/theory.md, 26). A single
 * wrong result therefore changes nothing.
 *
 * The step is called once in `every` periods of T, with the means of these periods. It divides once, at the
 * end of a way. Does not handle: a load that rises and falls again on the way; friction, which changes its
 * sign at zero speed and makes the samples invalid. */
#ifndef MEDIUM_ADAPT_INERTIA_H
#define MEDIUM_ADAPT_INERTIA_H

#include <stdbool.h>
#include <stdint.h>

#include "math/bounds.h"
#include "medium/adapt/assumed.h"

#define INERTIA_LOAD_CUTOFF  1000.0f /* [rad/s] of the low-pass from i_q to i_L */
#define INERTIA_LOAD_SETTLES 25.0f   /* [rad/s] the same for INERTIA_TAIL after a way */
#define INERTIA_ARRIVED      8.0f    /* [rad/s] electrical: the speed is near the reference */
#define INERTIA_TAIL         0.15f   /* [s] */
#define INERTIA_LONGEST      4.0f    /* [s] longest way with its tail */
#define INERTIA_SPEED_LEAST  60.0f   /* [rad/s] electrical */
#define INERTIA_NEAR_ZERO    60.0f   /* [rad/s] electrical: the load may change its sign soon */
#define INERTIA_TORQUE_LEAST 0.02f   /* [-] of the current limit: mean of i_q - i_L on the way */
#define INERTIA_LOAD_MOST    0.15f   /* [-] of that mean: largest load that may have been added */
#define INERTIA_RANGE        5.0f    /* [-] largest factor between J and the parameter, up and down */
#define INERTIA_LOAD_UNKNOWN 1e6f    /* [A] represents an unknown load */

typedef struct {
    float from;         /* J of the parameters [kg m^2], above 0 */
    float inertia;      /* assumed J [kg m^2], above 0 */
    float flux_linkage; /* assumed psi_f [Wb], above 0 */
    float pole_pairs;   /* p [-] */
    float current_max;  /* limit of i_q [A] */
    float period;       /* from one step to the next [s] */
    bool on;
} inertia_params_t;

typedef struct {
    float from;          /* [kg m^2] */
    float impulse;       /* 1.5 p^2 psi_f T [kg m^2 rad/s per A and step], T being the time of a step */
    float gain;          /* K T, for the same T [rad/s per A and step] */
    float load_share;    /* of the low-pass to i_L [-] */
    float torque;        /* least mean of i_q - i_L [A] */
    float half_per_tail; /* r per step of a way [-] */
    uint32_t tail_steps; /* [-] */
    uint32_t most_steps; /* [-] largest number of steps of a way with its tail */
    uint32_t on;         /* [-] 1 */
} inertia_tuning_t;

typedef struct {
    float follows; /* share per period with which the load follows i_q at a constant speed [-] */
    float settles; /* the same for INERTIA_TAIL after a way, and before zero speed [-] */
    float most;    /* load from which a way through zero gives the loop no torque [A] */
} inertia_shares_t;

typedef struct {
    inertia_tuning_t tuning;
    learnt_value_t learnt; /* J [kg m^2] */
    float said[2];         /* of the last two ways [kg m^2] */
    float load;            /* i_L [A] */
    float share;           /* share of the low-pass in the next step [-]: 1: the load is not known yet */
    float omega_ref;       /* of the last step [rad/s], electrical */
    /* of the way */
    uint32_t under_way;  /* [-] 1 */
    uint32_t through;    /* [-] 1: the reference has passed zero before the rotor, or the rotor has */
    uint32_t near;       /* [-] 1: the rotor is or was near zero speed */
    uint32_t sound;      /* [-] 1: all samples so far were sound */
    uint32_t steps;      /* [-] since the beginning */
    uint32_t left;       /* [-] remaining steps of its tail, 0: not arrived; after it, in which i_L settles */
    float omega;         /* at the beginning [rad/s] */
    float omega_arrived; /* at the beginning of the tail [rad/s] */
    float sum;           /* sum(i_q - i_L) since the beginning [A] */
    float sum_arrived;   /* the same sum at the beginning of the tail [A] */
} inertia_t;

/* The values over the periods since the last step. */
typedef struct {
    float omega_ref; /* present speed reference [rad/s], electrical */
    float omega;     /* present estimated speed of the rotor, smoothed [rad/s], electrical */
    float i_q; /* mean in the rotor's frame, as the current that makes the torque with psi_f, finite [A] */
} inertia_input_t;

/* Computes the coefficients. Divisions and an exponential: for the background. */
inertia_tuning_t inertia_prepare(const inertia_params_t *params);

/* Takes these coefficients; nothing is learnt. */
void inertia_init(inertia_t *x, const inertia_tuning_t *tuning);

/* Takes over the coefficients. The learnt value is kept while the parameter from which it started is
 * unchanged and learning is on; otherwise learning restarts from the parameter. */
void inertia_take(inertia_t *x, const inertia_tuning_t *tuning);

/* A step without a tracked rotor: the load is unknown. */
static inline void inertia_rest(inertia_t *x)
{
    x->under_way = 0u;
    x->left = 0u;
    x->load = 0.0f;
    x->share = 1.0f;
}

/* The speed or the current before this step is invalid: the present way gives no result. */
static inline void inertia_spoil(inertia_t *x)
{
    x->sound = 0u;
}

/* The two ends of a way, for inertia_step(). */
void inertia_begin(inertia_t *x, float omega);
void inertia_end(inertia_t *x, float omega);

/* One step with a tracked rotor. The response of the current to a reference that has changed since
 * the last step carries no load. */
static inline void inertia_step(inertia_t *x, const inertia_input_t *input)
{
    const bool moves = input->omega_ref != x->omega_ref;
    const float beyond = input->i_q - x->load;
    x->omega_ref = input->omega_ref;
    if (x->under_way == 0u) {
        x->left -= x->left != 0u ? 1u : 0u;
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
    x->near |= x->through != 0u && bounds_within(input->omega, INERTIA_NEAR_ZERO) ? 1u : 0u;
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

/* The share with which the load estimate of the fast task follows i_q in each period. It is 0 on a way. The
 * loop compensates for a load that changes there, so a jump of i_L would be a load step for it: for some
 * time after the way i_L only `settles`. On a way through zero speed with a load of `most` it settles as
 * well. All of i_q counts as load once the rotor is near zero speed, and while the load is unknown. */
static inline float inertia_load_share(const inertia_t *x, const inertia_shares_t *shares)
{
    if (x->under_way != 0u) {
        if (x->through == 0u || bounds_within(x->load, shares->most)) {
            return 0.0f;
        }
        return x->near != 0u ? 1.0f : shares->settles;
    }
    if (x->share >= 1.0f) {
        return 1.0f;
    }
    return x->left != 0u ? shares->settles : shares->follows;
}

/* i_L [A] for a part that has to know the load; INERTIA_LOAD_UNKNOWN while the loop gets no torque. Without
 * learning the loop gets the torque of all of i_q. */
static inline float inertia_load_seen(const inertia_t *x)
{
    return x->share < 1.0f || x->tuning.on == 0u ? x->load : INERTIA_LOAD_UNKNOWN;
}

/* The speed gained on this way, and the gain that follows from K (i_q - i_L)
 * [rad/s], electrical: 0 without a way. */
static inline float inertia_gained(const inertia_t *x, float omega)
{
    return x->under_way != 0u ? omega - x->omega : 0.0f;
}

static inline float inertia_foreseen(const inertia_t *x)
{
    return x->under_way != 0u ? x->tuning.gain * x->sum : 0.0f;
}

#endif
