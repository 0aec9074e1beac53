/* The master with a slave that misbehaves on command. The tests expect the reaction that the standard
 * requires of a master, and the requests that the slave received. */
#include <math.h>
#include <poll.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "host_sim/line/master.h"
#include "host_sim/line/master_parts.h"
#include "host_sim/rig/rig.h"
#include "math/float_bits.h"
#include "settings/reasons.h"
#include "tests/line/slave.h"
#include "unity.h"

static slave_t slave;
static master_t *master;
static master_error_t error;

/* Calculated by hand, in the order of the extensions. */
static uint32_t hash_of_tables(void)
{
    static const char *const names[] = {"signals", "params", "requests", "services"};
    uint32_t hash = 0;
    for (uint32_t n = 0; n < 4u; n++) {
        for (uint32_t t = 0; t < rig_table_count(); t++) {
            if (strcmp(rig_table(t)->name, names[n]) == 0) {
                hash = table_hash(rig_table(t), hash);
            }
        }
    }
    return hash;
}

static int begin(void)
{
    const int descriptor = slave_start(&slave);
    slave.epk_hash = hash_of_tables();
    return descriptor;
}

static void connect_with(bool lossless)
{
    const int descriptor = begin();
    slave.serial = !lossless;
    master = master_over(descriptor, lossless, "slave", &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(master, error.text);
}

void setUp(void)
{
    master = NULL;
    error.text[0] = '\0';
}

void tearDown(void)
{
    /* A slave that does not answer delays the DISCONNECT only for a short time. */
    slave_end(&slave);
    master_close(master);
}

static const table_row_t *row(const char *name)
{
    return rig_row_by_name(name);
}

static void has_text(const char *part)
{
    TEST_ASSERT_NOT_NULL_MESSAGE(strstr(error.text, part), error.text);
}

static double value_of(const char *name)
{
    double value = (double)NAN;
    TEST_ASSERT_TRUE_MESSAGE(master_get(master, row(name), &value, &error), error.text);
    return value;
}

/* The action took this time, and at most somewhat more on a busy machine. */
static void took(double seconds, double started)
{
    const double elapsed = master_now() - started;
    TEST_ASSERT_TRUE(elapsed > seconds - 0.01 && elapsed < seconds + 2.0);
}

/* ---- connecting ---- */

static void test_connects_and_knows_the_tables(void)
{
    connect_with(true);
    TEST_ASSERT_EQUAL(1u, slave_count(&slave, 0xFF));
    TEST_ASSERT_EQUAL_STRING_LEN("lagless-", master_epk(master), 8);
}

static void other_tables(void)
{
    slave.epk_hash ^= 0x1000u;
}

static void closes(void)
{
    slave.close_next = true;
}

static void granularity_of_words(void)
{
    slave.connect[2] = 0x02;
}

static void packets_that_the_frames_have_no_room_for(void)
{
    slave.connect[4] = 0xFF;
}

static void speaks_something_else(void)
{
    slave_octets(&slave, (const uint8_t *)"SSH-2.0-OpenSSH_9.2\r\n", 21);
}

static void test_what_is_not_a_drive_of_these_tables_is_refused(void)
{
    char both[128];
    snprintf(both, sizeof both, "tables are lagless-%08lx, those of this program lagless-%08lx",
             (unsigned long)(hash_of_tables() ^ 0x1000u), (unsigned long)hash_of_tables());
    const struct {
        void (*spoil)(void);
        const char *told;
    } rows[] = {{other_tables, both},
                {closes, "another one is connected"},
                {granularity_of_words, "this is not a lagless drive"},
                {packets_that_the_frames_have_no_room_for, "this is not a lagless drive"},
                {speaks_something_else, "the received data are not XCP"}};
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const int descriptor = begin();
        rows[n].spoil();
        TEST_ASSERT_NULL(master_over(descriptor, true, "slave", &error));
        has_text(rows[n].told);
        if (n + 1u < sizeof rows / sizeof rows[0]) {
            slave_end(&slave);
        }
    }
}

