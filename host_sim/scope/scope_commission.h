/* Commissioning from a page: the request of the page, the run, and the report to the page. While the run
 * waits, it lets the scope work, so that samples, values and STOP continue. */
#ifndef HOST_SIM_SCOPE_SCOPE_COMMISSION_H
#define HOST_SIM_SCOPE_SCOPE_COMMISSION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "host_sim/lab/commission.h"
#include "host_sim/scope/commission_line.h"

typedef struct {
    /* the scope: works for this time [s], false: the line is lost or the program ends; then it reports to the
     * pages */
    bool (*work)(void *context, double seconds);
    void (*tell)(void *context);
    void *context;
    /* request of a page */
    bool wanted, stopped;
    commission_plate_t plate;
    commission_options_t options;
    /* the run */
    bool running, done;
    commission_line_t line;
    commission_drive_t drive;
    commission_do_t step;
    double step_begun; /* [s] of the drive's time */
    double told_at;    /* [s] of the drive's time */
    uint32_t tries;    /* of the step [-] */
    bool ended[COMMISSION_STEP_COUNT];
    bool asking, answered;
    commission_question_t question;
    double answer; /* NAN: not known */
    commission_result_t result;
    char refused[640]; /* refusal by the board; "": none */
} scope_commission_t;

/* "PAIRS CURRENT SPEED LINK FREE RESUME STEPS" in SI units: LINK 0 for not measured, FREE 1 if the shaft may
 * turn, RESUME 1 to take earlier results, STEPS names separated by commas. The run begins by itself later.
 * false: *why. */
bool scope_commission_want(scope_commission_t *commission, const char *body, char *why, size_t size);

/* Gives the answer to the present question: one of its accepted answers, or "unknown". false: *why has the
 * reason. */
bool scope_commission_answer(scope_commission_t *commission, const char *body, char *why, size_t size);

/* Runs commissioning to its end. */
void scope_commission_run(scope_commission_t *commission, master_t *master);

/* All data of commissioning for a page, as JSON. */
void scope_commission_text(FILE *to, const scope_commission_t *commission);

#endif
