/* Opening and closing of the link, and requests that wait for their answers: values, orders, fault log,
 * capture buffer. */
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/line/master_parts.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

#define RESOURCE_CALIBRATION 0x01u

#define EPK_LENGTH 16u /* [octets] "lagless-" and 8 digits */
#define AGAIN_WAIT 0.1 /* [s] from one attempt to reconnect to the next */

/* ---- life ---- */

static master_t *create(const char *name, bool can_open, master_error_t *error)
{
    master_t *master = calloc(1, sizeof *master);
    if (master == NULL) {
        master_fail(error, "%s: no memory for the line", name);
        return NULL;
    }
    snprintf(master->name, sizeof master->name, "%s", name);
    master->can_open = can_open;
    master->descriptor = -1;
    return master;
}

static double patience_of(const char *name, bool lossless)
{
    transport_target_t target;
    char ignored[TRANSPORT_NAME_SIZE * 2u];
    const bool known = transport_parse(name, &target, ignored, sizeof ignored) && !target.tcp;
    const double serial = MASTER_PATIENCE_SERIAL + 300.0 * 10.0 / (known ? target.baud : TRANSPORT_BAUD);
    return lossless || serial > MASTER_PATIENCE ? MASTER_PATIENCE : serial;
}

/* Resets all data about the line to their state before CONNECT. If the line continues, a frame may have been
 * received in part. */
static void begin(master_t *master, int descriptor, bool lossless)
{
    const bool goes_on = descriptor == master->descriptor;
    master_forget(master);
    master->descriptor = descriptor;
    master->lost[0] = '\0';
    master->patience = patience_of(master->name, lossless);
    if (!goes_on) {
        frames_init(&master->in, lossless);
        master->out_begin = master->out_end = 0;
    }
    master->in.counted = false;
    master->synchs = 0;
    master->clock_rate = 1.0;
    master->asking_clock = false;
    master->daq = (daq_t){0};
}

/* Computes the hash over the tables of the drive, in the order of their extensions. */
static uint32_t tables_hash(void)
{
    uint32_t hash = 0;
    for (master_extension_t wanted = MASTER_SIGNALS; wanted <= MASTER_SERVICES; wanted++) {
        for (uint32_t t = 0; t < rig_table_count(); t++) {
            master_extension_t extension;
            uint32_t address;
            if (master_place(&rig_table(t)->rows[0], &extension, &address) && extension == wanted) {
                hash = table_hash(rig_table(t), hash);
            }
        }
    }
    return hash;
}

static bool check_epk(master_t *master, master_error_t *error)
{
    char own[sizeof master->epk];
    uint8_t text[EPK_LENGTH];
    if (!master_read(master, MASTER_EPK, 0u, text, EPK_LENGTH, error)) {
        return false;
    }
    snprintf(master->epk, sizeof master->epk, "%.*s", (int)EPK_LENGTH, (const char *)text);
    snprintf(own, sizeof own, "lagless-%08lx", (unsigned long)tables_hash());
    return strcmp(own, master->epk) == 0 ||
           master_fail(
               error,
               "%s: the drive's tables are %s, those of this program %s: names and ids would be confused; "
               "build both from the same sources",
               master->name, master->epk, own);
}

bool master_connect(master_t *master, master_error_t *error)
{
    uint8_t answer[MASTER_READ_MAX];
    const int result = master_asked(master, master_question(XCP_CONNECT, 2u, 7u, NULL, NULL), answer, NULL);
    if (result == MASTER_LOST && strstr(master->lost, "closed") != NULL) {
        return master_fail(
            error, "%s: %s before it answered: it takes one client at a time, and another one is connected",
            master->name, master->lost);
    }
    if (result != MASTER_OK) {
        return master_fail_result(master, error, "connect", result);
    }
    if ((answer[1] & 0x07u) != 0u) {
        return master_fail(
            error, "%s: its addresses do not count octets in Intel's order: this is not a lagless drive",
            master->name);
    }
    master->packet_max = answer[2];
    master->sample_max = master_take(answer + 3, 2u);
    if (master->packet_max < 8u || master->sample_max < 8u || master->sample_max > FRAMES_PACKET) {
        return master_fail(error, "%s: it uses packets of %u and %u octets: this is not a lagless drive",
                           master->name, (unsigned)master->packet_max, (unsigned)master->sample_max);
    }
    master->connected = true;
    return check_epk(master, error) && (master->key == 0u || master_unlock(master, master->key, error));
}

