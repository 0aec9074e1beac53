/* The setup of a map from a scenario. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host_sim/lab/map.h"
#include "host_sim/lab/scenario_parts.h"

#define RPM  (2.0 * 3.14159265358979323846 / 60.0) /* [rad/s] */
#define SAME 1e-6                                  /* [-] of a value */
#define FINE 1e6                                   /* [-] decimals that are kept of a value in another unit */

/* Magnitudes, each once. */
typedef struct {
    double *values;
    size_t count, most;
} list_t;

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

/* false: there are more than fit. */
static bool add(list_t *list, double value)
{
    for (size_t n = 0; n < list->count; n++) {
        if (fabs(list->values[n] - value) <= SAME * value) {
            return true;
        }
    }
    if (list->count == list->most) {
        return false;
    }
    list->values[list->count++] = value;
    return true;
}

static bool fail(const scenario_t *scenario, scenario_error_t *error, scenario_place_t place,
                 const char *name, const char *message)
{
    scenario_fail(error, place, name, "%s", message);
    snprintf(error->file, sizeof error->file, "%s", scenario->path);
    return false;
}

/* Collects all values of a row, divided by `unit`. A list with a smallest accepted value does not include 0.
 * */
static bool gather(const scenario_t *scenario, const table_row_t *row, double unit, double least, list_t *to,
                   scenario_error_t *error)
{
    char message[160];
    for (uint32_t e = 0; e < scenario->event_count; e++) {
        for (uint32_t n = 0; n < scenario->events[e].count; n++) {
            const scenario_setting_t *setting = &scenario->events[e].settings[n];
            const double value = round(fabs(setting->value) / unit * FINE) / FINE;
            if (setting->row != row || (value == 0.0 && least > 0.0)) {
                continue;
            }
            if (value < least) {
                snprintf(message, sizeof message, "%g r/min; a map accepts %g r/min or more, or 0", value,
                         least);
                return fail(scenario, error, setting->place, row->name, message);
            }
            if (!add(to, value)) {
                snprintf(message, sizeof message, "a map accepts at most %zu different values", to->most);
                return fail(scenario, error, setting->place, row->name, message);
            }
        }
    }
    return true;
}

/* The speeds of the file, unless the setup has its own. */
static bool take_speeds(map_setup_t *setup, const scenario_t *scenario, scenario_error_t *error)
{
    const table_row_t *row = rig_row_by_name("speed_request");
    list_t list = {.values = setup->speeds, .most = MAP_SPEEDS_MAX};
    if (setup->speed_count > 0u) {
        return true;
    }
    if (!gather(scenario, row, RPM, MAP_RPM_MIN, &list, error)) {
        return false;
    }
    if (list.count == 0u) {
        return fail(scenario, error, (scenario_place_t){0}, row->name,
                    "a map needs a speed: set this request to one other than 0, or give --speeds");
    }
    qsort(list.values, list.count, sizeof list.values[0], ascending);
    setup->speed_count = list.count;
    return true;
}

bool map_of_scenario(map_setup_t *setup, const scenario_t *scenario, scenario_error_t *error)
{
    const table_row_t *row = rig_row_by_name("plant.load_torque");
    list_t list = {.values = setup->loads, .most = MAP_LOADS_MAX};
    add(&list, fabs(scenario_initial(scenario, row)));
    if (!take_speeds(setup, scenario, error) || !gather(scenario, row, 1.0, 0.0, &list, error)) {
        return false;
    }
    qsort(list.values, list.count, sizeof list.values[0], ascending);
    setup->load_count = list.count;
    setup->scenario = scenario;
    return true;
}
