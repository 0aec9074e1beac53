/* Wrong bits on the serial line. A write consists of SET_MTA twice and DOWNLOAD twice, or once if the
 * value is a code. Its octets are sent with every single bit wrong, every pair of bits, and every burst of
 * up to eight bits. No request, parameter or service may then have a value that was not sent. The sum at
 * the end of a frame cannot ensure this: it misses two wrong bits of equal weight and opposite direction
 * (a bit of the value and the same bit of the sum). Therefore numbers are sent twice and named values have
 * codes. */
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/talk_values.h"
#include "host_sim/rig/rig_state.h"
#include "tests/rig/frames.h"
#include "tests/rig/run.h"
#include "tests/rig/the_rig.h"
#include "unity.h"

#define SILENCE     50u
#define OCTETS_MAX  64u
#define PARAMS      1u
#define REQUESTS    2u
#define SERVICES    3u
#define SHORT_OF_ON 20.0f

static app_t *app_of_rig;
static app_t before;

/* The slave as in talk.c, without the serial line of the chip. */
static frame_receiver_t receiver;
static xcp_t xcp;
static daq_t daq;
static uint32_t now;
static uint32_t positive; /* number of positive answers */

typedef struct {
    uint8_t octets[OCTETS_MAX];
    uint32_t count;
    uint32_t counter;
} stream_t;

static void hear(uint8_t octet)
{
    if (frame_take(&receiver, octet, now)) {
        uint16_t answer[FRAME_MAX_CTO];
        const uint32_t count = xcp_command(&xcp, &daq, &talk_access, frame_packet(&receiver), answer);
        positive += count != 0u && answer[0] == 0xFFu;
    }
}

static void hear_all(const stream_t *stream)
{
    for (uint32_t n = 0; n < stream->count; n++) {
        hear(stream->octets[n]);
    }
}

static void put_frame(stream_t *stream, const uint8_t *packet, uint32_t count)
{
    stream->count += frames_make(stream->octets + stream->count, packet, count, stream->counter, true);
    stream->counter = (stream->counter + 1u) & 0xFFFFu;
    TEST_ASSERT_TRUE(stream->count <= OCTETS_MAX);
}

/* Returns the octets of the commands that write `bits` to a row. `chooses` and `downloads` are the numbers
 * of commands of each kind. */
static stream_t write_of(uint8_t extension, uint32_t id, uint32_t bits, uint32_t chooses, uint32_t downloads)
{
    stream_t stream = {.counter = 0x00FFu + 1u};
    uint8_t choose[8] = {0xF6, 0, 0, extension};
    uint8_t download[6] = {0xF0, 4};
    frames_put_long(choose + 4, 4u * id);
    frames_put_long(download + 2, bits);
    for (uint32_t n = 0; n < chooses; n++) {
        put_frame(&stream, choose, sizeof choose);
    }
    for (uint32_t n = 0; n < downloads; n++) {
        put_frame(&stream, download, sizeof download);
    }
    return stream;
}

static uint32_t id_of(const char *name)
{
    return rig_row_by_name(name)->id;
}

static frame_receiver_t connected_receiver;
static xcp_t connected_xcp;

/* The slave is connected with CTR 0xFF; all values are the defaults, and the drive is ready. */
void setUp(void)
{
    static const uint8_t connect[] = {0xFF, 0x00};
    stream_t stream = {.counter = 0x00FFu};
    rig = rig_create(1u);
    rig_run(rig, rig_periods(0.06));
    rig_bind(rig);
    app_of_rig = &rig_state(rig)->app;
    before = *app_of_rig;
    now = 1000u;
    positive = 0u;
    frame_receiver_init(&receiver, SILENCE);
    receiver.tail = 1u;
    xcp_init(&xcp, 1u);
    daq_clear(&daq);
    put_frame(&stream, connect, sizeof connect);
    hear_all(&stream);
    TEST_ASSERT_EQUAL_UINT32(1u, positive);
    connected_receiver = receiver;
    connected_xcp = xcp;
}

