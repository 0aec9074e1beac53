/* Commands of `lagless connect` about values and about the state of the drive. */
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/connect.h"
#include "host_sim/lab/json.h"
#include "host_sim/lab/scenario_parts.h"
#include "host_sim/lab/times.h"
#include "host_sim/lab/units.h"
#include "host_sim/line/judge.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

#define START_WAIT  2.0  /* [s] for the bridge to come on */
#define RESET_WAIT  0.05 /* [s] until a fault is absent, after each of ... */
#define RESET_TRIES 6u   /* ... this number of resets */
#define KEEP_WAIT   10.0 /* [s] for a memory on the drive's I2C bus to take a set */
#define KEEP_LOOK   0.02 /* [s] from one query to the next */
#define RETURN_WAIT 10.0 /* [s] for the drive to answer after its restart */

static bool extra(session_t *session, uint32_t count, char **words)
{
    return count == 0u || connect_fail(session, "%s: no argument is accepted", words[0]);
}

static bool is_param(const table_row_t *row)
{
    master_extension_t extension;
    uint32_t address;
    return master_place(row, &extension, &address) && extension == MASTER_PARAMS;
}

/* ---- set, get ---- */

static bool set_row(session_t *session, const table_row_t *row, double value)
{
    master_error_t why;
    if (master_set(session->master, row, value, &session->error)) {
        if (strcmp(row->name, "enable") == 0) {
            session->steers = connect_is("enable", value, "on");
        }
        return true;
    }
    if (master_descriptor(session->master) >= 0 && judge_request(session->master, row, value, &why)) {
        session->error = why;
    }
    return false;
}

bool connect_set_named(session_t *session, const char *name, double value)
{
    const table_row_t *row = connect_row(session, name);
    return row != NULL && set_row(session, row, value);
}

bool connect_set_choice(session_t *session, const char *name, const char *choice)
{
    const table_row_t *row = connect_row(session, name);
    return row != NULL && set_row(session, row, (double)table_choice(row, choice));
}

static void show(const session_t *session, const table_row_t *row, double value, const char *remark)
{
    char text[UNITS_TEXT_SIZE];
    if (session->json) {
        connect_json(row, value);
    } else {
        printf("%-22s %s%s\n", row->name, units_row_text(text, value, row), remark);
    }
}

static const char *remark_of(const session_t *session, const table_row_t *row)
{
    for (uint32_t n = 0; n < session->staged_count; n++) {
        if (session->staged[n].row == row) {
            return " (staged)";
        }
    }
    return "";
}

bool connect_get(session_t *session, uint32_t count, char **words)
{
    const table_row_t *rows[CONNECT_WORDS];
    const uint32_t found = connect_rows(session, count, words, rows, CONNECT_WORDS);
    for (uint32_t n = 0; n < found; n++) {
        double value;
        if (!connect_get_row(session, rows[n], &value)) {
            return false;
        }
        show(session, rows[n], value, remark_of(session, rows[n]));
    }
    return found != 0u;
}

static void stage(session_t *session, const table_row_t *row, double value)
{
    uint32_t at = 0;
    while (at < session->staged_count && session->staged[at].row != row) {
        at++;
    }
    if (at < CONNECT_STAGED) {
        session->staged[at] = (connect_staged_t){row, value};
        session->staged_count += at == session->staged_count ? 1u : 0u;
    }
}

bool connect_set(session_t *session, uint32_t count, char **words)
{
    char text[CONNECT_LINE];
    double value;
    bool staged = false;
    if (count == 0u) {
        return connect_fail(session, "set: name or value is missing; write: set NAME VALUE");
    }
    const table_row_t *row = connect_row(session, words[0]);
    const uint32_t from = count > 1u && strcmp(words[1], "=") == 0 ? 2u : 1u;
    if (row == NULL ||
        !connect_value(session, row, connect_joined(text, count - from, words + from), &value) ||
        !set_row(session, row, value)) {
        return false;
    }
    if (is_param(row)) {
        stage(session, row, value);
        if (!connect_look_staged(session, &staged)) {
            return false;
        }
    }
    show(session, row, value,
         !staged                    ? ""
         : row->access == TABLE_OFF ? " (staged; apply, with the bridge off)"
                                    : " (staged; apply)");
    if (session->json) {
        printf(", \"staged\": %s", staged ? "true" : "false");
    }
    return true;
}

