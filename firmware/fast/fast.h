/* The fast task, in every PWM period: samples to duties.
 *
 *     samples --> measure --> voltage that acted --> estimator --> frame, demand --> current control
 *                                                    |         --> inverter --> duties
 *                                                    +--> trips: rows of the fault table of each period
 *                                                    +--> sums of the window
 *
 * The fast task follows the setpoint of the window (fast/reference/setpoint.h). It opens the bridge itself,
 * without waiting for the medium task. */
#ifndef FAST_FAST_H
#define FAST_FAST_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/chosen.h"
#include "estimator/encoder.h"
#include "estimator/loop_lean.h"
#include "fast/control/current_control.h"
#include "fast/control/excite.h"
#include "fast/inverter/doubt.h"
#include "fast/inverter/inverter.h"
#include "fast/measure.h"
#include "fast/protect/chopper.h"
#include "fast/protect/link_limit.h"
#include "fast/protect/still_watch.h"
#include "fast/reference/reference.h"
#include "fast/window.h"
#include "guard/guard.h"

/* [periods] from the first duties until the bridge is on and the samples show it. */
#define FAST_ON 4u

/* The bits of the windows among which another one without a new setpoint opens the bridge: two of three. In a
 * single window without one, the last setpoint continues to act. */
#define FAST_LATE_WINDOWS UINT32_C(3)

typedef enum {
    GATES_KEEP, /* no change of the trip zone */
    GATES_ON,   /* release the trip zone once */
    GATES_OFF   /* trip by software */
} drive_gates_t;

typedef struct {
    abc_t duty;       /* [-] 0..1, high time of each leg over the period; acts from t_{k+1} */
    int32_t gates;    /* [-] drive_gates_t */
    uint32_t outputs; /* [-] DRIVE_OUTPUT_... bits, at once */
} drive_command_t;

/* Single values of the tuning. */
typedef struct {
    float jump;    /* least difference from the prediction that counts as a jump of the encoder [rad] */
    float settled; /* largest distance of the encoder's angle behind its prediction by braking [rad] */
    float pole_pairs_inverse; /* 1/p [-] */
    float dc_undervoltage; /* below this link voltage a rotor may feed the link while the bridge is off [V] */
    uint32_t charge_periods; /* [periods] with only the lower switches on, before an upper one may be on */
} fast_limits_t;

typedef struct {
    measure_tuning_t measure;
    guard_tuning_t guard;
    encoder_tuning_t encoder;
    chosen_tuning_t estimator;
    loop_lean_tuning_t lean;
    inverter_tuning_t inverter;
    doubt_tuning_t doubt;
    current_control_tuning_t current_control;
    reference_tuning_t reference;
    link_limit_tuning_t link;
    chopper_tuning_t chopper;
    still_watch_tuning_t still_watch;
    fast_limits_t limits;
} fast_tuning_t;

/* Output of the encoder at t_k. */
typedef struct {
    position_t position;
    frame_t frame; /* the same as a frame, computed while control uses the encoder */
} fast_shaft_t;

/* The outputs other than the gates. */
typedef struct {
    uint32_t permitted; /* [-] DRIVE_OUTPUT_... bits that may be on */
    uint32_t chops;     /* [-] 1: the link voltage requires the chopper */
} fast_outputs_t;

typedef struct {
    uint32_t on;       /* [periods] since the first duties went out, up to FAST_ON; 0: the bridge is off */
    uint32_t charging; /* [periods] for which only the lower switches remain on */
    uint32_t runs;     /* [-] 1: a sample has shown that the gates are on and the charging has ended */
    uint32_t open; /* [-] 1: the bridge stays off until a setpoint of window open_since or later has the gates
                      off */
    uint32_t open_since; /* [windows] number of the window that contains the reason */
    fast_outputs_t outputs;
} fast_bridge_t;

