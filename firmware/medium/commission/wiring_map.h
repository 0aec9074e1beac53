/* Which current sensor is on which phase, and which phase is open, from the answers to six pulses.
 *
 *     M = 1/3 sum r d^T    over six directions 60 degrees apart: r answer, d unit vector of the pulse
 *
 * Opposite pulses cancel offsets and the loss of the dead time. An open phase leaves one direction without an
 * answer: M has rank one. With correct wiring M is symmetric and positive (L^-1 of the winding). There are 24
 * maps of two sensors (leg and sign of each). The effect of each map is removed from M; the true map is the
 * one that leaves a symmetric and positive matrix. After the pulses, one map in a window. */
#ifndef MEDIUM_COMMISSION_WIRING_MAP_H
#define MEDIUM_COMMISSION_WIRING_MAP_H

#include <stdbool.h>
#include <stdint.h>

#include "math/frames.h"

/* Columns: the answers to unit vectors along alpha and beta [A]. */
typedef struct {
    ab_t of_alpha, of_beta;
} wiring_matrix_t;

/* Legs and signs of the sensors a and b. */
typedef struct {
    int32_t leg_a, leg_b;   /* [-] 0 to 2 */
    int32_t sign_a, sign_b; /* [-] 1 or -1 */
} wiring_map_t;

#define WIRING_DIRECTIONS 6u

/* The unit vector of a direction of the pulses, in steps of 60 degrees: an even one is along the axis of a
 * phase. */
rotation_t wiring_direction(uint32_t direction);

/* Adds the answer [A] to a pulse along this unit vector. */
void wiring_matrix_add(wiring_matrix_t *matrix, ab_t answer, rotation_t direction);

/* 2 |det M|/|M|^2 [-]: 1 for a round rotor, 0 with an open phase. */
float wiring_rank(const wiring_matrix_t *matrix);

/* The phase without an answer, 1 to 3; 0: each phase has one. */
int32_t wiring_open_phase(const wiring_matrix_t *matrix);

/* The sensor that does not change, 1 or 2, of a matrix in which each phase has an answer; 0: both change. */
int32_t wiring_stuck_sensor(const wiring_matrix_t *matrix);

#define WIRING_MAPS 24u

/* One of the WIRING_MAPS maps; 0: the right one. */
wiring_map_t wiring_map_of(uint32_t n);

/* Search for the map with the smallest score; it begins with zeros. */
typedef struct {
    uint32_t tried; /* [-] number of maps whose score is known */
    uint32_t best;  /* [-] the one with the smallest score, for wiring_map_of() */
    float least;    /* this score [-] */
} wiring_search_t;

/* Tries one map. true: it was the last one. */
bool wiring_search(wiring_search_t *search, const wiring_matrix_t *matrix);

static inline bool wiring_is_right(wiring_map_t map)
{
    return map.leg_a == 0 && map.leg_b == 1 && map.sign_a > 0 && map.sign_b > 0;
}

/* A map as a number: thousands and hundreds the legs (1 to 3) of the sensors a and b, tens and units 1 where
 * its sign is wrong. */
static inline int32_t wiring_code(wiring_map_t map)
{
    return 1000 * (map.leg_a + 1) + 100 * (map.leg_b + 1) + (map.sign_a < 0 ? 10 : 0) +
           (map.sign_b < 0 ? 1 : 0);
}

#endif
