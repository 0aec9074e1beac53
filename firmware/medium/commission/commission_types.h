/* Types that the steps of commissioning share: their inputs, their state, the limits, the results, and the
 * reasons.
 */
#ifndef MEDIUM_COMMISSION_COMMISSION_TYPES_H
#define MEDIUM_COMMISSION_COMMISSION_TYPES_H

#include <stdbool.h>
#include <stdint.h>

#include "fast/control/excite.h"
#include "math/frames.h"

/* The reasons for which a step ends without a result: R(NAME, "|name", "what happened", "what to do"). Append
 * only: the numbers are those of the signal `commission_reason`, and the joined names are its choices. */
#define COMMISSION_REASONS(R)                                                                                \
    R(NONE, "none", "nothing is wrong", "nothing to do")                                                     \
    R(NOISE, "|noise", "a current sensor is noisier than three steps of its converter",                      \
      "screen the cables of the current sensors, check their ground")                                        \
    R(LINK_LOW, "|link_low", "the DC link is below dc_undervoltage", "check supply and precharge")           \
    R(ZERO_VECTOR_CURRENT, "|zero_vector_current",                                                           \
      "a current flows with all three legs at the same voltage",                                             \
      "wait until the rotor stands; check the gates")                                                        \
    R(ROTOR_TURNS, "|rotor_turns", "the answers to opposite pulses do not cancel: the rotor turns",          \
      "wait until the rotor stands, or brake it")                                                            \
    R(NO_MOTOR_CURRENT, "|no_motor_current", "no current flows at a quarter of the DC-link voltage",         \
      "connect the motor; check contactor and wires")                                                        \
    R(OPEN_PHASE, "|open_phase", "a phase carries no current", "check the wire of the phase that is named")  \
    R(SENSOR_MAP, "|sensor_map", "the current sensors are not on their phases, or have the wrong sign",      \
      "exchange the signals of the sensors, or the sign, as named")                                          \
    R(RIPPLE_TOO_LARGE, "|ripple_too_large", "the ripple of the current exceeds 0.6 of the largest current", \
      "use a choke, a lower DC-link voltage or a faster carrier")                                            \
    R(HEAT_LIMIT_TOO_LOW, "|heat_limit_too_low", "the permitted steady current is below 0.5 A",              \
      "raise motor_current_continuous, if the motor permits it")                                             \
    R(NO_STEADY_CURRENT, "|no_steady_current", "the current or its voltage did not settle",                  \
      "hold the shaft free of any drive; check the wiring")                                                  \
    R(ROTOR_SWINGS, "|rotor_swings", "the rotor still swings about the current vector",                      \
      "add friction, or hold the shaft")                                                                     \
    R(SENSOR_GAIN, "|sensor_gain",                                                                           \
      "R differs between the directions by more than 2 %, or the gains of two sensors by 3.5 %",             \
      "check the gains of the current sensors")                                                              \
    R(INDUCTANCE_IMPLAUSIBLE, "|inductance_implausible", "the measured inductance is not possible",          \
      "check the wiring; repeat with less current")                                                          \
    R(TIME_CONSTANT_SHORT, "|time_constant_short", "L/R is shorter than two periods",                        \
      "use a faster carrier or a choke")                                                                     \
    R(ALIGNMENT_UNSTABLE, "|alignment_unstable", "the rotor leaves the direction of the current",            \
      "repeat with less current")                                                                            \
    R(ROTOR_NOT_TURNING, "|rotor_not_turning", "the rotor does not follow the current",                      \
      "release the brake, uncouple the load, or permit more current")                                        \
    R(EMF_TOO_SMALL, "|emf_too_small", "the back-EMF of the motion is too small to be measured",             \
      "permit more speed; in the step swing, more current")                                                  \
    R(SENSORLESS_LOST, "|sensorless_lost", "the drive lost the rotor, or did not reach the speed",           \
      "uncouple the load; permit more current")                                                              \
    R(INERTIA_NOT_SEEN, "|inertia_not_seen", "the torque test gave no J, or another one than the swing",     \
      "uncouple the load, and repeat")                                                                       \
    R(TIME_OUT, "|time_out", "the step exceeded its largest time", "repeat the step")                        \
    R(EARLIER_STEP, "|earlier_step", "the step needs the result of an earlier one",                          \
      "run the steps in their order")                                                                        \
    R(BRIDGE_OPENED, "|bridge_opened", "the bridge was switched off during the step",                        \
      "read fault_reason; then repeat the step")                                                             \
    R(CURRENT_LOOP, "|current_loop",                                                                         \
      "the gain of the current loop differs from its design by more than 12 %",                              \
      "repeat the step inductance; check the gains of the current sensors")                                  \
    R(NO_STANDSTILL_ANGLE, "|no_standstill_angle",                                                           \
      "L does not show the direction of the magnets: the rotor followed the current, or its iron does not "  \
      "saturate",                                                                                            \
      "hold the shaft, or let it turn and run the other steps")                                              \
    R(SENSOR_STUCK, "|sensor_stuck", "a current sensor does not change with the current of its phase",       \
      "check supply and cable of the sensor that is named")                                                  \
    R(TRIP_FAILED, "|trip_failed", "the trip zone does not hold the gates off while the bridge is off",      \
      "do not switch on; check the control board")

typedef enum {
#define COMMISSION_REASON(NAME, name, text, remedy) COMMISSION_REASON_##NAME,
    COMMISSION_REASONS(COMMISSION_REASON)
#undef COMMISSION_REASON
} commission_reason_t;
#define COMMISSION_REASON_NAME(NAME, name, text, remedy) name
#define COMMISSION_REASON_NAMES                          COMMISSION_REASONS(COMMISSION_REASON_NAME)