static void list_staged(const session_t *session, bool staged)
{
    char text[UNITS_TEXT_SIZE];
    const char *separator = "";
    if (session->json) {
        printf(", \"staged\": [");
        for (uint32_t n = 0; n < session->staged_count; n++) {
            printf("%s", n != 0u ? ", " : "");
            json_text(stdout, session->staged[n].row->name);
        }
        printf("], \"applied\": %s", staged ? "false" : "true");
        return;
    }
    if (!staged) {
        return;
    }
    printf("staged, not applied: ");
    if (session->staged_set != NULL || session->staged_count == 0u) {
        printf("%s", session->staged_set != NULL ? session->staged_set : "what another client has set");
        separator = ", ";
    }
    for (uint32_t n = 0; n < session->staged_count; n++) {
        const connect_staged_t *one = &session->staged[n];
        printf("%s%s %s", separator, one->row->name, units_row_text(text, one->value, one->row));
        separator = ", ";
    }
    printf("\n");
}

/* ---- orders ---- */

static bool order(session_t *session, const char *name, master_refusal_t *refusal)
{
    return master_order(session->master, name, refusal, &session->error);
}

bool connect_apply(session_t *session, uint32_t count, char **words)
{
    master_refusal_t refusal;
    master_error_t why;
    if (!extra(session, count, words)) {
        return false;
    }
    if (!order(session, "apply", &refusal)) {
        if (refusal.row != NULL && refusal.reason != REASON_BRIDGE_ON &&
            judge_staged(session->master, &why)) {
            session->error = why;
        }
        return false;
    }
    if (session->json) {
        printf(", \"applied\": true");
    } else if (session->staged_set != NULL || session->staged_count == 0u) {
        printf("applied: %s", session->staged_set != NULL ? session->staged_set : "the staged set");
    } else {
        printf("applied: ");
    }
    for (uint32_t n = 0; !session->json && n < session->staged_count; n++) {
        printf("%s%s", n != 0u || session->staged_set != NULL ? ", " : "", session->staged[n].row->name);
    }
    printf(session->json ? "" : "\n");
    session->staged_count = 0;
    session->staged_set = NULL;
    return true;
}

/* A drive with its memory on the I2C bus works on an order after its answer. */
static bool await_memory(session_t *session, const char *order_name)
{
    double state;
    for (double waited = 0.0; connect_get_named(session, "store_state", &state); waited += KEEP_LOOK) {
        if (connect_is("store_state", state, "failed")) {
            return connect_fail(
                session,
                "%s: the memory has failed; `get store_error` shows the reason; what was saved "
                "before is kept, and after `restart` it is used again",
                order_name);
        }
        if (!connect_is("store_state", state, "busy")) {
            return true;
        }
        if (waited > KEEP_WAIT) {
            return connect_fail(session, "%s: the memory is still busy after 10 s; look at store_state",
                                order_name);
        }
        if (!master_wait(session->master, KEEP_LOOK)) {
            return connect_fail(
                session, "%s: the link was lost while the memory was busy; look at store_state", order_name);
        }
    }
    return false;
}

