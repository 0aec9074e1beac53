/* A small field-oriented control loop in double precision for the tests of the plant: dq PI control with
 * decoupling on the true angle, min-max modulation, dead band, pulses centred in the middle or at the ends
 * of the period. Its only purpose is to drive the plant. */
#ifndef TESTS_PLANT_LOOP_H
#define TESTS_PLANT_LOOP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/plant/plant.h"
#include "tests/oracle/oracle.h"

#define LOOP_PERIOD 15000u /* [tick] 10 kHz */

typedef struct {
    double i_d_ref, i_q_ref; /* [A] */
    double sum_d, sum_q;     /* [V] integrators */
    double u_d, u_q;         /* [V] computed last, active from the next period on */
    uint32_t high[3];        /* [tick] on-times in the period that begins now */
    uint32_t dead;           /* [tick] */
    uint32_t gates;          /* present command bits */
    uint32_t averaged;       /* 1: plant_carrier is used instead of edges */
    uint32_t parts;          /* number of steps between two edges; 0: the plant chooses them */
    uint32_t upper_ends;     /* 1: the pulses are centred at the ends of the period, not in its middle */
} loop_t;

/* Simulates one carrier period from the plant's present tick, which must be k LOOP_PERIOD. Appends the
 * commanded edges to edges (NULL: none) and adds to *count. The plant is at the start of the next period
 * afterwards. */
void loop_period(loop_t *loop, plant_t *plant, oracle_edge_t *edges, size_t *count);

/* These parameters, or the defaults, with changed values: "name = value, name = value". */
plant_params_t plant_with(plant_params_t params, const char *changes);
plant_params_t plant_of(const char *changes);

#define NO_DROPS "igbt_voltage = 0, igbt_resistance = 0, diode_voltage = 0, diode_resistance = 0"

#endif
