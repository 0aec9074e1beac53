/* The drive: one step per PWM period turns samples into a command. State machine, offset calibration,
 * protection, position, speed and current control, modulation. Pure: no registers, no globals.
 *
 * Timing (design): the step of period k gets the currents and the encoder at t_k; the duties it returns act
 * on [t_{k+1}, t_{k+2}). The dq voltage is therefore turned into the stationary frame at theta_e + 1.5 T_s
 * omega_e, and the estimator gets the duties of two steps ago: their voltage less what dead time and drops
 * took of it at the mean of the currents at t_{k-1} and t_k.
 *
 * Position: the encoder or the estimator, as position_source says. The estimator runs whenever the bridge is
 * on; it starts from the encoder's angle, which stands for the start that a drive without one needs.
 *
 * States carry the names of DS-402:
 *   not ready           current offsets are being measured, gates off
 *   ready               gates off, waiting for `enable` = on
 *   switched on         two periods: control preset to the turning rotor, gates coming on
 *   operation enabled   the motor follows the references
 *   quick stop          speed reference zero until standstill, then ready
 *   fault               gates off until fault_reset, then not ready
 */
#ifndef DRIVE_DRIVE_H
#define DRIVE_DRIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "adapt/flux.h"
#include "control/current_control.h"
#include "control/dead_time.h"
#include "control/offset_trim.h"
#include "control/speed_control.h"
#include "control/svpwm.h"
#include "drive/params.h"
#include "drive/protection.h"
#include "drive/requests.h"
#include "estimator/chosen.h"
#include "estimator/encoder.h"
#include "estimator/position.h"
#include "math/frames.h"

typedef enum {
    DRIVE_NOT_READY,
    DRIVE_READY,
    DRIVE_SWITCHED_ON,
    DRIVE_OPERATION_ENABLED,
    DRIVE_QUICK_STOP,
    DRIVE_FAULT
} drive_state_t;
#define DRIVE_STATE_NAMES "not_ready|ready|switched_on|operation_enabled|quick_stop|fault"

#define DRIVE_SAMPLE_TRIPPED    UINT32_C(1) /* the trip zone holds the gates off */
#define DRIVE_SAMPLE_FAULT_LINE UINT32_C(2) /* the power module pulls its fault line now */
#define DRIVE_SAMPLE_ENCODER    UINT32_C(4) /* quadrature phase error since the last sample */
#define DRIVE_SAMPLE_LATE       UINT32_C(8) /* this period's interrupt came too late */

/* What a sensor that the board has not reads: no temperature there is [degC]. */
#define DRIVE_NO_TEMPERATURE (-273.15f)

typedef struct {
    float i_a;               /* [A] phase currents at t_k, as the sensors say, positive into the motor */
    float i_b;               /* [A] */
    float i_c;               /* [A] with two sensors minus the sum of the others */
    float u_dc;              /* [V] DC link */
    float sink_temperature;  /* [degC] DRIVE_NO_TEMPERATURE without a sensor, this one and the next */
    float motor_temperature; /* [degC] */
    uint32_t encoder;        /* [counts] 0 .. 4 encoder_lines - 1, at t_k */
    uint32_t flags;          /* [-] DRIVE_SAMPLE_... */
} drive_samples_t;

typedef enum {
    GATES_KEEP, /* leave the trip zone as it is */
    GATES_ON,   /* release the trip, this once */
    GATES_OFF   /* trip by software */
} drive_gates_t;

typedef struct {
    abc_t duty;    /* [-] 0..1, high time of each leg over the period; acts from t_{k+1} */
    int32_t gates; /* [-] drive_gates_t */
} drive_command_t;

/* What the drive saw when it stopped: the first fault freezes it, later ones only add their bits. */
typedef struct {
    int32_t reason;  /* [-] reason_t; REASON_NONE: no fault since start or reset */
    uint32_t period; /* [periods] when */
    uint32_t later;  /* [-] bits of protection_step that came after it */
    float i_a, i_b;  /* [A] */
    float u_dc;      /* [V] */
    float theta_e;   /* [rad] */
    float omega_e;   /* [rad/s] */
} drive_fault_t;

/* A sample inside these is a measurement, and nothing breaks a limit: nothing asks for a closer look. */
typedef struct {
    float current;           /* [A] of each phase current's amount, offsets removed */
    float u_dc_middle;       /* [V] */
    float u_dc_half;         /* [V] of the distance from the middle */
    float sink_temperature;  /* [degC] of its amount */
    float motor_temperature; /* [degC] of its amount */
    float omega_m;           /* [rad/s] of its amount, mechanical: no overspeed */
} drive_calm_t;

