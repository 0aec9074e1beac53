/* The ring, closed: firmware and HAL on the virtual F28335, which switches the inverter that feeds the motor
 * whose currents its ADC samples. One call steps one PWM period.
 *
 * This is the only door for CLI, tests, debugger and everything later. Values are reached by the permanent
 * ids of the tables: parameters (staged until rig_apply), requests, signals, services, and on the desk truth
 * (3000..), plant (4000..) and rig (5000..). All numbers in the SI unit of their row.
 *
 * Deterministic: the same calls with the same seed give the same bits on every machine. Rigs do not disturb
 * each other; one rig belongs to one thread at a time. */
#ifndef HOST_SIM_RIG_RIG_H
#define HOST_SIM_RIG_RIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "contract/capture.h"
#include "contract/table.h"
#include "hal/board.h"

typedef struct rig rig_t;

#if defined(LAGLESS_ANY_BOARD)
#define RIG_PERIOD_TICKS ((uint64_t)rig_period_ticks)
#else
#if BOARD_PERIOD_CYCLES * 150000 % (BOARD_SYSCLK_HZ / 1000) != 0
#error                                                                                                       \
    "docs/board.md, line 3: the simulation counts in 1/150 MHz, and the period of this carrier is not a whole number of ticks; choose another carrier nearby (125 MHz: 9992 Hz)"
#endif

/* One rig_step: a period of the board's carrier, in ticks [1/150 MHz] whatever its system clock. */
#define RIG_PERIOD_TICKS ((uint64_t)BOARD_PERIOD_CYCLES * 150000u / (BOARD_SYSCLK_HZ / 1000u))
#endif
#define RIG_PERIOD_SECONDS ((double)RIG_PERIOD_TICKS / 150e6)

/* Of the board that this program or library simulates, for sources that are compiled once for all boards. */
extern const uint32_t rig_period_ticks; /* RIG_PERIOD_TICKS; a debugger reads it too, which knows no macros */
extern const uint32_t rig_window_periods; /* [periods] of a window of the medium task */
extern const char rig_board[];            /* BOARD_NAME */

/* [periods] of so many ticks, nearest to this time [s], which is not negative. */
static inline uint32_t rig_periods_of(double seconds, uint64_t period_ticks)
{
    return (uint32_t)(seconds / ((double)period_ticks / 150e6) + 0.5);
}

static inline uint32_t rig_periods(double seconds)
{
    return rig_periods_of(seconds, RIG_PERIOD_TICKS);
}

/* Power on: firmware defaults, plant defaults, rotor at rest, seed of all noise. The board is up and period 0
 * begins when this returns. NULL only without memory. */
rig_t *rig_create(uint64_t seed);
void rig_free(rig_t *rig);

/* One PWM period. */
void rig_step(rig_t *rig);

/* Runs so many periods and returns what the sample interrupt took on this machine, mean [s], clock overhead
 * taken off. Changes nothing else: they are the periods that rig_run would have run. */
double rig_interrupt_seconds(rig_t *rig, uint32_t periods);

/* The estimator by itself. A record is a block of rig_estimator_size() octets, aligned like any that malloc
 * gives, good in every process of the same program: the drive's estimator as it stands, and what
 * estimator_step gets in the next RIG_ESTIMATOR_STEPS periods, which rig_estimator_record runs. The bridge
 * must be on. */
#define RIG_ESTIMATOR_STEPS 20000u
size_t rig_estimator_size(void);
void rig_estimator_record(rig_t *rig, void *record);

/* Takes these steps again on a copy of that estimator, by a call that no compiler sees through, so that an
 * instruction counter may count between entry and return; or as many empty functions of the same shape, to be
 * subtracted. Returns theta_hat of the last step [rad]. */
float rig_estimator_replay(const void *record, bool empty);

/* What a step took on this machine, mean of one replay [s], loop and call taken off. */
double rig_estimator_seconds(const void *record);

/* Up to n periods; fewer if the stop condition is met. Returns how many ran. */
uint32_t rig_run(rig_t *rig, uint32_t periods);