static void test_a_slave_that_never_answers_is_given_up(void)
{
    const int descriptor = begin();
    slave.mute = SLAVE_MUTE;
    slave.serial = true;
    const double started = master_now();
    TEST_ASSERT_NULL(master_over(descriptor, false, "slave", &error));
    took((1.0 + MASTER_SYNCHS) * MASTER_PATIENCE_SERIAL, started);
    TEST_ASSERT_EQUAL(1u + MASTER_SYNCHS, slave_count(&slave, 0xFF));
    TEST_ASSERT_EQUAL_MESSAGE(0u, slave_count(&slave, 0xFC), "no SYNCH before CONNECT");
    has_text("no XCP device answers");
}

/* A chip that restarts does not answer for a while, and then it answers only CONNECT. */
static void test_connects_again_after_a_restart(void)
{
    double value;
    connect_with(false);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("omega_m")->id, float_bits(3.0f));
    slave.mute = 2; /* the request of the clock, and the first CONNECT */
    slave.counter = 0;
    const double started = master_now();
    TEST_ASSERT_TRUE_MESSAGE(master_again(master, 5.0, &error), error.text);
    TEST_ASSERT_TRUE(master_now() - started < 3.0);
    TEST_ASSERT_TRUE(master_get(master, row("omega_m"), &value, &error));
    TEST_ASSERT_EQUAL_DOUBLE(3.0, value);
    TEST_ASSERT_EQUAL(0u, slave_count(&slave, 0xFC));
}

/* ---- values ---- */

static void test_values_of_every_kind(void)
{
    connect_with(true);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("omega_m")->id, float_bits(-12.5f));
    slave_put(&slave, MASTER_SIGNALS, 4u * row("period")->id, 4000000000u);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("fault_reason")->id, (uint32_t)-3);
    slave_put(&slave, MASTER_PARAMS, 4u * row("motor_resistance")->id, float_bits(0.5f));
    TEST_ASSERT_EQUAL_DOUBLE(-12.5, value_of("omega_m"));
    TEST_ASSERT_EQUAL_DOUBLE(4e9, value_of("period"));
    TEST_ASSERT_EQUAL_DOUBLE(-3.0, value_of("fault_reason"));
    TEST_ASSERT_EQUAL_DOUBLE(0.5, value_of("motor_resistance"));
}

static void test_set_writes_the_slot_at_4_times_the_id(void)
{
    connect_with(true);
    slave_put(&slave, MASTER_PARAMS, 4u * row("motor_resistance")->id, 0u);
    slave_put(&slave, MASTER_REQUESTS, 4u * row("enable")->id, 0u);
    TEST_ASSERT_TRUE(master_set(master, row("motor_resistance"), 1.25, &error));
    TEST_ASSERT_TRUE(master_set(master, row("enable"), 2.0, &error));
    TEST_ASSERT_EQUAL_HEX32(float_bits(1.25f),
                            slave_get(&slave, MASTER_PARAMS, 4u * row("motor_resistance")->id));
    TEST_ASSERT_EQUAL_HEX32(0x22222222u ^ (row("enable")->id * 0x9E3779B1u),
                            slave_get(&slave, MASTER_REQUESTS, 4u * row("enable")->id));
}

/* The value is wrong although no check on the line has detected an error. */
static void test_what_was_set_is_read_back(void)
{
    connect_with(false);
    slave_put(&slave, MASTER_REQUESTS, 4u * row("speed_request")->id, 0u);
    slave_put(&slave, MASTER_PARAMS, 4u * row("motor_resistance")->id, 0u);
    slave.spoil = 0x80000000u; /* inverts the sign */
    TEST_ASSERT_FALSE(master_set(master, row("speed_request"), 10.0, &error));
    has_text("speed_request 10: the drive has -10 instead");
    slave.spoil = 0x00800000u; /* doubles the value */
    TEST_ASSERT_FALSE(master_set(master, row("motor_resistance"), 0.5, &error));
    has_text("motor_resistance 0.5: the drive has 1 instead");
    TEST_ASSERT_TRUE(master_set(master, row("speed_request"), 10.0, &error));
}