bool master_unlock(master_t *master, uint32_t key, master_error_t *error)
{
    uint8_t answer[MASTER_READ_MAX] = {0};
    question_t seed = master_question(XCP_GET_SEED, 3u, MASTER_ANY, NULL, NULL);
    seed.packets[0][2] = RESOURCE_CALIBRATION;
    master->key = key;
    int result = master_asked(master, seed, answer, NULL);
    if (result != MASTER_OK) {
        return master_fail_result(master, error, "seed", result);
    }
    if (answer[0] == 0u) {
        return true;
    }
    question_t unlock = master_question(XCP_UNLOCK, 6u, MASTER_ANY, NULL, NULL);
    unlock.packets[0][1] = 4u;
    master_put(unlock.packets[0] + 2, line_unlocks(master_take(answer + 1, 4u), key), 4u);
    result = master_asked(master, unlock, NULL, NULL);
    if (result == MASTER_LOCKED) {
        master->connected = false;
        return master_fail(
            error,
            "%s: the key is wrong: accepted: the drive's parameter line_key, and the drive has ended "
            "the connection; without a key it can be read",
            master->name);
    }
    return result == MASTER_OK || master_fail_result(master, error, "unlock", result);
}

static master_t *connected(master_t *master, master_error_t *error)
{
    if (!master_connect(master, error)) {
        master_close(master);
        return NULL;
    }
    return master;
}

static int open_target(const master_t *master, bool *lossless, master_error_t *error)
{
    return transport_open(master->name, lossless, error->text, sizeof error->text);
}

master_t *master_open(const char *target, master_error_t *error)
{
    master_t *master = create(target, true, error);
    if (master == NULL) {
        return NULL;
    }
    bool lossless = false;
    const int descriptor = open_target(master, &lossless, error);
    if (descriptor < 0) {
        free(master);
        return NULL;
    }
    begin(master, descriptor, lossless);
    return connected(master, error);
}

master_t *master_over(int descriptor, bool lossless, const char *name, master_error_t *error)
{
    master_t *master = create(name, false, error);
    if (master == NULL) {
        close(descriptor);
        return NULL;
    }
    (void)fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK);
    begin(master, descriptor, lossless);
    return connected(master, error);
}

void master_close(master_t *master)
{
    if (master == NULL) {
        return;
    }
    if (master->connected) {
        master_error_t ignored;
        if (master->daq.running) {
            (void)master_daq_stop(master, &ignored);
        }
        (void)master_asked(master, master_question(XCP_DISCONNECT, 1u, MASTER_ANY, NULL, NULL), NULL, NULL);
    }
    master_break(master, "closed");
    free(master);
}

bool master_again(master_t *master, double seconds, master_error_t *error)
{
    const double end = master_now() + seconds;
    const bool lossless = master->in.lossless;
    bool good = false;
    do {
        (void)master_wait(master, AGAIN_WAIT);
        int descriptor = master->descriptor;
        bool now_lossless = lossless;
        if (descriptor < 0 && master->can_open) {
            descriptor = open_target(master, &now_lossless, error);
        } else if (descriptor < 0) {
            return master_fail(error, "%s: %s", master->name, master->lost);
        }
        if (descriptor >= 0) {
            begin(master, descriptor, now_lossless);
            good = master_connect(master, error);
        }
    } while (!good && master_now() < end);
    return good;
}

const char *master_name(const master_t *master)
{
    return master->name;
}

const char *master_epk(const master_t *master)
{
    return master->epk;
}

/* ---- addresses and errors ---- */

/* The id that identifies the table of a row: that of its first row. Rows that were added later may have ids
 * outside the range of their table. */
static uint32_t table_id(const table_row_t *row)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        if (row >= table->rows && row < table->rows + table->count) {
            return table->rows[0].id;
        }
    }
    return row->id;
}

bool master_place(const table_row_t *row, master_extension_t *extension, uint32_t *address)
{
    static const struct {
        uint32_t first, last;
        master_extension_t extension;
    } places[] = {{1u, 999u, MASTER_PARAMS},
                  {1000u, 1899u, MASTER_REQUESTS},
                  {1900u, 1999u, MASTER_SERVICES},
                  {2000u, 2999u, MASTER_SIGNALS}};
    const uint32_t id = table_id(row);
    for (uint32_t n = 0; n < sizeof places / sizeof places[0]; n++) {
        if (id >= places[n].first && id <= places[n].last) {
            *extension = places[n].extension;
            *address = 4u * row->id;
            return true;
        }
    }
    return false;
}