/* Periods since creation; simulated time is this times RIG_PERIOD_SECONDS. */
uint32_t rig_period(const rig_t *rig);

/* All tables, in the order params, requests, signals, services, truth, plant, rig. */
uint32_t rig_table_count(void);
const table_t *rig_table(uint32_t index);
const table_row_t *rig_row(uint32_t id);              /* NULL: no such id */
const table_row_t *rig_row_by_name(const char *name); /* NULL: no such name */
uint32_t rig_tables_hash(void);

/* Default and accepted range of a settable row, in double: exact for every kind. */
double rig_initial(const table_row_t *row);
double rig_min(const table_row_t *row);
double rig_max(const table_row_t *row);
bool rig_accepts(const table_row_t *row, double value); /* finite, whole where the kind is, in the range */

/* A value of a slot, as short as it tells it from its neighbours; and a range in the row's unit, "1 to 10000
 * rad/s" or "none", whose ends as they are written are in it. Both return `to`. */
#define RIG_NUMBER_SIZE 32u
#define RIG_RANGE_SIZE  112u
const char *rig_value_text(char to[RIG_NUMBER_SIZE], double value);
const char *rig_range_text(char to[RIG_RANGE_SIZE], const table_row_t *row, double min, double max);

/* Value of a row; parameters: the active set. false: no such id (see rig_error). */
bool rig_get(rig_t *rig, uint32_t id, double *value);

/* Set a row. Parameters are staged; requests, plant and rig rows act at once. false: refused, nothing has
 * changed, and rig_error names the row, the value and what would have been accepted. */
bool rig_set(rig_t *rig, uint32_t id, double value);

/* Judge the staged parameters as a whole and take them over before the next period. false: refused, the old
 * set runs on. */
bool rig_apply(rig_t *rig);

/* The row whose text is the name of a flux map's file; and its value, the number of the map in this file. 0:
 * `why` says what is wrong, and what is accepted. */
bool rig_is_flux_map(const table_row_t *row);
uint32_t rig_read_flux_map(const char *path, char *why, size_t size);

/* By name, "inertia" or, where two tables have the name, "plant.inertia"; for tests and the CLI. A wrong name
 * in rig_value is a programming error (asserted). */
double rig_value(rig_t *rig, const char *name);
bool rig_put(rig_t *rig, const char *name, double value);

/* Set the rotor's true motion: mechanical angle [rad] and speed [rad/s]. The encoder counter is set to the
 * new angle, as an alignment would, and sees no jump. */
void rig_set_motion(rig_t *rig, double theta_m, double omega_m);

/* What the last refused call had to say; "" if none. */
const char *rig_error(const rig_t *rig);
uint32_t rig_error_id(const rig_t *rig);    /* row it was about; 0: none */
int32_t rig_error_reason(const rig_t *rig); /* drive's reason number */

/* The value that was refused and the range of that row that would be accepted with everything else as it is,
 * in its unit. false: the refusal was about no range, or nothing is accepted. */
bool rig_error_range(const rig_t *rig, double *value, double *min, double *max);

/* The tap: after every drive step the 32-bit slots of these rows are handed to `sink` (every `every`-th
 * period). */
typedef void (*rig_sink_t)(void *context, uint32_t period, const uint32_t *slots, uint32_t count);
#define RIG_TAP_MAX 160u
bool rig_tap(rig_t *rig, const uint32_t *ids, uint32_t count, uint32_t every, rig_sink_t sink, void *context);

/* What the drive's capture keeps (contract/capture.h): of the last periods the slots of some rows, as the
 * step of the period left them. Unless it is armed for something else a fault holds it, with its own period
 * as the newest, until it is reset; then it begins anew.
 * rig_history_held: is it held, and by the fault that is latched? rig_history_columns, rig_history_rows: how
 * many rows, and their ids. rig_history: the slots of the period that is so many periods older than the
 * newest, `ago` below the count; *period is that by the drive's own count, as `period` shows it. */
