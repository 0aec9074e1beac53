/* A small field-oriented loop in double precision for the plant's tests: dq PI control with decoupling on the
 * true angle, min-max modulation, dead band, pulses centred in the period or at its ends. Its only purpose is
 * to make the plant work. */
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
    double u_d, u_q;         /* [V] computed last, acting from the next period on */
    uint32_t high[3];        /* [tick] of the period that begins now */
    uint32_t dead;           /* [tick] */
    uint32_t gates;          /* command bits now */
    uint32_t averaged;       /* 1: plant_carrier instead of edges */
    uint32_t parts;          /* number of steps between two edges; 0: chosen by the plant */
    uint32_t upper_ends;     /* 1: pulses centred at the ends of the period, not in its middle */
} loop_t;

/* One carrier period from plant's present tick, which must be k LOOP_PERIOD; commanded edges are appended to
 * edges (NULL: none) and *count. Returns with the plant advanced to the next period's start. */
void loop_period(loop_t *loop, plant_t *plant, oracle_edge_t *edges, size_t *count);

/* These parameters, or the defaults, with other values in their places: "name = value, name = value". */
plant_params_t plant_with(plant_params_t params, const char *changes);
plant_params_t plant_of(const char *changes);

#define NO_DROPS "igbt_voltage = 0, igbt_resistance = 0, diode_voltage = 0, diode_resistance = 0"

#endif
