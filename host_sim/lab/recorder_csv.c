/* Samples as comma-separated text. */
#include "host_sim/lab/recorder_parts.h"
#include "host_sim/lab/times.h"

/* The longest line: every cell with its comma, and the time. */
#define LINE_SIZE (RECORDER_NUMBER_SIZE * (RIG_TAP_MAX + 1u))

int recorder_csv_write(const recorder_t *recorder, recorder_out_t *out)
{
    recorder_out_meta(out, recorder, "# ", "");
    recorder_out_text(out, "time[s]");
    for (uint32_t c = 0; c < recorder->column_count; c++) {
        recorder_out_text(out, ",");
        recorder_out_text(out, recorder->columns[c].name);
        recorder_out_text(out, "[");
        recorder_out_text(out, recorder->columns[c].row->unit);
        recorder_out_text(out, "]");
    }
    recorder_out_text(out, "\n");

    slot_kind_t kinds[RIG_TAP_MAX];
    for (uint32_t c = 0; c < recorder->column_count; c++) {
        kinds[c] = recorder->columns[c].row->kind;
    }
    const uint64_t count = recorder_store_count(&recorder->rows);
    for (uint64_t n = 0; n < count && out->error == 0; n++) {
        const uint32_t *sample = recorder_store_at(&recorder->rows, n);
        char *const begin = recorder_out_room(out, LINE_SIZE);
        char *end = begin + times_write(begin, sample[0], RIG_PERIOD_TICKS);
        for (uint32_t c = 0; c < recorder->column_count; c++) {
            *end++ = ',';
            end += recorder_slot_text(end, kinds[c], sample[1u + c]);
        }
        *end++ = '\n';
        out->used += (size_t)(end - begin);
    }
    recorder_out_flush(out);
    return out->error;
}
