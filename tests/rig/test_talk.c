/* The drive on its line, octet by octet, with a master that is part of this file. */
#include "app/talk.h"
#include "host_sim/rig/rig_state.h"
#include "settings/reasons.h"
#include "settings/signals.h"
#include "tests/rig/frames.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"

#define ROOM 65536u

#define EXTENSION_SIGNALS  0u
#define EXTENSION_PARAMS   1u
#define EXTENSION_REQUESTS 2u
#define EXTENSION_SERVICES 3u

/* ---- a line of unlimited length; the chip's line is tested in cases/test_talk_noise.c and
 * test_talk_fuzz.c ---- */

static struct {
    uint8_t to_drive[ROOM];
    uint32_t put, taken;
    uint8_t from_drive[ROOM];
    uint32_t count;
    uint32_t throughput; /* [octets] that the drive can send in a period */
    uint32_t left;
} wire;
static uint32_t counter;

static uint32_t wire_read(void *context, uint8_t *octets, uint32_t room)
{
    (void)context;
    uint32_t count = 0u;
    while (count < room && wire.taken < wire.put) {
        octets[count++] = wire.to_drive[wire.taken++ % ROOM];
    }
    return count;
}

static uint32_t wire_write(void *context, const uint8_t *octets, uint32_t count)
{
    (void)context;
    uint32_t taken = 0u;
    while (taken < count && wire.left > 0u && wire.count < ROOM) {
        wire.from_drive[wire.count++] = octets[taken++];
        wire.left--;
    }
    return taken;
}

static void put_octets(const uint8_t *octets, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        wire.to_drive[wire.put++ % ROOM] = octets[n];
    }
}

static void period(void)
{
    wire.left = wire.throughput;
    rig_step(rig);
}

static void periods(uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        period();
    }
}

/* ---- the master ---- */

static void send(const uint8_t *packet, uint32_t count)
{
    uint8_t frame[FRAMES_MOST];
    put_octets(frame, frames_make(frame, packet, count, counter++, false));
}
#define SEND(...) send((const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}))

/* The next packet from the drive on the line; returns its number of octets, 0 if there is none yet. */
static uint32_t next_packet(uint8_t packet[256])
{
    const uint32_t length =
        wire.count < 4u ? 0u : (uint32_t)wire.from_drive[0] | (uint32_t)wire.from_drive[1] << 8;
    const uint32_t whole = 4u + length;
    if (wire.count < 4u || wire.count < whole) {
        return 0u;
    }
    TEST_ASSERT_TRUE(length >= 1u && length <= FRAME_MAX_DTO);
    memcpy(packet, wire.from_drive + 4, length);
    memmove(wire.from_drive, wire.from_drive + whole, wire.count - whole);
    wire.count -= whole;
    return length;
}

static uint8_t answer[256];
static uint32_t samples; /* number of samples that arrived while the master waited for an answer */

/* Waits for the answer to the last command and skips packets of samples. Returns the number of octets. */
static uint32_t wait_answer(uint32_t patience)
{
    for (uint32_t n = 0; n < patience; n++) {
        period();
        uint32_t length;
        while ((length = next_packet(answer)) != 0u) {
            if (answer[0] >= 0xFEu) {
                return length;
            }
            samples++;
        }
    }
    TEST_FAIL_MESSAGE("no answer");
    return 0u;
}

#define PATIENCE 200u /* [periods] */

static void expect_ok(void)
{
    (void)wait_answer(PATIENCE);
    TEST_ASSERT_EQUAL_HEX8(0xFF, answer[0]);
}

static void expect_error(uint8_t code)
{
    (void)wait_answer(PATIENCE);
    TEST_ASSERT_EQUAL_HEX8(0xFE, answer[0]);
    TEST_ASSERT_EQUAL_HEX8(code, answer[1]);
}

/* A command that names a row: its code, the number of slots or octets, and the address. */
static void address(uint8_t packet[8], uint8_t command, uint8_t count, uint8_t extension, uint32_t id)
{
    const uint8_t head[8] = {command, count, 0, extension};
    memcpy(packet, head, sizeof head);
    frames_put_long(packet + 4, 4u * id);
}

static void choose(uint8_t extension, uint32_t id)
{
    uint8_t packet[8];
    address(packet, 0xF6, 0, extension, id);
    send(packet, sizeof packet);
    expect_ok();
}

/* Writes this number of slots at the selected address. */
static void download(const uint32_t *bits, uint32_t count)
{
    uint8_t packet[2u + 8u] = {0xF0, (uint8_t)(4u * count)};
    for (uint32_t n = 0; n < count; n++) {
        frames_put_long(packet + 2u + 4u * n, bits[n]);
    }
    send(packet, 2u + 4u * count);
}

