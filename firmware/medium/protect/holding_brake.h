/* The holding brake of the shaft: a spring sets it, its output releases it.
 *
 *     set to releasing       the bridge is on, the speed control can take over, and the torque of the
 *                            winding is near the pre-torque (BRAKE_NEAR, BRAKE_STEADY)
 *
 *     releasing to released  after the release time, and the time in which the speed control takes over the
 *                            difference of load and pre-torque; it is stiff, and holds speed zero until then
 *
 *     both to applying       the sequence requires the brake; the speed control holds speed zero
 *
 *     applying to set        after the apply time; then the bridge may open
 *
 * While the bridge is off, the brake is set. The fast task removes the output in the period in which it opens
 * the bridge (fast/fast.c), without waiting for this module. If the torque is not present BRAKE_TORQUE_TIME
 * after the bridge is on, that is a fault.
 *
 * Does not handle: a brake that does not hold or does not release (the watch of the speed finds it), a motor
 * without an encoder, which has no known torque at standstill (settings/rules.c). */
#ifndef MEDIUM_PROTECT_HOLDING_BRAKE_H
#define MEDIUM_PROTECT_HOLDING_BRAKE_H

#include <stdbool.h>
#include <stdint.h>

#define BRAKE_NEAR        0.05f   /* [-] of the current limit: largest difference of the torque */
#define BRAKE_STEADY      4e-3f   /* [s] for which the difference must be smaller */
#define BRAKE_TORQUE_TIME 500e-3f /* [s] until a missing torque is a fault */

typedef enum { BRAKE_SET, BRAKE_RELEASING, BRAKE_RELEASED, BRAKE_APPLYING } brake_state_t;
#define BRAKE_STATE_NAMES "set|releasing|released|applying"

typedef struct {
    bool on;             /* there is a brake */
    float release_time;  /* [s] from the output until the shaft is free */
    float take_time;     /* [s] in which the speed control takes over the load */
    float apply_time;    /* [s] from the output until the brake holds */
    float preload;       /* torque before the release, as a current of psi_f [A] */
    float current_limit; /* [A] */
    float period;        /* of a look [s] */
} holding_brake_params_t;

typedef struct {
    uint32_t on;            /* [-] 1: there is a brake */
    uint32_t release_looks; /* [looks] */
    uint32_t apply_looks;   /* [looks] */
    uint32_t steady_looks;  /* [looks] */
    uint32_t torque_looks;  /* [looks] of BRAKE_TORQUE_TIME */
    float preload;          /* [A] */
    float near;             /* [A] */
} holding_brake_tuning_t;

typedef struct {
    bool bridge;  /* it is on */
    bool holds;   /* control runs in the frame of a known rotor */
    bool set;     /* the brake has to be set */
    float torque; /* of the winding, as a current of psi_f [A] */
} holding_brake_input_t;

typedef struct {
    int32_t state;   /* [-] brake_state_t */
    uint32_t looks;  /* [looks] in a state with a time, or with the torque present */
    uint32_t waits;  /* [looks] with the bridge on and the brake set */
    uint32_t failed; /* [-] 1: the torque for holding is missing */
} holding_brake_t;

/* Computes the coefficients. Divisions: for the background. */
holding_brake_tuning_t holding_brake_prepare(const holding_brake_params_t *params);

/* One look, once per window, where tuning->on is not 0. */
void holding_brake_step(holding_brake_t *x, const holding_brake_tuning_t *tuning,
                        const holding_brake_input_t *input);

/* True if the output releases the brake. */
static inline bool holding_brake_opens(const holding_brake_t *x)
{
    return x->state == (int32_t)BRAKE_RELEASING || x->state == (int32_t)BRAKE_RELEASED;
}

#endif
