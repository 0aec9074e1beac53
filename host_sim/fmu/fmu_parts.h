/* An instance of the unit, which the functions of FMI share. */
#ifndef HOST_SIM_FMU_FMU_PARTS_H
#define HOST_SIM_FMU_FMU_PARTS_H

#include "fmi2Functions.h"

#include "host_sim/lab/course.h"
#include "host_sim/lab/fmu_model.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/rig/rig.h"

/* Data of an instance that are part of its saved state. */
typedef struct {
    double now;                  /* [s] end of the last step */
    double start;                /* [s] time of period 0 */
    double set[FMU_ID_END];      /* [unit] last value of a row that can be set */
    uint32_t slots[RIG_TAP_MAX]; /* outputs of the last period */
    uint32_t periods;            /* [periods] run */
} kept_t;

typedef struct {
    char *name;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    rig_part_t part;
    uint64_t seed;
    scenario_t *scenario;
    rig_t *rig;
    course_t course;
    uint32_t outputs[RIG_TAP_MAX]; /* ids */
    uint32_t output_count;
    uint16_t place[FMU_ID_END]; /* place of an output in `slots` */
    bool initialized;
    kept_t kept;
} instance_t;

/* Gives the text to the master's logger and returns the status. */
fmi2Status fmu_say(const instance_t *instance, fmi2Status status, const char *text);

/* The same for a value reference that no variable of this kind has. */
fmi2Status fmu_no_variable(const instance_t *instance, fmi2ValueReference reference, const char *kind);

#endif
