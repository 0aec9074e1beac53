#include "host_sim/scope/scope.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host_sim/lab/json.h"
#include "host_sim/line/transport.h"
#include "host_sim/rig/rig.h"
#include "host_sim/scope/http.h"
#include "host_sim/scope/scope_capture.h"
#include "host_sim/scope/scope_commission.h"
#include "host_sim/scope/scope_text.h"
#include "settings/reasons.h"

#define FRAME       0.025 /* [s] from one picture to the next */
#define ASK         0.03  /* [s] from one request for values to the next */
#define TELL        0.1   /* [s] between two reports of values and state of the line */
#define AGAIN       0.5   /* [s] from one try to find a lost drive to the next */
#define AGAIN_TRY   0.05  /* [s] that a try lasts, at least */
#define LONGEST     0.1   /* [s] of waiting */
#define BLOCK_MAX   15u   /* [slots] of one question: MASTER_READ_MAX octets */
#define SAMPLES_MAX 4096u /* [samples] after which they are sent, independent of the time */
#define LINE_SHARE  0.8   /* [-] of a serial line that samples may take */
#define SILENT      2.0   /* [s] without an expected sample, until the drive counts as restarted */
#define TEXT_MAX    700u

/* Slots that are read together: their ids follow each other. */
typedef struct {
    uint32_t first, count; /* places in the values */
} block_t;

struct scope {
    master_t *master;
    http_t *http;
    const char *page;
    size_t page_size;
    bool lost;
    bool started;      /* the motor was switched on by this server */
    double alone_from; /* [s] when the last page was closed; 0: a page is open */
    double next_frame, next_ask, next_tell, next_again; /* [s] */
    /* values */
    scope_values_t values;
    double heard_at;                /* [s] arrival of the last of them */
    block_t blocks[SCOPE_ROWS_MAX]; /* those that change fast first */
    uint32_t block_count, fast_count;
    uint32_t next_fast, next_slow, asks;
    uint32_t asked; /* block; block_count or more: none */
    bool asking, staged;
    /* samples */
    const table_row_t *rows[SCOPE_SIGNALS];
    uint32_t row_count, every;
    bool every_given;    /* chosen by a page, else as often as the line allows */
    uint32_t generation; /* of the choice of signals */
    uint32_t first, last, sample_count;
    double sample_at; /* [s] of the last one, or of the start */
    uint32_t slots[SAMPLES_MAX * SCOPE_SIGNALS];
    scope_capture_t capture;
    scope_commission_t commission;
    double wake; /* [s] time at which commissioning continues */
    const volatile sig_atomic_t *stop;
};

static const char *const first_signals[] = {"omega_m", "omega_m_ref", "i_q", "i_d", "u_q", "u_d"};

/* The values in the head of the page. */
static const char *const fast_rows[] = {"state",     "fault_reason", "refusal",       "warnings",
                                        "manoeuvre", "u_dc",         "omega_m",       "enable",
                                        "i_q",       "warnings_2",   "order_refusal", "capture_state"};

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* ---- telling ---- */

typedef struct {
    FILE *file; /* NULL: no memory, the event is lost */
    char *data;
    size_t size;
} text_t;

static bool text_begin(text_t *text)
{
    text->data = NULL;
    text->size = 0u;
    text->file = open_memstream(&text->data, &text->size);
    return text->file != NULL;
}

static void tell(scope_t *scope, text_t *text, uint32_t client, const char *event, bool may_be_lost)
{
    if (fclose(text->file) == 0) {
        http_event(scope->http, client, event, text->data, text->size, may_be_lost);
    }
    free(text->data);
}

static void tell_samples(scope_t *scope)
{
    text_t text;
    if (scope->sample_count > 0u && http_streams(scope->http) > 0u && text_begin(&text)) {
        fprintf(text.file, "{\"g\":%u,\"p\":%u,\"e\":%u,\"c\":%u,\"n\":%u,\"d\":\"",
                (unsigned)scope->generation, (unsigned)scope->first, (unsigned)scope->every,
                (unsigned)scope->row_count, (unsigned)scope->sample_count);
        scope_base64(text.file, (const uint8_t *)scope->slots,
                     (size_t)scope->sample_count * scope->row_count * sizeof scope->slots[0]);
        fputs("\"}", text.file);
        tell(scope, &text, HTTP_ALL, "samples", true);
    }
    scope->sample_count = 0u;
}

