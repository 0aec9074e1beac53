/* Writes recordings for programs of other authors: `recorder_samples FOLDER`.
 *
 * run.csv, .mat, .mf4       the simulation, 0.3 s at 1000 r/min, with signals of every kind
 * thinned.csv, .mat, .mf4   the same run, every 7th period, with texts beyond ASCII
 * extremes.csv, .mat, .mf4  the ends of the range of every kind, floats of all exponents
 * empty.csv, .mat, .mf4     no sample
 * duty.vcd, duty.json       three legs at constant compare values, and these values */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "host_sim/lab/recorder.h"
#include "host_sim/rig/rig.h"

#define COUNT(array) ((uint32_t)(sizeof(array) / sizeof((array)[0])))

static const char *folder;

static void fail(const char *text)
{
    fprintf(stderr, "recorder_samples: %s\n", text);
    exit(1);
}

static recorder_t *open_recorder(const char *name, uint32_t formats, const uint32_t *ids, uint32_t count,
                                 uint32_t every, uint32_t isr_ticks)
{
    static const recorder_value_t values[] = {{"motor_resistance", (double)0.95f, "ohm"},
                                              {"plant.inertia", (double)0.003f, "kg m^2"},
                                              {"enable", 1.0, "-"}};
    const bool beyond_ascii = every == 7u;
    recorder_error_t error;
    const recorder_options_t options = {
        /* Theta; omega, which needs more than 16 bits. */
        .folder = folder,
        .name = name,
        .formats = formats,
        .ids = ids,
        .count = count,
        .every = every,
        .isr_ticks = isr_ticks,
        .meta = {.program = "recorder_samples",
                 .commit = beyond_ascii ? "\xce\xb8 \xf0\x9d\x9c\x94" : "none",
                 .scenario = "",
                 .scenario_text = "schema = 1\ntitle = \"sample\"\n",
                 .title = beyond_ascii ? "\xce\xb8 = 30\xc2\xb0" : "sample",
                 .seed = UINT64_C(18446744073709551615),
                 .values = values,
                 .value_count = COUNT(values)},
    };
    recorder_t *recorder = recorder_open(&options, &error);
    if (recorder == NULL) {
        fail(error.text);
    }
    if (!recorder_note(recorder, RECORDER_EVENT, "0.5 s", "load_torque = 5 N m") ||
        !recorder_note(recorder, RECORDER_VERDICT, "failed", "dip: -60 r/min, at least -56 r/min")) {
        fail("notes");
    }
    return recorder;
}

static void close_recorder(recorder_t *recorder)
{
    recorder_error_t error;
    if (!recorder_close(recorder, "complete", &error)) {
        fail(error.text);
    }
}

static void write_run(const char *name, uint32_t every)
{
    /* i_q, u_dc, state, refusal, period, encoder_count, theta_e, duty_a, true_omega_m, theta_err, i_a,
     * sample_flags */
    static const uint32_t ids[] = {2016, 2024, 2001, 2003, 2000, 2034, 2030, 2025, 3002, 3010, 2010, 2044};
    rig_t *rig = rig_create(1);
    recorder_t *recorder = open_recorder(name, RECORDER_SAMPLED, ids, COUNT(ids), every, 0);
    rig_put(rig, "speed_request", 104.7);
    rig_put(rig, "enable", 1.0);
    if (!rig_tap(rig, ids, COUNT(ids), every, recorder_sink, recorder)) {
        fail(rig_error(rig));
    }
    rig_run(rig, 3000);
    close_recorder(recorder);
    rig_free(rig);
}

