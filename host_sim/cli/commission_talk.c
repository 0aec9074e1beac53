/* Questions and output of `lagless commission`. */
#include "host_sim/cli/commission_talk.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/select.h>
#include <unistd.h>

#include "host_sim/lab/json.h"

#define RPM (3.14159265358979323846 / 30.0)

/* ---- answers ---- */

/* A voltage above zero. */
static bool link_of(const char *text, double *link)
{
    char *end = NULL;
    *link = strtod(text, &end);
    return end != text && *end == '\0' && isfinite(*link) && *link > 0.0;
}

bool commission_talk_answer(commission_answers_t *answers, const char *text)
{
    const char *equals = strchr(text, '=');
    const size_t length = equals != NULL ? (size_t)(equals - text) : 0u;
    if (strcmp(text, "shaft_free=yes") == 0 || strcmp(text, "shaft_free=no") == 0) {
        answers->turns = strcmp(text, "shaft_free=yes") == 0;
        return true;
    }
    if (strncmp(text, "link=", 5u) == 0) {
        return link_of(text + 5, &answers->link);
    }
    for (uint32_t n = 0; equals != NULL && n < COMMISSION_QUESTION_COUNT; n++) {
        const char *name = commission_question_name((commission_question_t)n);
        if (strlen(name) == length && strncmp(text, name, length) == 0) {
            return commission_answer_of((commission_question_t)n, equals + 1, &answers->of[n]);
        }
    }
    return false;
}

/* ---- keys ---- */

#define ESCAPE 0x1b

static volatile sig_atomic_t interrupted; /* Ctrl-C: as Esc, so that the terminal is as before */

static void interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

static commission_keys_t keys_begin(void)
{
    commission_keys_t keys = {.on = isatty(STDIN_FILENO) && tcgetattr(STDIN_FILENO, &keys.before) == 0};
    if (keys.on) {
        struct termios now = keys.before;
        now.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
        keys.on = signal(SIGINT, interrupt) != SIG_ERR && tcsetattr(STDIN_FILENO, TCSANOW, &now) == 0;
    }
    return keys;
}

static void keys_end(const commission_keys_t *keys)
{
    if (keys->on) {
        (void)tcsetattr(STDIN_FILENO, TCSANOW, &keys->before);
    }
}

static bool goes_on(void *context, commission_do_t step)
{
    const commission_talk_t *talk = context;
    (void)step;
    fd_set input;
    struct timeval now = {0, 0};
    char key = '\0';
    FD_ZERO(&input);
    FD_SET(STDIN_FILENO, &input);
    if (interrupted != 0) {
        return false;
    }
    if (!talk->keys.on || select(STDIN_FILENO + 1, &input, NULL, NULL, &now) != 1) {
        return true;
    }
    return read(STDIN_FILENO, &key, 1u) != 1 || key != ESCAPE;
}

/* ---- progress ---- */

static void show(const char *name, commission_value_t value, double factor, const char *unit)
{
    if (isfinite(value.value)) {
        printf("  %-10s %10.4g +- %.2g %s\n", name, factor * value.value, factor * value.error, unit);
    }
}

static void say_turn(const commission_result_t *result)
{
    if (result->reversed) {
        printf("  the shaft turned backward: exchange two wires of the motor, or reverse the sign of the "
               "speeds\n");
    }
    printf(isfinite(result->turns) ? "  one turn of the shaft: the pole pairs are confirmed\n"
                                   : "  the pole pairs are not confirmed\n");
}

