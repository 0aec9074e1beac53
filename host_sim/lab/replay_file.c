#include "host_sim/lab/replay_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/inputs.h"
#include "settings/reasons.h"

#define FORMAT      1u
#define SLOTS_A_ROW 8u
#define OCTETS_MAX  (UINT32_C(1) << 20) /* [octets] of a file */
#define SLOTS_MAX   (CAPTURE_SLOTS + RIG_RECORD_HEAD)
#define TABLES      4u /* of the drive */

/* ---- writing ---- */

typedef struct {
    FILE *file;
    uint64_t check;
} sink_t;

static uint64_t check_of(uint64_t check, const char *text, size_t octets)
{
    for (size_t n = 0; n < octets; n++) {
        check = (check ^ (unsigned char)text[n]) * UINT64_C(1099511628211);
    }
    return check;
}

#define CHECK_BEGIN UINT64_C(14695981039346656037)

__attribute__((format(printf, 2, 3))) static void put(sink_t *sink, const char *format, ...)
{
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    sink->check = check_of(sink->check, text, (size_t)length);
    fputs(text, sink->file);
}

const char *replay_file_tables(char to[24])
{
    static const char *const order[TABLES] = {"signals", "params", "requests", "services"};
    uint32_t hash = 0u;
    for (uint32_t n = 0; n < TABLES; n++) {
        for (uint32_t t = 0; t < rig_table_count(); t++) {
            if (strcmp(rig_table(t)->name, order[n]) == 0) {
                hash = table_hash(rig_table(t), hash);
            }
        }
    }
    snprintf(to, 24, "lagless-%08" PRIx32, hash);
    return to;
}

static const char *name_of(int32_t reason)
{
    const reason_row_t *row = reason_by_number(reason);
    return row != NULL ? row->name : "none";
}

static void put_parameters(sink_t *sink, const uint32_t *slots, uint32_t count)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; strcmp(table->name, "params") == 0 && n < table->count; n++) {
            const table_row_t *row = &table->rows[n];
            char number[RIG_NUMBER_SIZE];
            double found;
            if (rig_record_value(slots, count, row, &found)) {
                put(sink, "set %s = %s\n", row->name, rig_value_text(number, found));
            }
        }
    }
}

void replay_file_write(FILE *file, const char *tables, const uint32_t *slots, uint32_t count)
{
    sink_t sink = {file, CHECK_BEGIN};
    rig_record_t record;
    rig_record_head(slots, &record);
    put(&sink, REPLAY_FILE_FIRST "%u\n", FORMAT);
    put(&sink, "firmware %" PRIu32 ".%" PRIu32 ".%" PRIu32 "\n", record.version >> 16,
        record.version >> 8 & 0xFFu, record.version & 0xFFu);
    put(&sink, "tables %s\nlayout %08" PRIx32 "\n", tables, record.layout);
    put(&sink, "board %s\ncarrier %" PRIu32 " ns\n", record.board, record.carrier_ns);
    put(&sink, "reason %" PRId32 " %s\nperiod %" PRIu32 "\n", record.reason, name_of(record.reason),
        record.at);
    put_parameters(&sink, slots, count);
    put(&sink, "slots %" PRIu32 "\n", count);
    for (uint32_t n = 0; n < count; n++) {
        put(&sink, "%08" PRIx32 "%c", slots[n],
            n % SLOTS_A_ROW == SLOTS_A_ROW - 1u || n + 1u == count ? '\n' : ' ');
    }
    fprintf(file, "check %016" PRIx64 "\n", sink.check);
}

/* ---- reading ---- */

__attribute__((format(printf, 2, 3))) static bool fail(char why[REPLAY_FILE_WHY], const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, REPLAY_FILE_WHY, format, arguments);
    va_end(arguments);
    return false;
}

static char *read_text(const char *path, char why[REPLAY_FILE_WHY])
{
    FILE *file = fopen(path, "rb");
    char *text = file != NULL ? malloc(OCTETS_MAX + 1u) : NULL;
    if (text == NULL) {
        fail(why, "it cannot be read: %s", strerror(errno));
        if (file != NULL) {
            fclose(file);
        }
        return NULL;
    }
    const size_t octets = fread(text, 1, OCTETS_MAX + 1u, file);
    fclose(file);
    if (octets > OCTETS_MAX || memchr(text, '\0', octets) != NULL ||
        strncmp(text, REPLAY_FILE_FIRST,
                octets < strlen(REPLAY_FILE_FIRST) ? octets : strlen(REPLAY_FILE_FIRST)) != 0) {
        free(text);
        fail(why, "it is no record for a replay: accepted: a file of `capture save` in lagless connect, or "
                  "of "
                  "`lagless run --out` with the parameter fault_record = replay");
        return NULL;
    }
    text[octets] = '\0';
    inputs_note(path);
    return text;
}

