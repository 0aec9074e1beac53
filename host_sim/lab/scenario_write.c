#include "host_sim/lab/scenario_write.h"

#include <inttypes.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/units.h"

static void write_value(FILE *file, const scenario_setting_t *setting)
{
    char text[UNITS_TEXT_SIZE];
    if (setting->row->kind == SLOT_ENUM) {
        fprintf(file, "%s = \"%s\"\n", setting->row->name,
                units_row_text(text, setting->value, setting->row));
    } else {
        fprintf(file, "%s = %.17g\n", setting->row->name, setting->value);
    }
}

static void write_initial(FILE *file, const scenario_event_t *initial)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const char *section = rig_table(t)->name;
        for (uint32_t n = 0; n < initial->count; n++) {
            if (scenario_table_of(initial->settings[n].row) != rig_table(t)) {
                continue;
            }
            if (section != NULL) {
                fprintf(file, "\n[%s]\n", section);
            }
            section = NULL;
            write_value(file, &initial->settings[n]);
        }
    }
}

static void write_event(FILE *file, const scenario_event_t *event)
{
    fprintf(file, "\n[[at]]\ntime = %.17g\n", event->time);
    if (event->ramp_periods > 0u) {
        fprintf(file, "ramp = %.17g\n", event->ramp);
    }
    for (uint32_t n = 0; n < event->count; n++) {
        fprintf(file, "%s.", scenario_table_of(event->settings[n].row)->name);
        write_value(file, &event->settings[n]);
    }
}

void scenario_write(FILE *file, const scenario_t *scenario, uint64_t seed)
{
    fprintf(file, "schema = 1\n%stitle = ", boards_line());
    json_text(file, scenario->title); /* a string of TOML is written as one of JSON */
    fprintf(file, "\n\n[run]\nduration = %.17g\nseed = %" PRIu64 "\n", scenario->duration, seed);
    if (scenario->has_start) {
        fprintf(file, "\n[start]\nangle = %.17g\n", scenario->start_angle);
    }
    if (scenario->has_start_speed) {
        fprintf(file, "speed = %.17g\n", scenario->start_speed);
    }
    write_initial(file, &scenario->events[0]);
    for (uint32_t n = 1; n < scenario->event_count; n++) {
        write_event(file, &scenario->events[n]);
    }
}
