#include "host_sim/scope/scope_commission.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/json.h"

#define TELL 0.25 /* [s] of the drive's time between two reports */
#define WORK 0.05 /* [s] while an answer is awaited */

/* ---- requests of a page ---- */

bool scope_commission_want(scope_commission_t *commission, const char *body, char *why, size_t size)
{
    char steps[256] = "";
    commission_plate_t plate;
    commission_options_t options = {.progress = NULL};
    double link = 0.0;
    int may_turn = 0;
    int resume = 0;
    if (commission->wanted || commission->running) {
        snprintf(why, size, "commissioning is in progress already; STOP ends it");
        return false;
    }
    if (sscanf(body, "%lf %lf %lf %lf %d %d %255s", &plate.pole_pairs, &plate.current, &plate.speed, &link,
               &may_turn, &resume, steps) != 7 ||
        !(isfinite(plate.pole_pairs) && plate.pole_pairs >= 1.0 &&
          plate.pole_pairs == round(plate.pole_pairs)) ||
        !(isfinite(plate.current) && plate.current > 0.0) || !(isfinite(plate.speed) && plate.speed > 0.0) ||
        !(isfinite(link) && link >= 0.0)) {
        snprintf(why, size,
                 "the plate: accepted: whole pole pairs from 1 on, a positive current and a positive speed; "
                 "the link's voltage is positive, or empty");
        return false;
    }
    if (!commission_choose(&options, steps, why, size)) {
        return false;
    }
    for (uint32_t n = COMMISSION_DO_turn; may_turn == 0 && n < COMMISSION_STEP_COUNT; n++) {
        options.skip[n] = true;
    }
    options.link = link;
    options.resume = resume != 0;
    commission->plate = plate;
    commission->options = options;
    commission->stopped = false;
    commission->wanted = true;
    return true;
}

bool scope_commission_answer(scope_commission_t *commission, const char *body, char *why, size_t size)
{
    double answer = (double)NAN;
    if (!commission->asking) {
        snprintf(why, size, "no question is open");
        return false;
    }
    if (strcmp(body, "unknown") != 0 && !commission_answer_of(commission->question, body, &answer)) {
        snprintf(why, size, "accepted: %s", commission_question_accepts(commission->question));
        return false;
    }
    commission->answer = strcmp(body, "unknown") == 0 ? (double)NAN : answer;
    commission->answered = true;
    return true;
}

/* ---- the run ---- */

static double seconds(const scope_commission_t *commission)
{
    return commission->drive.seconds(commission->drive.context);
}

static void tell(scope_commission_t *commission)
{
    commission->told_at = seconds(commission);
    commission->tell(commission->context);
}

static void on_progress(void *context, commission_do_t step, bool done, const commission_result_t *result)
{
    scope_commission_t *commission = context;
    (void)result;
    commission->tries = !done && commission->step == step ? commission->tries + 1u : done ? 0u : 1u;
    commission->step = step;
    commission->step_begun = seconds(commission);
    commission->ended[step] = done && commission->result.reason[0] == '\0';
    tell(commission);
}

static bool goes_on(void *context, commission_do_t step)
{
    scope_commission_t *commission = context;
    (void)step;
    if (seconds(commission) - commission->told_at > TELL) {
        tell(commission);
    }
    return !commission->stopped;
}

static bool ask(void *context, commission_question_t question, double *answer)
{
    scope_commission_t *commission = context;
    commission->question = question;
    commission->asking = true;
    commission->answered = false;
    tell(commission);
    while (!commission->answered && !commission->stopped && commission->work(commission->context, WORK)) {
    }
    commission->asking = false;
    tell(commission);
    *answer = commission->answered ? commission->answer : (double)NAN;
    return isfinite(*answer);
}

void scope_commission_run(scope_commission_t *commission, master_t *master)
{
    scenario_error_t error = {.file = ""};
    commission->wanted = false;
    commission->running = true;
    commission->done = false;
    commission->refused[0] = '\0';
    memset(commission->ended, 0, sizeof commission->ended);
    commission->line =
        (commission_line_t){.master = master, .pump = commission->work, .context = commission->context};
    commission->drive = commission_line_drive(&commission->line);
    commission->options.progress = on_progress;
    commission->options.goes_on = goes_on;
    commission->options.ask = ask;
    commission->options.context = commission;
    commission->step = COMMISSION_STEP_COUNT;
    if (!commission_drive(&commission->drive, &commission->plate, &commission->options, &commission->result,
                          &error)) {
        snprintf(commission->refused, sizeof commission->refused, "%.80s: %.500s", error.name, error.message);
    }
    commission->running = false;
    commission->done = true;
    tell(commission);
}

/* ---- messages to a page ---- */

static void put_number(FILE *to, const char *name, double value)
{
    fprintf(to, ",\"%s\":", name);
    json_number(to, value);
}

