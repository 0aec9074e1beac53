/* Questions and output of `lagless commission`. */
#ifndef HOST_SIM_CLI_COMMISSION_TALK_H
#define HOST_SIM_CLI_COMMISSION_TALK_H

#include <stdbool.h>
#include <stdio.h>
#include <termios.h>

#include "host_sim/lab/commission.h"

/* A terminal that gives each key at once, without showing it. */
typedef struct {
    struct termios before;
    bool on;
} commission_keys_t;

/* The answers that were given by --answer; NAN: none. */
typedef struct {
    bool turns;  /* shaft_free */
    double link; /* [V]; 0: none */
    double of[COMMISSION_QUESTION_COUNT];
} commission_answers_t;

typedef struct {
    bool quiet, terminal;
    bool sees_shaft; /* the user of the terminal sees the shaft */
    commission_answers_t answers;
    commission_keys_t keys;
} commission_talk_t;

/* --answer NAME=VALUE. false: it is none of the accepted ones. */
bool commission_talk_answer(commission_answers_t *answers, const char *text);

/* Requests link voltage and free shaft on a terminal, and puts answers and call-backs into the options. */
void commission_talk_begin(commission_talk_t *talk, commission_options_t *steps);
void commission_talk_end(commission_talk_t *talk);

/* The result as one JSON object. */
void commission_print_json(FILE *file, const commission_result_t *result);

/* The measured values and those of the plate's file (NAN: none), in the order of the results. */
typedef struct {
    double resistance, inductance_d, inductance_q, flux_linkage, inertia;
} commission_sheet_t;
void commission_print_sheet(const commission_result_t *result, const commission_sheet_t *sheet);

#endif
