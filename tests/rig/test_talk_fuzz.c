/* Random and mutated octets at the drive's line, over the line of the test and over the chip's serial
 * line, while the drive runs. No period is missed and none is late. The drive sends whole frames in their
 * order. Parameters and requests are always a permitted set, and none of them changes unless its new value
 * was sent after the code of a DOWNLOAD. Argument 1 is the total number of octets. */
#include "app/talk.h"
#include "host_sim/rig/rig_state.h"
#include "settings/signals.h"
#include "tests/rig/frames.h"
#include "tests/rig/run.h"

#define RECENT 1024u /* octets that are kept: more than a command and the octets that wait before it */

static rig_t *rig;
static uint64_t octets_each = 250000u; /* number of octets in each of the six runs */
static uint32_t seed;

static bool by_chip;
static bool locked;         /* locked by a key that is never sent: no write may take effect */
static bool writes_nothing; /* no octet of a DOWNLOAD or SET_CAL_PAGE is sent, or the drive is locked */

static uint8_t to_drive[4096];
static uint32_t put, taken;
static uint8_t recent[RECENT];
static uint32_t sent; /* number of octets sent so far */
static uint64_t sent_all;

static uint8_t from_drive[4096];
static uint32_t received;
static uint32_t frames;
static bool counting; /* true once the counter of the drive's frames is known */
static uint32_t frame_counter;
static uint32_t count_sent; /* counter of the next frame to the drive */

static params_t staged, active;
static services_t services;
static requests_t requests;
static uint32_t last_period;
static uint32_t booting; /* [periods] until the drive answers after an order to restart */
static uint32_t changes;

static uint32_t dice(uint32_t sides)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed % sides;
}

/* ---- the wire ---- */

static uint32_t wire_read(void *context, uint8_t *octets, uint32_t room)
{
    (void)context;
    uint32_t count = 0u;
    while (count < room && taken < put) {
        octets[count++] = to_drive[taken++ % sizeof to_drive];
    }
    return count;
}

static uint32_t wire_write(void *context, const uint8_t *octets, uint32_t count)
{
    (void)context;
    const uint32_t room = (uint32_t)sizeof from_drive - received;
    const uint32_t some = dice(8u) == 0u ? dice(count + 1u) : count; /* at times the line is slow */
    const uint32_t given = some < room ? some : room;
    memcpy(from_drive + received, octets, given);
    received += given;
    return given;
}

static void send_octet(uint32_t octet)
{
    octet &= 0xFFu;
    if (writes_nothing && !locked && (octet == 0xF0u || octet == 0xEBu)) {
        octet ^= 0x0Fu;
    }
    to_drive[put++ % sizeof to_drive] = (uint8_t)octet;
    recent[sent++ % RECENT] = (uint8_t)octet;
    sent_all++;
}

/* Moves the waiting octets to the chip's line, at the rate of that line. */
static void move_to_chip(void)
{
    for (uint32_t n = 0; n < 9u && taken < put; n++) {
        if (rig_serial_put(rig, &to_drive[taken % sizeof to_drive], 1u) == 0u) {
            return;
        }
        taken++;
    }
}

/* ---- conditions that every run must meet ---- */

static uint32_t on_line(const table_row_t *row, uint32_t bits)
{
    return row->id >= 1000u && row->kind == SLOT_ENUM ? frames_code(row->id, bits) : bits;
}

static bool was_sent(uint32_t bits)
{
    const uint32_t count = sent < RECENT ? sent : RECENT;
    bool download = false;
    for (uint32_t n = sent - count; n != sent; n++) {
        download = download || recent[n % RECENT] == 0xF0u;
        if (download && sent - n >= 4u) {
            uint8_t octets[4];
            for (uint32_t m = 0; m < 4u; m++) {
                octets[m] = recent[(n + m) % RECENT];
            }
            if (frames_long_at(octets) == bits) {
                return true;
            }
        }
    }
    return false;
}

static void check_changes(const table_t *table, const void *before, const void *now, const void *also)
{
    for (uint32_t n = 0; n < table->count; n++) {
        const table_row_t *row = &table->rows[n];
        const uint32_t bits = table_bits(row, now);
        if (bits != table_bits(row, before)) {
            changes++;
            TEST_ASSERT_FALSE_MESSAGE(writes_nothing, row->name);
            TEST_ASSERT_TRUE_MESSAGE(
                was_sent(on_line(row, bits)) || (also != NULL && bits == table_bits(row, also)), row->name);
        }
        TEST_ASSERT_TRUE_MESSAGE(table_holds(row, now), row->name);
    }
}