static void test_what_a_row_does_not_accept_is_not_sent(void)
{
    connect_with(true);
    const uint32_t before = slave_count(&slave, 0xF0);
    TEST_ASSERT_FALSE(master_set(master, row("motor_resistance"), 1000.0, &error));
    has_text("motor_resistance 1000: accepted: 0.001 to 100 ohm");
    TEST_ASSERT_FALSE(master_set(master, row("motor_pole_pairs"), 1.5, &error));
    has_text("whole numbers 1 to 64");
    TEST_ASSERT_FALSE(master_set(master, row("motor_resistance"), (double)NAN, &error));
    TEST_ASSERT_FALSE(master_set(master, row("omega_m"), 1.0, &error));
    has_text("omega_m: it can be read, but not set; accepted: parameters, requests and services");
    TEST_ASSERT_FALSE(master_set(master, row("load_torque"), 1.0, &error));
    has_text("load_torque: a row of the simulation only");
    TEST_ASSERT_EQUAL(before, slave_count(&slave, 0xF0));
}

static void test_error_codes_become_texts(void)
{
    double value;
    connect_with(true);
    slave_put(&slave, MASTER_PARAMS, 4u * row("motor_resistance")->id, 0u);
    slave.error_at = 0xF0;
    slave.error = 0x22;
    TEST_ASSERT_FALSE(master_set(master, row("motor_resistance"), 1.0, &error));
    has_text("motor_resistance 1: refused");
    slave.error = 0x23;
    TEST_ASSERT_FALSE(master_set(master, row("motor_resistance"), 1.0, &error));
    has_text("it can be read, but not set");
    slave.error = 0x31;
    TEST_ASSERT_FALSE(master_set(master, row("motor_resistance"), 1.0, &error));
    has_text("error 0x31");
    TEST_ASSERT_FALSE_MESSAGE(master_get(master, row("omega_m"), &value, &error),
                              "no such slot in the slave");
    has_text("omega_m: the drive has nothing at this address");
    slave.error_at = 0;
    TEST_ASSERT_TRUE(master_set(master, row("motor_resistance"), 1.0, &error));
}

static void test_long_reads_are_cut_into_packets(void)
{
    uint8_t data[4u * 40u];
    connect_with(true);
    for (uint32_t n = 0; n < 40u; n++) {
        slave_put(&slave, MASTER_CAPTURE, 4u * n, 0x01000000u * n + n);
    }
    const uint32_t before = slave_count(&slave, 0xF4);
    TEST_ASSERT_TRUE(master_read(master, MASTER_CAPTURE, 0u, data, sizeof data, &error));
    for (uint32_t n = 0; n < 40u; n++) {
        TEST_ASSERT_EQUAL_HEX8(n, data[4u * n]);
        TEST_ASSERT_EQUAL_HEX8(n, data[4u * n + 3u]);
    }
    TEST_ASSERT_EQUAL_MESSAGE(before + 3u, slave_count(&slave, 0xF4), "160 octets are 60 + 60 + 40");
}

/* ---- a disturbed line ---- */

