#include "host_sim/lab/commission_drive.h"

#include <math.h>
#include <string.h>

static bool get(void *context, const table_row_t *row, double *value)
{
    const commission_rig_room_t *room = context;
    return rig_get(room->rig, row->id, value);
}

static bool put(void *context, const table_row_t *row, double value)
{
    const commission_rig_room_t *room = context;
    return rig_set(room->rig, row->id, value);
}

static bool apply(void *context)
{
    const commission_rig_room_t *room = context;
    return rig_apply(room->rig);
}

static bool wait(void *context, double seconds)
{
    commission_rig_room_t *room = context;
    const uint32_t periods = rig_run(room->rig, rig_periods(seconds));
    room->turned += periods * RIG_PERIOD_SECONDS * rig_value(room->rig, "true_omega_m");
    return true;
}

static double seconds(void *context)
{
    const commission_rig_room_t *room = context;
    return rig_period(room->rig) * RIG_PERIOD_SECONDS;
}

static double largest(void *context)
{
    commission_rig_room_t *room = context;
    const double most = room->largest;
    room->largest = 0.0;
    return most;
}

static double turned(void *context)
{
    commission_rig_room_t *room = context;
    const double turns = room->turned / (2.0 * 3.14159265358979323846);
    room->turned = 0.0;
    return turns;
}

static const char *why(void *context)
{
    const commission_rig_room_t *room = context;
    return rig_error(room->rig);
}

static void note_currents(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    commission_rig_room_t *room = context;
    (void)period;
    for (uint32_t n = 0; n < count; n++) {
        float value;
        memcpy(&value, &slots[n], sizeof value);
        room->largest = fmax(room->largest, fabs((double)value));
    }
}

commission_drive_t commission_rig_drive(commission_rig_room_t *room, rig_t *rig)
{
    const uint32_t currents[] = {rig_row_by_name("i_a")->id, rig_row_by_name("i_b")->id,
                                 rig_row_by_name("i_c")->id};
    *room = (commission_rig_room_t){.rig = rig};
    (void)rig_tap(rig, currents, 3u, 1u, note_currents, room);
    return (commission_drive_t){.get = get,
                                .put = put,
                                .apply = apply,
                                .wait = wait,
                                .seconds = seconds,
                                .largest = largest,
                                .turned = turned,
                                .why = why,
                                .context = room};
}

void commission_rig_leave(commission_rig_room_t *room)
{
    (void)rig_tap(room->rig, NULL, 0u, 1u, NULL, NULL);
}