bool master_fail_result(const master_t *master, master_error_t *error, const char *what, int result)
{
    static const struct {
        int result;
        const char *text;
    } texts[] = {
        {MASTER_NOT_SENT, "too many commands wait for their answers"},
        {MASTER_BUSY, "the drive is busy"},
        {0x20, "the drive does not know this command"},
        {0x21, "the drive reports that the command has a wrong form"},
        {MASTER_OUT_OF_RANGE, "the drive has nothing at this address, or the value is out of its range"},
        {MASTER_PROTECTED, "it can be read, but not set"},
        {0x24, "access denied"},
        {MASTER_LOCKED,
         "the drive is locked by its line_key: it can be read and stopped; to write, connect with --key KEY"},
        {0x26, "no such set of parameters"},
        {0x27, "not in this mode"},
        {0x29, "the drive does not accept the commands in this order"},
        {0x2A, "the samples are not set up"},
        {0x30, "the drive has no room for more samples"},
    };
    if (result == MASTER_LOST) {
        return master_fail(error, "%s: %s: %s", master->name, what, master->lost);
    }
    for (uint32_t n = 0; n < sizeof texts / sizeof texts[0]; n++) {
        if (texts[n].result == result) {
            return master_fail(error, "%s: %s: %s", master->name, what, texts[n].text);
        }
    }
    return master_fail(error, "%s: %s: the drive's error 0x%02x", master->name, what, (unsigned)result);
}

const table_row_t *master_service(const char *name, master_error_t *error)
{
    const table_row_t *row = rig_row_by_name(name);
    if (row == NULL) {
        master_fail(error, "%s: this program's tables have no such service", name);
    }
    return row;
}

/* ---- values ---- */

static question_t read_question(master_extension_t extension, uint32_t address, uint32_t octets)
{
    question_t question = master_question(XCP_SHORT_UPLOAD, 8u, octets, NULL, NULL);
    question.packets[0][1] = (uint8_t)octets;
    question.packets[0][3] = (uint8_t)extension;
    master_put(question.packets[0] + 4, address, 4u);
    return question;
}

static question_t write_question(master_extension_t extension, uint32_t address, uint32_t bits)
{
    question_t question = master_question(XCP_SET_MTA, 8u, MASTER_ANY, NULL, NULL);
    question.packets[0][3] = (uint8_t)extension;
    master_put(question.packets[0] + 4, address, 4u);
    question.packets[1][0] = XCP_DOWNLOAD;
    question.packets[1][1] = 4u;
    master_put(question.packets[1] + 2, bits, 4u);
    question.lengths[1] = 6u;
    question.count = 2u;
    return question;
}

void master_ask_read(master_t *master, master_extension_t extension, uint32_t address, uint32_t octets,
                     master_answer_t answer, void *context)
{
    question_t question = read_question(extension, address, octets);
    question.answer = answer;
    question.context = context;
    master_ask(master, &question);
}

void master_ask_write(master_t *master, master_extension_t extension, uint32_t address, uint32_t bits,
                      master_answer_t answer, void *context)
{
    question_t question = write_question(extension, address, bits);
    question.answer = answer;
    question.context = context;
    master_ask(master, &question);
}

bool master_read(master_t *master, master_extension_t extension, uint32_t address, uint8_t *to,
                 uint32_t octets, master_error_t *error)
{
    const uint32_t room =
        master->packet_max > MASTER_READ_MAX ? MASTER_READ_MAX : (master->packet_max - 1u) & ~3u;
    for (uint32_t done = 0; done < octets;) {
        uint8_t data[MASTER_READ_MAX];
        const uint32_t count = octets - done < room ? octets - done : room;
        const int result = master_asked(master, read_question(extension, address + done, count), data, NULL);
        if (result != MASTER_OK) {
            char what[64];
            snprintf(what, sizeof what, "reading address %u:%u", (unsigned)extension,
                     (unsigned)(address + done));
            return master_fail_result(master, error, what, result);
        }
        memcpy(to + done, data, count);
        done += count;
    }
    return true;
}