/* Each misbehaviour occurs once; the requested values are right nevertheless. */
static void test_a_slave_that_misbehaves_is_understood(void)
{
    static const struct {
        const char *what;
        uint32_t *field, value;
        bool lossless;
        uint32_t synchs; /* number of SYNCH commands that the master sends */
        double seconds;  /* shortest time of the first answer */
    } rows[] = {
        {"answers in single octets", &slave.split, 1u, false, 0u, 0.0},
        {"a lost answer is requested again after SYNCH", &slave.mute, 1u, false, 1u, MASTER_PATIENCE_SERIAL},
        /* The answer comes after the time-out of the master, which has sent SYNCH by then. */
        {"a late answer is not taken for the answer to the next command", &slave.late, 700u, false, 1u, 0.7},
        {"meaningless octets", &slave.noise, 21u, false, 0u, 0.0},
        {"a jump of the counter", &slave.counter_jump, 100u, false, 0u, 0.0},
        {"busy", &slave.busy, 5u, true, 0u, 0.0},
        {"the event pending extends the time-out", &slave.pending, 3u, true, 0u, 1.8},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        connect_with(rows[n].lossless);
        slave_put(&slave, MASTER_SIGNALS, 4u * row("omega_m")->id, float_bits(3.0f));
        slave_put(&slave, MASTER_SIGNALS, 4u * row("i_q")->id, float_bits(7.0f));
        *rows[n].field = rows[n].value;
        const double started = master_now();
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(3.0, value_of("omega_m"), rows[n].what);
        TEST_ASSERT_TRUE_MESSAGE(master_now() - started > rows[n].seconds - 0.01, rows[n].what);
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(7.0, value_of("i_q"), rows[n].what);
        TEST_ASSERT_EQUAL_DOUBLE_MESSAGE(3.0, value_of("omega_m"), rows[n].what);
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32_MESSAGE(rows[n].synchs, slave_count(&slave, 0xFC), rows[n].what);
        TEST_ASSERT_TRUE_MESSAGE(rows[n].synchs != 0u || slave_count(&slave, 0xFC) == 0u, rows[n].what);
        TEST_ASSERT_EQUAL_MESSAGE(0u, slave.dropped, rows[n].what);
        if (n + 1u < sizeof rows / sizeof rows[0]) {
            tearDown();
        }
    }
}

/* DOWNLOAD increments the address; a DOWNLOAD that is simply repeated would write to the wrong address. */
static void test_a_write_whose_answer_is_lost_is_repeated_from_its_address_on(void)
{
    const uint32_t address = 4u * row("motor_resistance")->id;
    connect_with(false);
    slave_put(&slave, MASTER_PARAMS, address, 0u);
    slave_put(&slave, MASTER_PARAMS, address + 4u, 0xDEADBEEFu);
    slave.mute_at = 0xF0; /* DOWNLOAD takes effect, its answer is lost */
    TEST_ASSERT_TRUE(master_set(master, row("motor_resistance"), 2.0, &error));
    TEST_ASSERT_EQUAL_HEX32(float_bits(2.0f), slave_get(&slave, MASTER_PARAMS, address));
    TEST_ASSERT_EQUAL_HEX32(0xDEADBEEFu, slave_get(&slave, MASTER_PARAMS, address + 4u));
    TEST_ASSERT_EQUAL(4u, slave_count(&slave, 0xF6)); /* each command comes twice over a serial line */
    /* The first DOWNLOAD of the pair is not carried out and not answered. */
    TEST_ASSERT_EQUAL(3u, slave_count(&slave, 0xF0));
}

static void test_a_slave_that_stops_answering_is_given_up_and_each_call_reports_it(void)
{
    double value;
    connect_with(false);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("omega_m")->id, float_bits(3.0f));
    slave.mute = SLAVE_MUTE;
    const double started = master_now();
    TEST_ASSERT_FALSE(master_get(master, row("omega_m"), &value, &error));
    took((1.0 + MASTER_SYNCHS) * MASTER_PATIENCE_SERIAL, started);
    has_text("omega_m: the drive does not answer any more");
    TEST_ASSERT_EQUAL(MASTER_SYNCHS, slave_count(&slave, 0xFC));
    TEST_ASSERT_EQUAL(-1, master_descriptor(master));
    const double again = master_now();
    TEST_ASSERT_FALSE(master_get(master, row("omega_m"), &value, &error));
    TEST_ASSERT_TRUE(master_now() - again < 0.1);
    TEST_ASSERT_FALSE(master_work(master));
}