static void check_values(void)
{
    const app_t *now = &rig_state(rig)->app;
    params_error_t why;
    params_t defaults;
    if (memcmp(&staged, &now->staged, sizeof staged) != 0) {
        params_defaults(&defaults);
        const bool whole = now->services.order == ORDER_LOAD;
        check_changes(&params_table, &staged, &now->staged, whole ? &now->staged : &defaults);
        staged = now->staged;
    }
    if (memcmp(&active, &now->active, sizeof active) != 0) {
        TEST_ASSERT_FALSE(writes_nothing);
        TEST_ASSERT_TRUE(params_check(&now->active, &why));
        active = now->active;
    }
    for (uint32_t n = 0; n < services_table.count && writes_nothing; n++) {
        const table_row_t *row = &services_table.rows[n];
        TEST_ASSERT_TRUE_MESSAGE(row->access == TABLE_READ ||
                                     table_bits(row, &services) == table_bits(row, &now->services),
                                 row->name);
    }
    if (locked && now->drive.requests.enable == (int32_t)REQUEST_QUICK_STOP) {
        requests.enable = (int32_t)REQUEST_QUICK_STOP; /* the one request that a locked drive accepts */
    }
    if (memcmp(&requests, &now->drive.requests, sizeof requests) != 0) {
        requests_t stopped = requests; /* the requests if the master was silent */
        stopped.enable = REQUEST_QUICK_STOP;
        check_changes(&requests_table, &requests, &now->drive.requests, &stopped);
        TEST_ASSERT_TRUE(requests_check(&now->drive.requests, &now->active, &why));
        requests = now->drive.requests;
    }
}

static void check_frames(void)
{
    uint32_t at = 0u;
    while (received - at >= 4u) {
        const uint32_t length = (uint32_t)from_drive[at] | (uint32_t)from_drive[at + 1u] << 8;
        const uint32_t count = (uint32_t)from_drive[at + 2u] | (uint32_t)from_drive[at + 3u] << 8;
        TEST_ASSERT_TRUE(length >= 1u && length <= FRAME_MAX_DTO);
        const uint32_t whole = 4u + length + (by_chip ? length % 2u + 2u : 0u);
        if (received - at < whole) {
            break;
        }
        TEST_ASSERT_TRUE(!counting || count == frame_counter);
        counting = true;
        frame_counter = (count + 1u) & 0xFFFFu;
        frames++;
        at += whole;
    }
    memmove(from_drive, from_drive + at, received - at);
    received -= at;
}

static void begin_anew(void)
{
    const app_t *now = &rig_state(rig)->app;
    staged = now->staged;
    active = now->active;
    requests = now->drive.requests;
    services = now->services;
    last_period = now->drive.fast.period;
    counting = false;
    received = 0u;
}

static void period(void)
{
    const app_t *now = &rig_state(rig)->app;
    if (by_chip) {
        move_to_chip();
    }
    rig_step(rig);
    if (by_chip) {
        received += rig_serial_get(rig, from_drive + received, (uint32_t)sizeof from_drive - received);
    }
    if (now->drive.fast.period < last_period) {
        TEST_ASSERT_FALSE(writes_nothing);
        booting = 300u;
        begin_anew();
    }
    booting -= booting > 0u ? 1u : 0u;
    if (now->services.order != ORDER_SAVE && booting == 0u) { /* no sample comes while the flash is erased */
        TEST_ASSERT_EQUAL_UINT32(last_period + 1u, now->drive.fast.period);
        TEST_ASSERT_EQUAL_UINT32(0u, now->drive.fast.measure.measured.flags & DRIVE_SAMPLE_LATE);
    }
    last_period = now->drive.fast.period;
    check_values();
    check_frames();
}

/* ---- octets ---- */

static uint32_t some_id(uint32_t table)
{
    if (dice(8u) == 0u) {
        return dice(6000u);
    }
    const table_t *of = app_tables[table % (uint32_t)APP_TABLES];
    return of->rows[dice(of->count)].id;
}

static uint32_t some_value(uint32_t id)
{
    const float small = (float)dice(2000u) / 100.0f;
    uint32_t bits;
    switch (dice(5u)) {
    case 0:
        return dice(4u);
    case 4:
        return frames_code(id, dice(4u));
    case 1:
        return dice(UINT32_MAX);
    default:
        memcpy(&bits, &small, sizeof bits);
        return bits;
    }
}