static bool simple_order(session_t *session, uint32_t count, char **words, const char *name, const char *done,
                         const char *set)
{
    master_refusal_t refusal;
    bool staged;
    if (!extra(session, count, words) || !order(session, name, &refusal) ||
        (strcmp(name, "defaults") != 0 && !await_memory(session, name)) ||
        !connect_look_staged(session, &staged)) {
        return false;
    }
    if (set != NULL && staged) {
        session->staged_count = 0;
        session->staged_set = set;
    }
    if (session->json) {
        printf(", \"applied\": %s", staged ? "false" : "true");
    } else {
        printf("%s%s\n", done, staged ? "; staged: apply activates it" : "");
    }
    return true;
}

bool connect_save(session_t *session, uint32_t count, char **words)
{
    return simple_order(session, count, words, "save", "saved: the active parameters", NULL);
}

bool connect_load(session_t *session, uint32_t count, char **words)
{
    double store;
    if (!connect_get_named(session, "store_state", &store)) {
        return false;
    }
    if (connect_is("store_state", store, "empty") || connect_is("store_state", store, "foreign")) {
        return connect_fail(session,
                            "load: this drive has no saved parameters; `save` saves the active ones");
    }
    return simple_order(session, count, words, "load", "loaded: the saved parameters", "the saved set");
}

bool connect_defaults(session_t *session, uint32_t count, char **words)
{
    return simple_order(session, count, words, "defaults", "defaults: the default parameters of the program",
                        "the defaults");
}

/* The word is required as a confirmation, because erased data are lost. */
bool connect_erase(session_t *session, uint32_t count, char **words)
{
    if (count != 1u || strcmp(words[0], "yes") != 0) {
        return connect_fail(session,
                            "erase: all saved parameters of this drive would be lost, or the data of another "
                            "program in their place; to confirm it, write: erase yes");
    }
    return simple_order(session, 0u, words, "erase", "erased: this drive has no saved parameters", NULL);
}

/* A drive that has restarted has lost its orders; this detects a drive that reports a restart without one. */
bool connect_restart(session_t *session, uint32_t count, char **words)
{
    master_refusal_t refusal;
    double last;
    if (!extra(session, count, words) || !order(session, "restart", &refusal) ||
        !master_again(session->master, RETURN_WAIT, &session->error) ||
        !connect_get_named(session, "order", &last)) {
        return false;
    }
    if (!connect_is("order", last, "none")) {
        return connect_fail(session, "restart: the drive has not restarted; repeat the command");
    }
    session->staged_count = 0;
    session->staged_set = NULL;
    if (!session->json) {
        printf("restarted\n");
    }
    const table_row_t *row = connect_row(session, "store_state");
    double store;
    if (row == NULL || !connect_get_row(session, row, &store)) {
        return false;
    }
    show(session, row, store, "");
    return true;
}

/* ---- status ---- */

static bool show_status(session_t *session)
{
    static const char *const names[] = {"state", "manoeuvre", "enable",       "omega_m", "omega_m_ref",
                                        "i_q",   "u_dc",      "fault_reason", "refusal", "store_state"};
    for (uint32_t n = 0; n < sizeof names / sizeof names[0]; n++) {
        double value;
        const table_row_t *row = connect_row(session, names[n]);
        if (row == NULL || !connect_get_row(session, row, &value)) {
            return false;
        }
        const reason_row_t *reason = strcmp(names[n], "fault_reason") == 0 || strcmp(names[n], "refusal") == 0
                                         ? reason_by_number((int32_t)value)
                                         : NULL;
        if (reason == NULL) {
            show(session, row, value, "");
        } else if (session->json) {
            connect_json_text(row->name, reason->name);
        } else {
            printf("%-22s %s%s%s\n", row->name, reason->name, reason->number != REASON_NONE ? ": " : "",
                   reason->number != REASON_NONE ? reason->text : "");
        }
    }
    return true;
}

bool connect_status(session_t *session, uint32_t count, char **words)
{
    bool staged;
    if (!extra(session, count, words) || !show_status(session) || !connect_look_staged(session, &staged)) {
        return false;
    }
    list_staged(session, staged);
    return true;
}

/* ---- lists ---- */

