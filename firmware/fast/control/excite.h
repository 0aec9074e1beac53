/* Excitation of a standing motor whose data are unknown, in place of current control. The medium task orders
 * it and evaluates the sums (medium/commission/commission.h); this module contains only the part that runs in
 * each period.
 *
 *     pulse   +U for n periods, -U for n periods, then the zero vector until the current has ended
 *     hold    a current along a fixed axis by a slow PI control, and along or across it a sine of voltage;
 *             across the axis a resistance only, u = -r i, so that a rotor that swings is braked; a larger
 *             resistance for the part of the whole current that exceeds a limit, because the EMF of a light
 *             rotor that swings drives more current than the trip accepts
 *     loop    along the axis the current control of the drive itself, whose reference steps between two
 *             values; across the axis the same resistance
 *
 * With e the distance of the current from the reference after a step, the loop obeys (current_control.h)
 *
 *     e_k - e_k+1 = K e_k-1,   so that   K = sum (e_k - e_k+1) e_k-1 / sum e_k-1^2
 *
 * over the first EXCITE_FITTED periods after each step: these two sums are in voltage_cos and current_cos
 * along the axis.
 *
 * The loss of the dead time is not compensated, because its size is not known yet. The sums contain the
 * voltage of the duties that acted in the period that ends with the sample, and the current of the sample:
 * their means, and their products with the cosine and sine of the phase of the excitation.
 *
 * One step per T. No division. Does not handle: a rotating frame; the trips, which stay as they are. */
#ifndef FAST_CONTROL_EXCITE_H
#define FAST_CONTROL_EXCITE_H

#include <stdint.h>

#include "math/frames.h"

/* Current below which a pulse has ended [A], for this number of consecutive periods. */
#define EXCITE_STILL         0.06f
#define EXCITE_STILL_PERIODS 10u

/* Gains over the inductance [rad/s]. */
#define EXCITE_BANDWIDTH   300.0f  /* of the control along the axis */
#define EXCITE_ACROSS_HARD 450.0f  /* of the additional resistance across the axis above across_from */
#define EXCITE_MOST_HARD   2500.0f /* of the resistance for the part of the current that is too long */

/* Up to this period after a step of the loop's reference its sums are taken [periods]. */
#define EXCITE_FITTED 24u

typedef enum {
    EXCITE_NONE,  /* current control works */
    EXCITE_PULSE, /* one pulse along the axis */
    EXCITE_HOLD,  /* current along the axis, and a sine of voltage */
    EXCITE_LOOP   /* the current control of the drive, with a stepping reference */
} excite_kind_t;

typedef struct {
    int32_t kind;       /* [-] excite_kind_t */
    uint32_t serial;    /* [-] a new number restarts the excitation: a new pulse, or a current from zero */
    rotation_t axis;    /* direction of pulse or current [-] */
    float voltage;      /* of the pulse, or amplitude of the sine [V] */
    uint32_t periods;   /* [periods] of each half of a pulse, or from one step of the reference to the next */
    float current_max;  /* the pulse ends above this current [A] */
    float current;      /* along the axis [A] */
    float step;         /* of the reference to either side of it, loop [A] */
    float slew;         /* largest change of the current reference per period [A] */
    float inductance;   /* L, from which the gains follow [H] */
    float ki;           /* of the integral of the control along the axis, per period [V/A] */
    float voltage_max;  /* of the control along the axis [V] */
    float across;       /* resistance across the axis [V/A] */
    float across_from;  /* current across the axis above which the resistance is larger [A] */
    float most_inverse; /* 1 over the square of the length above which the whole current is reduced [1/A^2] */
    float turn;         /* phase of the sine per period [rad], 0 to pi */
    uint32_t sine_across; /* [-] 1: the sine acts across the axis; 0: along it */
} excite_order_t;

/* Sums over the periods of a window, in the frame of the axis. */
typedef struct {
    uint32_t periods; /* [periods] */
    uint32_t serial;  /* [-] of the order that acted in the last period */
    uint32_t done;    /* [-] 1: the pulse has ended, or the current has reached its reference */
    rotation_t axis;  /* of that order [-] */
    ab_t response;    /* change of the current by the first half of the pulse [A] */
    dq_t voltage;     /* [V] */
    dq_t current;     /* [A] */
    dq_t voltage_cos; /* times the cosine of the phase [V] */
    dq_t voltage_sin; /* times its sine [V] */
    dq_t current_cos; /* the same [A] */
    dq_t current_sin; /* the same [A] */
} excite_seen_t;

typedef struct {
    excite_seen_t seen; /* of this window */
    float integral;     /* [V] */
    float reference;    /* present current reference [A] */
    float phase;        /* of the sine [rad] */
    uint32_t count;     /* [periods] since the pulse began */
    uint32_t still;     /* [periods] consecutive, without a current after it */
    ab_t before;        /* current before the pulse; loop: e of the last two periods [A] */
} excite_t;

/* Sets the state in which no excitation has begun. */
void excite_init(excite_t *excite);

/* The voltage [V] that is to act, in the stationary frame, from the current [A] at t_k; `acted` [V]: the
 * voltage of the duties in the period that ends at t_k, without losses. */
ab_t excite_step(excite_t *excite, const excite_order_t *order, ab_t current, ab_t acted);

/* The same for EXCITE_LOOP: along the axis the reference [A] of the current control, across it the voltage
 * [V]. */
dq_t excite_loop(excite_t *excite, const excite_order_t *order, dq_t current);

/* The end of a window: its sums, and the sums begin again. */
void excite_close(excite_t *excite, excite_seen_t *seen);

#endif
