#include "host_sim/cli/traces.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/json.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/lab/times.h"

#define ROOM_FIRST UINT64_C(4096) /* [samples] */

static bool make_room(traces_t *traces)
{
    const uint64_t width = (traces->count + 1u) * sizeof *traces->slots;
    const uint64_t room = traces->room > 0u ? 2u * traces->room : ROOM_FIRST;
    uint32_t *slots = room * width <= TRACES_OCTETS_MAX ? realloc(traces->slots, room * width) : NULL;
    if (slots == NULL) {
        return false;
    }
    traces->slots = slots;
    traces->room = room;
    return true;
}

void traces_sink(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    traces_t *traces = context;
    traces->full = traces->full || (traces->samples == traces->room && !make_room(traces));
    if (!traces->full) {
        uint32_t *sample = &traces->slots[traces->samples++ * (count + 1u)];
        sample[0] = period;
        memcpy(&sample[1], slots, count * sizeof *slots);
    }
    if (traces->next != NULL) {
        traces->next(traces->next_context, period, slots, count);
    }
}

static void print_slot(uint32_t slot, slot_kind_t kind)
{
    float value;
    switch (kind) {
    case SLOT_UINT:
        printf("%" PRIu32, slot);
        return;
    case SLOT_INT:
    case SLOT_ENUM:
        printf("%" PRId32, (int32_t)slot);
        return;
    case SLOT_FLOAT:
    case SLOT_KINDS:
        break;
    }
    memcpy(&value, &slot, sizeof value);
    json_number(stdout, (double)value);
}

void traces_print(const traces_t *traces)
{
    const uint64_t width = traces->count + 1u;
    printf("[\n  {\"name\": \"time\", \"unit\": \"s\", \"values\": [");
    for (uint64_t n = 0; n < traces->samples; n++) {
        char when[TIMES_TEXT_SIZE];
        printf("%s%s", n == 0u ? "" : ", ", times_text(when, traces->slots[n * width]));
    }
    printf("]}");
    for (uint32_t c = 0; c < traces->count; c++) {
        const table_row_t *row = rig_row(traces->ids[c]);
        char name[96];
        scenario_row_name(row, name, sizeof name);
        printf(",\n  {\"name\": \"%s\", \"unit\": ", name);
        json_text(stdout, row->unit);
        printf(", \"values\": [");
        for (uint64_t n = 0; n < traces->samples; n++) {
            printf("%s", n == 0u ? "" : ", ");
            print_slot(traces->slots[n * width + 1u + c], row->kind);
        }
        printf("]}");
    }
    printf("]");
}

void traces_free(traces_t *traces)
{
    free(traces->slots);
    traces->slots = NULL;
    traces->samples = 0;
    traces->room = 0;
}