static void progress(void *context, commission_do_t step, bool done, const commission_result_t *result)
{
    const commission_talk_t *talk = context;
    if (talk->quiet) {
        return;
    }
    if (!done) {
        printf("%s (up to %.0f s): %s\n", commission_step_name(step), commission_step_seconds(step),
               commission_step_text(step));
        fflush(stdout);
        return;
    }
    if (result->reason[0] != '\0') {
        printf("  ended by %s after %.1f s: %s\n", result->reason, result->seconds, result->what);
        return;
    }
    switch (step) {
    case COMMISSION_DO_board:
    case COMMISSION_DO_wiring:
        printf("  passed\n");
        break;
    case COMMISSION_DO_current_loop:
        printf("  gain %.3f of its design\n", result->loop_gain);
        break;
    case COMMISSION_DO_turn:
        say_turn(result);
        break;
    case COMMISSION_DO_resistance:
        show("R", result->resistance, 1.0, "ohm");
        show("V_dead", result->dead_voltage, 1.0, "V");
        show("zone", result->current_zone, 1e3, "mA");
        break;
    case COMMISSION_DO_angle:
        printf("  d axis at %.1f degrees, electrical\n", result->angle_d * 180.0 / 3.14159265358979);
        break;
    case COMMISSION_DO_inductance:
        show("L_d", result->inductance_d, 1e3, "mH");
        show("L_q", result->inductance_q, 1e3, "mH");
        if (result->saturation_current.value > 0.0) {
            show("I_s", result->saturation_current, 1.0, "A");
        } else {
            printf("  %s\n", result->saturation_current.value == 0.0 ? "L_q does not depend on the current"
                                                                     : "saturation not measured");
        }
        break;
    case COMMISSION_DO_swing:
        printf("  first values: psi_f %.3g Wb, J %.3g kg m^2\n", result->flux_first, result->inertia_first);
        break;
    case COMMISSION_DO_flux:
        show("psi_f", result->flux_linkage, 1e3, "mWb");
        break;
    case COMMISSION_DO_inertia:
        show("J", result->inertia, 1e3, "g m^2");
        show("T_c", result->friction_coulomb, 1e3, "mN m");
        show("B", result->friction_viscous, 1e6, "uN m s/rad");
        break;
    case COMMISSION_DO_least_speed:
        printf("  the drive runs without an encoder from %.3g r/min on\n", result->least_speed / RPM);
        break;
    case COMMISSION_STEP_COUNT:
        break;
    }
}

/* The measured points of each step, "NAME": [[x, y], ...]. */
static void print_points(FILE *file, const commission_result_t *result)
{
    uint32_t step = COMMISSION_STEP_COUNT; /* of the point before */
    fprintf(file, "{");
    for (uint32_t n = 0; n < result->points_count; n++) {
        const commission_measured_t *point = &result->points[n];
        if (point->step != step) {
            fprintf(file, "%s\"%s\": [", n > 0u ? "], " : "",
                    commission_step_name((commission_do_t)point->step));
        }
        fprintf(file, "%s[", point->step == step ? ", " : "");
        json_number(file, point->x);
        fprintf(file, ", ");
        json_number(file, point->y);
        fprintf(file, "]");
        step = point->step;
    }
    fprintf(file, "%s}", result->points_count > 0u ? "]" : "");
}

void commission_print_json(FILE *file, const commission_result_t *result)
{
    const struct {
        const char *name;
        commission_value_t value;
    } values[] = {
        {"resistance", result->resistance},
        {"inductance_d", result->inductance_d},
        {"inductance_q", result->inductance_q},
        {"saturation_current", result->saturation_current},
        {"flux_linkage", result->flux_linkage},
        {"inertia", result->inertia},
        {"friction_coulomb", result->friction_coulomb},
        {"friction_viscous", result->friction_viscous},
        {"dead_voltage", result->dead_voltage},
        {"current_zone", result->current_zone},
    };
    const struct {
        const char *name;
        double value;
    } others[] = {
        {"angle_d", result->angle_d},           {"loop_gain", result->loop_gain},
        {"least_speed", result->least_speed},   {"turns", result->turns},
        {"seconds", result->seconds},           {"largest_current", result->largest_current},
        {"largest_heat", result->largest_heat},
    };
    fprintf(file, "{");
    for (size_t n = 0; n < sizeof values / sizeof values[0]; n++) {
        fprintf(file, "\"%s\": ", values[n].name);
        json_number(file, values[n].value.value);
        fprintf(file, ", ");
    }
    for (size_t n = 0; n < sizeof others / sizeof others[0]; n++) {
        fprintf(file, "\"%s\": ", others[n].name);
        json_number(file, others[n].value);
        fprintf(file, ", ");
    }
    fprintf(file, "\"reason\": ");
    json_text(file, result->reason[0] != '\0' ? result->reason : NULL);
    fprintf(file, ", \"uncertainty\": {");
    for (size_t n = 0; n < sizeof values / sizeof values[0]; n++) {
        fprintf(file, "%s\"%s\": ", n > 0u ? ", " : "", values[n].name);
        json_number(file, values[n].value.error);
    }
    fprintf(file, "}, \"points\": ");
    print_points(file, result);
    fprintf(file, "}\n");
}

