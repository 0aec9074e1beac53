/* The timed part of a scenario on a rig that the caller steps: the settings before t = 0, then events and
 * ramps, each before its period.
 *
 *     course_start, then for k = 0, 1, ..: course_change(k), rig_step
 *
 * Before period k it executes the events of period k in the order of the file, then the active ramps (start +
 * (end - start) n/N after n of N periods, in double). It does not use names. */
#ifndef HOST_SIM_LAB_COURSE_H
#define HOST_SIM_LAB_COURSE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/lab/scenario.h"
#include "host_sim/rig/rig.h"

#define COURSE_NEVER UINT32_MAX

typedef struct course_ramp course_ramp_t;

/* All zero: nothing to free. */
typedef struct {
    const scenario_t *scenario;
    rig_t *rig;
    uint32_t next_event;
    course_ramp_t *ramps; /* active ramps */
    uint32_t ramp_count;
    uint32_t ramp_room; /* [-] largest number of active ramps */
} course_t;

/* Scenario and rig must exist as long as the course. false: not enough memory. */
bool course_init(course_t *course, const scenario_t *scenario, rig_t *rig);
void course_free(course_t *course);

/* Executes the settings before t = 0 and sets the rotor's motion. false: the rig refused a setting, see
 * `error`. */
bool course_start(course_t *course, scenario_error_t *error);

/* Executes everything that is due before this period. Call it at least for each period that course_next
 * returns. false: the rig refused a setting, see `error`; the course continues with the next setting. */
bool course_change(course_t *course, uint32_t period, scenario_error_t *error);

/* Runs the rig from period `from` of the course to `to`, with everything that is due. Returns the period that
 * was reached, which is before `to` if the condition of rig_stop_when was met. COURSE_NEVER: the rig refused
 * a setting, see `error`. */
uint32_t course_run(course_t *course, uint32_t from, uint32_t to, scenario_error_t *error);

/* Saves and loads the state of the course (executed events, active ramps) as octets without pointers; the
 * scenario determines the size. After a load the course continues from the saved state, on a rig that was
 * loaded with the state of the same time (rig_save). false: the octets are not a course of this scenario, and
 * nothing has changed. */
size_t course_state_size(const course_t *course);
void course_save(const course_t *course, void *state);
bool course_load(course_t *course, const void *state);

/* The next period after this one that has something to do; COURSE_NEVER: none. */
uint32_t course_next(const course_t *course, uint32_t period);

#endif