static void test_a_line_that_is_closed_is_reported(void)
{
    double value;
    connect_with(true);
    slave.close_next = true;
    TEST_ASSERT_FALSE(master_get(master, row("omega_m"), &value, &error));
    has_text("the other end closed the connection");
}

static void test_an_idle_line_is_kept_alive(void)
{
    connect_with(true);
    const uint32_t before = slave_count(&slave, 0xDC);
    TEST_ASSERT_TRUE(master_wait(master, 10.5 * MASTER_ALIVE));
    const uint32_t count = slave_count(&slave, 0xDC) - before;
    TEST_ASSERT_TRUE(count >= 3u && count <= 11u); /* 10 on an idle machine */
}

/* ---- requests that do not wait ---- */

static uint32_t answers[3];
static int last_result;

static void count_answer(void *context, int result, const uint8_t *data, uint32_t octets)
{
    (void)data;
    (void)octets;
    answers[*(const uint32_t *)context]++;
    last_result = result;
}

static void test_questions_wait_in_the_queue_and_are_all_answered(void)
{
    static const uint32_t kinds[3] = {0, 1, 2};
    memset(answers, 0, sizeof answers);
    connect_with(true);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("omega_m")->id, float_bits(3.0f));
    for (uint32_t n = 0; n < 20u; n++) {
        master_ask_read(master, MASTER_SIGNALS, 4u * row("omega_m")->id, 4u, count_answer, (void *)&kinds[0]);
    }
    TEST_ASSERT_EQUAL_MESSAGE(0u, answers[0], "the call must not wait for an answer");
    for (uint32_t n = 0; n < 100u && answers[0] < 20u; n++) {
        TEST_ASSERT_TRUE(master_wait(master, 0.05));
    }
    TEST_ASSERT_EQUAL(20u, answers[0]);
    for (uint32_t n = 0; n < MASTER_QUEUE + 3u; n++) {
        master_ask_read(master, MASTER_SIGNALS, 4u * row("omega_m")->id, 4u, count_answer, (void *)&kinds[1]);
    }
    /* The request of the drive's clock may occupy one more place. */
    TEST_ASSERT_TRUE_MESSAGE(answers[1] == 3u || answers[1] == 4u,
                             "requests that do not fit into the queue are reported at once");
    TEST_ASSERT_EQUAL(MASTER_NOT_SENT, last_result);
    slave.close_next = true;
    (void)master_wait(master, 0.5);
    TEST_ASSERT_EQUAL_MESSAGE(MASTER_QUEUE + 3u, answers[1],
                              "after a loss of the line every request is answered");
    TEST_ASSERT_EQUAL(MASTER_LOST, last_result);
}

/* ---- orders ---- */

static void test_an_order_that_is_refused_names_reason_and_row(void)
{
    master_refusal_t refusal;
    connect_with(true);
    slave_put(&slave, MASTER_SERVICES, 4u * row("order")->id, 0u);
    slave_put(&slave, MASTER_SERVICES, 4u * row("order_refusal")->id, REASON_BRIDGE_ON);
    slave_put(&slave, MASTER_SERVICES, 4u * row("order_row")->id, row("motor_pole_pairs")->id);
    slave.error_at = 0xF0;
    slave.error = 0x22;
    TEST_ASSERT_FALSE(master_order(master, "apply", &refusal, &error));
    has_text("apply: refused for motor_pole_pairs");
    has_text("switch off first");
    TEST_ASSERT_EQUAL(REASON_BRIDGE_ON, refusal.reason);
    TEST_ASSERT_EQUAL_PTR(row("motor_pole_pairs"), refusal.row);
    slave.error_at = 0;
    slave_put(&slave, MASTER_SERVICES, 4u * row("order_refusal")->id, REASON_NONE);
    TEST_ASSERT_TRUE(master_order(master, "save", &refusal, &error));
    TEST_ASSERT_EQUAL_HEX32(2u * 0x11111111u ^ (row("order")->id * 0x9E3779B1u),
                            slave_get(&slave, MASTER_SERVICES, 4u * row("order")->id));
    TEST_ASSERT_FALSE(master_order(master, "dance", &refusal, &error));
    has_text("dance: no such order; accepted: none|apply|save");
}

