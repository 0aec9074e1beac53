#include "host_sim/lab/course.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A row that moves from one value to another. */
struct course_ramp {
    const scenario_event_t *event;
    const scenario_setting_t *setting;
    double start;
};

bool course_init(course_t *course, const scenario_t *scenario, rig_t *rig)
{
    uint32_t settings = 0;
    for (uint32_t n = 0; n < scenario->event_count; n++) {
        settings += scenario->events[n].count;
    }
    *course = (course_t){.scenario = scenario, .rig = rig, .next_event = 1u};
    course->ramp_room = settings + 1u;
    course->ramps = calloc(course->ramp_room, sizeof *course->ramps);
    return course->ramps != NULL;
}

void course_free(course_t *course)
{
    free(course->ramps);
    course->ramps = NULL;
}

bool course_start(course_t *course, scenario_error_t *error)
{
    const scenario_t *scenario = course->scenario;
    const scenario_event_t *initial = &scenario->events[0];
    if (!scenario_set(course->rig, initial->settings, initial->count)) {
        scenario_refused(scenario, course->rig, initial->settings, initial->count, error);
        return false;
    }
    if (scenario->has_start) {
        rig_set_motion(course->rig, scenario->start_angle, scenario->start_speed);
    }
    return true;
}

static bool refused(const course_t *course, const scenario_setting_t *settings, uint32_t count,
                    uint32_t period, scenario_error_t *error)
{
    scenario_refused(course->scenario, course->rig, settings, count, error);
    const size_t used = strlen(error->message);
    snprintf(error->message + used, sizeof error->message - used, " (at %.9g s)",
             period * RIG_PERIOD_SECONDS);
    return false;
}

static void end_ramp_of(course_t *course, const table_row_t *row)
{
    for (uint32_t n = 0; n < course->ramp_count; n++) {
        if (course->ramps[n].setting->row == row) {
            course->ramp_count--;
            memmove(&course->ramps[n], &course->ramps[n + 1u],
                    (course->ramp_count - n) * sizeof course->ramps[0]);
            return;
        }
    }
}

static bool is_ramped(const scenario_event_t *event, const scenario_setting_t *setting)
{
    return event->ramp_periods > 0u && setting->row->kind == SLOT_FLOAT;
}

/* Rows that change at once, in their order; then the rows with a ramp, which start from their present values.
 */
static bool begin_event(course_t *course, const scenario_event_t *event, uint32_t period,
                        scenario_error_t *error)
{
    uint32_t first = 0;
    for (uint32_t n = 0; n <= event->count; n++) {
        if (n < event->count && !is_ramped(event, &event->settings[n])) {
            end_ramp_of(course, event->settings[n].row);
            continue;
        }
        if (n > first && !scenario_set(course->rig, &event->settings[first], n - first)) {
            return refused(course, &event->settings[first], n - first, period, error);
        }
        first = n + 1u;
    }
    for (uint32_t n = 0; n < event->count; n++) {
        const scenario_setting_t *setting = &event->settings[n];
        double start = 0.0;
        if (is_ramped(event, setting) && rig_get(course->rig, setting->row->id, &start)) {
            end_ramp_of(course, setting->row);
            course->ramps[course->ramp_count++] = (course_ramp_t){event, setting, start};
        }
    }
    return true;
}

/* A refused ramp ends at its present value. */
static bool move_ramps(course_t *course, uint32_t period, scenario_error_t *error)
{
    const scenario_event_t *event = NULL; /* that parameters changed for */
    bool good = true;
    uint32_t kept = 0;
    for (uint32_t n = 0; n < course->ramp_count; n++) {
        const course_ramp_t ramp = course->ramps[n];
        const uint32_t done = period - ramp.event->period;
        const uint32_t all = ramp.event->ramp_periods;
        const double end = ramp.setting->value;
        const double value =
            done >= all ? end : ramp.start + (end - ramp.start) * ((double)done / (double)all);
        if (done > 0u && !rig_set(course->rig, ramp.setting->row->id, value)) {
            good = refused(course, ramp.setting, 1u, period, error);
            continue;
        }
        event = done > 0u && scenario_is_param(ramp.setting->row) ? ramp.event : event;
        if (done < all) {
            course->ramps[kept++] = ramp;
        }
    }
    course->ramp_count = kept;
    if (event != NULL && !rig_apply(course->rig)) {
        good = refused(course, event->settings, event->count, period, error);
    }
    return good;
}