/* ---- questions ---- */

/* A line of the terminal, without its end. false: none. */
static bool read_line(char line[64])
{
    if (fgets(line, 64, stdin) == NULL) {
        return false;
    }
    line[strcspn(line, "\n")] = '\0';
    return true;
}

/* An answer that was given on the command line, or is typed now. */
static bool ask(void *context, commission_question_t question, double *answer)
{
    commission_talk_t *talk = context;
    char line[64];
    *answer = talk->answers.of[question];
    if (isfinite(*answer) || !talk->terminal || !talk->sees_shaft) {
        return isfinite(*answer);
    }
    bool known = false;
    keys_end(&talk->keys);
    do {
        fprintf(stderr, "%s [%s; empty: not known] ", commission_question_text(question),
                commission_question_accepts(question));
    } while (read_line(line) && line[0] != '\0' && !(known = commission_answer_of(question, line, answer)));
    talk->keys = keys_begin();
    return known;
}

/* The turning steps need a free shaft, and every value the true link. */
void commission_talk_begin(commission_talk_t *talk, commission_options_t *steps)
{
    char line[64];
    for (bool asks = talk->terminal && talk->answers.link == 0.0; asks;) {
        fprintf(stderr, "Voltage of the DC link by a meter, in V? [empty: not measured] ");
        asks = read_line(line) && line[0] != '\0' && !link_of(line, &talk->answers.link);
    }
    if (talk->answers.turns && talk->terminal) {
        fprintf(stderr, "Is the shaft free, uncoupled and out of reach of persons? It will turn. [y/n] ");
        talk->answers.turns = read_line(line) && (line[0] == 'y' || line[0] == 'Y');
    }
    for (uint32_t n = COMMISSION_DO_turn; !talk->answers.turns && n < COMMISSION_STEP_COUNT; n++) {
        steps->skip[n] = true;
    }
    steps->link = talk->answers.link;
    steps->progress = progress;
    steps->goes_on = goes_on;
    steps->context = talk;
    const bool answers = isfinite(talk->answers.of[COMMISSION_ASK_direction]) ||
                         isfinite(talk->answers.of[COMMISSION_ASK_turn]);
    steps->ask = (talk->terminal && talk->sees_shaft) || answers ? ask : NULL;
    talk->keys = keys_begin();
    if (talk->keys.on && !talk->quiet) {
        fprintf(stderr, "Esc opens the bridge.\n");
    }
}

void commission_talk_end(commission_talk_t *talk)
{
    keys_end(&talk->keys);
}

void commission_print_sheet(const commission_result_t *result, const commission_sheet_t *sheet)
{
    const struct {
        const char *name, *unit;
        double factor, measured, said;
    } rows[] = {
        {"R", "ohm", 1.0, result->resistance.value, sheet->resistance},
        {"L_d", "mH", 1e3, result->inductance_d.value, sheet->inductance_d},
        {"L_q", "mH", 1e3, result->inductance_q.value, sheet->inductance_q},
        {"psi_f", "mWb", 1e3, result->flux_linkage.value, sheet->flux_linkage},
        {"J", "g m^2", 1e3, result->inertia.value, sheet->inertia},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        if (isfinite(rows[n].measured) && isfinite(rows[n].said)) {
            printf("  %-6s measured %.4g, plate %.4g %s: %+.1f %%\n", rows[n].name,
                   rows[n].factor * rows[n].measured, rows[n].factor * rows[n].said, rows[n].unit,
                   100.0 * (rows[n].measured / rows[n].said - 1.0));
        }
    }
}
