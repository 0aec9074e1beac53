/* `lagless completion`, `lagless man`: made from the same tables as the help texts. */
#include <argp.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/cli/arguments.h"
#include "host_sim/cli/cli.h"
#include "host_sim/cli/output.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/rig/rig.h"
#include "settings/reasons.h"

static void print_rows(bool settable, const char *after)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        const table_t *table = rig_table(t);
        for (uint32_t n = 0; n < table->count; n++) {
            char name[96];
            if (!settable || table->rows[n].access != TABLE_READ) {
                scenario_row_name(&table->rows[n], name, sizeof name);
                printf("%s%s ", name, after);
            }
        }
    }
}

/* The options that are read, in the form for completion. */
static void print_options(const struct argp *argp, void *nothing)
{
    (void)nothing;
    for (const struct argp_option *row = argp->options; row != NULL && row->name != NULL; row++) {
        if ((row->flags & OPTION_HIDDEN) == 0) {
            printf("--%s ", row->name);
        }
    }
}

static void print_bash(void)
{
    printf("_lagless() {\n"
           "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} "
           "command=${COMP_WORDS[1]}\n"
           "    COMPREPLY=()\n"
           "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n        COMPREPLY=($(compgen -W \"");
    for (size_t n = 0; n < cli_command_count; n++) {
        printf("%s ", cli_commands[n].name);
    }
    printf("--help --version\" -- \"$word\"))\n        return\n    fi\n"
           "    case $before in\n"
           "    --set) compopt -o nospace 2>/dev/null; COMPREPLY=($(compgen -W \"");
    print_rows(true, "=");
    printf("\" -- \"$word\")); return ;;\n"
           "    --record) COMPREPLY=($(compgen -W \"");
    print_rows(false, "");
    printf(
        "\" -- \"$word\")); return ;;\n"
        "    --format) COMPREPLY=($(compgen -W \"csv mat vcd mdf html png svg\" -- \"$word\")); return ;;\n"
        "    --out) COMPREPLY=($(compgen -d -- \"$word\")); return ;;\n"
        "    esac\n"
        "    case $command in\n");
    for (size_t n = 0; n < cli_command_count; n++) {
        const cli_command_t *command = &cli_commands[n];
        printf("    %s)\n        COMPREPLY=($(compgen -W \"", command->name);
        arguments_show(command->run, print_options, NULL);
        printf("--help");
        if (command->run == command_explain) {
            for (uint32_t r = 0; r < reasons_count; r++) {
                printf(" %s", reasons[r].name);
            }
        }
        printf("\" -- \"$word\")%s)\n        ;;\n",
               command->run == command_plot || command->run == command_compare
                   ? " $(compgen -f -X '!*.csv' -- \"$word\") $(compgen -f -X '!*.mat' -- \"$word\")"
               : command->run == command_run || command->run == command_serve
                   ? " $(lagless scenarios 2>/dev/null | awk '{print $1}' | grep \"^$word\")"
                     " $(compgen -f -X '!*.toml' -- \"$word\")"
                   : "");
    }
    printf("    esac\n}\ncomplete -F _lagless lagless\n");
}

/* fish: one line for each candidate. A text in single quotes, in which fish interprets \\ and \'. */
static void print_quoted(const char *text)
{
    printf("'");
    for (; *text != '\0'; text++) {
        printf(*text == '\'' || *text == '\\' ? "\\%c" : "%c", *text);
    }
    printf("'");
}

static void print_fish_options(const struct argp *argp, void *context)
{
    const cli_command_t *command = context;
    for (const struct argp_option *row = argp->options; row != NULL && row->name != NULL; row++) {
        if ((row->flags & OPTION_HIDDEN) != 0) {
            continue;
        }
        printf("complete -c lagless -n '__fish_seen_subcommand_from %s' -l %s", command->name, row->name);
        if (row->key > ' ' && row->key <= '~') {
            printf(" -s '%c'", row->key);
        }
        if (strcmp(row->name, "set") == 0 || strcmp(row->name, "record") == 0) {
            printf(" -x -a \"$lagless_%s\"", row->name);
        } else if (row->arg != NULL) {
            printf(" -r");
        }
        printf(" -d ");
        print_quoted(row->doc);
        printf("\n");
    }
}

static void print_fish(void)
{
    printf("complete -c lagless -e\nset -g lagless_set ");
    print_rows(true, "=");
    printf("\nset -g lagless_record ");
    print_rows(false, "");
    printf("\n");
    for (size_t n = 0; n < cli_command_count; n++) {
        const cli_command_t *command = &cli_commands[n];
        printf("complete -c lagless -f -n __fish_use_subcommand -a %s -d ", command->name);
        print_quoted(command->text);
        printf("\n");
        arguments_show(command->run, print_fish_options, (void *)command);
        if (command->run == command_run || command->run == command_serve) {
            printf("complete -c lagless -n '__fish_seen_subcommand_from %s' -a '(lagless scenarios "
                   "2>/dev/null | "
                   "string replace -r \" .*\" \"\")'\n",
                   command->name);
        } else if (command->run == command_explain) {
            printf("complete -c lagless -f -n '__fish_seen_subcommand_from explain' -a '");
            for (uint32_t r = 0; r < reasons_count; r++) {
                printf("%s ", reasons[r].name);
            }
            printf("'\n");
        }
    }
}

