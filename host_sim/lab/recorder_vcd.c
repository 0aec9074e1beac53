/* Edges as a value change dump (IEEE 1364, clause 18).
 *
 * Simulated interrupts take no time: isr falls isr_ticks after it rose, or later if the function let time
 * pass. An interrupt that follows while another one is shown begins at the end of that one. These falling
 * edges are later than the present edge, so that the dump is written from a short list of future changes. */
#include "host_sim/lab/recorder_parts.h"

#include <string.h>

#include "host_sim/lab/times.h"

enum { WIRE_ISR = 6, WIRE_ADC, WIRE_TRIP, WIRES };

static const char *const names[WIRES] = {
    "upper_a", "lower_a", "upper_b", "lower_b", "upper_c", "lower_c", "isr", "adc_start", "trip",
};

typedef struct {
    recorder_out_t *out;
    uint64_t tick;           /* [1/150 MHz] of the changes not yet written */
    char level[WIRES];       /* at `tick` */
    char shown[WIRES];       /* as written */
    uint64_t time_shown;     /* [1/150 MHz] as last written */
    uint32_t isr_depth;      /* [-] interrupt functions that have not returned */
    uint64_t isr_until;      /* [1/150 MHz] the shown interrupt lasts at least to here */
    uint64_t adc_until;      /* [1/150 MHz] end of the mark of the last start */
    bool isr_ends, adc_ends; /* these ends are not written yet */
} dump_t;

static uint64_t later(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static void put_time(recorder_out_t *out, uint64_t tick)
{
    char *to = recorder_out_room(out, RECORDER_NUMBER_SIZE);
    to[0] = '#';
    const size_t length = 1u + recorder_uint_text(to + 1, times_nanoseconds(tick));
    to[length] = '\n';
    out->used += length + 1u;
}

static void put_level(recorder_out_t *out, uint32_t wire, char level)
{
    char *to = recorder_out_room(out, 3);
    to[0] = level;
    to[1] = (char)('!' + wire);
    to[2] = '\n';
    out->used += 3u;
}

/* Writes the values that have changed at the present tick. */
static void show(dump_t *dump)
{
    if (memcmp(dump->level, dump->shown, sizeof dump->level) == 0) {
        return;
    }
    put_time(dump->out, dump->tick);
    dump->time_shown = dump->tick;
    for (uint32_t wire = 0; wire < WIRES; wire++) {
        if (dump->level[wire] != dump->shown[wire]) {
            put_level(dump->out, wire, dump->level[wire]);
        }
    }
    memcpy(dump->shown, dump->level, sizeof dump->shown);
}

static void step_to(dump_t *dump, uint64_t tick)
{
    if (tick != dump->tick) {
        show(dump);
        dump->tick = tick;
    }
}

/* Writes the ends of pulses up to this tick, in the order of time. */
static void advance(dump_t *dump, uint64_t tick)
{
    for (;;) {
        const bool isr = dump->isr_ends && dump->isr_until <= tick;
        const bool adc = dump->adc_ends && dump->adc_until <= tick;
        if (isr && (!adc || dump->isr_until <= dump->adc_until)) {
            step_to(dump, dump->isr_until);
            dump->level[WIRE_ISR] = '0';
            dump->isr_ends = false;
        } else if (adc) {
            step_to(dump, dump->adc_until);
            dump->level[WIRE_ADC] = '0';
            dump->adc_ends = false;
        } else {
            break;
        }
    }
    step_to(dump, tick);
}

static void take(dump_t *dump, uint32_t what, uint32_t value, uint32_t isr_ticks)
{
    switch ((rig_edge_t)what) {
    case RIG_EDGE_GATES:
        for (uint32_t wire = 0; wire < 6u; wire++) {
            dump->level[wire] = (value >> wire & 1u) != 0u ? '1' : '0';
        }
        break;
    case RIG_EDGE_ADC_START:
        dump->level[WIRE_ADC] = '1';
        dump->adc_until = dump->tick + RECORDER_ADC_TICKS;
        dump->adc_ends = true;
        break;
    case RIG_EDGE_ISR_ENTER:
        dump->isr_until = (dump->level[WIRE_ISR] == '1' ? dump->isr_until : dump->tick) + isr_ticks;
        dump->isr_ends = false;
        dump->isr_depth++;
        dump->level[WIRE_ISR] = '1';
        break;
    case RIG_EDGE_ISR_EXIT:
        if (dump->isr_depth > 0u && --dump->isr_depth == 0u) {
            dump->isr_until = later(dump->isr_until, dump->tick);
            dump->isr_ends = true;
        }
        break;
    case RIG_EDGE_TRIP:
        dump->level[WIRE_TRIP] = value != 0u ? '1' : '0';
        break;
    }
}

int recorder_vcd_write(const recorder_t *recorder, recorder_out_t *out)
{
    recorder_out_text(out, "$version lagless $end\n$comment\n");
    /* no text may end the comment, and a dump contains printable ASCII only */
    recorder_out_meta(out, recorder, "", "$" RECORDER_ALL_BUT_ASCII);
    recorder_out_text(out, "$end\n$timescale 1 ns $end\n$scope module lagless $end\n");
    for (uint32_t wire = 0; wire < WIRES; wire++) {
        const char code[2] = {(char)('!' + wire), '\0'};
        recorder_out_text(out, "$var wire 1 ");
        recorder_out_text(out, code);
        recorder_out_text(out, " ");
        recorder_out_text(out, names[wire]);
        recorder_out_text(out, " $end\n");
    }
    recorder_out_text(out, "$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n");

    dump_t dump = {.out = out};
    memcpy(dump.level, "xxxxxx000", WIRES);
    const uint64_t count = recorder_store_count(&recorder->edges);
    uint64_t n = 0;
    /* Values at tick 0 are initial values and no changes. */
    for (; n < count; n++) {
        const recorder_edge_t edge = *(const recorder_edge_t *)recorder_store_at(&recorder->edges, n);
        if (edge >> 16 != 0u) {
            break;
        }
        take(&dump, (uint32_t)(edge >> 8) & 0xFFu, (uint32_t)edge & 0xFFu, recorder->isr_ticks);
    }
    for (uint32_t wire = 0; wire < WIRES; wire++) {
        put_level(out, wire, dump.level[wire]);
    }
    memcpy(dump.shown, dump.level, sizeof dump.shown);
    recorder_out_text(out, "$end\n");

    for (; n < count && out->error == 0; n++) {
        const recorder_edge_t edge = *(const recorder_edge_t *)recorder_store_at(&recorder->edges, n);
        advance(&dump, edge >> 16);
        take(&dump, (uint32_t)(edge >> 8) & 0xFFu, (uint32_t)edge & 0xFFu, recorder->isr_ticks);
    }
    /* The record continues to the end of the last sample's period, and until all pulses have ended. */
    uint64_t end = dump.tick;
    const uint64_t rows = recorder_store_count(&recorder->rows);
    if (rows != 0u) {
        const uint32_t *last = recorder_store_at(&recorder->rows, rows - 1u);
        end = later(end, (last[0] + UINT64_C(1)) * RIG_PERIOD_TICKS);
    }
    end = dump.isr_ends ? later(end, dump.isr_until) : end;
    end = dump.adc_ends ? later(end, dump.adc_until) : end;
    advance(&dump, end);
    show(&dump);
    if (dump.time_shown != end) {
        put_time(out, end);
    }
    recorder_out_flush(out);
    return out->error;
}