bool course_change(course_t *course, uint32_t period, scenario_error_t *error)
{
    const scenario_t *scenario = course->scenario;
    bool good = true;
    while (course->next_event < scenario->event_count &&
           scenario->events[course->next_event].period == period) {
        good = begin_event(course, &scenario->events[course->next_event], period, error) && good;
        course->next_event++;
    }
    return (course->ramp_count == 0u || move_ramps(course, period, error)) && good;
}

/* ---- its state ---- */

/* A ramp in the saved state, by its position in the scenario. */
typedef struct {
    double start;
    uint32_t event, setting;
} kept_ramp_t;

typedef struct {
    uint32_t next_event, ramp_count;
} kept_course_t;

size_t course_state_size(const course_t *course)
{
    return sizeof(kept_course_t) + course->ramp_room * sizeof(kept_ramp_t);
}

void course_save(const course_t *course, void *state)
{
    const kept_course_t kept = {course->next_event, course->ramp_count};
    char *to = state;
    memset(to, 0, course_state_size(course));
    memcpy(to, &kept, sizeof kept);
    for (uint32_t n = 0; n < course->ramp_count; n++) {
        const course_ramp_t *ramp = &course->ramps[n];
        const kept_ramp_t one = {.start = ramp->start,
                                 .event = (uint32_t)(ramp->event - course->scenario->events),
                                 .setting = (uint32_t)(ramp->setting - ramp->event->settings)};
        memcpy(to + sizeof kept + n * sizeof one, &one, sizeof one);
    }
}

static kept_ramp_t kept_ramp(const void *state, uint32_t n)
{
    kept_ramp_t ramp;
    memcpy(&ramp, (const char *)state + sizeof(kept_course_t) + n * sizeof ramp, sizeof ramp);
    return ramp;
}

bool course_load(course_t *course, const void *state)
{
    const scenario_t *scenario = course->scenario;
    kept_course_t kept;
    memcpy(&kept, state, sizeof kept);
    bool good = kept.next_event <= scenario->event_count && kept.ramp_count <= course->ramp_room;
    for (uint32_t n = 0; good && n < kept.ramp_count; n++) {
        const kept_ramp_t ramp = kept_ramp(state, n);
        good = ramp.event < scenario->event_count && ramp.setting < scenario->events[ramp.event].count;
    }
    for (uint32_t n = 0; good && n < kept.ramp_count; n++) {
        const kept_ramp_t ramp = kept_ramp(state, n);
        const scenario_event_t *event = &scenario->events[ramp.event];
        course->ramps[n] = (course_ramp_t){event, &event->settings[ramp.setting], ramp.start};
    }
    if (good) {
        course->next_event = kept.next_event;
        course->ramp_count = kept.ramp_count;
    }
    return good;
}

uint32_t course_next(const course_t *course, uint32_t period)
{
    const scenario_t *scenario = course->scenario;
    if (course->ramp_count > 0u) {
        return period + 1u;
    }
    return course->next_event < scenario->event_count ? scenario->events[course->next_event].period
                                                      : COURSE_NEVER;
}

uint32_t course_run(course_t *course, uint32_t from, uint32_t to, scenario_error_t *error)
{
    uint32_t period = from;
    while (period < to) {
        if (!course_change(course, period, error)) {
            return COURSE_NEVER;
        }
        const uint32_t due = course_next(course, period);
        const uint32_t asked = (due < to ? due : to) - period;
        const uint32_t done = rig_run(course->rig, asked);
        period += done;
        if (done < asked) {
            break;
        }
    }
    return period;
}
