/* Heat of motor and power module by their currents, and the current limit that follows from it.
 *
 *     tau dh/dt = i^2/I_c^2 - h,      h = 1: final temperature with the continuous current I_c
 *
 * for the motor with the length of its current vector, for the module leg by leg with the leg's own
 * current: at standstill one leg may carry the whole current as direct current; while the rotor turns
 * the mean square is half of that. I_c of the module is therefore the largest continuous direct current
 * of a leg. Both models start cold.
 *
 * The current limit falls before a trip, on a straight line in h:
 *
 *     i_max(h) = I_max - (I_max - I_c) (h - h_d)/(1 - h_d)    from h_d = THERMAL_WARM on
 *
 * At h = 1 the limit is I_c, and I_c keeps h at 1: a motor with a larger requested torque settles there, and
 * its torque is reduced. If the heat rises further (a forced frame with the current of a start), the drive
 * trips at THERMAL_TRIP. Measured temperatures reduce the limit as well, from I_max at THERMAL_KELVIN below
 * the temperature that stops the drive to THERMAL_LEAST of it there, a sixteenth of the losses.
 *
 * Each call of thermal_add() adds squares; thermal_step() takes the mean of THERMAL_SUMS of them, and is
 * exact if the mean is constant for that time (docs/theory.md, 29).
 *
 * Does not handle: a second time constant (the iron under the winding, the sink under the chip), iron and
 * switching losses, a resistance that rises with the temperature, the initial temperature, legs that are
 * sampled only once in half an electrical turn. */
#ifndef MEDIUM_PROTECT_THERMAL_H
#define MEDIUM_PROTECT_THERMAL_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "math/frames.h"

/* Number of squares in a mean. */
#define THERMAL_SUMS 8u

#define THERMAL_WARM   0.9f  /* [-] h from which the limit falls */
#define THERMAL_TRIP   1.1f  /* [-] h that stops the drive */
#define THERMAL_KELVIN 10.0f /* [K] below a temperature limit: from here on the limit falls as well */
#define THERMAL_LEAST  0.25f /* [-] of I_max, at a temperature limit */

/* The conditions: bits. */
#define THERMAL_MOTOR    UINT32_C(1) /* the motor is overloaded */
#define THERMAL_MODULE   UINT32_C(2) /* the module is overloaded */
#define THERMAL_DERATING UINT32_C(4) /* the limit is below I_max */

typedef struct {
    float current_max;       /* I_max [A], above 0 */
    float motor_continuous;  /* I_c of the motor [A], length of the vector; 0: not judged */
    float motor_time;        /* tau of the motor [s]; 0: not judged */
    float module_continuous; /* I_c of a leg [A]; 0: not judged */
    float module_time;       /* tau of the module [s]; 0: not judged */
    float sink_hot;          /* [degC] heat-sink temperature that stops the drive */
    float motor_hot;         /* [degC] motor temperature that stops the drive */
    float period;            /* [s] from one sample to the next */
} thermal_params_t;

/* A first-order body. */
typedef struct {
    float share;    /* of the new square in h, 1 - exp(-t/tau) [-] */
    float per_sum;  /* mean of i^2/I_c^2 per sum of squares [1/A^2] */
    float per_heat; /* decrease of the limit per h [A] */
} thermal_body_t;

typedef struct {
    thermal_body_t motor;
    thermal_body_t module;
    float current_max; /* [A] */
    float least;       /* current limit at a temperature limit [A] */
    float per_kelvin;  /* decrease of the limit per kelvin [A/K] */
    float sink_hot;    /* [degC] */
    float motor_hot;   /* [degC] */
} thermal_tuning_t;

typedef struct {
    thermal_tuning_t tuning;
    abc_t squares;       /* [A^2] of each phase, since the last step */
    uint32_t count;      /* [-] number of samples in them */
    float motor_heat;    /* h of the motor [-] */
    abc_t leg_heat;      /* h of each leg [-] */
    float module_heat;   /* largest h of the legs [-] */
    float limit;         /* current limit [A], 0 .. I_max */
    uint32_t conditions; /* [-] THERMAL_... bits */
} thermal_t;

/* Computes the coefficients. Divisions and exponentials: for the background. */
thermal_tuning_t thermal_prepare(const thermal_params_t *params);

/* Takes these coefficients; everything is cold. */
void thermal_init(thermal_t *x, const thermal_tuning_t *tuning);

/* Takes over new coefficients; the heat is kept, relative to the new I_c. */
void thermal_take(thermal_t *x, const thermal_tuning_t *tuning);

/* Adds the squares of these phase currents [A]. */
static inline void thermal_add(thermal_t *x, abc_t current)
{
    x->squares.a += current.a * current.a;
    x->squares.b += current.b * current.b;
    x->squares.c += current.c * current.c;
    x->count++;
}

/* True if there are enough samples for a step. */
static inline bool thermal_is_due(const thermal_t *x)
{
    return x->count >= THERMAL_SUMS;
}

/* Computes heat, limit and conditions after THERMAL_SUMS samples, with the temperatures that were
 * measured last [degC]. No division. */
void thermal_step(thermal_t *x, const measured_t *measured);

#endif
