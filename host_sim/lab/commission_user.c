/* The questions of commissioning to the user, and the lowest speed without an encoder. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/commission_parts.h"

#define TURN_MOST 0.2 /* distance of the counted turns from a ratio of pole pairs [-] */

static const struct {
    const char *name, *text, *accepts;
} questions[] = {
#define QUESTION_OF(name, text, accepted) {#name, text, accepted},
    COMMISSION_QUESTIONS(QUESTION_OF)
#undef QUESTION_OF
};

const char *commission_question_name(commission_question_t question)
{
    return questions[question].name;
}

const char *commission_question_text(commission_question_t question)
{
    return questions[question].text;
}

const char *commission_question_accepts(commission_question_t question)
{
    return questions[question].accepts;
}

bool commission_answer_of(commission_question_t question, const char *text, double *answer)
{
    if (question == COMMISSION_ASK_direction) {
        *answer = strcmp(text, "reversed") == 0 ? -1.0 : 1.0;
        return *answer < 0.0 || strcmp(text, "as_said") == 0;
    }
    char *end = NULL;
    *answer = strcmp(text, "one") == 0 ? 1.0 : strtod(text, &end);
    return (end == NULL || (end != text && *end == '\0')) && isfinite(*answer) && *answer > 0.0;
}

/* The user's answer, or that of the simulated motor. */
static bool ask(commission_work_t *work, commission_question_t question, double turned, double *answer)
{
    const commission_options_t *options = work->options;
    if (options->ask != NULL && options->ask(options->context, question, answer)) {
        return true;
    }
    *answer = question == COMMISSION_ASK_turn ? round(20.0 * fabs(turned)) / 20.0 : turned < 0.0 ? -1.0 : 1.0;
    return options->plant_answers && work->drive->turned != NULL;
}

bool commission_ask_turn(commission_work_t *work)
{
    commission_result_t *result = work->result;
    double answer = 0.0;
    char text[200];
    const commission_drive_t *drive = work->drive;
    const double turned = drive->turned != NULL ? drive->turned(drive->context) : 1.0;
    if (ask(work, COMMISSION_ASK_direction, turned, &answer)) {
        result->reversed = answer < 0.0;
    }
    if (!ask(work, COMMISSION_ASK_turn, turned, &answer)) {
        return true;
    }
    result->turns = answer;
    if (fabs(answer - 1.0) < 1e-9) {
        return true;
    }
    const double pairs = work->plate->pole_pairs / answer;
    const double whole = round(pairs);
    const bool named = whole >= 1.0 && fabs(pairs - whole) < TURN_MOST;
    snprintf(text, sizeof text, "%.0f electrical turns made %.3g turns of the shaft in place of one",
             work->plate->pole_pairs, answer);
    char remedy[80] = "count the poles of the motor";
    if (named) {
        snprintf(remedy, sizeof remedy, "begin again with pole_pairs = %.0f", whole);
    }
    commission_end(work, "pole_pairs_doubted", text, remedy);
    return false;
}

/* ---- least speed ---- */

#define LOOK       5e-3 /* [s] between two checks */
#define BEGIN      1.5  /* first speed over that of the hand-over [-] */
#define STEADY     1.0  /* [s] to the first speed, after the start */
#define START_MOST 20.0 /* [s] of the start */
#define LOWER      0.8  /* from one speed to the next [-] */
#define SETTLE     0.3  /* [s] after the change of the speed */
#define COAST      0.3  /* [s] after the last speed, with the bridge open */
#define JUDGED     0.5  /* [s] */
#define SCATTER    0.05 /* largest standard deviation of the speed, relative [-] */
#define APART      0.05 /* largest distance of its mean from the reference, relative [-] */
#define MARGIN     1.3  /* result over the lowest speed that held [-] */
#define NO_FORCED  0.01 /* fallback_speed over that of the hand-over: not reached [-] */
#define SPEEDS     20u
#define LOOKS      60.0 /* [-] of a speed, at least */

/* The drive runs at this speed for a while. true: with its own estimate, and steadily. */
static bool holds(commission_work_t *work, double speed, double losses)
{
    const double running = commission_choice("manoeuvre", "run");
    double sum = 0.0;
    double square = 0.0;
    double count = 0.0;
    bool good = commission_put(work, "speed_request", speed);
    const double begin = work->drive->seconds(work->drive->context);
    for (double passed = 0.0; good && (passed < SETTLE + JUDGED || count < LOOKS);
         passed = work->drive->seconds(work->drive->context) - begin) {
        commission_wait(work, LOOK);
        const double omega = commission_value(work, "omega_m");
        good = !work->lost && !commission_is_stopped(work, COMMISSION_DO_least_speed) &&
               commission_value(work, "manoeuvre") == running &&
               commission_value(work, "lock_losses") == losses;
        if (passed > SETTLE) {
            sum += omega - speed;
            square += (omega - speed) * (omega - speed);
            count += 1.0;
        }
    }
    const double mean = count > 0.0 ? sum / count : 0.0;
    return good && count > 0.0 && fabs(mean) < APART * speed &&
           sqrt(fmax(square / count - mean * mean, 0.0)) < SCATTER * speed;
}

/* The lowest speed that held [rad/s]; NAN: the first speed did not hold. */
static double lowest(commission_work_t *work)
{
    double speed = BEGIN * work->handover;
    double held = (double)NAN;
    const double losses = commission_value(work, "lock_losses");
    for (uint32_t n = 0; n < SPEEDS && holds(work, speed, losses); n++) {
        held = speed;
        speed *= LOWER;
    }
    return held;
}

bool commission_least_speed(commission_work_t *work)
{
    commission_result_t *result = work->result;
    const double first = BEGIN * work->handover;
    /* Only the run is without a forced frame: the start judges from fallback_speed on whether the rotor
     * follows, and would call it stalled where the EMF is smaller than the error of the voltage. */
    const bool begun =
        commission_put(work, "commission", 0.0) &&
        commission_wait_for(work, "state", commission_choice("state", "ready"), START_MOST) &&
        commission_put(work, "speed_request", first) && commission_put(work, "enable", 1.0) &&
        commission_wait_for(work, "manoeuvre", commission_choice("manoeuvre", "run"), START_MOST) &&
        commission_put(work, "fallback_speed", NO_FORCED * work->handover) &&
        work->drive->apply(work->drive->context);
    if (begun) {
        commission_wait(work, STEADY);
        const double held = lowest(work);
        result->least_speed = MARGIN * held;
    }
    const bool fault = commission_value(work, "state") == commission_choice("state", "fault");
    (void)commission_put(work, "enable", 0.0);
    commission_wait(work, COAST);
    if (fault && !isfinite(result->least_speed) && result->reason[0] == '\0') {
        commission_end_with_fault(work);
    } else if (fault) { /* losing the rotor at the last speed is no failure */
        (void)commission_put(work, "fault_reset", 1.0);
        commission_wait(work, LOOK);
        (void)commission_put(work, "fault_reset", 0.0);
        commission_wait(work, LOOK);
    }
    if (!isfinite(result->least_speed) && result->reason[0] == '\0') {
        commission_end(work, "sensorless_lost", "the drive did not hold 1.5 times the speed of its hand-over",
                       "uncouple the load; permit more current");
    }
    return result->reason[0] == '\0';
}