/* zsh runs the functions of bash by its own bashcompinit. */
static void print_zsh(void)
{
    printf("autoload -U +X compinit && compinit\nautoload -U +X bashcompinit && bashcompinit\n");
    print_bash();
}

static const struct {
    const char *name;
    void (*print)(void);
} shells[] = {{"bash", print_bash}, {"zsh", print_zsh}, {"fish", print_fish}};

static error_t parse(int key, char *argument, struct argp_state *state)
{
    size_t *shell = state->input;
    const size_t count = sizeof shells / sizeof shells[0];
    switch (key) {
    case ARGP_KEY_ARG:
        for (*shell = 0; *shell < count && strcmp(argument, shells[*shell].name) != 0;) {
            (*shell)++;
        }
        if (*shell == count) {
            argp_error(state, "%s: no such shell; accepted: bash, zsh, fish", argument);
        }
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "the name of the shell is missing; accepted: bash, zsh, fish");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

int command_completion(int argc, char **argv)
{
    static const struct argp argp = {
        NULL,
        parse,
        "bash|zsh|fish",
        "Prints the completion of commands, options, names of rows, reasons and scenarios for a shell.\v"
        "In bash and zsh: `source <(lagless completion bash)`; in fish: `lagless completion fish | source`.",
        NULL,
        NULL,
        NULL};
    size_t shell;
    if (!arguments_parse(&argp, argc, argv, &shell)) {
        return EXIT_USAGE;
    }
    shells[shell].print();
    return EXIT_DONE;
}

/* Text of a command: a \v separates the part before the options from the part after them, a \n ends a line.
 */
static void print_roff(const char *text, size_t length)
{
    for (size_t n = 0; n < length; n++) {
        printf(text[n] == '\n' ? "\n.br\n" : text[n] == '-' || text[n] == '\\' ? "\\%c" : "%c", text[n]);
    }
}

static void print_manual(const struct argp *argp, void *context)
{
    const cli_command_t *command = context;
    const char *doc = argp->doc != NULL ? argp->doc : "";
    const size_t before = strcspn(doc, "\v"); /* the rest is printed after the options */
    printf(".SS \"lagless %s%s", command->name, argp->options != NULL ? " [OPTION...]" : "");
    printf("%s%s\"\n", argp->args_doc != NULL ? " " : "", argp->args_doc != NULL ? argp->args_doc : "");
    print_roff(doc, before);
    printf("\n");
    for (const struct argp_option *row = argp->options; row != NULL && row->name != NULL; row++) {
        if ((row->flags & OPTION_HIDDEN) != 0) {
            continue;
        }
        printf(".TP\n");
        if (row->key > ' ' && row->key <= '~') {
            printf("\\fB\\-%c\\fR, ", row->key);
        }
        printf("\\fB\\-\\-");
        print_roff(row->name, strlen(row->name));
        printf("\\fR%s", row->arg != NULL ? "=" : "");
        printf("%s%s%s\n", row->arg != NULL ? "\\fI" : "", row->arg != NULL ? row->arg : "",
               row->arg != NULL ? "\\fR" : "");
        print_roff(row->doc, strlen(row->doc));
        printf("\n");
    }
    if (doc[before] != '\0') {
        printf(".PP\n");
        print_roff(doc + before + 1u, strlen(doc + before + 1u));
        printf("\n");
    }
}

int command_man(int argc, char **argv)
{
    if (!arguments_none(argc, argv, "Prints the manual page, for `man -l -`.")) {
        return EXIT_USAGE;
    }
    printf(".TH LAGLESS 1 \"\" \"%s\" \"User Commands\"\n.SH NAME\nlagless \\- a motor drive's firmware on a "
           "virtual "
           "TMS320F28335\n.SH SYNOPSIS\n.B lagless\n.I COMMAND\n[\\fIOPTION\\fR...]\n.SH COMMANDS\n",
           CLI_VERSION);
    for (size_t n = 0; n < cli_command_count; n++) {
        printf(".TP\n\\fB%s\\fR\n%s.\n", cli_commands[n].name, cli_commands[n].text);
    }
    printf(".SH OPTIONS\n");
    for (size_t n = 0; n < cli_command_count; n++) {
        arguments_show(cli_commands[n].run, print_manual, (void *)&cli_commands[n]);
    }
    printf(".SH EXIT STATUS\n.TP\n%d\ndone, all expectations met\n.TP\n%d\nran, but an expectation failed or "
           "could not be "
           "judged\n.TP\n%d\nwrong use or input\n.TP\n%d\ninternal error, or a file could not be written\n",
           EXIT_DONE, EXIT_FAILED, EXIT_USAGE, EXIT_INTERNAL);
    printf(".SH ENVIRONMENT\n.TP\nNO_COLOR\nno colours\n.TP\nLAGLESS_STOP\nperiod before which rig_stop_at "
           "is called, for a "
           "debugger\n.TP\nLAGLESS_SCENARIOS\nfolder of the scenarios known by name\n.TP\nLAGLESS_PYTHON, "
           "LAGLESS_TOOLS\n"
           "interpreter and folder of the plotting scripts\n");
    return EXIT_DONE;
}