bool master_bits_of(const table_row_t *row, double value, uint32_t *bits)
{
    if (!rig_accepts(row, value)) {
        return false;
    }
    if (row->kind == SLOT_FLOAT) {
        const float number = (float)value;
        memcpy(bits, &number, sizeof *bits);
    } else {
        *bits = line_bits(row, (uint32_t)(int64_t)value);
    }
    return true;
}

double master_value_of(const table_row_t *row, uint32_t on_line)
{
    float number;
    int32_t whole;
    uint32_t bits = 0;
    (void)line_bits_back(row, on_line, &bits);
    memcpy(&number, &bits, sizeof number);
    memcpy(&whole, &bits, sizeof whole);
    return row->kind == SLOT_FLOAT ? (double)number : row->kind == SLOT_UINT ? (double)bits : (double)whole;
}

static bool placed(const table_row_t *row, master_extension_t *extension, uint32_t *address,
                   master_error_t *error)
{
    return master_place(row, extension, address) ||
           master_fail(
               error,
               "%s: a row of the simulation only; a drive has parameters, requests, services and signals",
               row->name);
}

bool master_get(master_t *master, const table_row_t *row, double *value, master_error_t *error)
{
    master_extension_t extension = MASTER_SIGNALS;
    uint32_t address = 0;
    uint8_t data[MASTER_READ_MAX];
    if (!placed(row, &extension, &address, error)) {
        return false;
    }
    const int result = master_asked(master, read_question(extension, address, 4u), data, NULL);
    if (result != MASTER_OK) {
        return master_fail_result(master, error, row->name, result);
    }
    *value = master_value_of(row, master_take(data, 4u));
    return true;
}

static bool fail_range(const table_row_t *row, double value, master_error_t *error)
{
    char given[RIG_NUMBER_SIZE];
    char range[RIG_RANGE_SIZE];
    if (row->kind == SLOT_ENUM) {
        return master_fail(error, "%s %s: accepted: %s (0 and up)", row->name, rig_value_text(given, value),
                           row->choices);
    }
    return master_fail(error, "%s %s: accepted: %s", row->name, rig_value_text(given, value),
                       rig_range_text(range, row, rig_min(row), rig_max(row)));
}

/* Reads the value back: the line may change it in a way that the checksum does not detect. */
static bool reads_back(master_t *master, const table_row_t *row, double value, uint32_t bits,
                       master_error_t *error)
{
    master_extension_t extension = MASTER_SIGNALS;
    uint32_t address = 0;
    uint8_t data[MASTER_READ_MAX];
    char given[RIG_NUMBER_SIZE];
    char read[RIG_NUMBER_SIZE];
    (void)master_place(row, &extension, &address);
    const int result = master_asked(master, read_question(extension, address, 4u), data, NULL);
    if (result != MASTER_OK) {
        return master_fail_result(master, error, row->name, result);
    }
    const uint32_t found = master_take(data, 4u);
    return found == bits ||
           master_fail(error, "%s %s: the drive has %s instead, read back after the write", row->name,
                       rig_value_text(given, value), rig_value_text(read, master_value_of(row, found)));
}

bool master_set(master_t *master, const table_row_t *row, double value, master_error_t *error)
{
    master_extension_t extension = MASTER_SIGNALS;
    uint32_t address = 0;
    uint32_t bits = 0;
    if (!placed(row, &extension, &address, error)) {
        return false;
    }
    if (row->access == TABLE_READ) {
        return master_fail(
            error, "%s: it can be read, but not set; accepted: parameters, requests and services", row->name);
    }
    if (!master_bits_of(row, value, &bits)) {
        return fail_range(row, value, error);
    }
    question_t question = write_question(extension, address, bits);
    question.patience = strcmp(row->name, "order") == 0 ? MASTER_PATIENCE_ORDER : MASTER_PATIENCE;
    const int result = master_asked(master, question, NULL, NULL);
    if (result == MASTER_OUT_OF_RANGE) {
        char given[RIG_NUMBER_SIZE];
        return master_fail(error,
                           "%s %s: refused, because the value contradicts the other values of its table",
                           row->name, rig_value_text(given, value));
    }
    if (result != MASTER_OK) {
        return master_fail_result(master, error, row->name, result);
    }
    return extension == MASTER_SERVICES || reads_back(master, row, value, bits, error);
}

/* ---- orders ---- */

