/* The capture in services (contract/capture.h): the configuration, as rows that can be
 * written, and the orders that use it. */
#ifndef APP_CAPTURING_H
#define APP_CAPTURING_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/capture.h"
#include "contract/refusal.h"
#include "settings/signals.h"

#define CAPTURING_LEVEL_MAX 1e9f

#define CAPTURING_CONTENT_NAMES "signals|replay"

#define CAPTURING_COLUMN(U, id, name, signal, text)                                                          \
    U(id, name, "-", SIGNAL_ID_##signal, 2000, 2999, TABLE_LIVE, text)

/* Written rows act with the order capture_arm. The defaults, which capture_release restores,
 * are the rows of signals_history. */
#define APP_CAPTURE_SERVICES(F, I, U, E)                                                                     \
    E(1910, capture_state, CAPTURE_STATE_NAMES, TABLE_READ,                                                  \
      "idle: records until the next fault; held: ready to be read, until armed or released, or the fault "   \
      "is reset")                                                                                            \
    E(1911, capture_on, CAPTURE_ON_NAMES, TABLE_LIVE,                                                        \
      "trigger besides a fault: a value that rises above capture_level or falls below it, or an order")      \
    U(1912, capture_source, "-", SIGNAL_ID_omega_m, 2000, 2999, TABLE_LIVE,                                  \
      "id of the signal that triggers above or below")                                                       \
    F(1913, capture_level, "-", 0.0f, -CAPTURING_LEVEL_MAX, CAPTURING_LEVEL_MAX, TABLE_LIVE,                 \
      "level of the trigger, in the unit of capture_source")                                                 \
    U(1914, capture_after, "periods", 0, 0, (int32_t)CAPTURE_PERIODS - 1, TABLE_LIVE,                        \
      "number of periods recorded after the trigger; fewer than fit into the buffer")                        \
    U(1915, capture_signals, "-", (int32_t)CAPTURE_COLUMNS, 1, (int32_t)CAPTURE_COLUMNS, TABLE_LIVE,         \
      "number of recorded signals, capture_1 and so on; up to eight fit for 512 periods, more for 341")      \
    CAPTURING_COLUMN(U, 1916, capture_1, state, "id of the signal in the first column")                      \
    CAPTURING_COLUMN(U, 1917, capture_2, i_a, "id of the signal in the second column")                       \
    CAPTURING_COLUMN(U, 1918, capture_3, i_b, "id of the signal in the third column")                        \
    CAPTURING_COLUMN(U, 1919, capture_4, u_dc, "id of the signal in the fourth column")                      \
    CAPTURING_COLUMN(U, 1920, capture_5, i_d, "id of the signal in the fifth column")                        \
    CAPTURING_COLUMN(U, 1921, capture_6, i_q, "id of the signal in the sixth column")                        \
    CAPTURING_COLUMN(U, 1922, capture_7, i_q_ref, "id of the signal in the seventh column")                  \
    CAPTURING_COLUMN(U, 1923, capture_8, u_d, "id of the signal in the eighth column")                       \
    CAPTURING_COLUMN(U, 1924, capture_9, u_q, "id of the signal in the ninth column")                        \
    CAPTURING_COLUMN(U, 1925, capture_10, theta_e, "id of the signal in the tenth column")                   \
    CAPTURING_COLUMN(U, 1926, capture_11, omega_e, "id of the signal in the eleventh column")                \
    CAPTURING_COLUMN(U, 1927, capture_12, sample_flags, "id of the signal in the twelfth column")            \
    U(1928, capture_periods, "periods", 0, 0, 0, TABLE_READ,                                                 \
      "number of periods in the buffer, the oldest first")                                                   \
    U(1929, capture_at, "periods", 0, 0, 0, TABLE_READ, "period of the last trigger, as `period` shows it")  \
    E(2481, capture_content, CAPTURING_CONTENT_NAMES, TABLE_READ,                                            \
      "what is in the buffer: signals, or a record for `lagless replay` (fault_record)")

/* From the background: the buffer restarts with the configuration of the rows. false: `why` names the
 * row; the active capture continues. */
bool capturing_arm(params_error_t *why);

/* Triggers with the present period, for any trigger condition; no effect if the
 * capture has triggered already. */
void capturing_trigger(void);

/* Restores the capture that explains a fault, with an empty buffer. capturing_start: at the start of the
 * program, before the interrupts; capturing_restart: fault_record has changed, and no client uses the buffer
 * unless it is armed. */
void capturing_release(void);
void capturing_start(void);
void capturing_restart(void);

/* Updates the rows that are only shown. */
void capturing_show(void);

/* A slot of the held buffer, by its number: row after row, the oldest first. false: the slot does not
 * exist, or the buffer is not held. */
bool capturing_slot(uint32_t number, uint32_t *bits);

#endif