/* ---- samples ---- */

typedef struct {
    uint32_t count;
    uint32_t periods[64];
    uint32_t slots[64][MASTER_DAQ_MAX];
} samples_t;

static void keep(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    samples_t *samples = context;
    if (samples->count < 64u) {
        samples->periods[samples->count] = period;
        memcpy(samples->slots[samples->count], slots, count * sizeof *slots);
    }
    samples->count++;
}

static void start(samples_t *samples, uint32_t count, uint32_t every)
{
    static const char *const names[MASTER_DAQ_MAX] = {
        "omega_m", "i_a",    "i_b",    "i_c",    "i_d",     "i_q",     "u_d",    "u_q",
        "u_dc",    "duty_a", "duty_b", "duty_c", "theta_e", "omega_e", "period", "state"};
    const table_row_t *rows[MASTER_DAQ_MAX] = {NULL};
    for (uint32_t n = 0; n < count; n++) {
        rows[n] = row(names[n]);
    }
    memset(samples, 0, sizeof *samples);
    TEST_ASSERT_TRUE_MESSAGE(master_daq_start(master, rows, count, every, keep, samples, &error), error.text);
    TEST_ASSERT_EQUAL(count, slave.rows);
    for (uint32_t n = 0; n < count; n++) {
        TEST_ASSERT_EQUAL(4u * rows[n]->id, slave.row_addresses[n]);
    }
    TEST_ASSERT_EQUAL(every, slave.prescaler);
}

static void sample(uint32_t stamp)
{
    uint32_t slots[MASTER_DAQ_MAX];
    for (uint32_t n = 0; n < MASTER_DAQ_MAX; n++) {
        slots[n] = 1000u * stamp + n;
    }
    slave_sample(&slave, stamp, slots);
}

static void test_samples_have_their_periods_and_gaps_are_found(void)
{
    samples_t samples;
    connect_with(true);
    start(&samples, 3u, 1u);
    for (uint32_t stamp = 10; stamp < 20u; stamp++) {
        if (stamp != 14u && stamp != 15u) {
            sample(stamp);
        }
    }
    TEST_ASSERT_TRUE(master_wait(master, 0.2));
    TEST_ASSERT_EQUAL(8u, samples.count);
    TEST_ASSERT_EQUAL(10u, samples.periods[0]);
    TEST_ASSERT_EQUAL(16u, samples.periods[4]);
    TEST_ASSERT_EQUAL(16002u, samples.slots[4][2]);
    const master_daq_t sum = master_daq(master);
    TEST_ASSERT_EQUAL(8u, sum.samples);
    TEST_ASSERT_EQUAL(1u, sum.gaps);
    TEST_ASSERT_EQUAL(2u, sum.missing);
    TEST_ASSERT_EQUAL_MESSAGE(0u, sum.frames_missing, "the drive has left these samples out, not the line");
    TEST_ASSERT_TRUE(master_daq_stop(master, &error));
    TEST_ASSERT_FALSE(slave.running);
}

static void test_stamps_wrap(void)
{
    samples_t samples;
    connect_with(true);
    start(&samples, 1u, 2u);
    for (uint32_t n = 0; n < 6u; n++) {
        sample(UINT32_MAX - 3u + 2u * n);
    }
    TEST_ASSERT_TRUE(master_wait(master, 0.2));
    TEST_ASSERT_EQUAL(6u, samples.count);
    TEST_ASSERT_EQUAL(0u, master_daq(master).gaps);
}