/* Compares the checksum in the last line with that of all lines before it. */
static bool judge_check(const char *text, char why[REPLAY_FILE_WHY])
{
    const char *last = strstr(text, "\ncheck ");
    uint64_t check;
    char end;
    if (last == NULL || sscanf(last, "\ncheck %16" SCNx64 "%c", &check, &end) != 2 || end != '\n') {
        return fail(why,
                    "the line `check` is missing at the end: the file is cut; read it from the drive again");
    }
    const uint64_t found = check_of(CHECK_BEGIN, text, (size_t)(last + 1 - text));
    return found == check || fail(why,
                                  "check %016" PRIx64 ": accepted: %016" PRIx64
                                  ", that of the content; the file was changed or "
                                  "damaged; read it from the drive again",
                                  check, found);
}

/* A line `key value`; the text behind it. NULL: `why`. */
static const char *take(const char *text, const char *key, char *value, size_t size,
                        char why[REPLAY_FILE_WHY])
{
    const size_t length = strlen(key);
    const char *end = strchr(text, '\n');
    if (end == NULL || strncmp(text, key, length) != 0 || text[length] != ' ' ||
        (size_t)(end - text) - length > size) {
        fail(why, "the line `%s` is missing: accepted: the lines of format %u in their order", key, FORMAT);
        return NULL;
    }
    const size_t octets = (size_t)(end - text) - length - 1u;
    memcpy(value, text + length + 1u, octets);
    value[octets] = '\0';
    return end + 1;
}

static bool read_slots(const char *text, replay_file_t *to, char why[REPLAY_FILE_WHY])
{
    to->slots = calloc(SLOTS_MAX, sizeof *to->slots);
    if (to->slots == NULL) {
        return fail(why, "there is no memory for its slots");
    }
    for (uint32_t n = 0; n < to->count; n++) {
        char *end;
        to->slots[n] = (uint32_t)strtoul(text, &end, 16);
        if (end - text != 8) {
            return fail(why, "slot %" PRIu32 ": accepted: 8 hexadecimal digits", n);
        }
        text = end + 1;
    }
    return strncmp(text, "check ", 6) == 0 ||
           fail(why, "slots %" PRIu32 ": accepted: the number of slots that follow", to->count);
}

/* The values of the lines agree with the slots. */
static bool judge_lines(const replay_file_t *to, const char *board, uint32_t period,
                        char why[REPLAY_FILE_WHY])
{
    if (strcmp(to->record.board, board) != 0) {
        return fail(why, "board %.40s: accepted: %s, that of its slots", board, to->record.board);
    }
    return period == to->record.at ||
           fail(why, "period %" PRIu32 ": accepted: %" PRIu32 ", that of its slots", period, to->record.at);
}

static bool parse(const char *text, replay_file_t *to, char why[REPLAY_FILE_WHY])
{
    char value[8][80];
    char own[24];
    static const char *const keys[8] = {"lagless replay", "firmware", "tables", "layout",
                                        "board",          "carrier",  "reason", "period"};
    for (uint32_t n = 0; n < 8u; n++) {
        text = take(text, keys[n], value[n], sizeof value[n], why);
        if (text == NULL) {
            return false;
        }
        if (n == 0u && strtoul(value[0], NULL, 10) != FORMAT) {
            return fail(why, "format %s: accepted: %u; use a program of the version that wrote it", value[0],
                        FORMAT);
        }
    }
    if (strcmp(value[2], replay_file_tables(own)) != 0) {
        return fail(why,
                    "tables %s: accepted: %s, those of this program; build lagless from the sources of the "
                    "drive's firmware (%s)",
                    value[2], own, value[1]);
    }
    snprintf(to->tables, sizeof to->tables, "%s", own);
    while (strncmp(text, "set ", 4) == 0) {
        text = strchr(text, '\n') + 1;
    }
    char slots[80];
    text = take(text, "slots", slots, sizeof slots, why);
    to->count = text != NULL ? (uint32_t)strtoul(slots, NULL, 10) : 0u;
    if (text == NULL) {
        return false;
    }
    if (to->count < RIG_RECORD_HEAD || to->count > SLOTS_MAX) {
        return fail(why, "slots %s: accepted: %u to %u", slots, RIG_RECORD_HEAD, (unsigned)SLOTS_MAX);
    }
    if (!read_slots(text, to, why)) {
        return false;
    }
    rig_record_head(to->slots, &to->record);
    return judge_lines(to, value[4], (uint32_t)strtoul(value[7], NULL, 10), why);
}

bool replay_file_read(const char *path, replay_file_t *to, char why[REPLAY_FILE_WHY])
{
    *to = (replay_file_t){0};
    char *text = read_text(path, why);
    const bool good = text != NULL && judge_check(text, why) && parse(text, to, why);
    free(text);
    if (!good) {
        replay_file_free(to);
    }
    return good;
}

void replay_file_free(replay_file_t *file)
{
    free(file->slots);
    file->slots = NULL;
}