static void send_write(uint8_t extension, uint32_t id, uint32_t bits)
{
    choose(extension, id);
    download(&bits, 1u);
}

static void write_slot(uint8_t extension, uint32_t id, uint32_t bits)
{
    send_write(extension, id, bits);
    expect_ok();
}

static void write_choice(uint8_t extension, uint32_t id, uint32_t choice)
{
    write_slot(extension, id, frames_code(id, choice));
}

static uint32_t read_slot(uint8_t extension, uint32_t id)
{
    uint8_t packet[8];
    address(packet, 0xF4, 4, extension, id);
    send(packet, sizeof packet);
    expect_ok();
    return frames_long_at(answer + 1);
}

static void connect(void)
{
    SEND(0xFF, 0);
    expect_ok();
}

static uint32_t id_of(const char *name)
{
    return rig_row_by_name(name)->id;
}

static void plug_in(void)
{
    static const rig_line_t line = {wire_read, wire_write, NULL};
    rig_line(rig, &line);
}

void setUp(void)
{
    memset(&wire, 0, sizeof wire);
    wire.throughput = 200u;
    counter = 0u;
    samples = 0u;
    rig = run_rig(1u);
    plug_in();
    rig_run(rig, rig_periods(0.06)); /* the drive is ready */
}

/* ---- values ---- */

static void test_every_row_reads_as_the_rig_has_it(void)
{
    connect();
    for (uint32_t table = 0; table < (uint32_t)APP_TABLES; table++) {
        for (uint32_t n = 0; n < app_tables[table]->count; n++) {
            const table_row_t *row = &app_tables[table]->rows[n];
            if (table == EXTENSION_SIGNALS || row->id >= 1950u) {
                continue; /* these values change during the reading */
            }
            double value = 0.0;
            const uint32_t bits = read_slot((uint8_t)table, row->id);
            TEST_ASSERT_TRUE(rig_get(rig, row->id, &value));
            if (table >= EXTENSION_REQUESTS && row->kind == SLOT_ENUM && row->access != TABLE_READ) {
                TEST_ASSERT_EQUAL_HEX32_MESSAGE(frames_code(row->id, (uint32_t)value), bits, row->name);
                continue;
            }
            TEST_ASSERT_EQUAL_FLOAT_MESSAGE((float)value, table_value_of_bits(row, bits), row->name);
        }
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "line_errors"));
    for (uint32_t n = 0; n < 5u; n++) { /* a signal that is constant */
        TEST_ASSERT_EQUAL_HEX32(float_bits((float)rig_value(rig, "offset_a")),
                                read_slot(EXTENSION_SIGNALS, id_of("offset_a")));
    }
}

/* Two requests in one command are one set. Speed 20 and mode current would be refused one by one in either
 * order, but they are accepted in the same period. */
static void test_requests_of_one_command_are_one_set(void)
{
    connect();
    const uint32_t slow[] = {frames_code(id_of("mode"), MODE_CURRENT), float_bits(20.0f)};
    const uint32_t too_fast[] = {frames_code(id_of("mode"), MODE_SPEED), float_bits(1000.0f)};
    choose(EXTENSION_REQUESTS, id_of("mode"));
    download(slow, 2u);
    expect_ok();
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "mode"));
    TEST_ASSERT_EQUAL_DOUBLE(20.0, rig_value(rig, "speed_request"));
    choose(EXTENSION_REQUESTS, id_of("mode"));
    download(too_fast, 2u);
    expect_error(0x22);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, rig_value(rig, "mode")); /* neither request has taken effect */
}

static void test_identification_is_at_the_address_of_the_description(void)
{
    connect();
    static const struct {
        uint8_t extension;
    } places[] = {{XCP_EXTENSION_EPK}, {EXTENSION_SIGNALS}};
    char expected[17];
    snprintf(expected, sizeof expected, "lagless-%08lx", (unsigned long)app_tables_hash());
    for (uint32_t n = 0; n < 2u; n++) {
        SEND(0xF4, 16, 0, places[n].extension, 0, 0, 0, 0);
        expect_ok();
        TEST_ASSERT_EQUAL_MEMORY(expected, answer + 1, 16u);
    }
}