static bool read_refusal(master_t *master, master_refusal_t *refusal, master_error_t *error)
{
    const table_row_t *reason_row = master_service("order_refusal", error);
    const table_row_t *about_row = master_service("order_row", error);
    double reason;
    double about;
    if (reason_row == NULL || about_row == NULL || !master_get(master, reason_row, &reason, error) ||
        !master_get(master, about_row, &about, error)) {
        return false;
    }
    *refusal = (master_refusal_t){.reason = (int32_t)reason, .row = rig_row((uint32_t)about)};
    return true;
}

static bool fail_refusal(const char *order, const table_row_t *order_row, const master_refusal_t *refusal,
                         master_error_t *error)
{
    const reason_row_t *reason = reason_by_number(refusal->reason);
    const bool about = refusal->row != NULL && refusal->row != order_row;
    return master_fail(error, "%s: refused%s%s: %s; %s", order, about ? " for " : "",
                       about ? refusal->row->name : "",
                       reason != NULL ? reason->text : "a reason that this program does not know",
                       reason != NULL ? reason->remedy : "see the documentation of the drive's program");
}

bool master_order(master_t *master, const char *order, master_refusal_t *refusal, master_error_t *error)
{
    *refusal = (master_refusal_t){0};
    const table_row_t *row = master_service("order", error);
    const int32_t number = row != NULL ? table_choice(row, order) : -1;
    if (row == NULL) {
        return false;
    }
    if (number < 0) {
        return master_fail(error, "%s: no such order; accepted: %s", order, row->choices);
    }
    question_t question = write_question(MASTER_SERVICES, 4u * row->id, line_bits(row, (uint32_t)number));
    question.patience = MASTER_PATIENCE_ORDER;
    const bool restart = strcmp(order, "restart") == 0;
    if (restart) {
        question.patience = MASTER_PATIENCE; /* a drive that has restarted may have lost the command */
    }
    const int result = master_asked(master, question, NULL, NULL);
    if (restart && (result == MASTER_LOST || result == MASTER_OK)) {
        return true;
    }
    if (result != MASTER_OK && result != MASTER_OUT_OF_RANGE) {
        return master_fail_result(master, error, order, result);
    }
    if (!read_refusal(master, refusal, error)) {
        return false;
    }
    return (result == MASTER_OK && refusal->reason == REASON_NONE) ||
           fail_refusal(order, row, refusal, error);
}

bool master_staged(master_t *master, bool *staged, master_error_t *error)
{
    uint8_t data[MASTER_READ_MAX];
    question_t question = master_question(XCP_GET_CAL_PAGE, 3u, 3u, NULL, NULL);
    question.packets[0][1] = 1u; /* the page that the drive uses */
    const int result = master_asked(master, question, data, NULL);
    *staged = result == MASTER_OK && data[2] != 0u;
    return result == MASTER_OK || master_fail_result(master, error, "which set is active", result);
}

/* ---- capture buffer and fault log ---- */

static bool get_service(master_t *master, const char *name, double *value, master_error_t *error)
{
    const table_row_t *row = master_service(name, error);
    return row != NULL && master_get(master, row, value, error);
}

static bool capture_columns(master_t *master, master_capture_t *capture, master_error_t *error)
{
    double count;
    if (!get_service(master, "capture_signals", &count, error)) {
        return false;
    }
    if (count < 1.0 || count > MASTER_CAPTURE_MAX) {
        return master_fail(error, "capture_signals %g: accepted: 1 to %u", count, MASTER_CAPTURE_MAX);
    }
    capture->count = (uint32_t)count;
    for (uint32_t n = 0; n < capture->count; n++) {
        char name[24];
        double id;
        snprintf(name, sizeof name, "capture_%u", (unsigned)(n + 1u));
        if (!get_service(master, name, &id, error)) {
            return false;
        }
        capture->rows[n] = rig_row((uint32_t)id);
        if (capture->rows[n] == NULL) {
            return master_fail(error, "%s: no row has the id %g", name, id);
        }
    }
    return true;
}

/* True if the buffer has the kind of content that the call needs. */
static bool judge_content(master_t *master, bool replay, master_error_t *error)
{
    double content;
    if (!get_service(master, "capture_content", &content, error)) {
        return false;
    }
    const table_row_t *row = rig_row_by_name("capture_content");
    if (((int32_t)content == table_choice(row, "replay")) == replay) {
        return true;
    }
    return master_fail(error,
                       replay ? "the capture buffer contains signals: accepted: a record for a replay; set "
                                "fault_record replay, apply, and wait for a fault or trigger the buffer"
                              : "the capture buffer contains a record for a replay: `capture save FILE` "
                                "writes it; `capture arm` records signals instead");
}

