/* The timed part of a scenario on a rig that somebody else steps: what is set before t = 0, then events and
 * ramps, each before the period that it belongs to.
 *
 *     course_start, then for k = 0, 1, ..: course_change(k), rig_step
 *
 * Before period k: events of period k in the order of the file, then ramps under way (start + (end - start)
 * n/N after n of N periods, in double). Nothing is looked up by name. */
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
    course_ramp_t *ramps; /* under way */
    uint32_t ramp_count;
    uint32_t ramp_room; /* [-] no more can be under way */
} course_t;

/* Scenario and rig must outlive it. false: not enough memory. */
bool course_init(course_t *course, const scenario_t *scenario, rig_t *rig);
void course_free(course_t *course);

/* What is set before t = 0, and the rotor's motion. false: the rig refused a setting, see `error`. */
bool course_start(course_t *course, scenario_error_t *error);

/* Everything that is due before this period; to be called for each period that course_next names, at least.
 * false: the rig refused a setting, see `error`; the course goes on with what comes after it. */
bool course_change(course_t *course, uint32_t period, scenario_error_t *error);

/* Turns the rig from period `from` of the course to `to`, with all that is due on the way. Returns the period
 * that it came to: sooner than `to` where rig_stop_when held. COURSE_NEVER: the rig refused a setting, see
 * `error`. */
uint32_t course_run(course_t *course, uint32_t from, uint32_t to, scenario_error_t *error);

/* Where the course is, as octets without pointers, of a size that its scenario fixes: events that are done,
 * ramps under way. A load goes on where the save was, on a rig that was loaded with the same moment's state
 * (rig_save). false: they are no course of this scenario, and nothing has changed. */
size_t course_state_size(const course_t *course);
void course_save(const course_t *course, void *state);
bool course_load(course_t *course, const void *state);

/* The next period after this one that has something to do; COURSE_NEVER: none. */
uint32_t course_next(const course_t *course, uint32_t period);

#endif