/* A command that is valid in most cases. */
static uint32_t command(uint8_t packet[64])
{
    static const uint8_t codes[] = {0xFF, 0xFE, 0xFD, 0xFC, 0xFB, 0xFA, 0xF6, 0xF5, 0xF4, 0xF3,
                                    0xF0, 0xF0, 0xF0, 0xF0, 0xF6, 0xF6, 0xF6, 0xEB, 0xEA, 0xE9,
                                    0xE8, 0xE7, 0xE2, 0xE1, 0xE0, 0xDE, 0xDD, 0xDC, 0xDA, 0xD9,
                                    0xD7, 0xD6, 0xD5, 0xD4, 0xD3, 0xE1, 0xE1, 0xFF, 0xF8, 0xF7};
    uint32_t count = 8u;
    for (uint32_t n = 0; n < 64u; n++) {
        packet[n] = (uint8_t)(dice(3u) == 0u ? dice(256u) : dice(3u));
    }
    packet[0] = codes[dice((uint32_t)sizeof codes)];
    const uint32_t table = dice(10u);
    switch (packet[0]) {
    case 0xF6:
    case 0xF4:
    case 0xE1:
        packet[1] = (uint8_t)(packet[0] == 0xE1u ? 0xFFu : 4u * (1u + dice(4u)));
        packet[2] = 4u;
        packet[3] = (uint8_t)table;
        frames_put_long(packet + 4, 4u * some_id(table));
        break;
    case 0xF0:
        packet[1] = (uint8_t)(4u * (1u + dice(3u)));
        count = 2u + packet[1];
        for (uint32_t n = 2u; n < count; n += 4u) {
            frames_put_long(packet + n, some_value(some_id(2u)));
        }
        break;
    default:
        break;
    }
    return count;
}

/* Sends a packet in a frame, which may be mutated in a bit, an octet or its length, or truncated. Half of
 * the mutated frames on the serial line have a correct sum nevertheless. */
static void send_frame(const uint8_t *packet, uint32_t length, bool mutated)
{
    const uint32_t number = by_chip && dice(32u) != 0u ? count_sent : dice(65536u);
    uint8_t frame[FRAMES_MOST];
    const bool sum_agrees = mutated && dice(2u) == 0u;
    uint32_t count = frames_make(frame, packet, length, number, by_chip && !sum_agrees);
    count_sent = (number + 1u) & 0xFFFFu;
    if (mutated) {
        switch (dice(4u)) {
        case 0:
            frame[dice(count)] ^= (uint8_t)(1u << dice(8u));
            break;
        case 1:
            count = 1u + dice(count);
            break;
        case 2:
            frame[dice(2u)] = (uint8_t)dice(256u);
            break;
        default:
            frame[dice(count)] = (uint8_t)dice(256u);
            break;
        }
    }
    if (by_chip && sum_agrees) {
        count = frames_tail(frame, count);
    }
    for (uint32_t n = 0; n < count; n++) {
        send_octet(frame[n]);
    }
}

/* A client connects, selects a row and writes it. */
static void send_write(void)
{
    static const uint8_t connect[] = {0xFF, 0x00};
    const uint32_t table = 1u + dice(3u);
    uint8_t choose[8] = {0xF6, 0u, 0u, (uint8_t)table};
    uint8_t download[6] = {0xF0, 4u};
    const uint32_t id = some_id(table);
    frames_put_long(choose + 4, 4u * id);
    frames_put_long(download + 2, some_value(id));
    send_frame(connect, 2u, false);
    for (uint32_t n = by_chip ? 2u : 1u; n > 0u; n--) {
        send_frame(choose, 8u, dice(16u) == 0u);
    }
    for (uint32_t n = by_chip ? 2u : 1u; n > 0u; n--) {
        send_frame(download, 6u, dice(16u) == 0u);
    }
}

static void some_octets(void)
{
    uint8_t packet[64];
    const uint32_t what = dice(64u);
    if (what == 0u) {
        for (uint32_t n = dice(200u); n > 0u; n--) {
            send_octet(dice(256u));
        }
    } else if (what < 16u) {
        send_write();
    } else {
        send_frame(packet, command(packet), what < 24u);
    }
}