/* Data from the medium task. */
typedef struct {
    uint32_t fresh;   /* [-] 1: the next period is the first one of a setpoint */
    uint32_t late;    /* [-] a bit for each window, the newest is bit 0; 1: it had no new setpoint */
    uint32_t overdue; /* [-] 1: two of the last three windows had none */
} fast_given_t;

/* Current and voltage in the frame of the demand. */
typedef struct {
    dq_t current;     /* [A] at t_k */
    dq_t voltage;     /* [V] that the inverter will apply, losses of the dead time included */
    uint32_t limited; /* [-] 1: this voltage is less than the current control requires */
    excite_t excite;  /* in place of current control, while the motor is commissioned */
} fast_control_t;

/* Data of the present window other than its sums. */
typedef struct {
    uint32_t number;     /* [windows] closed before this one */
    int32_t calibration; /* [-] calibration_t of the last period */
    uint32_t offsets;    /* [-] 1: the offsets were measured again in this window */
    window_report_t window;
} fast_report_t;

typedef struct {
    uint32_t period; /* [periods] the clock of the drive */
    fast_shaft_t shaft;
    fast_bridge_t bridge;
    fast_given_t given;
    uint32_t estimating;    /* [-] 1: the estimator runs */
    inverter_acted_t acted; /* in [t_{k-1}, t_k), input of the estimator */
    frame_t rotor;          /* estimated, at t_k */
    float omega_m;          /* [rad/s] mechanical, of the rotor */
    demand_t demand;        /* with the present frame */
    fast_control_t control;
    float load_current; /* part of i_q that carries the load and does not accelerate [A] */
    bounds_t bounds;    /* present limits of i_q by heat and DC link [A] */
    drive_command_t command;

    measure_t measure;
    encoder_t encoder;
    inverter_t inverter;
    doubt_t doubt;
    chosen_t estimator;
    reference_t reference;
    current_control_t current_control;
    link_limit_t link;
    still_watch_t still_watch;
    guard_t trips; /* the rows of the fault table that are judged in each period */

    window_sums_t sum; /* of the present window */
    fast_report_t report;
} fast_t;

/* Tuning and setpoint of a period. Each change of them has a period of its own: the first one of a window
 * takes over the setpoint, the second one a tuning, and the last one closes the window. */
typedef struct {
    const fast_tuning_t *tuning;
    const setpoint_t *setpoint;
} fast_orders_t;

/* Clears all state and sets these orders. */
void fast_init(fast_t *fast, fast_orders_t orders);

/* The end of a window: the next period begins with another setpoint than `before`. The next period itself
 * takes it over, because this period has already closed a window. This function only does the work that
 * needs the previous setpoint, or that must be done before a possible trip. */
void fast_turn(fast_t *fast, const setpoint_t *setpoint, const setpoint_t *before);

/* Continues with the tuning of these orders in place of `before`. */
void fast_take_tuning(fast_t *fast, fast_orders_t orders, const fast_tuning_t *before);

/* One period. `opens` [-] is a reason_t that the medium task has found since its last setpoint: if it is not
 * REASON_NONE, the bridge opens at once. The run time is bounded and no libm function is used. Observer and
 * modulator have one division each, and a limited voltage needs one more. */
void fast_step(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples, int32_t opens,
               drive_command_t *command);

/* The last period of a window: writes its `window` for this setpoint. fast_turn() has to follow. */
void fast_close(fast_t *fast, const setpoint_t *setpoint, window_t *window);

/* The last period of a window while the medium task still reads the previous one: the sums are lost, those of
 * the next window are not sound, because the time between both is unknown, and the present setpoint continues
 * to act. */
void fast_miss(fast_t *fast);

/* Opens the bridge at once, for this reason. */
void fast_stop(fast_t *fast, int32_t reason);

/* true: the gates are on or will come on with the duties that went out. */
static inline bool fast_bridge_on(const fast_t *fast)
{
    return fast->bridge.on != 0u;
}

#endif