bool rig_history_held(const rig_t *rig);
uint32_t rig_history_count(const rig_t *rig);
uint32_t rig_history_columns(const rig_t *rig);
const uint32_t *rig_history_rows(const rig_t *rig);
const uint32_t *rig_history(const rig_t *rig, uint32_t ago, uint32_t *period);

/* The drive's serial line, led past the chip's transmitter and receiver: octets as they come, no line time.
 * Both functions return how many they took or gave, at once; they are called from within rig_step. NULL: the
 * chip's own line. What comes and goes there is outside the rig's state, as a master at the wire is. */
typedef struct {
    uint32_t (*read)(void *context, uint8_t *octets, uint32_t room);
    uint32_t (*write)(void *context, const uint8_t *octets, uint32_t count);
    void *context;
} rig_line_t;
void rig_line(rig_t *rig, const rig_line_t *line);

/* What happens between the samples, in order of time; tick [1/150 MHz] from the beginning of period 0. On
 * watching, the present levels of gates and trip are reported first. */
typedef enum {
    RIG_EDGE_GATES, /* value: six switch commands, bit 2n upper, 2n + 1 lower of leg n; switched fidelity only
                     */
    RIG_EDGE_ADC_START, /* a conversion sequence begins */
    RIG_EDGE_ISR_ENTER, /* an interrupt function is called; value: number of its PIE vector */
    RIG_EDGE_ISR_EXIT,  /* it has returned; value the same */
    RIG_EDGE_TRIP       /* value: bit n = leg n is held off by its trip zone */
} rig_edge_t;
typedef void (*rig_edge_sink_t)(void *context, uint64_t tick, uint32_t what, uint32_t value);
void rig_watch_edges(rig_t *rig, rig_edge_sink_t sink, void *context); /* sink NULL: nobody */

/* The serial line of the chip, in simulated time: octets towards the drive, as many as there was room for on
 * the line (128); and those that the drive has sent by now, at most `room`: how many. The far end runs at
 * BOARD_SERIAL_BAUD, or at the rate [bit/s] of rig_serial_baud(); 0: always at that of the chip. */
void rig_serial_baud(rig_t *rig, uint32_t baud);
uint32_t rig_serial_put(rig_t *rig, const uint8_t *octets, uint32_t count);
uint32_t rig_serial_get(rig_t *rig, uint8_t *octets, uint32_t room);

/* The supply of the control board goes off and on again: the drive begins anew, with what its flash holds.
 * The rotor coasts meanwhile, about 10 ms; parameters of the plant and the rig's rows, time and periods go
 * on. A drive that asks for a restart of the chip (hal_restart) gets one before the next step. */
void rig_power_cycle(rig_t *rig);

/* What the drive stores in flash, as octets of a file: two pages, words with the lower octet first. A load is
 * what a programmer would do, seen by the drive when it looks, at the latest after rig_power_cycle. false:
 * another size, or a page in which something stands where the desk keeps nothing (see rig_error). */
#define RIG_FLASH_SIZE 131072u
void rig_flash_save(const rig_t *rig, uint8_t *octets);
bool rig_flash_load(rig_t *rig, const uint8_t *octets, size_t size);

/* Stop condition of rig_run, judged after each period on a row's value. */
typedef enum { RIG_NEVER, RIG_EQUAL, RIG_NOT_EQUAL, RIG_ABOVE, RIG_BELOW } rig_compare_t;
bool rig_stop_when(rig_t *rig, uint32_t id, rig_compare_t compare, double value);

/* The stop hook: before this period runs, rig_stop_at is called, an empty function to break on. */
void rig_stop_before(rig_t *rig, uint32_t period);
void rig_stop_at(rig_t *rig, uint32_t period);

/* The whole state as bytes; a load goes on exactly where the save was, in any rig of the same program. */
size_t rig_state_size(void);
void rig_save(const rig_t *rig, void *state);
bool rig_load(rig_t *rig, const void *state, size_t size);
uint64_t rig_hash(const rig_t *rig); /* of the state: equal states, equal hashes, in every build */

#endif