/* Returns to the state at the begin of the test, after a silence on the line. */
static void begin_anew(void)
{
    receiver = connected_receiver;
    xcp = connected_xcp;
    app_of_rig->drive.requests = before.drive.requests;
    app_of_rig->staged = before.staged;
    app_of_rig->services = before.services;
    app_of_rig->talk = before.talk;
    positive = 0u;
    now += 2u * SILENCE;
    frame_listen(&receiver, now);
}

/* The result of the stream without wrong bits. */
typedef struct {
    requests_t requests;
    params_t staged;
    services_t services;
} values_t;

static values_t values(void)
{
    return (values_t){app_of_rig->drive.requests, app_of_rig->staged, app_of_rig->services};
}

static bool same(const values_t *a, const values_t *b)
{
    return memcmp(&a->requests, &b->requests, sizeof a->requests) == 0 &&
           memcmp(&a->staged, &b->staged, sizeof a->staged) == 0 &&
           memcmp(&a->services, &b->services, sizeof a->services) == 0;
}

static uint32_t trials, taken;

static void try_stream(const stream_t *stream, const values_t *old, const values_t *sent)
{
    begin_anew();
    hear_all(stream);
    const values_t is = values();
    trials++;
    taken += same(&is, sent);
    if (!same(&is, old) && !same(&is, sent)) {
        TEST_FAIL_MESSAGE("a value is active that was not sent");
    }
    TEST_ASSERT_EQUAL_UINT32(0u, app_of_rig->talk.restart);
}

