/* What the fault table's rows compare: a field for each of their quantities, made of what the guard is told
 * of a period; and whether any of them holds. For guard.c, and for whoever asks whether it has to be called.
 */
#ifndef DRIVE_GUARD_QUANTITIES_H
#define DRIVE_GUARD_QUANTITIES_H

#include <stdbool.h>

#include "drive/guard.h"
#include "drive/manoeuvres.h"
#include "drive/measure.h"
#include "estimator/chosen.h"
#include "math/bounds.h"
#include "protect/current_watch.h"
#include "protect/encoder_watch.h"
#include "protect/link.h"
#include "protect/motion_watch.h"
#include "protect/thermal.h"

/* A condition holds while its bits are not 0. */
typedef struct {
    /* of the rows that are judged in each period */
    float phase_current;         /* [A] the largest amount of the three, offsets removed */
    float u_dc;                  /* [V] */
    float speed;                 /* [rad/s] amount, mechanical */
    uint32_t tripped;            /* [-] the trip zone holds the gates off; conditions likewise: */
    uint32_t bad_sample;         /* [-] not a number, or a current sensor at its rail */
    uint32_t late;               /* [-] this interrupt came too late for its period */
    uint32_t medium_late;        /* [-] the medium task has missed two windows in a row */
    uint32_t encoder_error;      /* [-] quadrature phase error since the last sample */
    uint32_t estimate_amplitude; /* [-] the estimate in use is lost by this criterion */
    uint32_t estimate_detector;  /* [-] likewise */
    uint32_t estimate_current;   /* [-] likewise */
    uint32_t estimate_speed;     /* [-] likewise */
    uint32_t unlocked;           /* [-] a sign of a lost lock stands */
    uint32_t lock_lost;          /* [-] the manoeuvre has failed by this, and the next three */
    uint32_t start_stalled;      /* [-] likewise */
    uint32_t start_unlocked;     /* [-] likewise */
    uint32_t rotor_too_fast;     /* [-] likewise */
    uint32_t encoder_jump;       /* [-] the encoder is wrong by this */
    uint32_t current_stuck;      /* [-] a sensor is, as current_watch.h says */
    /* of the slow rows */
    float sink_temperature;      /* [degC] */
    float motor_temperature;     /* [degC] */
    uint32_t program_corrupt;    /* [-] flash, or its copy in RAM, has changed */
    uint32_t params_corrupt;     /* [-] the active set has changed */
    uint32_t stack_low;          /* [-] the end of the stack was written to */
    uint32_t background_stalled; /* [-] the background has not come round for too long */
    uint32_t encoder_direction;  /* [-] the encoder is wrong by this */
    uint32_t encoder_mismatch;   /* [-] likewise */
    uint32_t runaway;            /* [-] the shaft does not move as it should, by this */
    uint32_t stalled;            /* [-] likewise */
    uint32_t speed_error;        /* [-] likewise */
    uint32_t encoder_lost;       /* [-] the motor goes on without an encoder that was wrong */
    uint32_t current_gain;       /* [-] as current_watch.h says, and the next two */
    uint32_t phase_loss;         /* [-] likewise */
    uint32_t current_sum;        /* [-] likewise */
    uint32_t motor_overload;     /* [-] by its heat, and the next */
    uint32_t module_overload;    /* [-] likewise */
    uint32_t derating;           /* [-] the limit of the current is lower */
    uint32_t dc_ripple;          /* [-] of the DC link */
    uint32_t dc_limits;          /* [-] the DC link limits the torque */
    uint32_t loop_slow;          /* [-] the tracking loop is set too slow */
    uint32_t oscillation;        /* [-] the speed loop oscillated, and was slowed down */
    uint32_t master_silent;      /* [-] the master on the line was silent for too long */
} guard_quantities_t;

