/* What the fault table's rows compare: a function for each of their quantities, of what the guard is told of
 * a period; and whether any of them holds. For guard.c, and for whoever asks whether it has to be called. */
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

/* A condition holds while its bits are not 0: a whole field of guard_input_t, or some bits. */
#define GUARD_CONDITION(quantity, field)                                                                     \
    static inline uint32_t guard_##quantity(const guard_input_t *input)                                      \
    {                                                                                                        \
        return input->field;                                                                                 \
    }
#define GUARD_BITS(quantity, field, bits)                                                                    \
    static inline uint32_t guard_##quantity(const guard_input_t *input)                                      \
    {                                                                                                        \
        return input->field & (bits);                                                                        \
    }
#define GUARD_NUMBER(quantity, field)                                                                        \
    static inline float guard_##quantity(const guard_input_t *input)                                         \
    {                                                                                                        \
        return input->field;                                                                                 \
    }

/* ---- of the rows that are judged in each period ---- */

/* The largest amount of the three, offsets removed [A]. */
static inline float guard_phase_current(const guard_input_t *input)
{
    const abc_t i = input->measured->current_abc;
    return bounds_span(bounds_magnitude(i.a), bounds_magnitude(i.b), bounds_magnitude(i.c)).largest;
}
GUARD_NUMBER(u_dc, measured->u_dc) /* [V] */
/* Amount, mechanical [rad/s]. */
static inline float guard_speed(const guard_input_t *input)
{
    return bounds_magnitude(input->omega_m);
}
GUARD_BITS(tripped, measured->flags, DRIVE_SAMPLE_TRIPPED) /* the trip zone holds the gates off */
/* Not a number, or a current sensor at its rail. */
static inline uint32_t guard_bad_sample(const guard_input_t *input)
{
    return input->measured->good ^ 1u;
}
GUARD_BITS(late, measured->flags, DRIVE_SAMPLE_LATE) /* this interrupt came too late for its period */
GUARD_CONDITION(medium_late, medium_late)            /* the medium task has missed two windows in a row */
/* Quadrature phase error since the last sample. */
GUARD_BITS(encoder_error, measured->flags, DRIVE_SAMPLE_ENCODER)
/* The estimate in use is lost by this criterion. */
GUARD_BITS(estimate_amplitude, estimate_invalid, ESTIMATOR_AMPLITUDE)
GUARD_BITS(estimate_detector, estimate_invalid, ESTIMATOR_DETECTOR)
GUARD_BITS(estimate_current, estimate_invalid, ESTIMATOR_CURRENT)
GUARD_BITS(estimate_speed, estimate_invalid, ESTIMATOR_SPEED)
GUARD_CONDITION(unlocked, unlocked)           /* a sign of a lost lock stands */
GUARD_BITS(lock_lost, failed, MANOEUVRE_LOST) /* the manoeuvre has failed by this, and the next three */
GUARD_BITS(start_stalled, failed, MANOEUVRE_STALLED)
GUARD_BITS(start_unlocked, failed, MANOEUVRE_UNLOCKED)
GUARD_CONDITION(rotor_too_fast, too_fast)
GUARD_BITS(encoder_jump, encoder_wrong, ENCODER_WATCH_JUMP)    /* the encoder is wrong by this */
GUARD_BITS(current_stuck, current_faults, CURRENT_WATCH_STUCK) /* a sensor is, as current_watch.h says */

/* ---- of the slow rows ---- */

