/* Protection: which fault, if any, must stop the drive now. Every row of the fault table is one condition
 * with its own debounce; the table lives in protection.c. Pure counting and comparing, straight line, no
 * division.
 *
 * The gates themselves are shut by the trip zone without software; this module is the reaction of the
 * software and the protection against everything the power module cannot see. */
#ifndef DRIVE_PROTECTION_H
#define DRIVE_PROTECTION_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

/* What is judged once per period. */
typedef struct {
    abc_t current;           /* [A] phase currents, offsets removed */
    float u_dc;              /* [V] */
    float sink_temperature;  /* [degC] */
    float motor_temperature; /* [degC] */
    float omega_m;           /* [rad/s] mechanical */
    uint32_t tripped;        /* [-] 1: the trip zone holds the gates off though the drive wants them on */
    uint32_t encoder_error;  /* [-] 1: quadrature phase error since the last sample */
    uint32_t late;           /* [-] 1: this interrupt came too late for its period */
    uint32_t bad_sample;     /* [-] 1: not a number, or a current sensor at its rail */
    uint32_t estimate;       /* [-] bits of the signs by which the estimate in use is lost, debounced */
    uint32_t bridge_on;      /* [-] 1: the drive drives the motor; some faults count only then */
} protection_input_t;

typedef struct {
    float overcurrent;           /* [A] */
    float overvoltage;           /* [V] */
    float undervoltage;          /* [V] */
    float sink_temperature_max;  /* [degC] */
    float motor_temperature_max; /* [degC] */
    float overspeed;             /* [rad/s] mechanical */
} protection_limits_t;

#define PROTECTION_FAULTS 14u

typedef struct {
    protection_limits_t limits;
    uint32_t run[PROTECTION_FAULTS]; /* [periods] how long each condition has held without a break */
    uint32_t counting;               /* [-] bits of the conditions that held in the last period */
} protection_t;

void protection_init(protection_t *protection, const protection_limits_t *limits);
void protection_retune(protection_t *protection, const protection_limits_t *limits);
void protection_reset(protection_t *protection);

/* The conditions that have held for their debounce, as bits: bit n is row n of the fault table, lower is
 * graver. */
uint32_t protection_step(protection_t *protection, const protection_input_t *input);

/* Reason number of the gravest of these bits; REASON_NONE for 0. */
int32_t protection_reason(uint32_t faults);

/* Debounce [periods] of the row with this reason; 0 if there is none. For tests and documentation. */
uint32_t protection_debounce(int32_t reason);

#endif