/* The samples of one message have no gap. */
static void on_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    scope_t *scope = context;
    const bool gap = scope->sample_count > 0u && period - scope->last != scope->every;
    if (gap || scope->sample_count == SAMPLES_MAX) {
        tell_samples(scope);
    }
    if (scope->sample_count == 0u) {
        scope->first = period;
    }
    memcpy(&scope->slots[(size_t)scope->sample_count * count], slots, count * sizeof slots[0]);
    scope->sample_count++;
    scope->last = period;
    scope->sample_at = now();
}

static void put_line(const scope_t *scope, FILE *to)
{
    const master_daq_t daq = master_daq(scope->master);
    fprintf(to, "\"link\":%s,\"why\":", scope->lost ? "false" : "true");
    json_text(to, scope->lost ? master_lost(scope->master) : "");
    fprintf(to, ",\"age\":%.2f", now() - scope->heard_at);
    fprintf(to, ",\"staged\":%s,\"samples\":%.0f,\"missing\":%.0f,\"sampling\":%s",
            scope->staged ? "true" : "false", (double)daq.samples, (double)daq.missing,
            master_daq_running(scope->master) ? "true" : "false");
}

static void put_choice(const scope_t *scope, FILE *to)
{
    fprintf(to, "\"g\":%u,\"every\":%u,\"given\":%s,\"period\":%.9g,\"signals\":[",
            (unsigned)scope->generation, (unsigned)scope->every, scope->every_given ? "true" : "false",
            RIG_PERIOD_SECONDS);
    for (uint32_t n = 0; n < scope->row_count; n++) {
        fprintf(to, "%s%u", n == 0u ? "" : ",", (unsigned)scope->rows[n]->id);
    }
    fputc(']', to);
}

static void tell_state(scope_t *scope)
{
    text_t text;
    if (text_begin(&text)) {
        fputc('{', text.file);
        put_line(scope, text.file);
        fputs(",\"values\":", text.file);
        scope_values_text(text.file, &scope->values, false);
        fputc('}', text.file);
        tell(scope, &text, HTTP_ALL, "state", false);
    }
}

static void tell_choice(scope_t *scope)
{
    text_t text;
    if (text_begin(&text)) {
        fputc('{', text.file);
        put_choice(scope, text.file);
        fputc('}', text.file);
        tell(scope, &text, HTTP_ALL, "choice", false);
    }
}

static void tell_commission(void *context)
{
    scope_t *scope = context;
    text_t text;
    if (text_begin(&text)) {
        scope_commission_text(text.file, &scope->commission);
        tell(scope, &text, HTTP_ALL, "commission", false);
    }
}

/* All data that a page needs when it opens. */
static void greet(scope_t *scope, uint32_t client)
{
    text_t text;
    if (!text_begin(&text)) {
        return;
    }
    fputs("{\"target\":", text.file);
    json_text(text.file, master_name(scope->master));
    fputs(",\"epk\":", text.file);
    json_text(text.file, master_epk(scope->master));
    fprintf(text.file, ",\"most\":%u,", SCOPE_SIGNALS);
    put_choice(scope, text.file);
    fputc(',', text.file);
    put_line(scope, text.file);
    fputs(",\"rows\":", text.file);
    scope_rows_text(text.file, &scope->values);
    fputs(",\"reasons\":", text.file);
    scope_reasons_text(text.file);
    fputs(",\"warning_bits\":", text.file);
    scope_warnings_text(text.file);
    fputs(",\"commission\":", text.file);
    scope_commission_text(text.file, &scope->commission);
    fputs(",\"values\":", text.file);
    scope_values_text(text.file, &scope->values, true);
    fputc('}', text.file);
    tell(scope, &text, client, "hello", false);
}

/* ---- values, read cyclically ---- */

static bool is_fast(const table_row_t *row)
{
    for (size_t n = 0; n < sizeof fast_rows / sizeof fast_rows[0]; n++) {
        if (strcmp(row->name, fast_rows[n]) == 0) {
            return true;
        }
    }
    return false;
}

