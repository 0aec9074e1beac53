/* Quantities of the rows of the fault table: one function of guard_input_t for each. guard_is_calm() finds
 * whether no row holds, so that the caller can omit the guard's step. */
#ifndef GUARD_GUARD_QUANTITIES_H
#define GUARD_GUARD_QUANTITIES_H

#include <stdbool.h>

#include "estimator/chosen.h"
#include "fast/measure.h"
#include "guard/guard.h"
#include "math/bounds.h"
#include "medium/manoeuvre/manoeuvres.h"
#include "medium/protect/chopper_watch.h"
#include "medium/protect/current_watch.h"
#include "medium/protect/encoder_watch.h"
#include "medium/protect/link_watch.h"
#include "medium/protect/motion_watch.h"
#include "medium/protect/thermal.h"

/* The largest amount of the phase currents, offsets removed [A]. */
static inline float guard_phase_current(const guard_input_t *input)
{
    const abc_t i = input->measured->current_abc;
    return bounds_span(bounds_magnitude(i.a), bounds_magnitude(i.b), bounds_magnitude(i.c)).largest;
}

/* Amount, mechanical [rad/s]. */
static inline float guard_speed(const guard_input_t *input)
{
    return bounds_magnitude(input->omega_m);
}

/* The sample is not finite, or a current sensor is at its limit. */
static inline uint32_t guard_bad_sample(const guard_input_t *input)
{
    return input->measured->good ^ 1u;
}

/* All other quantities. NUMBER: a number in the unit of its limit. WHOLE, BITS: a condition that holds while
 * a field of guard_input_t, or some bits of it, are not 0. */
#define GUARD_QUANTITIES(NUMBER, WHOLE, BITS)                                                                \
    /* rows that are judged in each period */                                                                \
    NUMBER(u_dc, measured->u_dc)                         /* [V] */                                           \
    BITS(tripped, measured->flags, DRIVE_SAMPLE_TRIPPED) /* the trip zone holds the gates off */             \
    BITS(late, measured->flags, DRIVE_SAMPLE_LATE_OFTEN) /* too many interrupts came too late */             \
    WHOLE(medium_late, medium_late) /* the medium task has missed two consecutive windows */                 \
    /* quadrature phase error since the last sample */                                                       \
    BITS(encoder_error, measured->flags, DRIVE_SAMPLE_ENCODER)                                               \
    /* the estimate in use is not valid by this criterion */                                                 \
    BITS(estimate_amplitude, found->estimate_invalid, ESTIMATOR_AMPLITUDE)                                   \
    BITS(estimate_detector, found->estimate_invalid, ESTIMATOR_DETECTOR)                                     \
    BITS(estimate_current, found->estimate_invalid, ESTIMATOR_CURRENT | ESTIMATOR_SAMPLE)                    \
    BITS(estimate_speed, found->estimate_invalid, ESTIMATOR_SPEED)                                           \
    WHOLE(unlocked, found->unlocked) /* there is a sign of a lost lock */                                    \
    BITS(lock_lost, found->failed,                                                                           \
         MANOEUVRE_LOST) /* criterion of a failed manoeuvre, also the next three */                          \
    BITS(start_stalled, found->failed, MANOEUVRE_STALLED)                                                    \
    BITS(start_unlocked, found->failed, MANOEUVRE_UNLOCKED)                                                  \
    WHOLE(rotor_too_fast, found->too_fast)                                                                   \
    BITS(encoder_jump, encoder_wrong, ENCODER_WATCH_JUMP)           /* criterion of a wrong encoder */       \
    BITS(current_stuck, found->current_faults, CURRENT_WATCH_STUCK) /* a sensor fault of current_watch.h */  \
    /* rows that are judged once per window */                                                               \
    NUMBER(sink_temperature, measured->sink_temperature)   /* [degC] */                                      \
    NUMBER(motor_temperature, measured->motor_temperature) /* [degC] */                                      \
    /* flash, or its copy in RAM, has changed */                                                             \
    BITS(program_corrupt, found->reported, GUARD_CORRUPT_PROGRAM | GUARD_CORRUPT_INTERRUPT_CODE)             \
    BITS(params_corrupt, found->reported, GUARD_CORRUPT_PARAMS) /* the active set has changed */             \
    BITS(stack_low, found->reported, GUARD_CORRUPT_STACK_END)   /* the end of the stack was written to */    \
    WHOLE(background_stalled, found->unattended) /* the background has not run for too long */               \
    BITS(encoder_direction, encoder_wrong, ENCODER_WATCH_DIRECTION) /* criterion of a wrong encoder */       \
    BITS(encoder_mismatch, encoder_wrong, ENCODER_WATCH_MISMATCH)                                            \
    BITS(runaway, found->moves_wrong, MOTION_RUNAWAY) /* criterion of a wrong motion of the shaft */         \
    BITS(stalled, found->moves_wrong, MOTION_STALLED)                                                        \
    BITS(speed_error, found->moves_wrong, MOTION_SPEED_ERROR)                                                \
    WHOLE(encoder_lost, found->encoder_lost) /* the motor continues without an encoder that was wrong */     \
    BITS(current_gain, found->current_faults,                                                                \
         CURRENT_WATCH_GAIN) /* fault of current_watch.h, also the next two */                               \
    BITS(phase_loss, found->current_faults, CURRENT_WATCH_LOSS)                                              \
    BITS(current_sum, found->current_faults, CURRENT_WATCH_SUM)                                              \
    BITS(motor_overload, found->heat, THERMAL_MOTOR) /* thermal limit, also the next */                      \
    BITS(module_overload, found->heat, THERMAL_MODULE)                                                       \
    BITS(derating, found->heat, THERMAL_DERATING)  /* the current limit is reduced */                        \
    BITS(dc_ripple, found->link, LINK_RIPPLES)     /* ripple of the DC link */                               \
    BITS(dc_limits, found->link, LINK_LIMITS)      /* the DC link limits the torque */                       \
    BITS(loop_slow, found->loops, GUARD_LOOP_SLOW) /* the tracking loop is configured too slow */            \
    BITS(oscillation, found->loops,                                                                          \
         GUARD_LOOP_OSCILLATED) /* the speed loop oscillated and was slowed down */                          \
    BITS(chopper_overload, found->chopper, CHOPPER_OVERLOAD) /* the brake resistor, also the next */         \
    BITS(chopper_no_effect, found->chopper, CHOPPER_NO_EFFECT)                                               \
    WHOLE(brake_torque, found->brake_torque) /* the torque for releasing the brake is missing */             \
    /* the master of the serial link was silent for too long */                                              \
    BITS(master_silent, found->reported, GUARD_MASTER_SILENT)