/* State of a step after a window. */
typedef struct {
    uint32_t finished; /* [-] 1: the step has ended */
    int32_t reason;    /* [-] commission_reason_t; NONE: with a result */
    int32_t detail;    /* [-] open_phase: 1 to 3; sensor_map: wiring_code(); noise, sensor_stuck: 1 or 2;
                           no_standstill_angle: 1 or 2, see angle_step.h; else 0 */
} commission_verdict_t;

static inline commission_verdict_t commission_goes_on(void)
{
    return (commission_verdict_t){0u, (int32_t)COMMISSION_REASON_NONE, 0};
}

static inline commission_verdict_t commission_finished(void)
{
    return (commission_verdict_t){1u, (int32_t)COMMISSION_REASON_NONE, 0};
}

static inline commission_verdict_t commission_failed(commission_reason_t reason, int32_t detail)
{
    return (commission_verdict_t){1u, (int32_t)reason, detail};
}

/* The limits, from the parameters. */
typedef struct {
    float current_max;  /* largest current [A] */
    float current_hold; /* largest current of a standing motor, by its heat [A] */
    float pole_pairs;   /* p [-] */
    float undervoltage; /* least DC link [V] */
    float noise_max;    /* largest standard deviation of a current sensor [A] */
    float period;       /* T [s] */
    float window;       /* of the medium task [s] */
    float inductance_d; /* of the parameters, for the turning steps [H] */
    float inductance_q; /* without current [H] */
    float observed_q;   /* the constant L_q of the observer: another one if the q axis saturates [H] */
    float saturation;   /* I_s of the q axis; 0: none [A] */
    float flux_linkage; /* [Wb] */
    float inertia;      /* [kg m^2] */
    float loop_gain;    /* K_0 of the current loop: its bandwidth times T [-] */
    float edge_delay;   /* mean delay of the two edges of a leg after their commands [s] */
} commission_tuning_t;

/* A measured point of a step, for its picture:
 *
 *     resistance   current along the axis [A], voltage along it [V]
 *     inductance   amplitude of the current along d, or minus that along q [A], L [H]
 *     swing        number of the jump [-], psi_f [Wb]
 *     flux         electrical speed [rad/s], EMF [V]
 *     inertia      torque [N m], acceleration [rad/s^2] */
typedef struct {
    float x, y;
} commission_point_t;

/* The results; 0: not measured yet. */
typedef struct {
    commission_point_t point; /* the newest one */
    float noise;              /* largest standard deviation of a current sensor [A] */
    float inductance_pulse;   /* first value of L, by the pulses [H] */
    float resistance;         /* winding and devices [ohm] */
    float resistance_spread;  /* largest difference between two directions, relative [-] */
    float dead_voltage;       /* loss of a leg whose sign is certain [V] */
    float current_zone;       /* half width of the passage of a leg's loss through zero current [A] */
    float current_hold;       /* I_h: largest current of the standing motor [A] */
    float current_aligned;    /* at which the step `inductance` found the rotor aligned, at most I_h [A] */
    float inductance_d;       /* incremental, at 0.6 I_h [H] */
    float inductance_d_least; /* the same at I_h [H] */
    float inductance_q;       /* without current [H] */
    float saturation_current; /* I_s of the q axis; SINE_LINEAR: it does not saturate [A] */
    float loop_gain;          /* gain of the current loop over its design [-] */
    float angle_d;            /* direction of the d axis of a held rotor, electrical [rad] */
    float flux_first;         /* first value of psi_f, by the swing [Wb] */
    float inertia_first;      /* first value of J, by the swing [kg m^2] */
    float flux_linkage;       /* psi_f [Wb] */
    float flux_scatter;       /* standard deviation of its parts, relative [-] */
    float inertia;            /* J [kg m^2] */
    float inertia_scatter;    /* standard error of the regression, relative [-] */
    float friction_coulomb;   /* [N m] */
    float friction_viscous;   /* [N m s/rad] */
} commission_results_t;

/* A window, for the standing steps. */
typedef struct {
    const excite_seen_t *seen;
    abc_t current_abc; /* sample at its end [A] */
    ab_t current;      /* the same [A] */
    float u_dc;        /* [V] */
    uint32_t tripped;  /* [-] 1: the trip zone holds the gates off */
} commission_input_t;

/* Means over windows, in the frame of the axis. */
typedef struct {
    dq_t voltage;  /* sum [V] */
    dq_t current;  /* sum [A] */
    float periods; /* [periods] */
} commission_mean_t;

static inline void commission_mean_begin(commission_mean_t *mean)
{
    *mean = (commission_mean_t){{0.0f, 0.0f}, {0.0f, 0.0f}, 0.0f};
}

static inline void commission_mean_add(commission_mean_t *mean, const excite_seen_t *seen)
{
    mean->voltage.d += seen->voltage.d;
    mean->voltage.q += seen->voltage.q;
    mean->current.d += seen->current.d;
    mean->current.q += seen->current.q;
    mean->periods += (float)seen->periods;
}

/* [A] and [V]; a sum without a period is zero. */
static inline dq_t commission_mean_of(const commission_mean_t *mean, dq_t sum)
{
    const float share = mean->periods > 0.0f ? 1.0f / mean->periods : 0.0f;
    return (dq_t){share * sum.d, share * sum.q};
}

#endif