static void write_extremes(void)
{
    static const uint32_t ids[] = {2016, 2000, 2002, 2001}; /* float, uint32_t, int32_t, enumeration */
    static const uint32_t words[] = {0u,          1u,          0x80000000u, 0x80000001u, 0x007FFFFFu,
                                     0x00800000u, 0x7F7FFFFFu, 0xFF7FFFFFu, 0x7F800000u, 0xFF800000u,
                                     0x7FC00000u, 0x7FFFFFFFu, 0xFFFFFFFFu, 0x3DCCCCCDu, 0x3F800000u,
                                     0x4B800000u, 0x4E6E6B28u, 0x38D1B717u};
    recorder_t *recorder = open_recorder("extremes", RECORDER_SAMPLED, ids, COUNT(ids), 1, 0);
    uint32_t period = 0;
    for (uint32_t n = 0; n < COUNT(words); n++) {
        const uint32_t slots[] = {words[n], words[n], words[n], words[n]};
        recorder_sink(recorder, period++, slots, COUNT(slots));
    }
    for (uint32_t bits = 1; bits < UINT32_C(0x7F800000); bits += 100003u) {
        const uint32_t slots[] = {bits ^ (bits % 3u == 0u ? UINT32_C(0x80000000) : 0u), bits, bits, bits};
        recorder_sink(recorder, period++, slots, COUNT(slots));
    }
    close_recorder(recorder);
}

static void write_empty(void)
{
    static const uint32_t ids[] = {2016, 2000};
    close_recorder(open_recorder("empty", RECORDER_SAMPLED, ids, COUNT(ids), 1, 0));
}

/* ---- gates at constant duty ---- */

/* Centre-aligned pulses of three legs as the chip makes them (tests/chip/test_carrier.c), with a dead
 * band, and an interrupt and a conversion in each period. At the end a trip turns all gates off. */
static void write_duty(void)
{
    enum { PERIOD = 15000, DEAD_BAND = 375, ISR_TICKS = 1500, PERIODS = 40 }; /* [ticks of 150 MHz] */
    static const uint32_t compare[3] = {1234, 3750, 6001};
    recorder_t *edges = open_recorder("duty", RECORDER_VCD, NULL, 0, 1, ISR_TICKS);
    uint32_t last = 0x100u; /* differs from every level of six gates */
    for (uint32_t tick = 0; tick < PERIODS * PERIOD; tick++) {
        const uint32_t at = tick % PERIOD;
        uint32_t gates = 0u;
        for (uint32_t leg = 0; leg < 3u; leg++) {
            const uint32_t off = compare[leg], on = PERIOD - compare[leg]; /* times of the upper command */
            gates |= at < off || at >= on + DEAD_BAND ? 1u << 2u * leg : 0u;
            gates |= at >= off + DEAD_BAND && at < on ? 2u << 2u * leg : 0u;
        }
        if (gates != last) {
            recorder_edge(edges, tick, RIG_EDGE_GATES, gates);
            last = gates;
        }
        if (at == 60u) {
            recorder_edge(edges, tick, RIG_EDGE_ADC_START, 0u);
            recorder_edge(edges, tick, RIG_EDGE_ISR_ENTER, 32u);
            recorder_edge(edges, tick, RIG_EDGE_ISR_EXIT, 32u);
        }
    }
    recorder_edge(edges, PERIODS * PERIOD, RIG_EDGE_TRIP, 7u);
    recorder_edge(edges, PERIODS * PERIOD, RIG_EDGE_GATES, 0u);
    close_recorder(edges);

    char path[512];
    snprintf(path, sizeof path, "%s/duty.json", folder);
    FILE *json = fopen(path, "w");
    if (json == NULL) {
        fail(path);
    }
    fprintf(json,
            "{\"compare\": [%u, %u, %u], \"period\": %u, \"dead_band\": %u, \"isr_ticks\": %u, \"periods\": "
            "%u}\n",
            (unsigned)compare[0], (unsigned)compare[1], (unsigned)compare[2], PERIOD, DEAD_BAND, ISR_TICKS,
            PERIODS);
    if (fclose(json) != 0) {
        fail(path);
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) {
        fail("usage: recorder_samples FOLDER");
    }
    folder = argv[1];
    (void)mkdir(folder, 0777);
    write_run("run", 1);
    write_run("thinned", 7);
    write_extremes();
    write_empty();
    write_duty();
    return 0;
}
