/* Reasons: why the drive stopped, does not continue, or warns. Number (permanent, append only), name, text
 * and remedy, from the fault table (faults.h) and from the refusals here. */
#ifndef SETTINGS_REASONS_H
#define SETTINGS_REASONS_H

#include <stdint.h>

#include "medium/commission/commission_types.h"
#include "settings/faults.h"

/* R(number, NAME, "name", "what happened", "what to do"): refusals, and reasons for a stop that have no row
 * in the fault table. 36 is retired. */
#define DRIVE_REFUSALS(R)                                                                                    \
    R(0, NONE, "none", "nothing is wrong", "nothing to do")                                                  \
    R(1, NOT_READY, "not_ready", "the current offsets are still being measured",                             \
      "wait; it takes a tenth of a second with the bridge off")                                              \
    R(2, FAULT_LATCHED, "fault_latched", "a fault is latched",                                               \
      "read fault_reason, remove its cause, then reset")                                                     \
    R(3, FAULT_PRESENT, "fault_present",                                                                     \
      "the cause of the fault is still present, or ended less than 20 ms ago",                               \
      "remove the cause, wait 20 ms, then reset again")                                                      \
    R(4, UNKNOWN_ID, "unknown_id", "no row of the tables has this id", "list the tables")                    \
    R(5, OUT_OF_RANGE, "out_of_range", "the value is outside the range of its row",                          \
      "choose a value in the range")                                                                         \
    R(6, CROSS_RULE, "cross_rule", "the value contradicts other parameters",                                 \
      "change it, or the parameter that the rule names, in one set")                                         \
    R(7, BRIDGE_ON, "bridge_on", "possible only while the bridge is off", "switch off first")                \
    R(8, READ_ONLY, "read_only", "this value can be read, not set",                                          \
      "set the parameter or request that determines it")                                                     \
    R(9, BOARD_FAILED, "board_failed", "the board did not start (clock or configuration)",                   \
      "check crystal and supply, then reset the controller")                                                 \
    R(27, CURRENT_OFFSET, "current_offset",                                                                  \
      "a current sensor reads more than current_offset_max at zero current",                                 \
      "check sensor supply and wiring")                                                                      \
    R(119, CURRENT_NOISE, "current_noise",                                                                   \
      "the values of the current sensors scatter by more than 2.5 % of the range (rms) at zero current",     \
      "check shield and ground of the sensors' wiring, the supply of the sensors and the filter before the " \
      "ADC")                                                                                                 \
    R(31, GATES_REFUSED, "gates_refused", "the gates did not come on, or went off without a fault",          \
      "check the fault line of the power module; if they went off, the memory of the controller")            \
    R(70, STORE_CORRUPT, "store_corrupt", "the stored parameters are invalid: the drive uses its defaults",  \
      "set the parameters of your motor, reset the fault, save")                                             \
    R(74, STORE_FAILED, "store_failed",                                                                      \
      "the memory did not accept the parameters: those stored before are unchanged",                         \
      "switch the bridge off and save again; if this repeats, use a build with TI's flash API "              \
      "(docs/chip.md), or replace the controller")                                                           \
    R(116, STORE_FOREIGN, "store_foreign",                                                                   \
      "the memory for parameters holds data of another program: nothing is saved into it",                   \
      "if nothing in it is needed, erase it with `erase yes`, then save")                                    \
    R(118, STORE_BUSY, "store_busy", "an order to save or erase is not complete in the memory",              \
      "wait until store_state is no longer `busy`, then repeat the order")                                   \
    R(117, ENABLE_INPUT, "enable_input",                                                                     \
      "the enable input of the board is not active, or it was lost while the motor ran",                     \
      "activate the input; reset the fault if it is latched; set `enable` to off, then to on")               \
    R(80, ENABLE_HELD, "enable_held",                                                                        \
      "`enable` was on while a fault was reset or the enable input was not active: these events alone do "   \
      "not start the motor",                                                                                 \
      "set `enable` to off, then to on")                                                                     \
    R(81, STOPPING, "stopping", "a quick stop is running and must end first",                                \
      "wait until the rotor is at standstill, or set `enable` to off and let it coast")                      \
    R(82, ESTIMATE_ASTRAY, "estimate_astray",                                                                \
      "the estimated speed exceeded overspeed_trip, but the back-EMF did not confirm it: the shaft may be "  \
      "slow",                                                                                                \
      "check the current sensors for noise and delay; check motor_inductance_q and motor_flux_linkage")

typedef enum {
#define REASON_OF_REFUSAL(number, NAME, name, text, remedy) REASON_##NAME = number,
#define REASON_OF_FAULT(number, NAME, name, quantity, comparison, limit, margin, rate, debounce, when,       \
                        reaction, text, remedy)                                                              \
    REASON_##NAME = number,
    DRIVE_REFUSALS(REASON_OF_REFUSAL) DRIVE_FAULTS(REASON_OF_FAULT)
#undef REASON_OF_REFUSAL
#undef REASON_OF_FAULT
} reason_t;

typedef struct {
    int32_t number;
    const char *name;
    const char *text;
    const char *remedy;
} reason_row_t;

extern const reason_row_t reasons[];
extern const uint32_t reasons_count;

/* The row of a number; NULL if the table has none. */
const reason_row_t *reason_by_number(int32_t number);

/* The row of a commission_reason_t, with its own numbers; NULL if there is none. */
const reason_row_t *reason_of_commission(int32_t number);

#endif
