/* Commissioning of a scenario's motor. */
#include <stdio.h>
#include <string.h>

#include "host_sim/python/binding.h"

const char *binding_commission_step(uint32_t n, const char **text)
{
    if (n >= COMMISSION_STEP_COUNT) {
        return NULL;
    }
    *text = commission_step_text((commission_do_t)n);
    return commission_step_name((commission_do_t)n);
}

typedef struct {
    const binding_commission_t *how;
    bool stopped;
} listener_t;

static void on_progress(void *context, commission_do_t step, bool done, const commission_result_t *result)
{
    listener_t *listener = context;
    (void)result;
    listener->stopped = listener->how->progress((uint32_t)step, done ? 1u : 0u) == 0u || listener->stopped;
}

static bool goes_on(void *context, commission_do_t step)
{
    const listener_t *listener = context;
    return !listener->stopped && listener->how->progress((uint32_t)step, 2u) != 0u;
}

double binding_commission_answer(const char *question, const char *answer, const char **accepted)
{
    double value = 0.0;
    *accepted = NULL;
    for (uint32_t n = 0; n < COMMISSION_QUESTION_COUNT; n++) {
        const commission_question_t one = (commission_question_t)n;
        if (strcmp(commission_question_name(one), question) == 0) {
            *accepted = commission_question_accepts(one);
            return commission_answer_of(one, answer, &value) ? value : 0.0;
        }
    }
    return 0.0;
}

static bool ask(void *context, commission_question_t question, double *answer)
{
    const listener_t *listener = context;
    *answer = question == COMMISSION_ASK_direction ? listener->how->direction : listener->how->turns;
    return *answer != 0.0;
}

bool binding_commission(const scenario_t *scenario, binding_commission_t *how, commission_result_t *result,
                        char why[WHY_SIZE])
{
    scenario_error_t error = {.file = ""};
    listener_t listener = {how, false};
    const bool listens = how->progress != NULL;
    commission_options_t options = {.progress = listens ? on_progress : NULL,
                                    .goes_on = listens ? goes_on : NULL,
                                    .context = &listener,
                                    .link = how->link,
                                    .chosen = how->chosen != 0u,
                                    .plant_answers = true,
                                    .ask = how->direction != 0.0 || how->turns != 0.0 ? ask : NULL};
    for (uint32_t n = 0; n < COMMISSION_STEP_COUNT; n++) {
        options.skip[n] = (how->skip >> n & 1u) != 0u;
    }
    rig_t *rig = commission_rig_of(scenario, how->seed, &error);
    if (rig == NULL) {
        snprintf(why, WHY_SIZE, "%s", error.message);
        return false;
    }
    const commission_plate_t of_rig = commission_plate_of(rig);
    how->plate.pole_pairs = how->plate.pole_pairs > 0.0 ? how->plate.pole_pairs : of_rig.pole_pairs;
    how->plate.current = how->plate.current > 0.0 ? how->plate.current : of_rig.current;
    how->plate.speed = how->plate.speed > 0.0 ? how->plate.speed : of_rig.speed;
    const bool accepted = commission_rig(rig, &how->plate, &options, result, &error);
    rig_free(rig);
    if (!accepted) {
        snprintf(why, WHY_SIZE, "%s: %s", error.name, error.message);
    }
    return accepted;
}