/* Sends the next octets. If the drive drops all of them until a silence, it occasionally gets one. */
static void run(void)
{
    static const rig_line_t line = {wire_read, wire_write, NULL};
    rig_line(rig, by_chip ? NULL : &line);
    begin_anew();
    sent_all = 0u;
    while (sent_all < octets_each) {
        const bool drops = rig_state(rig)->app.talk.receiver.dropping != 0u;
        const uint32_t backlog = put - taken;
        if (drops && dice(4u) == 0u) {
            for (uint32_t n = backlog / 8u + 60u; n > 0u; n--) {
                period();
            }
        } else if (backlog == 0u || (!by_chip && backlog < 64u)) {
            some_octets();
            /* In most cases the drive has time to answer. */
            for (uint32_t n = by_chip ? dice(25u) : 0u; n > 0u; n--) {
                period();
            }
        }
        period();
    }
}

/* After all this the drive serves a new client. */
static void expect_sane(void)
{
    writes_nothing = false;
    for (uint32_t n = 0; n < 3000u; n++) {
        period();
    }
    static const uint8_t connect[] = {0x02, 0x00, 0x00, 0x00, 0xFF, 0x00, 0x01, 0x01};
    const uint32_t before = frames;
    for (uint32_t n = 0; n < (by_chip ? 8u : 6u); n++) {
        send_octet(connect[n]);
    }
    for (uint32_t n = 0; n < 500u && frames == before; n++) {
        period();
    }
    TEST_ASSERT_TRUE(frames > before);
    TEST_ASSERT_EQUAL_UINT32(1u, rig_state(rig)->app.talk.xcp.connected);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, rig_value(rig, "chip_reports"));
}

void setUp(void)
{
    seed = 20260101u;
    put = taken = sent = received = frames = changes = 0u;
    booting = 0u;
    locked = false;
    rig = run_rig(1u);
    run_put(rig, "fidelity", 1.0); /* averaged, since the test concerns the software only */
    rig_run(rig, rig_periods(0.06));
}

void tearDown(void)
{
    printf("%lu frames answered or sent, %lu values changed\n", (unsigned long)frames,
           (unsigned long)changes);
    rig_free(rig);
}

/* The drive runs as it does without a client. */
static void expect_nothing_changed(bool over_the_chip)
{
    by_chip = over_the_chip;
    writes_nothing = true;
    run_put(rig, "speed_request", 50.0);
    run_put(rig, "enable", 1.0);
    rig_run(rig, 2000u);
    run();
    TEST_ASSERT_EQUAL_UINT32(0u, changes);
    if (requests.enable == (int32_t)REQUEST_ON) {
        TEST_ASSERT_EQUAL_DOUBLE(DRIVE_OPERATION_ENABLED, rig_value(rig, "state"));
    }
    expect_sane();
}

static void test_octets_that_write_nothing_change_nothing_over_the_wire(void)
{
    expect_nothing_changed(false);
}

static void test_octets_that_write_nothing_change_nothing_over_the_serial_line(void)
{
    expect_nothing_changed(true);
}

/* All commands, among them writes, are sent to a locked drive: it accepts only a quick stop. */
static void expect_a_locked_drive_unchanged(bool over_the_chip)
{
    locked = true;
    run_parameter(rig, "line_key", 123456.0);
    expect_nothing_changed(over_the_chip);
}

static void test_a_locked_drive_is_not_written_over_the_wire(void)
{
    expect_a_locked_drive_unchanged(false);
}

static void test_a_locked_drive_is_not_written_over_the_serial_line(void)
{
    expect_a_locked_drive_unchanged(true);
}

static void expect_sent_changes(bool over_the_chip)
{
    by_chip = over_the_chip;
    writes_nothing = false;
    run();
    /* A write has 66 octets over the serial line and 22 otherwise. */
    TEST_ASSERT_TRUE(changes > octets_each / (over_the_chip ? 2000u : 1000u));
    expect_sane();
}

static void test_what_changes_was_sent_over_the_wire(void)
{
    expect_sent_changes(false);
}

static void test_what_changes_was_sent_over_the_serial_line(void)
{
    expect_sent_changes(true);
}

int main(int count, char **arguments)
{
    if (count > 1) {
        octets_each = strtoull(arguments[1], NULL, 10) / 6u;
    }
    UNITY_BEGIN();
    RUN_TEST(test_octets_that_write_nothing_change_nothing_over_the_wire);
    RUN_TEST(test_octets_that_write_nothing_change_nothing_over_the_serial_line);
    RUN_TEST(test_a_locked_drive_is_not_written_over_the_wire);
    RUN_TEST(test_a_locked_drive_is_not_written_over_the_serial_line);
    RUN_TEST(test_what_changes_was_sent_over_the_wire);
    RUN_TEST(test_what_changes_was_sent_over_the_serial_line);
    return UNITY_END();
}
