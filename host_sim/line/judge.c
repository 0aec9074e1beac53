#include "host_sim/line/judge.h"

#include <stdio.h>

#include "host_sim/rig/rig.h"

static const table_t *table_at(master_extension_t wanted)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        master_extension_t extension;
        uint32_t address;
        if (master_place(&rig_table(t)->rows[0], &extension, &address) && extension == wanted) {
            return rig_table(t);
        }
    }
    return NULL;
}

/* true: the simulation refuses as well. */
static bool tell(const rig_t *rig, master_error_t *why)
{
    snprintf(why->text, sizeof why->text, "%s", rig_error(rig));
    return true;
}

/* A rig with the drive's staged parameters. false: the line is lost. */
static bool copy_params(master_t *master, rig_t *rig)
{
    const table_t *params = table_at(MASTER_PARAMS);
    for (uint32_t n = 0; n < params->count; n++) {
        master_error_t ignored;
        double value;
        if (!master_get(master, &params->rows[n], &value, &ignored)) {
            return false;
        }
        (void)rig_set(rig, params->rows[n].id, value);
    }
    return true;
}

bool judge_staged(master_t *master, master_error_t *why)
{
    rig_t *rig = rig_create(0u);
    const bool refused = rig != NULL && copy_params(master, rig) && !rig_apply(rig) && tell(rig, why);
    rig_free(rig);
    return refused;
}

/* Requests are judged as a set, beginning with the active ones, which are consistent. */
static bool copy_requests(master_t *master, rig_t *rig)
{
    const table_t *requests = table_at(MASTER_REQUESTS);
    for (uint32_t n = 0; n < requests->count; n++) {
        master_error_t ignored;
        double value;
        if (!master_get(master, &requests->rows[n], &value, &ignored)) {
            return false;
        }
        (void)rig_set(rig, requests->rows[n].id, value);
    }
    return true;
}

bool judge_request(master_t *master, const table_row_t *row, double value, master_error_t *why)
{
    rig_t *rig = rig_create(0u);
    bool refused = false;
    if (rig != NULL && copy_params(master, rig)) {
        refused = !rig_apply(rig) && tell(rig, why);
        if (!refused && copy_requests(master, rig)) {
            refused = !rig_set(rig, row->id, value) && tell(rig, why);
        }
    }
    rig_free(rig);
    return refused;
}
