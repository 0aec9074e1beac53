/* `lagless connect`: a session, the table of its commands, and functions that they share. */
#ifndef HOST_SIM_CLI_CONNECT_H
#define HOST_SIM_CLI_CONNECT_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/table.h"
#include "host_sim/line/master.h"

#define CONNECT_WORDS  64u   /* [-] of a line */
#define CONNECT_LINE   1024u /* [octets] */
#define CONNECT_STAGED 128u

typedef struct {
    const table_row_t *row;
    double value; /* [unit] staged */
} connect_staged_t;

typedef struct {
    master_t *master;
    bool json, keep_going, quit;
    bool terminal; /* input from a terminal: commands without an end run until Ctrl-C */
    bool steers;   /* this session has switched the bridge on, and not off again */
    uint32_t line; /* [-] of the script, from 1 */
    master_error_t error;
    connect_staged_t staged[CONNECT_STAGED]; /* by this session, not applied */
    uint32_t staged_count;
    const char *staged_set; /* name of the set that an order has staged before these values; NULL: none */
} session_t;

/* ---- the table of commands ---- */

#define COMPLETE_PARAMS   1u
#define COMPLETE_REQUESTS 2u
#define COMPLETE_SERVICES 4u
#define COMPLETE_SIGNALS  8u
#define COMPLETE_REASONS  16u
#define COMPLETE_COMMANDS 32u
#define COMPLETE_ROWS     (COMPLETE_PARAMS | COMPLETE_REQUESTS | COMPLETE_SERVICES | COMPLETE_SIGNALS)

typedef struct {
    const char *name;
    const char *arguments;
    uint32_t completes; /* COMPLETE_... */
    const char *words;  /* words that may follow, separated by blanks */
    bool (*run)(session_t *session, uint32_t count,
                char **words); /* words after the name; false: session->error */
    const char *text;          /* one line */
} connect_command_t;

extern const connect_command_t connect_commands[];
extern const uint32_t connect_command_count;

bool connect_status(session_t *session, uint32_t count, char **words);
bool connect_get(session_t *session, uint32_t count, char **words);
bool connect_set(session_t *session, uint32_t count, char **words);
bool connect_apply(session_t *session, uint32_t count, char **words);
bool connect_params(session_t *session, uint32_t count, char **words);
bool connect_signals(session_t *session, uint32_t count, char **words);
bool connect_go(session_t *session, uint32_t count, char **words);
bool connect_stop(session_t *session, uint32_t count, char **words);
bool connect_quick_stop(session_t *session, uint32_t count, char **words);
bool connect_off(session_t *session, uint32_t count, char **words);
bool connect_reset(session_t *session, uint32_t count, char **words);
bool connect_save(session_t *session, uint32_t count, char **words);
bool connect_load(session_t *session, uint32_t count, char **words);
bool connect_defaults(session_t *session, uint32_t count, char **words);
bool connect_erase(session_t *session, uint32_t count, char **words);
bool connect_restart(session_t *session, uint32_t count, char **words);
bool connect_watch(session_t *session, uint32_t count, char **words);
bool connect_wait(session_t *session, uint32_t count, char **words);
bool connect_record(session_t *session, uint32_t count, char **words);
bool connect_capture(session_t *session, uint32_t count, char **words);
bool connect_faults(session_t *session, uint32_t count, char **words);

/* ---- shared functions ---- */

bool connect_fail(session_t *session, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Returns true once after Ctrl-C; then the next line is read. */
bool connect_stopped(void);

/* A row of the drive by "name" or "table.name"; NULL: session->error. */
const table_row_t *connect_row(session_t *session, const char *name);

/* Names of rows, separated by blanks or commas; how many, 0: session->error. */
uint32_t connect_rows(session_t *session, uint32_t count, char **words, const table_row_t **rows,
                      uint32_t room);

/* Words joined by blanks. */
const char *connect_joined(char to[CONNECT_LINE], uint32_t count, char **words);

/* Converts a text to the value of a row: with a unit, or a pure number in the row's unit. Only the range of
 * the row is judged. */
bool connect_value(session_t *session, const table_row_t *row, const char *text, double *value);

/* A time: "2 s", "20 ms", a pure number in s; 0 < time <= 1 day. */
bool connect_time(session_t *session, const char *text, double *seconds);

/* "for 2 s": a keyword and the words up to the next one, taken out of the line. */
typedef struct {
    const char *key;
    char value[CONNECT_LINE]; /* "" if it was not given */
    bool given;
} connect_clause_t;
bool connect_clauses(session_t *session, uint32_t *count, char **words, connect_clause_t *clauses,
                     uint32_t clause_count);

bool connect_get_row(session_t *session, const table_row_t *row, double *value);
bool connect_get_named(session_t *session, const char *name, double *value);

/* Sets a request or a service. The message of a refusal uses the rules of this program. */
bool connect_set_named(session_t *session, const char *name, double value);
bool connect_set_choice(session_t *session, const char *name, const char *choice);

/* true: the value is this choice of the row. */
bool connect_is(const char *row, double value, const char *choice);

/* `, "name": value` of a row, for --json. */
void connect_json(const table_row_t *row, double value);
void connect_json_text(const char *key, const char *text);

/* Waits for a time of the drive. `until` is called repeatedly; it may fail with session->error. */
typedef bool (*connect_until_t)(session_t *session, void *context, bool *met);
bool connect_wait_for(session_t *session, double seconds, connect_until_t until, void *context, bool *met);

/* Updates the list of staged values by the state of the drive. */
bool connect_look_staged(session_t *session, bool *staged);

#endif
