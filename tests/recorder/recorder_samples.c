/* Writes recordings for third parties to read: `recorder_samples FOLDER`.
 *
 *   run.csv, run.mat        the ring, 0.3 s at 1000 r/min, rows of every kind
 *   thinned.csv, .mat       the same, every 7th period, with texts beyond ASCII
 *   extremes.csv, .mat      the ends of every kind, floats of all exponents
 *   empty.csv, .mat         no sample at all
 *   duty.vcd, duty.json     the virtual chip, set up by the HAL, at constant compare values; what they are */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "hal/f28335/bus.h"
#include "hal/hal.h"
#include "host_sim/chip/chip.h"
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
        .folder = folder,
        .name = name,
        .formats = formats,
        .ids = ids,
        .count = count,
        .every = every,
        .isr_ticks = isr_ticks,
        .meta = {.program = "recorder_samples",
                 .commit =
                     beyond_ascii ? "\xce\xb8 \xf0\x9d\x9c\x94" : "none", /* theta; omega, beyond 16 bits */
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
    recorder_t *recorder = open_recorder(name, RECORDER_CSV | RECORDER_MAT, ids, COUNT(ids), every, 0);
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
    recorder_t *recorder = open_recorder("extremes", RECORDER_CSV | RECORDER_MAT, ids, COUNT(ids), 1, 0);
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
    close_recorder(open_recorder("empty", RECORDER_CSV | RECORDER_MAT, ids, COUNT(ids), 1, 0));
}

/* ---- the chip at constant duty ---- */

#define DEAD_BAND 375u /* 2.5 us */
#define ISR_TICKS 1500u
#define PERIODS   40u

static const uint16_t compare[3] = {1234, 3750, 6001};
static recorder_t *edges;
static uint64_t first_tick; /* carrier zero that counts as time 0 */
static uint32_t gates_level;
static uint32_t trip_mask;
static chip_t chip;

static void report_trip(uint64_t tick)
{
    const uint32_t mask = (chip_tripped(&chip, 1) ? 1u : 0u) | (chip_tripped(&chip, 2) ? 2u : 0u) |
                          (chip_tripped(&chip, 3) ? 4u : 0u);
    if (mask != trip_mask) {
        trip_mask = mask;
        recorder_edge(edges, tick - first_tick, RIG_EDGE_TRIP, mask);
    }
}

static void on_gates(void *context, uint64_t tick, uint32_t level, uint32_t driven)
{
    (void)context;
    gates_level = level & driven;
    if (edges != NULL) {
        report_trip(tick);
        recorder_edge(edges, tick - first_tick, RIG_EDGE_GATES, gates_level);
    }
}

static double on_analog(void *context, uint64_t tick, uint32_t channel)
{
    (void)context;
    (void)tick;
    (void)channel;
    return 1.5;
}

static void on_carrier(void *context, uint64_t tick, uint32_t period, const uint32_t high[3], uint32_t dead,
                       bool ends)
{
    (void)context;
    (void)tick;
    (void)period;
    (void)high;
    (void)dead;
    (void)ends;
}

static int64_t on_encoder(void *context, uint64_t tick)
{
    (void)context;
    (void)tick;
    return 0;
}

static void on_sample(void)
{
    hal_samples_t samples;
    if (edges != NULL) {
        recorder_edge(edges, chip_now(&chip) - first_tick, RIG_EDGE_ISR_ENTER, 32);
    }
    hal_read(&samples);
    hal_write_compare(compare[0], compare[1], compare[2]);
    (void)hal_gates_on();
    hal_end_of_sample();
    if (edges != NULL) {
        recorder_edge(edges, chip_now(&chip) - first_tick, RIG_EDGE_ISR_EXIT, 32);
    }
}

static void on_medium(void)
{
}

static void on_trip(void)
{
    hal_end_of_trip();
}

static void write_duty(void)
{
    static const chip_world_t world = {
        .analog = on_analog, .gates = on_gates, .carrier = on_carrier, .encoder = on_encoder};
    const hal_config_t config = {.dead_band_count = DEAD_BAND,
                                 .encoder_count_max = 9999,
                                 .on_sample = on_sample,
                                 .on_medium = on_medium,
                                 .on_trip = on_trip};
    chip_power_on(&chip, 30000000u);
    chip_bind(&chip, &world);
    if (hal_init(&config) != HAL_OK) {
        fail("the board does not come up");
    }
    chip_run(chip_now(&chip) + 5u * UINT64_C(15000)); /* compare values have been taken over */
    const uint64_t last_zero = chip_carrier_tick(&chip);
    first_tick = last_zero + UINT64_C(15000);
    chip_run(first_tick);
    edges = open_recorder("duty", RECORDER_VCD, NULL, 0, 1, ISR_TICKS);
    recorder_edge(edges, 0, RIG_EDGE_GATES, gates_level); /* what stands when the recording begins */
    report_trip(first_tick);
    chip_run(first_tick + PERIODS * UINT64_C(15000));
    const uint64_t trip_tick = chip_now(&chip);
    chip_set_pin(&chip, 12, false); /* the power module's fault line */
    report_trip(trip_tick);
    chip_run(trip_tick + UINT64_C(15000));
    close_recorder(edges);
    edges = NULL;

    char path[512];
    snprintf(path, sizeof path, "%s/duty.json", folder);
    FILE *json = fopen(path, "w");
    if (json == NULL) {
        fail(path);
    }
    /* From the registers, not from what was asked for. */
    fprintf(json,
            "{\"compare\": [%u, %u, %u], \"period\": %u, \"dead_band\": %u, \"isr_ticks\": %u, \"periods\": "
            "%u}\n",
            (unsigned)EPWM(1)->CMPA, (unsigned)EPWM(2)->CMPA, (unsigned)EPWM(3)->CMPA,
            2u * (unsigned)EPWM(1)->TBPRD, (unsigned)EPWM(1)->DBRED, ISR_TICKS, PERIODS);
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