static bool list_row(session_t *session, const table_row_t *row, const char **separator)
{
    char value_text[UNITS_TEXT_SIZE];
    double value;
    if (!connect_get_row(session, row, &value)) {
        return false;
    }
    if (session->json) {
        printf("%s{\"id\": %lu", *separator, (unsigned long)row->id);
        connect_json_text("name", row->name);
        connect_json_text("unit", row->unit);
        printf(", \"value\": ");
        json_number(stdout, value);
        if (row->access != TABLE_READ) {
            printf(", \"min\": ");
            json_number(stdout, rig_min(row));
            printf(", \"max\": ");
            json_number(stdout, rig_max(row));
        }
        printf("}");
        *separator = ", ";
        return true;
    }
    units_row_text(value_text, value, row);
    if (row->access == TABLE_READ) {
        printf("%-22s %-18s %s\n", row->name, value_text, row->text);
    } else {
        printf("%-24s %-14s %-32s %s%s\n", row->name, value_text, scenario_accepted(row).text, row->text,
               row->access == TABLE_OFF ? " (bridge off)" : "");
    }
    return true;
}

/* The rows of the given tables whose names contain the word. */
static bool list(session_t *session, uint32_t count, char **words, bool signals)
{
    const char *part = count != 0u ? words[0] : "";
    const char *separator = "";
    bool any = false;
    printf(session->json ? ", \"rows\": [" : "");
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        master_extension_t extension;
        uint32_t address;
        if (!master_place(&table->rows[0], &extension, &address) ||
            (extension == MASTER_SIGNALS) != signals) {
            continue;
        }
        for (uint32_t n = 0; n < table->count; n++) {
            if (strstr(table->rows[n].name, part) == NULL) {
                continue;
            }
            any = true;
            if (!list_row(session, &table->rows[n], &separator)) {
                printf(session->json ? "]" : "");
                return false;
            }
        }
    }
    printf(session->json ? "]" : "");
    return any ||
           connect_fail(session, "%s: no name contains this text; without it all names are listed", part);
}

bool connect_params(session_t *session, uint32_t count, char **words)
{
    return list(session, count, words, false);
}

bool connect_signals(session_t *session, uint32_t count, char **words)
{
    return list(session, count, words, true);
}

/* ---- motion ---- */

/* The reason why the drive does not run. */
static bool fail_reason(session_t *session, const char *what, int32_t number)
{
    const reason_row_t *reason = reason_by_number(number);
    return connect_fail(session, "%s: %s: %s; %s", what, reason != NULL ? reason->name : "unknown reason",
                        reason != NULL ? reason->text : "this program does not know it",
                        reason != NULL ? reason->remedy : "see the documentation of the drive's program");
}

static bool not_in_fault(session_t *session, const char *what)
{
    double state;
    double reason;
    if (!connect_get_named(session, "state", &state) ||
        !connect_get_named(session, "fault_reason", &reason)) {
        return false;
    }
    return !connect_is("state", state, "fault") || fail_reason(session, what, (int32_t)reason);
}

/* The bridge is on, or the drive is in fault: either ends the wait. */
static bool has_started(session_t *session, void *context, bool *met)
{
    double state;
    (void)context;
    if (!connect_get_named(session, "state", &state)) {
        return false;
    }
    *met = connect_is("state", state, "operation_enabled") || connect_is("state", state, "fault");
    return true;
}

static bool await_start(session_t *session)
{
    bool met;
    double refusal;
    if (!connect_wait_for(session, START_WAIT, has_started, NULL, &met) || !not_in_fault(session, "go")) {
        return false;
    }
    if (met) {
        return true;
    }
    if (!connect_get_named(session, "refusal", &refusal) || !connect_set_choice(session, "enable", "off")) {
        return false;
    }
    return fail_reason(session, "go: the bridge did not come on; enable is off again", (int32_t)refusal);
}