bool master_capture_head(master_t *master, master_capture_t *capture, master_error_t *error)
{
    double state;
    double periods;
    double at;
    double after;
    *capture = (master_capture_t){0};
    if (!judge_content(master, false, error) || !get_service(master, "capture_state", &state, error) ||
        !get_service(master, "capture_periods", &periods, error) ||
        !get_service(master, "capture_at", &at, error) ||
        !get_service(master, "capture_after", &after, error) || !capture_columns(master, capture, error)) {
        return false;
    }
    if ((int32_t)state != table_choice(rig_row_by_name("capture_state"), "held") || periods < 1.0) {
        return master_fail(error, "the capture buffer is still empty: arm it, and wait for its trigger");
    }
    capture->periods = (uint32_t)periods;
    capture->at = (uint32_t)at;
    capture->after = (uint32_t)after;
    return true;
}

bool master_capture(master_t *master, master_capture_t *capture, master_error_t *error)
{
    if (!master_capture_head(master, capture, error)) {
        return false;
    }
    const uint32_t octets = 4u * capture->periods * capture->count;
    uint8_t *data = malloc(octets);
    capture->slots = malloc(octets);
    bool good = data != NULL && capture->slots != NULL;
    if (!good) {
        master_fail(error, "no memory for the capture buffer");
    }
    good = good && master_read(master, MASTER_CAPTURE, 0u, data, octets, error);
    for (uint32_t n = 0; good && n < octets / 4u; n++) {
        capture->slots[n] = master_take(data + 4u * n, 4u);
    }
    free(data);
    if (!good) {
        free(capture->slots);
        capture->slots = NULL;
    }
    return good;
}

uint32_t *master_record(master_t *master, uint32_t *count, master_error_t *error)
{
    double state;
    uint8_t head[4];
    if (!judge_content(master, true, error) || !get_service(master, "capture_state", &state, error)) {
        return NULL;
    }
    if ((int32_t)state != table_choice(rig_row_by_name("capture_state"), "held")) {
        master_fail(error,
                    "the drive has no record yet: it stores one at a fault or after `capture trigger`");
        return NULL;
    }
    if (!master_read(master, MASTER_CAPTURE, 4u, head, sizeof head, error)) { /* slot 1 is their number */
        return NULL;
    }
    *count = master_take(head, 4u);
    if (*count < RIG_RECORD_HEAD || *count > CAPTURE_SLOTS + RIG_RECORD_HEAD) {
        master_fail(error, "the record has %u slots: accepted: %u to %u", (unsigned)*count, RIG_RECORD_HEAD,
                    (unsigned)(CAPTURE_SLOTS + RIG_RECORD_HEAD));
        return NULL;
    }
    uint8_t *data = malloc((size_t)4u * *count);
    uint32_t *slots = malloc((size_t)4u * *count);
    const bool good =
        data != NULL && slots != NULL && master_read(master, MASTER_CAPTURE, 0u, data, 4u * *count, error);
    for (uint32_t n = 0; good && n < *count; n++) {
        slots[n] = master_take(data + (size_t)4u * n, 4u);
    }
    free(data);
    if (!good) {
        free(slots);
        slots = NULL;
    }
    return slots;
}

bool master_faults(master_t *master, master_fault_t faults[MASTER_FAULTS_MAX], uint32_t *count,
                   master_error_t *error)
{
    double seen;
    const table_row_t *row = rig_row_by_name("faults_seen");
    if (!master_get(master, row, &seen, error)) {
        return false;
    }
    const uint32_t kept = seen < (double)MASTER_FAULTS_MAX ? (uint32_t)seen : MASTER_FAULTS_MAX;
    uint8_t data[8u * MASTER_FAULTS_MAX];
    if (!master_read(master, MASTER_FAULTS, 0u, data, 8u * kept, error)) {
        return false;
    }
    for (uint32_t n = 0; n < kept; n++) {
        faults[n] = (master_fault_t){.reason = (int32_t)master_take(data + 8u * n, 4u),
                                     .period = master_take(data + 8u * n + 4u, 4u)};
    }
    *count = kept;
    return true;
}
