/* Heat: what the currents have made of motor and power module, and how much current that leaves.
 *
 *     tau dh/dt = i^2/I_c^2 - h,      h = 1: as warm as the continuous current I_c makes it, for ever
 *
 * for the motor with the length of its current vector, for the module leg by leg with the leg's own current:
 * a standing rotor heats one leg with all of a direct current, a turning one with half of the square. So I_c
 * of the module is the direct current that a leg stands. Both start cold.
 *
 * The limit of the current goes down before anything trips, on a straight line in h:
 *
 *     i_max(h) = I_max - (I_max - I_c) (h - h_d)/(1 - h_d)    from h_d = THERMAL_WARM on
 *
 * At h = 1 it leaves I_c, and I_c keeps h at 1: a motor that is asked for more than it stands settles there,
 * the torque sags. A drive whose heat goes on nevertheless (a forced frame whose current is a start's) trips
 * at THERMAL_TRIP. Measured temperatures take the limit down as well, from all of I_max at THERMAL_KELVIN
 * below the one that stops the drive to THERMAL_LEAST of it there, a sixteenth of the losses.
 *
 * Squares are added up each time that thermal_add() is called; thermal_step() takes the mean of THERMAL_SUMS
 * of them, and is exact for one that stays for so long (docs/theory.md, 29).
 *
 * Does not handle: a second time constant (the iron under the winding, the sink under the chip), iron and
 * switching losses, a resistance that rises with heat, the temperature at switching on, legs that are looked
 * at just once in half an electrical turn. */
#ifndef MEDIUM_PROTECT_THERMAL_H
#define MEDIUM_PROTECT_THERMAL_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/measured.h"
#include "math/frames.h"

/* Squares in a mean. */
#define THERMAL_SUMS 8u

#define THERMAL_WARM   0.9f  /* [-] h from which on the limit goes down */
#define THERMAL_TRIP   1.1f  /* [-] h that stops the drive */
#define THERMAL_KELVIN 10.0f /* [K] below the limit of a temperature, likewise */
#define THERMAL_LEAST  0.25f /* [-] of I_max, at the limit of a temperature */

/* What holds: bits. */
#define THERMAL_MOTOR    UINT32_C(1) /* the motor is overloaded */
#define THERMAL_MODULE   UINT32_C(2) /* the module is */
#define THERMAL_DERATING UINT32_C(4) /* the limit is below I_max */

typedef struct {
    float current_max;       /* I_max [A], above 0 */
    float motor_continuous;  /* I_c of the motor [A], length of the vector; 0: not judged */
    float motor_time;        /* tau of the motor [s]; 0: not judged */
    float module_continuous; /* I_c of a leg [A]; 0: not judged */
    float module_time;       /* tau of the module [s]; 0: not judged */
    float sink_hot;          /* [degC] that stops the drive */
    float motor_hot;         /* [degC] likewise */
    float period;            /* [s] from one square to the next */
} thermal_params_t;

/* Of one first-order body. */
typedef struct {
    float share;    /* of the new square in h, 1 - exp(-t/tau) [-] */
    float per_sum;  /* mean of i^2/I_c^2 per sum of squares [1/A^2] */
    float per_heat; /* of the limit, less per h [A] */
} thermal_body_t;

typedef struct {
    thermal_body_t motor;
    thermal_body_t module;
    float current_max; /* [A] */
    float least;       /* of it, at the limit of a temperature [A] */
    float per_kelvin;  /* of the limit, less per kelvin [A/K] */
    float sink_hot;    /* [degC] */
    float motor_hot;   /* [degC] */
} thermal_tuning_t;

typedef struct {
    thermal_tuning_t tuning;
    abc_t squares;       /* [A^2] of each phase, since the last step */
    uint32_t count;      /* [-] in them */
    float motor_heat;    /* h of the motor [-] */
    abc_t leg_heat;      /* h of each leg [-] */
    float module_heat;   /* the largest of them [-] */
    float limit;         /* of the current [A], 0 .. I_max */
    uint32_t conditions; /* [-] THERMAL_... */
} thermal_t;

/* Coefficients. Divisions and exponentials: for the background. */
thermal_tuning_t thermal_prepare(const thermal_params_t *params);

/* These coefficients; all is cold. */
void thermal_init(thermal_t *x, const thermal_tuning_t *tuning);

/* New coefficients; what is warm stays so, in shares of the new I_c. */
void thermal_take(thermal_t *x, const thermal_tuning_t *tuning);

/* The phase currents [A] of a moment. */
static inline void thermal_add(thermal_t *x, abc_t current)
{
    x->squares.a += current.a * current.a;
    x->squares.b += current.b * current.b;
    x->squares.c += current.c * current.c;
    x->count++;
}

/* Are there enough for a step? */
static inline bool thermal_is_due(const thermal_t *x)
{
    return x->count >= THERMAL_SUMS;
}

/* Heat, limit and conditions after THERMAL_SUMS squares, beside the temperatures that were measured last
 * [degC]. No division. */
void thermal_step(thermal_t *x, const measured_t *measured);

#endif