static void test_faults_are_reported_newest_first(void)
{
    connect();
    SEND(0xF4, 8, 0, 7, 0, 0, 0, 0);
    expect_ok();
    static const uint8_t none[8] = {0};
    TEST_ASSERT_EQUAL_MEMORY(none, answer + 1, 8u);
    run_put(rig, "stuck_dc_link", 4095.0);
    periods(100u);
    const uint32_t reason = (uint32_t)rig_value(rig, "fault_reason");
    const uint32_t at = (uint32_t)rig_value(rig, "fault_period");
    TEST_ASSERT_EQUAL_UINT32(REASON_DC_OVERVOLTAGE, reason);
    TEST_ASSERT_EQUAL_UINT32(reason, read_slot(7u, 0u));
    TEST_ASSERT_EQUAL_UINT32(at, read_slot(7u, 1u));
    TEST_ASSERT_EQUAL_UINT32(0u, read_slot(7u, 2u));
}

/* ---- the master is silent ---- */

static void switch_on(void)
{
    write_slot(EXTENSION_REQUESTS, id_of("speed_request"), float_bits(50.0f));
    write_choice(EXTENSION_REQUESTS, id_of("enable"), REQUEST_ON);
}

static bool warns(void)
{
    return ((uint32_t)rig_value(rig, FAULT_MASTER_SILENT < 32 ? "warnings" : "warnings_2") >>
                ((uint32_t)FAULT_MASTER_SILENT % 32u) &
            1u) != 0u;
}

static void test_a_silent_master_brings_a_quick_stop(void)
{
    connect();
    switch_on();
    for (uint32_t n = 0; n < 30u; n++) { /* any correct command counts as a sign of life */
        periods(rig_periods(0.09));
        SEND(0xFD);
        expect_ok();
    }
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_ON, rig_value(rig, "enable"));
    periods(rig_periods(0.998));
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_ON, rig_value(rig, "enable"));
    TEST_ASSERT_FALSE(warns());
    periods(rig_periods(0.004));
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_QUICK_STOP, rig_value(rig, "enable"));
    TEST_ASSERT_EQUAL_DOUBLE(DRIVE_QUICK_STOP, rig_value(rig, "state"));
    TEST_ASSERT_TRUE(warns());
    periods(rig_periods(2.0));
    TEST_ASSERT_EQUAL_DOUBLE(DRIVE_READY, rig_value(rig, "state"));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "fault_reason"));
    TEST_ASSERT_TRUE(warns()); /* the warning remains until a client has read it */
    connect();
    TEST_ASSERT_TRUE(warns());
    write_choice(EXTENSION_REQUESTS, id_of("enable"), REQUEST_OFF);
    periods(rig_periods(0.002));
    TEST_ASSERT_FALSE(warns());
    write_choice(EXTENSION_REQUESTS, id_of("enable"), REQUEST_ON);
    periods(rig_periods(0.1));
    TEST_ASSERT_EQUAL_DOUBLE(DRIVE_OPERATION_ENABLED, rig_value(rig, "state"));
}

/* Octets that are not a command do not count as a sign of life. */
static void test_noise_is_not_a_sign_of_life(void)
{
    connect();
    switch_on();
    for (uint32_t n = 0; n < 11000u; n++) {
        const uint8_t noise[3] = {(uint8_t)(n * 37u), (uint8_t)(n * 101u | 0x80u), (uint8_t)(n >> 3)};
        put_octets(noise, 3u);
        period();
    }
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_QUICK_STOP, rig_value(rig, "enable"));
    TEST_ASSERT_TRUE(rig_value(rig, "line_errors") > 0.0);
}

static void test_command_timeout_may_be_changed_or_off(void)
{
    connect();
    run_parameter(rig, "command_timeout", 0.05);
    switch_on();
    periods(rig_periods(0.049));
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_ON, rig_value(rig, "enable"));
    periods(rig_periods(0.003));
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_QUICK_STOP, rig_value(rig, "enable"));
    periods(rig_periods(1.0));
    run_parameter(rig, "command_timeout", 0.0);
    write_choice(EXTENSION_REQUESTS, id_of("enable"), REQUEST_OFF);
    write_choice(EXTENSION_REQUESTS, id_of("enable"), REQUEST_ON);
    periods(rig_periods(5.0));
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_ON, rig_value(rig, "enable"));
}

/* A drive that was switched on in another way does not stop if a master disconnects. */
static void test_only_what_the_line_switched_on_stops_with_it(void)
{
    connect();
    run_put(rig, "speed_request", 50.0);
    run_put(rig, "enable", REQUEST_ON);
    write_slot(EXTENSION_REQUESTS, id_of("speed_request"), float_bits(55.0f));
    periods(rig_periods(3.0));
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_ON, rig_value(rig, "enable"));
    TEST_ASSERT_EQUAL_DOUBLE(DRIVE_OPERATION_ENABLED, rig_value(rig, "state"));
}

/* ---- floods ---- */

