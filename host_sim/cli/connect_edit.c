#include "host_sim/cli/connect_edit.h"

#include <stddef.h>

#ifndef LAGLESS_HAS_EDIT

bool connect_edit_has(void)
{
    return false;
}

void connect_edit_begin(bool (*line)(void *context, const char *line), bool (*wait)(void *context),
                        void *context)
{
    (void)line;
    (void)wait;
    (void)context;
}

void connect_edit_read(void)
{
}

bool connect_edit_goes_on(void)
{
    return false;
}

void connect_edit_end(void)
{
}

#else

#include <editline/readline.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/connect.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

#define PROMPT          "lagless> "

/* While a command runs, the terminal's own line discipline is active. It turns a Ctrl-D into a NUL, which
 * is handled like a Ctrl-D at the prompt. */
#define END_TYPED_AHEAD "bind ^@ em-delete-or-list"

static struct {
    bool (*line)(void *context, const char *line);
    bool (*wait)(void *context);
    void *context;
    bool goes_on;
} edit;

/* ---- completion: the n-th candidate of a word ---- */

static const connect_command_t *command_of(const char *line)
{
    const size_t length = strcspn(line, " \t");
    for (uint32_t n = 0; n < connect_command_count; n++) {
        if (strlen(connect_commands[n].name) == length &&
            strncmp(connect_commands[n].name, line, length) == 0) {
            return &connect_commands[n];
        }
    }
    return NULL;
}

static const char *nth_row(uint32_t completes, uint32_t *n)
{
    static const uint32_t bits[] = {COMPLETE_SIGNALS, COMPLETE_PARAMS, COMPLETE_REQUESTS, COMPLETE_SERVICES};
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        master_extension_t extension;
        uint32_t address;
        if (!master_place(&table->rows[0], &extension, &address) || extension > MASTER_SERVICES ||
            (completes & bits[extension]) == 0u) {
            continue;
        }
        if (*n < table->count) {
            return table->rows[*n].name;
        }
        *n -= table->count;
    }
    return NULL;
}

static char *nth_word(const char *words, uint32_t *n)
{
    while (*words != '\0') {
        const size_t length = strcspn(words, " ");
        if (*n == 0u) {
            return strndup(words, length);
        }
        --*n;
        words += length + (words[length] == ' ' ? 1u : 0u);
    }
    return NULL;
}

static char *candidate(const connect_command_t *command, uint32_t n)
{
    const uint32_t completes = command != NULL ? command->completes : COMPLETE_COMMANDS;
    char *word = command != NULL ? nth_word(command->words, &n) : NULL;
    if (word != NULL) {
        return word;
    }
    if ((completes & COMPLETE_COMMANDS) != 0u) {
        return n < connect_command_count ? strdup(connect_commands[n].name) : NULL;
    }
    if ((completes & COMPLETE_REASONS) != 0u) {
        return n < reasons_count ? strdup(reasons[n].name) : NULL;
    }
    const char *row = nth_row(completes, &n);
    return row != NULL ? strdup(row) : NULL;
}

static const connect_command_t *completed; /* NULL: a command's name is typed */

static char *next_match(const char *text, int state)
{
    static uint32_t next;
    next = state == 0 ? 0u : next;
    for (char *word = candidate(completed, next); word != NULL; word = candidate(completed, next)) {
        next++;
        if (strncmp(word, text, strlen(text)) == 0) {
            return word;
        }
        free(word);
    }
    return NULL;
}

static char **complete(const char *text, int begin, int end)
{
    (void)end;
    const char *line = rl_line_buffer + strspn(rl_line_buffer, " \t");
    const bool first = rl_line_buffer + begin <= line;
    completed = first ? NULL : command_of(line);
    rl_attempted_completion_over = 1; /* no names of files */
    return !first && completed == NULL ? NULL : rl_completion_matches(text, next_match);
}

/* ---- lines ---- */

static void take_line(char *line)
{
    if (line == NULL) {
        printf("\n");
        edit.goes_on = false;
        return;
    }
    if (line[strspn(line, " \t")] != '\0') {
        add_history(line);
    }
    rl_callback_handler_remove();
    edit.goes_on = edit.line(edit.context, line);
    free(line);
    if (edit.goes_on) {
        rl_callback_handler_install(PROMPT, take_line);
    }
}

bool connect_edit_has(void)
{
    return true;
}

/* Within a sequence of keys, after Esc or while history is searched, libedit waits for the next one itself.
 */
static int next_octet(FILE *from)
{
    unsigned char octet;
    (void)from;
    return edit.wait(edit.context) && read(STDIN_FILENO, &octet, 1u) == 1 ? (int)octet : EOF;
}

void connect_edit_begin(bool (*line)(void *context, const char *line), bool (*wait)(void *context),
                        void *context)
{
    edit.line = line;
    edit.wait = wait;
    edit.context = context;
    edit.goes_on = true;
    rl_attempted_completion_function = complete;
    rl_getc_function = next_octet;
    rl_callback_handler_install(PROMPT, take_line);
    rl_parse_and_bind(END_TYPED_AHEAD);
}

void connect_edit_read(void)
{
    rl_callback_read_char();
}

bool connect_edit_goes_on(void)
{
    return edit.goes_on;
}

void connect_edit_end(void)
{
    rl_callback_handler_remove();
}

#endif