static void flip(stream_t *stream, uint32_t bit)
{
    stream->octets[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
}

static void every_error_of(const stream_t *stream)
{
    const values_t old = values();
    begin_anew();
    hear_all(stream);
    const values_t sent = values();
    TEST_ASSERT_FALSE(same(&old, &sent)); /* without wrong bits the write takes effect */
    const uint32_t bits = 8u * stream->count;
    trials = taken = 0u;
    for (uint32_t first = 0; first < bits; first++) {
        stream_t wrong = *stream;
        flip(&wrong, first);
        try_stream(&wrong, &old, &sent);
        for (uint32_t second = first + 1u; second < bits; second++) {
            stream_t both = wrong;
            flip(&both, second);
            try_stream(&both, &old, &sent);
        }
        for (uint32_t pattern = 1u; pattern < 128u && first + 8u <= bits; pattern++) {
            stream_t burst = wrong;
            for (uint32_t n = 0; n < 7u; n++) {
                if ((pattern >> n & 1u) != 0u) {
                    flip(&burst, first + 1u + n);
                }
            }
            try_stream(&burst, &old, &sent);
        }
    }
    TEST_ASSERT_EQUAL_UINT32(bits + bits * (bits - 1u) / 2u + 127u * (bits - 7u), trials);
}

/* A write of each kind, with the values of the drive before it. Included are writes whose address differs
 * by one bit from that of another row: fault_reset and enable, i_d_request and i_q_request. A stop must
 * not become a start, and a start must take effect as a start or not at all. */
static void expect_what_was_sent_or_nothing(uint8_t extension, const char *name, uint32_t bits, bool number)
{
    before = *app_of_rig;
    const stream_t stream = write_of(extension, id_of(name), bits, 2u, number ? 2u : 1u);
    every_error_of(&stream);
}

static void test_a_named_value_is_the_one_that_was_sent_or_is_refused(void)
{
    static const struct {
        uint8_t extension;
        const char *name;
        uint32_t choice;
        int32_t enable; /* value of enable before the write */
    } writes[] = {{REQUESTS, "enable", REQUEST_OFF, REQUEST_QUICK_STOP},
                  {REQUESTS, "enable", REQUEST_ON, REQUEST_OFF},
                  {REQUESTS, "enable", REQUEST_QUICK_STOP, REQUEST_ON},
                  {REQUESTS, "fault_reset", 1u, REQUEST_OFF},
                  {SERVICES, "order", 1u, REQUEST_OFF}};
    app_of_rig->services.order_refusal = 5;
    for (size_t n = 0; n < sizeof writes / sizeof writes[0]; n++) {
        app_of_rig->drive.requests.enable = writes[n].enable;
        expect_what_was_sent_or_nothing(writes[n].extension, writes[n].name,
                                        frames_code(id_of(writes[n].name), writes[n].choice), false);
        begin_anew();
    }
}

static void test_a_number_is_the_one_that_was_sent_or_is_refused(void)
{
    static const struct {
        uint8_t extension;
        const char *name;
        float value;
    } writes[] = {{REQUESTS, "speed_request", SHORT_OF_ON},
                  {REQUESTS, "i_d_request", -1.5f},
                  {PARAMS, "current_limit", 8.0f}};
    for (size_t n = 0; n < sizeof writes / sizeof writes[0]; n++) {
        expect_what_was_sent_or_nothing(writes[n].extension, writes[n].name, float_bits(writes[n].value),
                                        true);
        begin_anew();
    }
}

/* A master that does not repeat its commands sends one SET_MTA and one DOWNLOAD. A number then never takes
 * effect, and a code only if the address was set before. */
static void test_a_single_pair_changes_nothing(void)
{
    const values_t old = values();
    const stream_t streams[] = {
        write_of(REQUESTS, id_of("speed_request"), float_bits(SHORT_OF_ON), 1u, 1u),
        write_of(REQUESTS, id_of("enable"), frames_code(id_of("enable"), REQUEST_ON), 1u, 1u),
    };
    for (uint32_t n = 0; n < 2u; n++) {
        for (uint32_t first = 0; first < 8u * streams[n].count; first++) {
            for (uint32_t second = first; second < 8u * streams[n].count; second++) {
                stream_t wrong = streams[n];
                flip(&wrong, first);
                flip(&wrong, second); /* both wrong bits are the same bit, which is then right */
                try_stream(&wrong, &old, &old);
            }
        }
    }
}

/* ---- the sequence ---- */

static void test_behind_a_lost_frame_nothing_acts_until_synch_and_a_new_address(void)
{
    static const uint8_t synch[] = {0xFC};
    stream_t all = write_of(REQUESTS, id_of("enable"), frames_code(id_of("enable"), REQUEST_ON), 2u, 1u);
    const values_t old = values();
    stream_t chosen = all;
    chosen.count = 28u; /* two SET_MTA of 14 octets each */
    stream_t lost = {.counter = all.counter};
    put_frame(&lost, synch, sizeof synch); /* no receiver gets this frame */
    stream_t last = {.counter = lost.counter};
    put_frame(&last, all.octets + 32u, 6u); /* the DOWNLOAD */
    begin_anew();
    const uint32_t errors = receiver.errors;
    hear_all(&chosen);
    hear_all(&last);
    values_t is = values();
    TEST_ASSERT_TRUE(same(&old, &is));
    TEST_ASSERT_EQUAL_UINT32(1u, positive); /* SET_MTA */
    TEST_ASSERT_EQUAL_UINT32(errors + 1u, receiver.errors);
    stream_t after = {.counter = last.counter + 5u}; /* the master continues to count after the loss */
    put_frame(&after, synch, sizeof synch);
    uint8_t download[6] = {0xF0, 4};
    frames_put_long(download + 2, frames_code(id_of("enable"), REQUEST_ON));
    put_frame(&after, download, sizeof download); /* the slave does not know the address any more */
    hear_all(&after);
    is = values();
    TEST_ASSERT_TRUE(same(&old, &is));
    stream_t again = write_of(REQUESTS, id_of("enable"), frames_code(id_of("enable"), REQUEST_ON), 2u, 1u);
    stream_t counted = {.counter = after.counter};
    for (uint32_t n = 0; n < 3u; n++) {
        put_frame(&counted, again.octets + 4u + 14u * n, n < 2u ? 8u : 6u);
    }
    hear_all(&counted);
    TEST_ASSERT_EQUAL(REQUEST_ON, app_of_rig->drive.requests.enable);
}

static void test_a_frame_that_comes_twice_acts_once(void)
{
    stream_t on = write_of(REQUESTS, id_of("enable"), frames_code(id_of("enable"), REQUEST_ON), 2u, 1u);
    begin_anew();
    hear_all(&on);
    TEST_ASSERT_EQUAL(REQUEST_ON, app_of_rig->drive.requests.enable);
    app_of_rig->drive.requests.enable = REQUEST_OFF;
    hear_all(&on);
    TEST_ASSERT_EQUAL(REQUEST_OFF, app_of_rig->drive.requests.enable);
}

static void test_connect_begins_a_new_count_anywhere(void)
{
    static const uint8_t connect[] = {0xFF, 0x00};
    static const uint8_t status[] = {0xFD};
    for (uint32_t counter = 0xFFF0u; counter < 0x10010u; counter++) {
        stream_t stream = {.counter = counter & 0xFFFFu};
        put_frame(&stream, connect, sizeof connect);
        put_frame(&stream, status, sizeof status);
        positive = 0u;
        hear_all(&stream);
        TEST_ASSERT_EQUAL_UINT32(2u, positive);
    }
}

/* ---- codes ---- */

/* Every named value that takes effect at once is tested, in all tables of the line. */
static void test_any_two_codes_differ_in_eight_bits(void)
{
    uint32_t codes[64];
    uint32_t count = 0u;
    for (uint32_t table = REQUESTS; table <= SERVICES; table++) {
        for (uint32_t n = 0; n < app_tables[table]->count; n++) {
            const table_row_t *row = &app_tables[table]->rows[n];
            if (row->kind == SLOT_ENUM && row->access != TABLE_READ) {
                for (int32_t choice = 0; choice <= table_whole_max(row); choice++) {
                    TEST_ASSERT_TRUE(count < 64u);
                    codes[count++] = frames_code(row->id, (uint32_t)choice);
                }
            }
        }
    }
    TEST_ASSERT_TRUE(count >= 3u + 2u + 2u + 9u);
    for (uint32_t a = 0; a < count; a++) {
        for (uint32_t b = 0; b < a; b++) {
            uint32_t distance = 0u;
            for (uint32_t left = codes[a] ^ codes[b]; left != 0u; left &= left - 1u) {
                distance++;
            }
            TEST_ASSERT_TRUE(distance >= 8u);
        }
    }
}

/* On any line, also TCP, the slave refuses a number that is not a code of this row, and reading returns
 * the code. */
static void test_only_the_codes_of_a_row_are_taken(void)
{
    const uint32_t id = id_of("enable");
    const uint32_t wrong[] = {0u,
                              1u,
                              2u,
                              frames_code(id, 3u),
                              frames_code(id, 15u),
                              frames_code(id + 1u, 1u),
                              frames_code(id, 1u) ^ 1u};
    uint16_t octets[4];
    for (uint32_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
        TEST_ASSERT_EQUAL_HEX32(XCP_OUT_OF_RANGE, talk_access.write(REQUESTS, 4u * id, 1u, &wrong[n]));
        TEST_ASSERT_EQUAL(REQUEST_OFF, app_of_rig->drive.requests.enable);
    }
    for (uint32_t choice = 0u; choice < 3u; choice++) {
        const uint32_t right = frames_code(id, choice);
        TEST_ASSERT_EQUAL_HEX32(XCP_OK, talk_access.write(REQUESTS, 4u * id, 1u, &right));
        TEST_ASSERT_EQUAL(choice, app_of_rig->drive.requests.enable);
        TEST_ASSERT_EQUAL_HEX32(XCP_OK, talk_access.read(REQUESTS, 4u * id, 4u, octets));
        for (uint32_t n = 0; n < 4u; n++) {
            TEST_ASSERT_EQUAL_HEX16(right >> 8u * n & 0xFFu, octets[n]);
        }
    }
}