GUARD_NUMBER(sink_temperature, measured->sink_temperature)   /* [degC] */
GUARD_NUMBER(motor_temperature, measured->motor_temperature) /* [degC] */
/* Flash, or its copy in RAM, has changed. */
GUARD_BITS(program_corrupt, reported, GUARD_CORRUPT_PROGRAM | GUARD_CORRUPT_INTERRUPT_CODE)
GUARD_BITS(params_corrupt, reported, GUARD_CORRUPT_PARAMS) /* the active set has changed */
GUARD_BITS(stack_low, reported, GUARD_CORRUPT_STACK_END)   /* the end of the stack was written to */
GUARD_CONDITION(background_stalled, unattended) /* the background has not come round for too long */
GUARD_BITS(encoder_direction, encoder_wrong, ENCODER_WATCH_DIRECTION) /* the encoder is wrong by this */
GUARD_BITS(encoder_mismatch, encoder_wrong, ENCODER_WATCH_MISMATCH)
GUARD_BITS(runaway, moves_wrong, MOTION_RUNAWAY) /* the shaft does not move as it should, by this */
GUARD_BITS(stalled, moves_wrong, MOTION_STALLED)
GUARD_BITS(speed_error, moves_wrong, MOTION_SPEED_ERROR)
GUARD_CONDITION(encoder_lost, encoder_lost) /* the motor goes on without an encoder that was wrong */
GUARD_BITS(current_gain, current_faults, CURRENT_WATCH_GAIN) /* as current_watch.h says, and the next two */
GUARD_BITS(phase_loss, current_faults, CURRENT_WATCH_LOSS)
GUARD_BITS(current_sum, current_faults, CURRENT_WATCH_SUM)
GUARD_BITS(motor_overload, heat, THERMAL_MOTOR) /* by its heat, and the next */
GUARD_BITS(module_overload, heat, THERMAL_MODULE)
GUARD_BITS(derating, heat, THERMAL_DERATING)             /* the limit of the current is lower */
GUARD_BITS(dc_ripple, link, LINK_RIPPLES)                /* of the DC link */
GUARD_BITS(dc_limits, link, LINK_LIMITS)                 /* the DC link limits the torque */
GUARD_BITS(loop_slow, loops, GUARD_LOOP_SLOW)            /* the tracking loop is set too slow */
GUARD_BITS(oscillation, loops, GUARD_LOOP_OSCILLATED)    /* the speed loop oscillated, and was slowed down */
GUARD_BITS(master_silent, reported, GUARD_MASTER_SILENT) /* the master on the line was silent for too long */

#undef GUARD_NUMBER
#undef GUARD_BITS
#undef GUARD_CONDITION

/* Does a row hold? */
#define GUARD_IF_ABOVE(tuning, quantity, NAME) ((quantity) > (tuning)->limit[FAULT_LIMIT_##NAME])
#define GUARD_IF_BELOW(tuning, quantity, NAME) ((quantity) < (tuning)->limit[FAULT_LIMIT_##NAME])
#define GUARD_IF_HOLDS(tuning, quantity, NAME) ((quantity) != 0u)

/* Does any of those with a limit hold; and the bits of all conditions? */
#define GUARD_BEYOND_ABOVE(tuning, quantity, NAME) GUARD_IF_ABOVE(tuning, quantity, NAME)
#define GUARD_BEYOND_BELOW(tuning, quantity, NAME) GUARD_IF_BELOW(tuning, quantity, NAME)
#define GUARD_BEYOND_HOLDS(tuning, quantity, NAME) false
#define GUARD_SIGN_ABOVE(quantity)                 0u
#define GUARD_SIGN_BELOW(quantity)                 0u
#define GUARD_SIGN_HOLDS(quantity)                 (quantity)

/* Does nothing hold, nor has held, of the rows of this rate? Of `input` only what they compare counts. */
static inline bool guard_is_calm(const guard_t *guard, const guard_tuning_t *tuning,
                                 const guard_input_t *input, fault_rate_t asked)
{
#define FAULT_SIGN(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,        \
                   reaction, text, remedy)                                                                   \
    signs |= FAULT_##rate == asked ? GUARD_SIGN_##comparison(guard_##quantity(input)) : 0u;
#define FAULT_BEYOND(number, NAME, name, quantity, comparison, limit_row, margin, rate, debounce, when,      \
                     reaction, text, remedy)                                                                 \
    || (FAULT_##rate == asked && GUARD_BEYOND_##comparison(tuning, guard_##quantity(input), NAME))
    uint32_t signs = 0u;
    DRIVE_FAULTS(FAULT_SIGN)
    return signs == 0u && !fault_set_any(guard->holding) && !(false DRIVE_FAULTS(FAULT_BEYOND));
#undef FAULT_BEYOND
#undef FAULT_SIGN
}

#endif