static inline guard_quantities_t guard_quantities_of(const guard_input_t *input)
{
    const measured_t *measured = input->measured;
    const uint32_t invalid = input->estimate_invalid;
    const abc_t i = measured->current_abc;
    return (guard_quantities_t){
        .phase_current =
            bounds_span(bounds_magnitude(i.a), bounds_magnitude(i.b), bounds_magnitude(i.c)).largest,
        .u_dc = measured->u_dc,
        .speed = bounds_magnitude(input->omega_m),
        .tripped = measured->flags & DRIVE_SAMPLE_TRIPPED,
        .bad_sample = measured->good ^ 1u,
        .late = measured->flags & DRIVE_SAMPLE_LATE,
        .medium_late = input->medium_late,
        .encoder_error = measured->flags & DRIVE_SAMPLE_ENCODER,
        .estimate_amplitude = invalid & ESTIMATOR_AMPLITUDE,
        .estimate_detector = invalid & ESTIMATOR_DETECTOR,
        .estimate_current = invalid & ESTIMATOR_CURRENT,
        .estimate_speed = invalid & ESTIMATOR_SPEED,
        .unlocked = input->unlocked,
        .lock_lost = input->failed & MANOEUVRE_LOST,
        .start_stalled = input->failed & MANOEUVRE_STALLED,
        .start_unlocked = input->failed & MANOEUVRE_UNLOCKED,
        .encoder_jump = input->encoder_wrong & ENCODER_WATCH_JUMP,
        .rotor_too_fast = input->too_fast,
        .current_stuck = input->current_faults & CURRENT_WATCH_STUCK,
        .sink_temperature = measured->sink_temperature,
        .motor_temperature = measured->motor_temperature,
        .program_corrupt = input->reported & (GUARD_CORRUPT_PROGRAM | GUARD_CORRUPT_INTERRUPT_CODE),
        .params_corrupt = input->reported & GUARD_CORRUPT_PARAMS,
        .stack_low = input->reported & GUARD_CORRUPT_STACK_END,
        .background_stalled = input->unattended,
        .encoder_direction = input->encoder_wrong & ENCODER_WATCH_DIRECTION,
        .encoder_mismatch = input->encoder_wrong & ENCODER_WATCH_MISMATCH,
        .runaway = input->moves_wrong & MOTION_RUNAWAY,
        .stalled = input->moves_wrong & MOTION_STALLED,
        .speed_error = input->moves_wrong & MOTION_SPEED_ERROR,
        .encoder_lost = input->encoder_lost,
        .current_gain = input->current_faults & CURRENT_WATCH_GAIN,
        .phase_loss = input->current_faults & CURRENT_WATCH_LOSS,
        .current_sum = input->current_faults & CURRENT_WATCH_SUM,
        .motor_overload = input->heat & THERMAL_MOTOR,
        .module_overload = input->heat & THERMAL_MODULE,
        .derating = input->heat & THERMAL_DERATING,
        .dc_ripple = input->link & LINK_RIPPLES,
        .dc_limits = input->link & LINK_LIMITS,
        .loop_slow = input->loops & GUARD_LOOP_SLOW,
        .oscillation = input->loops & GUARD_LOOP_OSCILLATED,
        .master_silent = input->reported & GUARD_MASTER_SILENT,
    };
}

/* Does a row hold? */
#define GUARD_IF_ABOVE(guard, quantity, NAME) ((quantity) > (guard)->tuning.limit[FAULT_LIMIT_##NAME])
#define GUARD_IF_BELOW(guard, quantity, NAME) ((quantity) < (guard)->tuning.limit[FAULT_LIMIT_##NAME])
#define GUARD_IF_HOLDS(guard, quantity, NAME) ((quantity) != 0u)

/* Does any of those with a limit hold; and the bits of all conditions? */
#define GUARD_BEYOND_ABOVE(guard, quantity, NAME) GUARD_IF_ABOVE(guard, quantity, NAME)
#define GUARD_BEYOND_BELOW(guard, quantity, NAME) GUARD_IF_BELOW(guard, quantity, NAME)
#define GUARD_BEYOND_HOLDS(guard, quantity, NAME) false
#define GUARD_SIGN_ABOVE(quantity)                0u
#define GUARD_SIGN_BELOW(quantity)                0u
#define GUARD_SIGN_HOLDS(quantity)                (quantity)

/* Does nothing hold, nor has held, of the rows of this rate? Of `input` only what they compare counts. */
static inline bool guard_is_calm(const guard_t *guard, const guard_input_t *input, fault_rate_t asked)
{
#define FAULT_SIGN(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,        \
                   reaction, text, remedy)                                                                   \
    signs |= FAULT_##rate == asked ? GUARD_SIGN_##comparison(now.quantity) : 0u;
#define FAULT_BEYOND(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,      \
                     reaction, text, remedy)                                                                 \
    || (FAULT_##rate == asked && GUARD_BEYOND_##comparison(guard, now.quantity, NAME))
    const guard_quantities_t now = guard_quantities_of(input);
    uint32_t signs = 0u;
    DRIVE_FAULTS(FAULT_SIGN)
    return signs == 0u && !fault_set_any(guard->holding) && !(false DRIVE_FAULTS(FAULT_BEYOND));
#undef FAULT_BEYOND
#undef FAULT_SIGN
}

#endif
