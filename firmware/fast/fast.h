/* The fast task, every PWM period: samples to duties.
 *
 *     samples --> measure --> what acted --> estimator --> frame, demand --> current control --> inverter:
 * duties
 *                                                     --> trips: the rows of the fault table that wait for
 * nobody
 *                                                     --> sums of the window
 *
 * It obeys the setpoint of the window (fast/reference/setpoint.h), and opens the bridge without asking
 * anybody. */
#ifndef FAST_FAST_H
#define FAST_FAST_H

#include <stdbool.h>
#include <stdint.h>

#include "estimator/chosen.h"
#include "estimator/encoder.h"
#include "fast/control/current_control.h"
#include "fast/inverter/doubt.h"
#include "fast/inverter/inverter.h"
#include "fast/measure.h"
#include "fast/protect/link_limit.h"
#include "fast/protect/still_watch.h"
#include "fast/reference/reference.h"
#include "fast/window.h"
#include "guard/guard.h"

/* [periods] after which a bridge that comes on is on, and its samples show it. */
#define FAST_ON 4u

/* Bits of what is new in the first period of a window. */
#define FAST_FRESH_SETPOINT UINT32_C(1)
#define FAST_FRESH_TUNING   UINT32_C(2)

/* [windows] without a new setpoint after which the bridge opens: for one the last setpoint goes on acting. */
#define FAST_LATE_WINDOWS 2u

typedef enum {
    GATES_KEEP, /* leave the trip zone as it is */
    GATES_ON,   /* release the trip, this once */
    GATES_OFF   /* trip by software */
} drive_gates_t;

typedef struct {
    abc_t duty;    /* [-] 0..1, high time of each leg over the period; acts from t_{k+1} */
    int32_t gates; /* [-] drive_gates_t */
} drive_command_t;

/* Single numbers of the tuning. */
typedef struct {
    float jump;               /* of the encoder's angle in a period, that no rotor makes [rad] */
    float pole_pairs_inverse; /* 1/p [-] */
    float dc_undervoltage;    /* below it a rotor may feed the link with the bridge off [V] */
    uint32_t smooth;          /* [-] 1: the speed is that without the loop's proportional part */
    uint32_t charge_periods;  /* [periods] of the lower switches before an upper one may be on */
} fast_limits_t;

typedef struct {
    measure_tuning_t measure;
    guard_tuning_t guard;
    encoder_tuning_t encoder;
    chosen_tuning_t estimator;
    inverter_tuning_t inverter;
    doubt_tuning_t doubt;
    current_control_tuning_t current_control;
    reference_tuning_t reference;
    link_limit_tuning_t link;
    still_watch_tuning_t still_watch;
    fast_limits_t limits;
} fast_tuning_t;

/* What the encoder says at t_k. */
typedef struct {
    position_t position;
    frame_t frame; /* the same, while control turns with it */
} fast_shaft_t;

typedef struct {
    uint32_t on;         /* [periods] since the first duties went out, up to FAST_ON; 0: it is off */
    uint32_t charging;   /* [periods] for which the lower switches are still on alone */
    uint32_t runs;       /* [-] 1: a sample has shown the gates on, the lower switches not alone */
    uint32_t open;       /* [-] 1: it stays open until a setpoint that knows why, with the gates off */
    uint32_t open_since; /* [windows] number of the window that has the reason */
} fast_bridge_t;

/* What the medium task gives. */
typedef struct {
    uint32_t fresh; /* [-] FAST_FRESH_...: what the next period begins with */
    uint32_t late;  /* [windows] without a break, for which no new setpoint was there */
} fast_given_t;

/* In the frame of the demand. */
typedef struct {
    dq_t current;     /* [A] at t_k */
    dq_t voltage;     /* [V] what the inverter will really apply, dead time accounted for */
    uint32_t limited; /* [-] 1: that is less than what the current control requires */
} fast_control_t;

/* What the window under way will say beside its sums. */
typedef struct {
    uint32_t number;     /* [windows] closed before it */
    int32_t calibration; /* [-] calibration_t of the last period */
    uint32_t offsets;    /* [-] 1: the offsets were measured anew in this window */
    fault_set_t failed;  /* fast rows of the fault table that have failed in this window */
    int32_t left;        /* [-] jump_reaction_t of this window */
    drive_fault_t stop;  /* by which the bridge was opened in this window */
} fast_report_t;

typedef struct {
    uint32_t period; /* [periods] the one clock */
    fast_shaft_t shaft;
    fast_bridge_t bridge;
    fast_given_t given;
    uint32_t estimating;    /* [-] 1: the estimator runs */
    inverter_acted_t acted; /* in [t_{k-1}, t_k), as the estimator got it */
    frame_t rotor;          /* as it is believed at t_k */
    float omega_m;          /* [rad/s] mechanical, of the rotor */
    demand_t demand;        /* with the frame in force */
    fast_control_t control;
    float load_current; /* of i_q, that carries the load and does not accelerate [A] */
    bounds_t bounds;    /* limits of i_q in force, by heat and DC link [A] */
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

    window_sums_t sum; /* of the window under way */
    fast_report_t report;
} fast_t;

/* What is in force in a period; neither changes but with a window. */
typedef struct {
    const fast_tuning_t *tuning;
    const setpoint_t *setpoint;
} fast_orders_t;

/* All state zero, with these orders. */
void fast_init(fast_t *fast, fast_orders_t orders);

/* The end of a window: the next period begins with other orders than `before`. What that takes is done there,
 * for this period has closed a window; here only what a trip in between has to find, and what needs the
 * orders before. The sample that comes has this encoder count. */
void fast_turn(fast_t *fast, fast_orders_t orders, fast_orders_t before, uint32_t encoder_count);

/* One period. `opens` [-] reason_t: what the medium task has found since its last setpoint; not REASON_NONE:
 * the bridge opens without waiting for the next one. Bounded, no libm; one division each of observer and
 * modulator, one more when the voltage is limited. */
void fast_step(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples, int32_t opens,
               drive_command_t *command);

/* The last period of a window, with this setpoint: its window, and the next one begins. */
void fast_close(fast_t *fast, const setpoint_t *setpoint, window_t *window);

/* The same without a window, for the medium task is not through with the last one: its sums are lost, and the
 * setpoint in force goes on acting. */
void fast_miss(fast_t *fast);

/* The bridge opens at once, for this reason. */
void fast_stop(fast_t *fast, int32_t reason);

/* Are the gates on, or coming on? */
static inline bool fast_bridge_on(const fast_t *fast)
{
    return fast->bridge.on != 0u;
}

#endif