static block_t block_at(const scope_values_t *values, uint32_t first, bool *fast)
{
    block_t block = {first, 1u};
    *fast = is_fast(values->rows[first]);
    while (block.count < BLOCK_MAX && first + block.count < values->count &&
           values->rows[first + block.count]->id == values->rows[first]->id + block.count &&
           values->tables[first + block.count] == values->tables[first]) {
        *fast = *fast || is_fast(values->rows[first + block.count]);
        block.count++;
    }
    return block;
}

static void make_blocks(scope_t *scope)
{
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t at = 0; at < scope->values.count;) {
            bool fast;
            const block_t block = block_at(&scope->values, at, &fast);
            if (fast == (pass == 0)) {
                scope->blocks[scope->block_count++] = block;
            }
            at += block.count;
        }
        scope->fast_count = pass == 0 ? scope->block_count : scope->fast_count;
    }
    scope->next_slow = scope->fast_count;
    scope->asked = UINT32_MAX;
}

/* A block that the drive does not have as a whole is read row by row from then on. */
static void split(scope_t *scope, uint32_t number)
{
    block_t *block = &scope->blocks[number];
    if (block->count > 1u && scope->block_count < SCOPE_ROWS_MAX) {
        const uint32_t half = block->count / 2u;
        scope->blocks[scope->block_count++] = (block_t){block->first + half, block->count - half};
        block->count = half;
    }
}

