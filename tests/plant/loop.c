#include "tests/plant/loop.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unity.h"

static double clamp(double x, double limit)
{
    return x > limit ? limit : x < -limit ? -limit : x;
}

static void control(loop_t *loop, const plant_truth_t *now, const plant_params_t *q)
{
    double err_d = loop->i_d_ref - now->i_d;
    double err_q = loop->i_q_ref - now->i_q;
    double bandwidth = 800.0;
    loop->sum_d = clamp(loop->sum_d + 1e-4 * bandwidth * q->resistance * err_d, 60.0);
    loop->sum_q = clamp(loop->sum_q + 1e-4 * bandwidth * q->resistance * err_q, 60.0);
    loop->u_d = bandwidth * q->inductance_d * err_d + loop->sum_d - now->omega_e * q->inductance_q * now->i_q;
    loop->u_q = bandwidth * q->inductance_q * err_q + loop->sum_q +
                now->omega_e * (q->inductance_d * now->i_d + q->flux_linkage);
    double length = sqrt(loop->u_d * loop->u_d + loop->u_q * loop->u_q);
    double limit = 0.55 * q->dc_voltage;
    if (length > limit) {
        loop->u_d *= limit / length;
        loop->u_q *= limit / length;
    }
}

static void modulate(loop_t *loop, double theta, double dc_voltage)
{
    double alpha = loop->u_d * cos(theta) - loop->u_q * sin(theta);
    double beta = loop->u_d * sin(theta) + loop->u_q * cos(theta);
    double v[3] = {alpha, -0.5 * alpha + sqrt(0.75) * beta, -0.5 * alpha - sqrt(0.75) * beta};
    double most = fmax(v[0], fmax(v[1], v[2]));
    double least = fmin(v[0], fmin(v[1], v[2]));
    for (int leg = 0; leg < 3; leg++) {
        double duty = 0.5 + (v[leg] - 0.5 * (most + least)) / dc_voltage;
        duty = duty < 0.04 ? 0.04 : duty > 0.96 ? 0.96 : duty;
        loop->high[leg] = (uint32_t)(duty * LOOP_PERIOD + 0.5);
    }
}

static void advance_in_parts(const loop_t *loop, plant_t *plant, uint64_t tick)
{
    const uint64_t from = plant->tick;
    for (uint32_t n = 1; n < loop->parts && tick > from; n++) {
        plant_advance(plant, from + (tick - from) * n / loop->parts);
    }
}

void loop_period(loop_t *loop, plant_t *plant, oracle_edge_t *edges, size_t *count)
{
    uint64_t start = plant->tick;
    plant_truth_t now;
    plant_truth(plant, &now);
    uint32_t high[3] = {loop->high[0], loop->high[1], loop->high[2]};
    control(loop, &now, &plant->params);
    modulate(loop, now.theta_e + 1.5e-4 * now.omega_e, now.dc_voltage);

    if (loop->averaged) {
        plant_carrier(plant, start, LOOP_PERIOD, high, loop->dead, loop->upper_ends != 0u);
        plant_advance(plant, start + LOOP_PERIOD);
        return;
    }
    /* The twelve edges, sorted by time: of each leg lower off, upper on, upper off, lower on. */
    struct {
        uint64_t tick;
        uint32_t clear, set;
    } list[12];
    int n = 0;
    for (uint32_t leg = 0; leg < 3; leg++) {
        uint32_t low = LOOP_PERIOD - high[leg];
        uint64_t rise = start + (loop->upper_ends ? (LOOP_PERIOD + low) / 2u : low / 2u);
        uint64_t fall = start + (loop->upper_ends ? high[leg] / 2u : low / 2u + high[leg]);
        uint32_t upper = PLANT_UPPER(leg);
        uint32_t lower = PLANT_LOWER(leg);
        if (high[leg] == 0) { /* all switches are off before the first command */
            continue;
        }
        list[n].tick = rise, list[n].clear = lower, list[n++].set = 0;
        list[n].tick = rise + loop->dead, list[n].clear = lower, list[n++].set = upper;
        list[n].tick = fall, list[n].clear = upper, list[n++].set = 0;
        list[n].tick = fall + loop->dead, list[n].clear = upper, list[n++].set = lower;
    }
    for (int done = 0; done < n; done++) {
        int first = 0;
        for (int k = 1; k < n; k++) {
            if (list[k].tick < list[first].tick) {
                first = k;
            }
        }
        loop->gates = (loop->gates & ~list[first].clear) | list[first].set;
        advance_in_parts(loop, plant, list[first].tick);
        plant_gates(plant, list[first].tick, loop->gates);
        if (edges != NULL) {
            edges[(*count)++] = (oracle_edge_t){list[first].tick, loop->gates};
        }
        list[first].tick = PLANT_NEVER;
    }
    advance_in_parts(loop, plant, start + LOOP_PERIOD);
    plant_advance(plant, start + LOOP_PERIOD);
}

static double *field_of(plant_params_t *params, const char *name, size_t length)
{
#define FIELD(field, unit, standard, minimum, maximum, text)                                                 \
    if (strlen(#field) == length && strncmp(#field, name, length) == 0) {                                    \
        return &params->field;                                                                               \
    }
    PLANT_PARAMS(FIELD)
#undef FIELD
    return NULL;
}

plant_params_t plant_with(plant_params_t params, const char *changes)
{
    while (*changes != '\0') {
        double *field = field_of(&params, changes, strcspn(changes, " "));
        TEST_ASSERT_NOT_NULL_MESSAGE(field, changes);
        char *end;
        *field = strtod(strchr(changes, '=') + 1, &end);
        changes = end + strspn(end, ", ");
    }
    return params;
}

plant_params_t plant_of(const char *changes)
{
    return plant_with(plant_params_default(), changes);
}
