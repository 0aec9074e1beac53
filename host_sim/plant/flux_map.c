#include "host_sim/plant/flux_map.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NODE       8u /* [-] of a point: psi, dpsi/di_d, dpsi/di_q, d2psi/di_d di_q; of psi_d, then of psi_q */
#define ENERGY_CUT 64u /* [-] parts of the integral of the energy along an axis */

struct flux_map {
    uint32_t count_d, count_q;
    double step;  /* [A] smallest */
    double *i_d;  /* [A] count_d; all following arrays are in the same block */
    double *i_q;  /* [A] count_q */
    double *node; /* NODE for each point */
};

static const flux_map_t *maps[FLUX_MAPS];

const flux_map_t *flux_map_of(uint32_t number)
{
    return number >= 1u && number <= FLUX_MAPS ? maps[number - 1u] : NULL;
}

double flux_map_step(const flux_map_t *map)
{
    return map->step;
}

/* ---- interpolation ---- */

/* The cell of a current: its lower point. */
static uint32_t cell_of(const double *at, uint32_t count, double i)
{
    uint32_t low = 0u;
    uint32_t high = count - 1u;
    while (high - low > 1u) {
        const uint32_t middle = (low + high) / 2u;
        if (i < at[middle]) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return low;
}

/* Weights of value and slope at both ends of a cell, for a value and for its derivative. */
typedef struct {
    double value[2], slope[2];
    double value_rate[2], slope_rate[2];
} weights_t;

static weights_t weights_at(double from, double to, double i)
{
    const double h = to - from;
    const double x = (i - from) / h;
    const double y = 1.0 - x;
    return (weights_t){
        .value = {(1.0 + 2.0 * x) * y * y, (1.0 + 2.0 * y) * x * x},
        .slope = {h * x * y * y, -h * y * x * x},
        .value_rate = {-6.0 * x * y / h, 6.0 * x * y / h},
        .slope_rate = {y * (1.0 - 3.0 * x), x * (1.0 - 3.0 * y)},
    };
}

static double clamped(double i, double least, double most)
{
    return i < least ? least : i > most ? most : i;
}

flux_map_point_t flux_map_at(const flux_map_t *map, double i_d, double i_q)
{
    const double at_d = clamped(i_d, map->i_d[0], map->i_d[map->count_d - 1u]);
    const double at_q = clamped(i_q, map->i_q[0], map->i_q[map->count_q - 1u]);
    const uint32_t n = cell_of(map->i_d, map->count_d, at_d);
    const uint32_t m = cell_of(map->i_q, map->count_q, at_q);
    const weights_t d = weights_at(map->i_d[n], map->i_d[n + 1u], at_d);
    const weights_t q = weights_at(map->i_q[m], map->i_q[m + 1u], at_q);
    double flux[2] = {0.0, 0.0};
    double by_d[2] = {0.0, 0.0};
    double by_q[2] = {0.0, 0.0};
    for (uint32_t k = 0; k < 4u; k++) {
        const uint32_t a = k / 2u;
        const uint32_t b = k % 2u;
        const double *node = &map->node[NODE * ((n + a) * map->count_q + m + b)];
        for (uint32_t axis = 0; axis < 2u; axis++, node += NODE / 2u) {
            const double value = node[0] * q.value[b] + node[2] * q.slope[b];
            const double slope = node[1] * q.value[b] + node[3] * q.slope[b];
            const double value_q = node[0] * q.value_rate[b] + node[2] * q.slope_rate[b];
            const double slope_q = node[1] * q.value_rate[b] + node[3] * q.slope_rate[b];
            flux[axis] += d.value[a] * value + d.slope[a] * slope;
            by_d[axis] += d.value_rate[a] * value + d.slope_rate[a] * slope;
            by_q[axis] += d.value[a] * value_q + d.slope[a] * slope_q;
        }
    }
    const double more_d = i_d - at_d;
    const double more_q = i_q - at_q;
    return (flux_map_point_t){
        .flux_d = flux[0] + by_d[0] * more_d + by_q[0] * more_q,
        .flux_q = flux[1] + by_d[1] * more_d + by_q[1] * more_q,
        .slope_dd = by_d[0],
        .slope_dq = by_q[0],
        .slope_qd = by_d[1],
        .slope_qq = by_q[1],
    };
}

/* 1.5 times the integral of i dpsi = psi i - integral of psi di, by Simpson's rule. */
double flux_map_energy(const flux_map_t *map, double i_d, double i_q)
{
    double below = 0.0;
    for (uint32_t n = 0; n <= ENERGY_CUT; n++) {
        const double x = (double)n / ENERGY_CUT;
        const double weight = n == 0u || n == ENERGY_CUT ? 1.0 : n % 2u == 1u ? 4.0 : 2.0;
        below += weight *
                 (flux_map_at(map, x * i_d, 0.0).flux_d * i_d + flux_map_at(map, i_d, x * i_q).flux_q * i_q);
    }
    const flux_map_point_t end = flux_map_at(map, i_d, i_q);
    return 1.5 * (end.flux_d * i_d + end.flux_q * i_q - below / (3.0 * ENERGY_CUT));
}

/* ---- building ---- */

/* Derivative at point n of `count` values that are `stride` apart, by the parabola through three of them. */
static double derivative(const double *at, const double *value, uint32_t stride, uint32_t count, uint32_t n)
{
    const uint32_t middle = n == 0u ? 1u : n == count - 1u ? count - 2u : n;
    const double h = at[middle] - at[middle - 1u];
    const double k = at[middle + 1u] - at[middle];
    const double before = (value[middle * stride] - value[(middle - 1u) * stride]) / h;
    const double behind = (value[(middle + 1u) * stride] - value[middle * stride]) / k;
    const double bend = (behind - before) / (h + k); /* half of the second derivative */
    const double slope = before + bend * h;
    return slope + 2.0 * bend * (at[n] - at[middle]);
}

static void differentiate(flux_map_t *map)
{
    const uint32_t across = NODE * map->count_q;
    for (uint32_t n = 0; n < map->count_d; n++) {
        for (uint32_t m = 0; m < map->count_q; m++) {
            for (uint32_t axis = 0; axis < 2u; axis++) {
                double *line = map->node + NODE / 2u * axis;
                double *node = line + NODE * (n * map->count_q + m);
                node[1] = derivative(map->i_d, line + NODE * m, across, map->count_d, n);
                node[2] = derivative(map->i_q, line + n * across, NODE, map->count_q, m);
            }
        }
    }
    for (uint32_t n = 0; n < map->count_d; n++) {
        for (uint32_t m = 0; m < map->count_q; m++) {
            for (uint32_t axis = 0; axis < 2u; axis++) {
                double *line = map->node + NODE / 2u * axis + n * across;
                line[NODE * m + 3u] = derivative(map->i_q, line + 1u, NODE, map->count_q, m);
            }
        }
    }
}

static bool refuse(flux_map_error_t *error, const char *rule, double i_d, double i_q)
{
    *error = (flux_map_error_t){rule, i_d, i_q};
    return false;
}

static bool axis_is_good(const double *at, uint32_t count)
{
    for (uint32_t n = 1; n < count; n++) {
        if (!(at[n] > at[n - 1u])) {
            return false;
        }
    }
    return count >= 3u && count <= FLUX_MAP_POINTS && at[0] <= 0.0 && at[count - 1u] >= 0.0;
}

/* At each point, and in the middle of each cell, both fluxes grow with their currents, also together. */
static bool grows(const flux_map_t *map, flux_map_error_t *error)
{
    for (uint32_t n = 0; n < 2u * map->count_d - 1u; n++) {
        for (uint32_t m = 0; m < 2u * map->count_q - 1u; m++) {
            const double i_d = 0.5 * (map->i_d[n / 2u] + map->i_d[(n + 1u) / 2u]);
            const double i_q = 0.5 * (map->i_q[m / 2u] + map->i_q[(m + 1u) / 2u]);
            const flux_map_point_t p = flux_map_at(map, i_d, i_q);
            if (!(p.slope_dd > 0.0)) {
                return refuse(error, "psi_d does not grow with i_d", i_d, i_q);
            }
            if (!(p.slope_qq > 0.0)) {
                return refuse(error, "psi_q does not grow with i_q", i_d, i_q);
            }
            if (!(p.slope_dd * p.slope_qq > p.slope_dq * p.slope_qd)) {
                return refuse(
                    error,
                    "a flux changes more with the current of the other axis than with that of its own axis",
                    i_d, i_q);
            }
        }
    }
    return true;
}

static double smallest_step(const double *at, uint32_t count)
{
    double step = at[1] - at[0];
    for (uint32_t n = 2; n < count; n++) {
        step = at[n] - at[n - 1u] < step ? at[n] - at[n - 1u] : step;
    }
    return step;
}

static flux_map_t *made_of(const flux_map_grid_t *grid)
{
    const size_t points = (size_t)grid->count_d * grid->count_q;
    flux_map_t *map = malloc(sizeof *map + (grid->count_d + grid->count_q + NODE * points) * sizeof(double));
    if (map == NULL) {
        return NULL;
    }
    map->count_d = grid->count_d;
    map->count_q = grid->count_q;
    map->i_d = (double *)(void *)(map + 1);
    map->i_q = map->i_d + grid->count_d;
    map->node = map->i_q + grid->count_q;
    memcpy(map->i_d, grid->i_d, grid->count_d * sizeof(double));
    memcpy(map->i_q, grid->i_q, grid->count_q * sizeof(double));
    for (size_t n = 0; n < points; n++) {
        map->node[NODE * n] = grid->flux_d[n];
        map->node[NODE * n + NODE / 2u] = grid->flux_q[n];
    }
    const double step_d = smallest_step(map->i_d, map->count_d);
    const double step_q = smallest_step(map->i_q, map->count_q);
    map->step = step_d < step_q ? step_d : step_q;
    differentiate(map);
    return map;
}

static bool is_same(const flux_map_t *one, const flux_map_t *other)
{
    const size_t doubles = one->count_d + one->count_q + (size_t)NODE * one->count_d * one->count_q;
    return one->count_d == other->count_d && one->count_q == other->count_q &&
           memcmp(one->i_d, other->i_d, doubles * sizeof(double)) == 0;
}

uint32_t flux_map_add(const flux_map_grid_t *grid, flux_map_error_t *error)
{
    if (!axis_is_good(grid->i_d, grid->count_d) || !axis_is_good(grid->i_q, grid->count_q)) {
        (void)refuse(error, "each current needs 3 to 256 values, from at most 0 to at least 0", 0.0, 0.0);
        return 0u;
    }
    flux_map_t *map = made_of(grid);
    if (map == NULL || !grows(map, error)) {
        if (map == NULL) {
            (void)refuse(error, "not enough memory", 0.0, 0.0);
        }
        free(map);
        return 0u;
    }
    for (uint32_t n = 0; n < FLUX_MAPS; n++) {
        if (maps[n] == NULL) {
            maps[n] = map;
            return n + 1u;
        }
        if (is_same(maps[n], map)) {
            free(map);
            return n + 1u;
        }
    }
    free(map);
    (void)refuse(error, "a program accepts at most 32 maps", 0.0, 0.0);
    return 0u;
}
