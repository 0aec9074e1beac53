/* States of an instance: a head, what the instance keeps itself, the rig's state, that of its part, the
 * course's. It has no
 * pointers, and interrupt vectors are distances within the library, so that any process with the same library
 * on the same kind of machine can load it. */
#include <stdlib.h>
#include <string.h>

#include "host_sim/fmu/fmu_parts.h"

typedef struct {
    uint64_t check;  /* FNV-1a over the octets that follow this word */
    uint64_t octets; /* of the whole state */
    uint32_t tables; /* hash of the tables */
    uint32_t initialized;
    uint64_t part; /* rig_part_t */
} state_head_t;

static size_t state_octets(const instance_t *instance)
{
    return sizeof(state_head_t) + sizeof(kept_t) + rig_state_size() + rig_part_state_size() +
           course_state_size(&instance->course);
}

static uint64_t check_of(const char *state, size_t octets)
{
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t n = sizeof(uint64_t); n < octets; n++) {
        hash = (hash ^ (unsigned char)state[n]) * UINT64_C(1099511628211);
    }
    return hash;
}

static void save(const instance_t *instance, char *to)
{
    state_head_t head = {.octets = state_octets(instance),
                         .tables = rig_tables_hash(),
                         .initialized = instance->initialized ? 1u : 0u,
                         .part = (uint64_t)instance->part};
    char *rig = to + sizeof head + sizeof instance->kept;
    memcpy(to, &head, sizeof head);
    memcpy(to + sizeof head, &instance->kept, sizeof instance->kept);
    rig_save(instance->rig, rig);
    rig_part_save(instance->rig, rig + rig_state_size());
    course_save(&instance->course, rig + rig_state_size() + rig_part_state_size());
    head.check = check_of(to, state_octets(instance));
    memcpy(to, &head, sizeof head);
}

/* false: it is no state of this instance's scenario and library. */
static bool is_state(const instance_t *instance, const char *from, size_t octets)
{
    state_head_t head;
    if (octets != state_octets(instance)) {
        return false;
    }
    memcpy(&head, from, sizeof head);
    return head.octets == octets && head.tables == rig_tables_hash() &&
           head.part == (uint64_t)instance->part && head.check == check_of(from, octets);
}

static fmi2Status no_state(const instance_t *instance)
{
    return fmu_say(
        instance, fmi2Error,
        "the state is damaged, or belongs to another model; accepted: a state that this library has saved "
        "for the same scenario");
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    instance_t *instance = component;
    char *octets = *state != NULL ? *state : malloc(state_octets(instance));
    if (octets == NULL) {
        return fmu_say(instance, fmi2Error, "no memory for the state");
    }
    save(instance, octets);
    *state = octets;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate state)
{
    instance_t *instance = component;
    const char *from = state;
    state_head_t head;
    const char *rig = from + sizeof head + sizeof instance->kept;
    if (!is_state(instance, from, state_octets(instance)) ||
        !course_load(&instance->course, rig + rig_state_size() + rig_part_state_size()) ||
        !rig_load(instance->rig, rig, rig_state_size())) {
        return no_state(instance);
    }
    rig_part_load(instance->rig, rig + rig_state_size());
    memcpy(&head, from, sizeof head);
    memcpy(&instance->kept, from + sizeof head, sizeof instance->kept);
    instance->initialized = head.initialized != 0u;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *state)
{
    (void)component;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate state, size_t *size)
{
    (void)state;
    *size = state_octets(component);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate state, fmi2Byte to[], size_t size)
{
    if (size < state_octets(component)) {
        return no_state(component);
    }
    memcpy(to, state, state_octets(component));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte from[], size_t size,
                                   fmi2FMUstate *state)
{
    instance_t *instance = component;
    if (!is_state(instance, from, size)) {
        return no_state(instance);
    }
    *state = malloc(size);
    if (*state == NULL) {
        return fmu_say(instance, fmi2Error, "no memory for the state");
    }
    memcpy(*state, from, size);
    return fmi2OK;
}