#define GUARD_NUMBER_OF(quantity, field)                                                                     \
    static inline float guard_##quantity(const guard_input_t *input)                                         \
    {                                                                                                        \
        return input->field;                                                                                 \
    }
#define GUARD_WHOLE_OF(quantity, field)                                                                      \
    static inline uint32_t guard_##quantity(const guard_input_t *input)                                      \
    {                                                                                                        \
        return input->field;                                                                                 \
    }
#define GUARD_BITS_OF(quantity, field, bits)                                                                 \
    static inline uint32_t guard_##quantity(const guard_input_t *input)                                      \
    {                                                                                                        \
        return input->field & (bits);                                                                        \
    }
GUARD_QUANTITIES(GUARD_NUMBER_OF, GUARD_WHOLE_OF, GUARD_BITS_OF)

/* Conditions for which a row holds. */
#define GUARD_IF_ABOVE(tuning, quantity, NAME) ((quantity) > (tuning)->limit[FAULT_LIMIT_##NAME])
#define GUARD_IF_BELOW(tuning, quantity, NAME) ((quantity) < (tuning)->limit[FAULT_LIMIT_##NAME])
#define GUARD_IF_HOLDS(tuning, quantity, NAME) ((quantity) != 0u)

/* Conditions over all rows: one with a limit is exceeded, and the bits of all conditions. */
#define GUARD_BEYOND_ABOVE(tuning, quantity, NAME) GUARD_IF_ABOVE(tuning, quantity, NAME)
#define GUARD_BEYOND_BELOW(tuning, quantity, NAME) GUARD_IF_BELOW(tuning, quantity, NAME)
#define GUARD_BEYOND_HOLDS(tuning, quantity, NAME) false
#define GUARD_SIGN_ABOVE(quantity)                 0u
#define GUARD_SIGN_BELOW(quantity)                 0u
#define GUARD_SIGN_HOLDS(quantity)                 (quantity)

/* true: no row of this rate holds or has held. Only the fields of `input` that these rows compare are
 * read. */
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