/* The page offers all steps except the one for a rotor that is held. */
static bool is_shown(commission_do_t step)
{
    return step != COMMISSION_DO_angle;
}

/* Number of shown steps before this one: its place in the list of the page. */
static uint32_t place_of(commission_do_t step)
{
    uint32_t place = 0u;
    for (uint32_t n = 0; n < (uint32_t)step; n++) {
        place += is_shown((commission_do_t)n) ? 1u : 0u;
    }
    return place;
}

static void put_steps(FILE *to, const scope_commission_t *commission)
{
    for (uint32_t n = 0; n < COMMISSION_STEP_COUNT; n++) {
        const commission_do_t step = (commission_do_t)n;
        if (!is_shown(step)) {
            continue;
        }
        fprintf(to, "%s{\"name\":", place_of(step) > 0u ? "," : "");
        json_text(to, commission_step_name(step));
        fputs(",\"text\":", to);
        json_text(to, commission_step_text(step));
        put_number(to, "limit", commission_step_seconds(step));
        fprintf(to, ",\"ended\":%s}", commission->ended[n] ? "true" : "false");
    }
}

static void put_values(FILE *to, const commission_result_t *result)
{
    const struct {
        const char *name, *unit;
        double factor;
        commission_value_t value;
    } rows[] = {
        {"R", "Ω", 1.0, result->resistance},
        {"L_d", "mH", 1e3, result->inductance_d},
        {"L_q", "mH", 1e3, result->inductance_q},
        {"I_s of L_q", "A", 1.0, result->saturation_current},
        {"psi_f", "mWb", 1e3, result->flux_linkage},
        {"J", "g·m²", 1e3, result->inertia},
        {"T_c", "mN·m", 1e3, result->friction_coulomb},
        {"B", "µN·m·s/rad", 1e6, result->friction_viscous},
        {"voltage loss of a leg", "V", 1.0, result->dead_voltage},
        {"loop gain, of design", "", 1.0, {result->loop_gain, (double)NAN}},
        {"least speed", "r/min", 9.5492965855137, {result->least_speed, (double)NAN}},
    };
    const char *separator = "";
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        const commission_value_t value = rows[n].value;
        if (isfinite(value.value) && (value.value != 0.0 || rows[n].value.error != 0.0)) {
            fprintf(to, "%s{\"name\":\"%s\",\"unit\":\"%s\"", separator, rows[n].name, rows[n].unit);
            put_number(to, "value", rows[n].factor * value.value);
            put_number(to, "error", rows[n].factor * value.error);
            fputc('}', to);
            separator = ",";
        }
    }
}

static void put_file(FILE *to, const scope_commission_t *commission)
{
    char *text = NULL;
    size_t size = 0u;
    FILE *file = open_memstream(&text, &size);
    if (file != NULL) {
        commission_write(file, &commission->plate, &commission->result,
                         "Measured from the page of the scope");
        if (fclose(file) == 0) {
            fputs(",\"file\":", to);
            json_text(to, text);
        }
        free(text);
    }
}

void scope_commission_text(FILE *to, const scope_commission_t *commission)
{
    const bool begun = commission->running || commission->done;
    const commission_result_t *result = &commission->result;
    fprintf(to, "{\"running\":%s,\"done\":%s", commission->running || commission->wanted ? "true" : "false",
            commission->done ? "true" : "false");
    fputs(",\"steps\":[", to);
    put_steps(to, commission);
    fprintf(to, "],\"step\":%u,\"tries\":%u", (unsigned)place_of(commission->step),
            (unsigned)commission->tries);
    put_number(to, "elapsed", commission->running ? seconds(commission) - commission->step_begun : 0.0);
    if (commission->asking) {
        fputs(",\"question\":", to);
        json_text(to, commission_question_name(commission->question));
        fputs(",\"question_text\":", to);
        json_text(to, commission_question_text(commission->question));
    }
    if (begun) {
        fputs(",\"values\":[", to);
        put_values(to, result);
        fputc(']', to);
    }
    if (commission->done) {
        fputs(",\"reason\":", to);
        json_text(to, commission->refused[0] != '\0' ? "refused"
                      : result->reason[0] != '\0'    ? result->reason
                                                     : NULL);
        fputs(",\"what\":", to);
        json_text(to, commission->refused[0] != '\0' ? commission->refused : result->what);
        fprintf(to, ",\"known\":%s", commission_known(result) ? "true" : "false");
        fprintf(to, ",\"reversed\":%s", result->reversed ? "true" : "false");
        put_number(to, "turns", result->turns);
        put_number(to, "seconds", result->seconds);
        put_number(to, "largest", result->largest_current);
        put_file(to, commission);
    }
    fputc('}', to);
}