/* 16 floats are 69 octets, which take two packets of 40 octets. */
static void test_a_sample_in_several_packets_is_put_together_or_lost_as_a_whole(void)
{
    samples_t samples;
    const int descriptor = begin();
    slave.connect[4] = 40;
    master = master_over(descriptor, true, "slave", &error);
    TEST_ASSERT_NOT_NULL(master);
    start(&samples, 16u, 1u);
    TEST_ASSERT_EQUAL(2u, slave.lists);
    TEST_ASSERT_EQUAL(8u, slave.entries[0]);
    TEST_ASSERT_EQUAL(8u, slave.entries[1]);
    sample(1);
    slave.lists = 1; /* only the first packet of the next sample is sent */
    sample(2);
    slave.lists = 2;
    sample(3);
    TEST_ASSERT_TRUE(master_wait(master, 0.2));
    TEST_ASSERT_EQUAL(2u, samples.count);
    TEST_ASSERT_EQUAL(1015u, samples.slots[0][15]);
    TEST_ASSERT_EQUAL(3u, samples.periods[1]);
    TEST_ASSERT_EQUAL(3015u, samples.slots[1][15]);
    TEST_ASSERT_EQUAL(1u, master_daq(master).missing);
}

static void test_samples_come_while_a_question_waits(void)
{
    samples_t samples;
    connect_with(true);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("i_q")->id, float_bits(7.0f));
    start(&samples, 1u, 1u);
    sample(1);
    slave.mute = 1; /* the request then waits for the full time-out */
    TEST_ASSERT_EQUAL_DOUBLE(7.0, value_of("i_q"));
    sample(2);
    TEST_ASSERT_EQUAL_DOUBLE(7.0, value_of("i_q"));
    TEST_ASSERT_EQUAL(2u, samples.count);
}

static void test_what_cannot_be_sampled_is_refused(void)
{
    samples_t samples;
    const table_row_t *rows[MASTER_DAQ_MAX + 1u];
    connect_with(true);
    for (uint32_t n = 0; n <= MASTER_DAQ_MAX; n++) {
        rows[n] = row("omega_m");
    }
    TEST_ASSERT_FALSE(master_daq_start(master, rows, 17u, 1u, keep, &samples, &error));
    has_text("17 rows to sample: accepted: 1 to 16");
    TEST_ASSERT_FALSE(master_daq_start(master, rows, 0u, 1u, keep, &samples, &error));
    TEST_ASSERT_FALSE(master_daq_start(master, rows, 1u, 256u, keep, &samples, &error));
    has_text("every 256 periods: accepted: 1 to 255");
    rows[0] = row("motor_resistance");
    TEST_ASSERT_FALSE(master_daq_start(master, rows, 1u, 1u, keep, &samples, &error));
    has_text("motor_resistance: only signals");
    slave.error_at = 0xD5;
    slave.error = 0x30;
    rows[0] = row("omega_m");
    TEST_ASSERT_FALSE(master_daq_start(master, rows, 1u, 1u, keep, &samples, &error));
    has_text("no room for more samples");
}

/* ---- fault log ---- */

static void test_fault_log(void)
{
    master_fault_t faults[MASTER_FAULTS_MAX];
    uint32_t count = 99;
    connect_with(true);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("faults_seen")->id, 0u);
    TEST_ASSERT_TRUE(master_faults(master, faults, &count, &error));
    TEST_ASSERT_EQUAL(0u, count);
    slave_put(&slave, MASTER_SIGNALS, 4u * row("faults_seen")->id, 20u);
    for (uint32_t n = 0; n < 16u; n++) {
        slave_put(&slave, MASTER_FAULTS, 8u * n, 20u + n);
        slave_put(&slave, MASTER_FAULTS, 8u * n + 4u, 5000u - n);
    }
    TEST_ASSERT_TRUE(master_faults(master, faults, &count, &error));
    TEST_ASSERT_EQUAL(16u, count);
    TEST_ASSERT_EQUAL(35, faults[15].reason);
    TEST_ASSERT_EQUAL(4985u, faults[15].period);
}
