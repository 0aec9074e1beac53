/* The matrix's data as rows. */
#include "host_sim/lab/matrix_table.h"

#define FAULT_ROW(NAME, name, when, watch, lasts, what, text) {name, text, when, watch, lasts, what},
#define MANOEUVRE_ROW(NAME, name, missing, enabled, turning, reference, load, settle, then, row, choice,     \
                      below, delay, text)                                                                    \
    {name, text, missing, enabled, turning, reference, load, settle, then, row, choice, below, delay},
#define PROMISE_ROW(FAULT, manoeuvres, places, reactions, reasons, within, current, rotor, because)          \
    {MATRIX_FAULT_##FAULT, manoeuvres, places, reactions, reasons, within, current, rotor, because},

const matrix_fault_t matrix_faults[] = {MATRIX_FAULTS(FAULT_ROW)};
const size_t matrix_fault_count = sizeof matrix_faults / sizeof matrix_faults[0];

const matrix_manoeuvre_t matrix_manoeuvres[] = {MATRIX_MANOEUVRES(MANOEUVRE_ROW)};
const size_t matrix_manoeuvre_count = sizeof matrix_manoeuvres / sizeof matrix_manoeuvres[0];

const matrix_promise_t matrix_promises[] = {MATRIX_PROMISES(PROMISE_ROW)};
const size_t matrix_promise_count = sizeof matrix_promises / sizeof matrix_promises[0];

#define NOT_YET_ROW(cell, because) {cell, because},
const matrix_not_yet_t matrix_not_yet[] = {MATRIX_NOT_YET(NOT_YET_ROW){NULL, NULL}};