/* Allocates one list with one table of this number of entries, the first of which is next. */
static void allocate(uint8_t entries)
{
    SEND(0xD6);
    expect_ok();
    SEND(0xD5, 0, 1, 0);
    expect_ok();
    SEND(0xD4, 0, 0, 0, 1);
    expect_ok();
    SEND(0xD3, 0, 0, 0, 0, entries);
    expect_ok();
    SEND(0xE2, 0, 0, 0, 0, 0);
    expect_ok();
}

static void send_entry(uint8_t extension, uint32_t place)
{
    SEND(0xE1, 0xFF, 4, extension, (uint8_t)place, (uint8_t)(place >> 8), 0, 0);
}

static void stream(uint32_t entries, uint8_t prescaler, const uint32_t *ids)
{
    allocate((uint8_t)entries);
    for (uint32_t n = 0; n < entries; n++) {
        send_entry(EXTENSION_SIGNALS, 4u * ids[n]);
        expect_ok();
    }
    SEND(0xE0, 0x10, 0, 0, 0, 0, prescaler, 0);
    expect_ok();
    SEND(0xDE, 2, 0, 0);
    expect_ok();
    SEND(0xDD, 1);
    expect_ok();
}

/* The drive sends samples of 16 slots in every period over a line that transfers a tenth of them. It must
 * obey the stop as soon as the octets have arrived, and send the answer when the present frame is out. */
static void test_stop_is_obeyed_while_the_line_is_flooded_by_samples(void)
{
    const uint32_t period_id = id_of("period");
    uint32_t ids[16];
    for (uint32_t n = 0; n < 16u; n++) {
        ids[n] = period_id;
    }
    connect();
    switch_on();
    stream(16u, 1u, ids);
    wire.throughput = 7u;
    periods(500u);
    TEST_ASSERT_TRUE(rig_value(rig, "daq_lost") > 100.0);
    send_write(EXTENSION_REQUESTS, id_of("enable"), frames_code(id_of("enable"), REQUEST_OFF));
    const double begun = rig_value(rig, "period");
    periods(3u);
    TEST_ASSERT_EQUAL_DOUBLE(REQUEST_OFF, rig_value(rig, "enable"));
    TEST_ASSERT_EQUAL_DOUBLE(begun + 3.0, rig_value(rig, "period"));
    expect_ok(); /* it comes after at most one frame, of 73 octets at 7 per period */
}

/* ---- restart ---- */

static void test_restart_is_answered_and_begins_again(void)
{
    connect();
    run_parameter(rig, "current_limit", 8.0);
    write_choice(EXTENSION_SERVICES, id_of("order"), ORDER_RESTART); /* the drive answers it */
    periods(rig_periods(0.1));
    TEST_ASSERT_TRUE(rig_value(rig, "period") < (double)rig_periods(0.1));
    TEST_ASSERT_EQUAL_DOUBLE(10.0, rig_value(rig, "current_limit"));
    TEST_ASSERT_EQUAL_UINT32(0u, rig_state(rig)->app.talk.xcp.connected);
    connect();
    switch_on();
    periods(rig_periods(0.1));
    send_write(EXTENSION_SERVICES, id_of("order"), frames_code(id_of("order"), ORDER_RESTART));
    expect_error(0x22);
    TEST_ASSERT_EQUAL_UINT32(REASON_BRIDGE_ON, read_slot(EXTENSION_SERVICES, id_of("order_refusal")));
    TEST_ASSERT_EQUAL_DOUBLE(DRIVE_OPERATION_ENABLED, rig_value(rig, "state"));
}

/* ---- refused requests ---- */

static void test_a_value_out_of_its_range_and_a_row_of_another_table_are_not_staged(void)
{
    connect();
    send_write(EXTENSION_PARAMS, id_of("current_limit"), float_bits(-1.0f));
    expect_error(0x22);
    TEST_ASSERT_EQUAL_HEX32(float_bits(10.0f), read_slot(EXTENSION_PARAMS, id_of("current_limit")));
    send_write(EXTENSION_PARAMS, id_of("i_a"), float_bits(1.0f));
    expect_error(0x22);
}

/* The entry of a list must be a whole signal: a row of another table, or an address within a slot, is
 * refused. */
static void test_nothing_but_a_whole_signal_is_measured(void)
{
    const uint32_t signal = 4u * id_of("i_a");
    const uint32_t parameter = 4u * id_of("current_limit");
    connect();
    allocate(1u);
    send_entry(EXTENSION_PARAMS, parameter);
    expect_error(0x22);
    send_entry(EXTENSION_PARAMS, signal);
    expect_error(0x22);
    for (uint32_t within = 1u; within < 4u; within++) {
        send_entry(EXTENSION_SIGNALS, signal + within);
        expect_error(0x22);
    }
    send_entry(EXTENSION_SIGNALS, signal);
    expect_ok();
}