bool connect_go(session_t *session, uint32_t count, char **words)
{
    char text[CONNECT_LINE];
    char shown[UNITS_TEXT_SIZE];
    double speed;
    const table_row_t *row = connect_row(session, "speed_request");
    if (row == NULL || !connect_value(session, row, connect_joined(text, count, words), &speed) ||
        !not_in_fault(session, "go") || !connect_set_choice(session, "mode", "speed") ||
        !set_row(session, row, speed) || !connect_set_choice(session, "enable", "on") ||
        !await_start(session)) {
        return false;
    }
    if (session->json) {
        connect_json(row, speed);
    } else {
        printf("on, going to %s\n", units_row_text(shown, speed, row));
    }
    return true;
}

static bool request(session_t *session, uint32_t count, char **words, const char *name, const char *choice,
                    const char *done)
{
    if (!extra(session, count, words) || !(choice != NULL ? connect_set_choice(session, name, choice)
                                                          : connect_set_named(session, name, 0.0))) {
        return false;
    }
    if (!session->json) {
        printf("%s\n", done);
    }
    return true;
}

bool connect_stop(session_t *session, uint32_t count, char **words)
{
    return request(session, count, words, "speed_request", NULL, "going to 0 r/min; the bridge stays on");
}

bool connect_quick_stop(session_t *session, uint32_t count, char **words)
{
    return request(session, count, words, "enable", "quick_stop", "braking to standstill, then off");
}

bool connect_off(session_t *session, uint32_t count, char **words)
{
    return request(session, count, words, "enable", "off", "bridge off, the motor coasts");
}

/* ---- faults ---- */

static bool is_reset(session_t *session, void *context, bool *met)
{
    double state;
    (void)context;
    if (!connect_get_named(session, "state", &state)) {
        return false;
    }
    *met = !connect_is("state", state, "fault");
    return true;
}

/* The change from no to yes resets. The cause must have been absent for 20 ms, so the reset is repeated a few
 * times. */
bool connect_reset(session_t *session, uint32_t count, char **words)
{
    bool met = false;
    double present;
    /* off first: an `enable` from before the fault is no request to run after it */
    if (!extra(session, count, words) || !connect_set_choice(session, "enable", "off")) {
        return false;
    }
    for (uint32_t n = 0; !met && n < RESET_TRIES; n++) {
        if (!connect_set_choice(session, "fault_reset", "no") ||
            !connect_set_choice(session, "fault_reset", "yes") ||
            !connect_wait_for(session, RESET_WAIT, is_reset, NULL, &met)) {
            return false;
        }
    }
    if (!connect_get_named(session, "fault_present", &present) ||
        !connect_set_choice(session, "fault_reset", "no")) {
        return false;
    }
    if (!met) {
        return fail_reason(session, "reset: still there", (int32_t)present);
    }
    if (!session->json) {
        printf("no fault\n");
    }
    return true;
}

bool connect_faults(session_t *session, uint32_t count, char **words)
{
    master_fault_t faults[MASTER_FAULTS_MAX];
    uint32_t found = 0;
    if (!extra(session, count, words) || !master_faults(session->master, faults, &found, &session->error)) {
        return false;
    }
    printf(session->json ? ", \"faults\": [" : found == 0u ? "none since power-on\n" : "");
    for (uint32_t n = 0; n < found; n++) {
        const reason_row_t *reason = reason_by_number(faults[n].reason);
        const char *name = reason != NULL ? reason->name : "?";
        char when[TIMES_TEXT_SIZE];
        times_text(when, faults[n].period - 1u); /* the drive counts its first step as 1 */
        if (session->json) {
            printf("%s{\"number\": %ld, \"reason\": \"%s\", \"time\": %s}", n != 0u ? ", " : "",
                   (long)faults[n].reason, name, when);
        } else {
            printf("%10s s  %-18s %s\n", when, name, reason != NULL ? reason->text : "");
        }
    }
    printf(session->json ? "]" : "");
    return true;
}