typedef struct {
    /* coefficients, made from the active parameters */
    drive_calm_t calm;
    float duty_min;           /* [-] */
    float duty_max;           /* [-] */
    float pole_pairs;         /* [-] */
    float pole_pairs_inverse; /* [-] */
    float calibration_weight; /* [-] 1 / calibration_periods */
    uint32_t doubt_periods;   /* [periods] for which the EMF filter remembers a doubtful voltage */

    /* modules */
    encoder_t encoder;
    chosen_t estimator;
    flux_t flux;
    offset_trim_t offset_trim;
    speed_control_t speed_control;
    current_control_t current_control;
    dead_time_t dead_time;       /* what the modulator compensates */
    dead_time_t dead_time_model; /* what the inverter takes: all of it, whatever share is compensated */
    protection_t protection;

    /* from outside */
    requests_t requests;

    /* state machine */
    int32_t state;            /* [-] drive_state_t */
    int32_t refusal;          /* [-] reason_t: why a wish is not obeyed now */
    uint32_t period;          /* [periods] the one clock */
    uint32_t state_periods;   /* [periods] since the state was entered */
    uint32_t clear_periods;   /* [periods] since the last sign of a fault */
    int32_t fault_reset_seen; /* [-] last value of the request, for its edge */
    uint32_t stopped;         /* [-] 1: quick stop is done; `enable` must go off before the next start */
    drive_fault_t fault;

    /* signals of this period */
    abc_t current_abc;           /* [A] offsets removed */
    abc_t offset;                /* [A] measured at zero current */
    ab_t current_ab;             /* [A] */
    ab_t current_ab_prev;        /* [A] one period ago */
    dq_t current;                /* [A] */
    dq_t current_ref;            /* [A] */
    dq_t voltage_ref;            /* [V] what the current control asked for */
    dq_t voltage;                /* [V] what the modulator will really apply, dead time accounted for */
    position_t position;         /* at t_k, what the control uses */
    position_t estimate;         /* at t_k, of the estimator */
    position_t encoder_position; /* at t_k, of the encoder */
    ab_t observer_voltage;       /* [V] on the winding in [t_{k-1}, t_k) */
    ab_t duty_prev[2];           /* [-] duties in the stationary frame, of one and two steps ago */
    float u_dc_prev;             /* [V] one period ago */
    uint32_t estimating;         /* [-] 1: the estimator runs */
    uint32_t doubt;              /* [periods] for which the tracking loop still coasts */
    float omega_m;               /* [rad/s] mechanical */
    float omega_m_ref;           /* [rad/s] mechanical */
    float u_dc;                  /* [V] */
    float sink_temperature;      /* [degC] */
    float motor_temperature;     /* [degC] */
    uint32_t encoder_count;      /* [counts] */
    uint32_t sample_flags;       /* [-] DRIVE_SAMPLE_... */
    drive_command_t command;

    /* the active parameters: last, since the interrupt reads few of them and the rest is then within reach */
    params_t params;
} drive_t;

/* All state zero, in not ready, requests off. The set must be good (checked). */
void drive_init(drive_t *drive, const params_t *params);

/* Take over a set of parameters between two periods; control states are kept, so a running drive goes on
 * smoothly. false: nothing has changed and `why` says what was wrong (params_check, or params_check_live
 * while the bridge is on). */
bool drive_apply(drive_t *drive, const params_t *next, params_error_t *why);

/* Take over a set of requests between two periods. false: nothing has changed and `why` says what was wrong.
 */
bool drive_request(drive_t *drive, const requests_t *next, params_error_t *why);

/* One period, in the interrupt. Bounded, no libm; one division (the modulator's), two when the voltage is
 * limited. */
void drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);

/* From the trip interrupt: the hardware has shut the gates. Goes to fault at once if the bridge was on; a
 * power module that pulls its line while the gates are off anyway (its supply comes up) is no fault. */
void drive_trip(drive_t *drive);

/* Latch a fault from outside the step: the board did not come up. */
void drive_stop(drive_t *drive, int32_t reason);

/* Are the gates on, or coming on? */
bool drive_bridge_on(const drive_t *drive);

#endif