static void on_values(void *context, int result, const uint8_t *data, uint32_t octets)
{
    scope_t *scope = context;
    scope_values_t *values = &scope->values;
    scope->asking = false;
    scope->heard_at = result == MASTER_OK ? now() : scope->heard_at;
    if (result == MASTER_OUT_OF_RANGE) {
        split(scope, scope->asked);
    }
    const block_t block = scope->blocks[scope->asked];
    for (uint32_t n = 0; result == MASTER_OK && n < block.count && 4u * n + 4u <= octets; n++) {
        const uint8_t *at = &data[4u * n];
        const uint32_t bits =
            (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
        const uint32_t place = block.first + n;
        values->news[place] = values->news[place] || !values->known[place] || values->bits[place] != bits;
        values->known[place] = true;
        values->bits[place] = bits;
    }
}

static void ask_block(scope_t *scope, uint32_t number)
{
    const block_t block = scope->blocks[number];
    master_extension_t extension;
    uint32_t address;
    if (master_place(scope->values.rows[block.first], &extension, &address)) {
        scope->asked = number;
        scope->asking = true;
        master_ask_read(scope->master, extension, address, 4u * block.count, on_values, scope);
    }
}

/* Every second request reads the values that change quickly. */
static void ask_next(scope_t *scope)
{
    if (scope->asks++ % 2u == 0u && scope->fast_count > 0u) {
        ask_block(scope, scope->next_fast);
        scope->next_fast = (scope->next_fast + 1u) % scope->fast_count;
    } else if (scope->block_count > scope->fast_count) {
        ask_block(scope, scope->next_slow);
        scope->next_slow++;
        if (scope->next_slow >= scope->block_count) {
            master_error_t ignored;
            scope->next_slow = scope->fast_count;
            (void)master_staged(scope->master, &scope->staged, &ignored);
        }
    }
}

static void tell_capture(scope_t *scope)
{
    text_t text;
    if (scope_capture_is_over(&scope->capture)) {
        if (text_begin(&text)) {
            scope_capture_text(text.file, &scope->capture, scope->master);
            tell(scope, &text, HTTP_ALL, "capture", false);
        }
        scope_capture_end(&scope->capture);
    }
}

/* Only one question is pending at a time. */
static void ask(scope_t *scope, double time)
{
    if (scope->asking || scope->capture.asking) {
        return;
    }
    if (time >= scope->next_ask) {
        scope->next_ask = time + ASK;
        ask_next(scope);
    } else {
        scope_capture_ask(&scope->capture, scope->master);
    }
}

/* Reads the rows near one that was just written, because the drive may have changed them with it. */
static void look_again(scope_t *scope, const table_row_t *row)
{
    for (uint32_t n = 0; n < scope->block_count; n++) {
        const block_t block = scope->blocks[n];
        if (row->id >= scope->values.rows[block.first]->id &&
            row->id <= scope->values.rows[block.first + block.count - 1u]->id) {
            uint8_t data[MASTER_READ_MAX];
            master_extension_t extension;
            uint32_t address;
            master_error_t error;
            if (master_place(scope->values.rows[block.first], &extension, &address) &&
                master_read(scope->master, extension, address, data, 4u * block.count, &error)) {
                const uint32_t asked = scope->asked;
                const bool asking = scope->asking;
                scope->asked = n;
                on_values(scope, MASTER_OK, data, 4u * block.count);
                scope->asked = asked;
                scope->asking = asking;
            }
        }
    }
}

/* ---- samples ---- */

uint32_t scope_every(const char *target, uint32_t signals)
{
    transport_target_t parsed;
    char why[TEXT_MAX];
    if (!transport_parse(target, &parsed, why, sizeof why) || parsed.tcp) {
        return 1u;
    }
    const double octets =
        12.0 +
        4.0 * signals; /* octets of header, identification, time stamp and tail; each octet has 10 bits */
    const double rate = LINE_SHARE * parsed.baud / (10.0 * octets);
    const double every = ceil(1.0 / (rate * RIG_PERIOD_SECONDS));
    return every < 1.0 ? 1u : every > 255.0 ? 255u : (uint32_t)every;
}

static bool start_samples(scope_t *scope, master_error_t *error)
{
    scope->sample_count = 0u;
    scope->sample_at = now();
    scope->generation++;
    if (!scope->every_given) {
        scope->every = scope_every(master_name(scope->master), scope->row_count);
    }
    if (!master_daq_stop(scope->master, error)) {
        return false;
    }
    const bool good = scope->row_count == 0u || master_daq_start(scope->master, scope->rows, scope->row_count,
                                                                 scope->every, on_sample, scope, error);
    tell_choice(scope);
    return good;
}

/* ---- requests of a page ---- */

static void answer(scope_t *scope, uint32_t client, bool good, const char *what)
{
    text_t text;
    if (!text_begin(&text)) {
        http_answer(scope->http, client, 500, "text/plain", "", 0u);
        return;
    }
    fprintf(text.file, "{\"ok\":%s,\"text\":", good ? "true" : "false");
    json_text(text.file, what);
    fputc('}', text.file);
    if (fclose(text.file) == 0) {
        http_answer(scope->http, client, 200, "application/json", text.data, text.size);
    }
    free(text.data);
}

static bool set_row(scope_t *scope, const table_row_t *row, double value, char *why, size_t size)
{
    master_error_t error = {{0}};
    const bool good = master_set(scope->master, row, value, &error);
    snprintf(why, size, "%s", good ? "" : error.text);
    look_again(scope, row);
    return good;
}

/* The present value of this row in the drive. */
static int32_t reported(scope_t *scope, const char *name)
{
    const table_row_t *row = rig_row_by_name(name);
    look_again(scope, row);
    const uint32_t place = scope_values_place(&scope->values, row->id);
    return (int32_t)scope_number(row, scope->values.bits[place]);
}

static bool is_state(int32_t state, const char *name)
{
    return state == table_choice(rig_row_by_name("state"), name);
}

/* True if the drive with `enable` on continues to run, according to its own report. Otherwise `enable` is
 * set off again, so that the motor does not start unexpectedly later. */
static bool goes_on(scope_t *scope, char *why, size_t size)
{
    char not_off[TEXT_MAX] = "";
    const bool faulty = is_state(reported(scope, "state"), "fault");
    const int32_t number = reported(scope, faulty ? "fault_reason" : "refusal");
    const reason_row_t *reason = reason_by_number(number);
    if (!faulty && number == REASON_NONE) {
        return true;
    }
    snprintf(why, size, "refused: %s%s; %s", faulty ? "fault latched; reset first: " : "",
             reason != NULL ? reason->text : "a reason that this program does not know",
             reason != NULL ? reason->remedy : "see the documentation of the drive's program");
    const table_row_t *row = rig_row_by_name("enable");
    if (!set_row(scope, row, (double)table_choice(row, "off"), not_off, sizeof not_off)) {
        const size_t used = strlen(why);
        snprintf(why + used, size - used, "; enable is still on: %.200s", not_off);
    } else {
        scope->started = false;
    }
    return false;
}

/* "NAME VALUE", the value as a user writes it. */
static bool set(scope_t *scope, const char *body, char *why, size_t size)
{
    char name[96];
    double value = 0.0;
    const size_t length = strcspn(body, " ");
    snprintf(name, sizeof name, "%.*s", (int)(length < 95u ? length : 95u), body);
    const table_row_t *row = rig_row_by_name(name);
    if (row == NULL || body[length] == '\0') {
        snprintf(why, size, "%s: no such row, or no value", name);
        return false;
    }
    if (!scope_read(row, body + length + 1u, &value, why, size)) {
        return false;
    }
    const bool is_enable = strcmp(name, "enable") == 0;
    if (is_enable && value == (double)table_choice(row, "on")) {
        scope->started = true; /* the motor counts as switched on even if the answer is lost */
    }
    bool good = set_row(scope, row, value, why, size);
    if (good && is_enable) {
        scope->started = value == (double)table_choice(row, "on");
        good = !scope->started || goes_on(scope, why, size);
    }
    return good;
}

static bool order(scope_t *scope, const char *name, char *why, size_t size)
{
    master_refusal_t refusal = {0};
    master_error_t error = {{0}};
    const table_row_t *row = rig_row_by_name("order");
    const bool known = row != NULL && table_choice(row, name) > 0;
    const bool good = known && master_order(scope->master, name, &refusal, &error);
    if (!known) {
        snprintf(why, size, "%s: no such order", name);
    } else {
        snprintf(why, size, "%s", good ? "" : error.text);
    }
    for (uint32_t n = 0; n < scope->values.count; n++) { /* an order may have changed any row */
        scope->values.known[n] = false;
    }
    if (good && strcmp(name, "restart") == 0) {
        scope->lost = true; /* until the drive has started again */
        scope->next_again = now() + AGAIN;
    } else {
        (void)master_staged(scope->master, &scope->staged, &error);
    }
    return good;
}

/* Brakes, then switches off; switches off at once if the drive refuses to brake. *why: the state after that.
 */
static bool stop_motor(scope_t *scope, char *why, size_t size)
{
    const table_row_t *row = rig_row_by_name("enable");
    if (!set_row(scope, row, (double)table_choice(row, "quick_stop"), why, size) &&
        !set_row(scope, row, 0.0, why, size)) {
        return false;
    }
    scope->started = false;
    scope->commission.stopped = true;
    const int32_t state = reported(scope, "state");
    snprintf(why, size, "%s",
             scope->commission.running  ? "the bridge is off, and commissioning has ended"
             : is_state(state, "fault") ? "the bridge is off already: a fault is latched"
             : is_state(state, "ready") || is_state(state, "not_ready")
                 ? "the bridge is off"
                 : "it brakes to standstill, then the bridge is off");
    return true;
}

/* "EVERY ID ID ..": every 0: as the line allows. */
static bool choose(scope_t *scope, const char *body, char *why, size_t size)
{
    const table_row_t *rows[SCOPE_SIGNALS];
    uint32_t count = 0;
    char *at = NULL;
    const unsigned long every = strtoul(body, &at, 10);
    for (char *end = at; *at != '\0'; at = end) {
        const unsigned long id = strtoul(at, &end, 10);
        const table_row_t *row = end != at ? rig_row((uint32_t)id) : NULL;
        if (row == NULL || count == SCOPE_SIGNALS) {
            snprintf(why, size, "signals: accepted: up to %u ids of signals", SCOPE_SIGNALS);
            return false;
        }
        rows[count++] = row;
        end += strspn(end, " \r\n");
    }
    if (every > 255u) {
        snprintf(why, size, "every %lu periods: accepted: 0 (the highest rate of the link) to 255", every);
        return false;
    }
    master_error_t error = {{0}};
    (void)master_daq_stop(scope->master, &error); /* the last samples of the old choice arrive during this
                                                   * call */
    tell_samples(scope);
    memcpy(scope->rows, rows, count * sizeof rows[0]);
    scope->row_count = count;
    scope->every_given = every != 0u;
    scope->every = (uint32_t)every;
    const bool good = start_samples(scope, &error);
    snprintf(why, size, "%s", good ? "" : error.text);
    return good;
}

/* Commissioning begins by itself when this request has been answered. */
static bool commission(scope_t *scope, const char *body, char *why, size_t size)
{
    const int32_t state = reported(scope, "state");
    if (!is_state(state, "ready")) {
        snprintf(why, size, "%s",
                 is_state(state, "fault") ? "a fault is latched: reset it first"
                                          : "the drive is not ready: switch it off first");
        return false;
    }
    const bool good = scope_commission_want(&scope->commission, body, why, size);
    scope->started = scope->started || good;
    return good;
}

static void handle_post(scope_t *scope, uint32_t client, const http_request_t *request)
{
    char why[TEXT_MAX] = "";
    bool good = false;
    if (scope->lost) {
        snprintf(why, sizeof why, "no link to the drive: %s", master_lost(scope->master));
    } else if (strcmp(request->path, "/stop") == 0) {
        good = stop_motor(scope, why, sizeof why);
    } else if (strcmp(request->path, "/commission") == 0) {
        good = commission(scope, request->body, why, sizeof why);
    } else if (strcmp(request->path, "/answer") == 0) {
        good = scope_commission_answer(&scope->commission, request->body, why, sizeof why);
    } else if ((strcmp(request->path, "/set") == 0 || strcmp(request->path, "/order") == 0) &&
               (scope->commission.running || scope->commission.wanted)) {
        snprintf(why, sizeof why, "commissioning is in progress; STOP ends it");
    } else if (strcmp(request->path, "/set") == 0) {
        good = set(scope, request->body, why, sizeof why);
    } else if (strcmp(request->path, "/order") == 0) {
        good = order(scope, request->body, why, sizeof why);
    } else if (strcmp(request->path, "/capture") == 0) {
        master_error_t error = {{0}};
        good = scope_capture_begin(&scope->capture, scope->master, &error);
        snprintf(why, sizeof why, "%s", error.text);
    } else if (strcmp(request->path, "/signals") == 0) {
        good = choose(scope, request->body, why, sizeof why);
    } else {
        snprintf(why, sizeof why, "nothing here");
    }
    answer(scope, client, good, why);
    tell_state(scope);
}

static void handle(void *context, uint32_t client, const http_request_t *request)
{
    scope_t *scope = context;
    if (request->post) {
        handle_post(scope, client, request);
    } else if (strcmp(request->path, "/") == 0) {
        http_answer(scope->http, client, 200, "text/html; charset=utf-8", scope->page, scope->page_size);
    } else if (strcmp(request->path, "/events") == 0) {
        http_stream(scope->http, client);
        greet(scope, client);
    } else {
        http_answer(scope->http, client, 404, "text/plain", "nothing here\n", 13u);
    }
}

/* ---- the loop ---- */

static void look_for_drive(scope_t *scope, double time)
{
    master_error_t error = {{0}};
    if (time < scope->next_again) {
        return;
    }
    if (master_again(scope->master, AGAIN_TRY, &error)) {
        scope->lost = false;
        scope->asking = false;
        scope->started = false; /* the drive's command_timeout has stopped it */
        memset(scope->values.known, 0, sizeof scope->values.known);
        (void)start_samples(scope, &error);
        tell_state(scope);
    }
    scope->next_again = now() + AGAIN;
}

static void look_for_pages(scope_t *scope, double time)
{
    char why[TEXT_MAX];
    if (http_streams(scope->http) > 0u) {
        scope->alone_from = 0.0;
    } else if (scope->alone_from == 0.0) {
        scope->alone_from = time;
    } else if (scope->started && !scope->lost && time - scope->alone_from > SCOPE_ALONE) {
        (void)stop_motor(scope, why, sizeof why);
    }
}

static void work_line(scope_t *scope, double time)
{
    if (scope->lost) {
        look_for_drive(scope, time);
        return;
    }
    if (!master_work(scope->master)) {
        scope->lost = true;
        scope->asking = false;
        scope->next_again = time + AGAIN;
        tell_samples(scope);
        tell_capture(scope);
        tell_state(scope);
        return;
    }
    ask(scope, time);
    tell_capture(scope);
    if (scope->row_count > 0u && time - scope->sample_at > SILENT) {
        master_error_t ignored;
        (void)start_samples(scope, &ignored);
    }
}

static void wait_for_something(const scope_t *scope, double time)
{
    struct pollfd looks[HTTP_CLIENTS + 2u];
    uint32_t count = http_descriptors(scope->http, looks);
    double patience = fmin(LONGEST, fmin(scope->next_frame, scope->next_tell) - time);
    if (!scope->lost) {
        looks[count++] =
            (struct pollfd){.fd = master_descriptor(scope->master), .events = master_events(scope->master)};
        patience = fmin(patience, fmin(master_patience(scope->master), scope->next_ask - time));
    }
    patience = scope->commission.running ? fmin(patience, scope->wake - time) : patience;
    (void)poll(looks, count, patience > 0.0 ? (int)ceil(1e3 * patience) : 0);
}

static void work(scope_t *scope)
{
    double time = now();
    wait_for_something(scope, time);
    time = now();
    work_line(scope, time);
    http_work(scope->http);
    look_for_pages(scope, time);
    if (time >= scope->next_frame) {
        scope->next_frame = time + FRAME;
        tell_samples(scope);
    }
    if (time >= scope->next_tell) {
        scope->next_tell = time + TELL;
        tell_state(scope);
    }
}

/* The same for this time [s], while commissioning waits. false: the line is lost, or the program shall end.
 */
static bool work_for(void *context, double seconds)
{
    scope_t *scope = context;
    scope->wake = now() + seconds;
    do {
        work(scope);
        scope->commission.stopped = scope->commission.stopped || *scope->stop != 0;
    } while (!scope->lost && *scope->stop == 0 && now() < scope->wake);
    return !scope->lost;
}

void scope_run(scope_t *scope, const volatile sig_atomic_t *stop)
{
    scope->stop = stop;
    while (*stop == 0) {
        work(scope);
        if (scope->commission.wanted && !scope->lost) {
            scope_commission_run(&scope->commission, scope->master);
            scope->started = false;
            memset(scope->values.known, 0, sizeof scope->values.known);
        }
    }
}

/* ---- life ---- */

scope_t *scope_open(master_t *master, uint32_t port, const char *page, size_t page_size, char *why,
                    size_t size)
{
    master_error_t error = {{0}};
    scope_t *scope = calloc(1, sizeof *scope);
    if (scope == NULL) {
        snprintf(why, size, "not enough memory");
        master_close(master);
        return NULL;
    }
    scope->master = master;
    scope->heard_at = now();
    scope->page = page;
    scope->page_size = page_size;
    scope->commission.work = work_for;
    scope->commission.tell = tell_commission;
    scope->commission.context = scope;
    scope->commission.step = COMMISSION_STEP_COUNT;
    scope_values_init(&scope->values);
    make_blocks(scope);
    for (uint32_t n = 0; n < sizeof first_signals / sizeof first_signals[0]; n++) {
        scope->rows[scope->row_count++] = rig_row_by_name(first_signals[n]);
    }
    scope->http = http_open(port, handle, scope, why, size);
    if (scope->http == NULL || !start_samples(scope, &error)) {
        if (scope->http != NULL) {
            snprintf(why, size, "%s", error.text);
        }
        scope_close(scope);
        return NULL;
    }
    return scope;
}

uint32_t scope_port(const scope_t *scope)
{
    return http_port(scope->http);
}

const char *scope_token(const scope_t *scope)
{
    return http_token(scope->http);
}

void scope_close(scope_t *scope)
{
    char why[TEXT_MAX];
    if (scope->started && !scope->lost) {
        (void)stop_motor(scope, why, sizeof why);
    }
    master_close(scope->master);
    http_close(scope->http);
    scope_capture_end(&scope->capture);
    free(scope);
}
