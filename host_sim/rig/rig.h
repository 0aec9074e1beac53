/* The simulation in closed loop: firmware and HAL run on the virtual F28335, which switches the inverter of
 * the motor and samples the motor's currents. One call simulates one PWM period.
 *
 * This is the only interface for command line, tests and debugger. Values have the permanent ids of the
 * tables: parameters (staged until rig_apply), requests, signals and services of the drive; truth (3000..),
 * plant (4000..) and rig (5000..) of the simulation. All numbers are in the SI unit of their row.
 *
 * The same calls with the same seed give the same bits on every machine. Rigs are independent of each other;
 * only one thread at a time may use a rig. */
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

/* Length of one rig_step: a period of the board's carrier, in ticks [1/150 MHz], independent of its system
 * clock. */
#define RIG_PERIOD_TICKS ((uint64_t)BOARD_PERIOD_CYCLES * 150000u / (BOARD_SYSCLK_HZ / 1000u))
#endif
#define RIG_PERIOD_SECONDS ((double)RIG_PERIOD_TICKS / 150e6)

/* [SYSCLK cycles] Time of the software on the chip. Sample interrupt and medium task:
 * isr_cycles_c28x_estimate and medium_cycles_c28x_estimate of tools/target/cost.json, within a quarter. These
 * are estimates within 30 %, and a small change of the firmware should not change the instants of its writes.
 * A section with interrupts off consists of a few instructions. */
#define RIG_INTERRUPT_CYCLES 5500u
#define RIG_MEDIUM_CYCLES    13800u
#define RIG_SECTION_CYCLES   50u

/* Values of the board that this program or library simulates, for sources that are compiled once for all
 * boards. */
extern const uint32_t
    rig_period_ticks; /* RIG_PERIOD_TICKS as a variable for a debugger, which cannot evaluate macros */
extern const uint32_t rig_window_periods; /* [periods] of a window of the medium task */
extern const char rig_board[];            /* BOARD_NAME */

/* Number of periods, each of period_ticks, nearest to this time [s], which must not be negative. */
static inline uint32_t rig_periods_of(double seconds, uint64_t period_ticks)
{
    return (uint32_t)(seconds / ((double)period_ticks / 150e6) + 0.5);
}

static inline uint32_t rig_periods(double seconds)
{
    return rig_periods_of(seconds, RIG_PERIOD_TICKS);
}

/* Power on: firmware defaults, plant defaults, rotor at standstill, seed of all noise. When the function
 * returns, the board is initialised and period 0 begins. NULL: there is no memory. */
rig_t *rig_create(uint64_t seed);
void rig_free(rig_t *rig);

/* One PWM period. */
void rig_step(rig_t *rig);

/* Runs this number of periods and returns the mean time [s] of the sample interrupt on this machine, without
 * the overhead of the clock. Otherwise the periods are the same as with rig_run. */
double rig_interrupt_seconds(rig_t *rig, uint32_t periods);

/* Measurement of the estimator alone. rig_estimator_record stores the present state of the drive's estimator,
 * runs the next RIG_ESTIMATOR_STEPS periods, and stores the inputs of estimator_step in each. The bridge must
 * be on. A record has rig_estimator_size() octets, aligned as by malloc, and is valid in every process of the
 * same program. */
#define RIG_ESTIMATOR_STEPS 20000u
size_t rig_estimator_size(void);
void rig_estimator_record(rig_t *rig, void *record);

/* Repeats these steps on a copy of that estimator. The compiler cannot inline the call, so that an
 * instruction counter can count between entry and return. `empty` calls as many empty functions with the same
 * arguments instead, whose count is to be subtracted. Returns theta_hat of the last step [rad]. */
float rig_estimator_replay(const void *record, bool empty);

/* Mean time [s] of a step on this machine in one replay, without loop and call. */
double rig_estimator_seconds(const void *record);

/* Runs up to `periods` periods, fewer if the stop condition is met. Returns their number. */
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
double rig_initial_named(const char *name); /* of an existing row */
double rig_min(const table_row_t *row);
double rig_max(const table_row_t *row);
bool rig_accepts(const table_row_t *row, double value); /* finite, whole where the kind is, in the range */

/* Writes a value with the fewest digits that distinguish it from the neighbouring floats, or a range in the
 * row's unit, "1 to 10000 rad/s" or "none". The printed ends are in the range. Both return `to`. */
#define RIG_NUMBER_SIZE 32u
#define RIG_RANGE_SIZE  112u
const char *rig_value_text(char to[RIG_NUMBER_SIZE], double value);
const char *rig_range_text(char to[RIG_RANGE_SIZE], const table_row_t *row, double min, double max);

/* Value of a row; parameters: the active set. false: no such id (see rig_error). */
bool rig_get(rig_t *rig, uint32_t id, double *value);

/* Sets a row. Parameters are staged; requests, plant and rig rows act at once. false: refused and unchanged;
 * rig_error has the row, the value and the accepted values. */
bool rig_set(rig_t *rig, uint32_t id, double value);

/* Judges the staged parameters as a set and activates them before the next period. false: refused; the old
 * set remains active. */
bool rig_apply(rig_t *rig);

/* rig_is_flux_map: true for the row whose text is the name of a flux map's file. rig_read_flux_map returns
 * the value of this row, the number of the map in this file. 0: the file is wrong; `why` has the message. */
bool rig_is_flux_map(const table_row_t *row);
uint32_t rig_read_flux_map(const char *path, char *why, size_t size);

/* By name, "inertia" or, where two tables have the name, "plant.inertia"; for tests and the CLI. A wrong name
 * in rig_value is a programming error (asserted). */
double rig_value(rig_t *rig, const char *name);
bool rig_put(rig_t *rig, const char *name, double value);

/* Set the rotor's true motion: mechanical angle [rad] and speed [rad/s]. The encoder counter is set to the
 * new angle, as by an alignment, so that it does not count the change. */
void rig_set_motion(rig_t *rig, double theta_m, double omega_m);

/* Message of the last refused call; "" if there is none. */
const char *rig_error(const rig_t *rig);
uint32_t rig_error_id(const rig_t *rig);    /* row of this message; 0: none */
int32_t rig_error_reason(const rig_t *rig); /* drive's reason number */

/* The refused value, and the range of that row that is accepted with all other present values, in its unit.
 * false: the refusal has another cause than a range, or no value is accepted. */
bool rig_error_range(const rig_t *rig, double *value, double *min, double *max);

/* The tap: after a drive step, in every `every`-th period, `sink` receives the 32-bit slots of these rows. */
typedef void (*rig_sink_t)(void *context, uint32_t period, const uint32_t *slots, uint32_t count);
#define RIG_TAP_MAX 160u
bool rig_tap(rig_t *rig, const uint32_t *ids, uint32_t count, uint32_t every, rig_sink_t sink, void *context);

/* The drive's capture buffer (contract/capture.h): the slots of some rows after the steps of the last
 * periods. Unless it is armed for another trigger, a fault stops it with the fault's period as the newest
 * one. It begins again when the fault is reset. rig_history_held: true if the latched fault has stopped it.
 * rig_history_columns, rig_history_rows: number and ids of the rows. rig_history: the slots of the period
 * that is `ago` periods older than the newest one; `ago` is below rig_history_count. *period is the number of
 * that period in the signal `period`. */
bool rig_history_held(const rig_t *rig);
uint32_t rig_history_count(const rig_t *rig);
uint32_t rig_history_columns(const rig_t *rig);
const uint32_t *rig_history_rows(const rig_t *rig);
const uint32_t *rig_history(const rig_t *rig, uint32_t ago, uint32_t *period);

/* The record for a replay, which the drive keeps instead if its parameter fault_record is replay
 * (firmware/app/recording.h): as slots, the same as over the serial line.
 * rig_record_count: how many; 0: none is held. rig_record: that many, which the caller provides.
 * rig_record_head: what the first RIG_RECORD_HEAD of them contain. */
#define RIG_RECORD_HEAD 20u
typedef struct {
    uint32_t format;
    uint32_t slots;        /* [-] of all */
    uint32_t version;      /* of the firmware: major << 16 | minor << 8 | patch */
    uint32_t layout;       /* hash of the layout of its structs */
    uint32_t rows;         /* [periods] recorded */
    uint32_t newest;       /* [periods] the last of them, by the drive's count */
    uint32_t at;           /* [periods] of the trigger */
    int32_t reason;        /* [-] of the fault; 0: another trigger */
    uint32_t fault_period; /* [periods] */
    uint32_t carrier_ns;   /* [ns] period of the carrier */
    char board[25];
} rig_record_t;
uint32_t rig_record_count(rig_t *rig);
void rig_record(rig_t *rig, uint32_t *slots, uint32_t count);
void rig_record_head(const uint32_t *slots, rig_record_t *record);

/* The parameter with which a replay of these slots begins. false: no parameter, the secret line_key, or a
 * record with which no replay of this program can begin. */
bool rig_record_value(const uint32_t *slots, uint32_t count, const table_row_t *row, double *value);

/* Runs the drive's two tasks on the samples of such a record, from the older of its snapshots on. The slots
 * must stay. rig_replay_begin: false: the record is of another firmware or board, or damaged (see rig_error).
 * rig_replay_step: one period in the place of rig_step; false: there are no more samples. The tap, the tables
 * and the stop hook act as in a run; truth and plant have no meaning. */
bool rig_replay_begin(rig_t *rig, const uint32_t *slots, uint32_t count);
bool rig_replay_step(rig_t *rig);

typedef struct {
    uint32_t begin;        /* [periods] of the snapshot, by the drive's count */
    uint32_t periods;      /* [periods] run */
    uint32_t windows;      /* [windows] run: calls of the medium task */
    uint32_t tunings;      /* [-] new tunings during this time */
    uint32_t requests;     /* [-] requests changed during this time */
    bool differs;          /* duties or gates were not those of the record */
    uint32_t wrong;        /* [periods] the first of them */
    int32_t reason;        /* [-] of the drive's last fault; 0: none */
    uint32_t fault_period; /* [periods] */
} rig_replayed_t;
rig_replayed_t rig_replayed(const rig_t *rig);

/* Connects the drive's serial line directly, without the chip's transmitter and receiver: octets need no time
 * on the line. Both functions return at once with the number of octets that they read or wrote; they are
 * called within rig_step. NULL: the chip's own line. The octets of this connection are not part of the rig's
 * state. */
typedef struct {
    uint32_t (*read)(void *context, uint8_t *octets, uint32_t room);
    uint32_t (*write)(void *context, const uint8_t *octets, uint32_t count);
    void *context;
} rig_line_t;
void rig_line(rig_t *rig, const rig_line_t *line);

/* Events between the samples, in order of time; tick [1/150 MHz] from the beginning of period 0. When
 * watching begins, the present levels of gates and trip are reported first. */
typedef enum {
    RIG_EDGE_GATES, /* value: six switch commands, bit 2n upper, 2n + 1 lower of leg n; switched fidelity only
                     */
    RIG_EDGE_ADC_START, /* a conversion sequence begins */
    RIG_EDGE_ISR_ENTER, /* an interrupt function is called; value: number of its PIE vector */
    RIG_EDGE_ISR_EXIT,  /* it has returned; value the same */
    RIG_EDGE_TRIP       /* value: bit n = leg n is held off by its trip zone */
} rig_edge_t;
typedef void (*rig_edge_sink_t)(void *context, uint64_t tick, uint32_t what, uint32_t value);
void rig_watch_edges(rig_t *rig, rig_edge_sink_t sink, void *context); /* sink = NULL: end of watching */

/* The serial line of the chip in simulated time. rig_serial_put sends octets to the drive, up to the free
 * room on the line (128). rig_serial_get reads those that the drive has sent, at most `room`. Both return the
 * number of octets. The far end runs at BOARD_SERIAL_BAUD, or at the rate [bit/s] of rig_serial_baud(); 0:
 * always at the rate of the chip. */
void rig_serial_baud(rig_t *rig, uint32_t baud);
uint32_t rig_serial_put(rig_t *rig, const uint8_t *octets, uint32_t count);
uint32_t rig_serial_get(rig_t *rig, uint8_t *octets, uint32_t room);

/* Switches the supply of the control board off and on: the drive starts again with the content of its flash.
 * The rotor coasts for about 10 ms. Plant parameters, rows of the rig, time and period count continue. If the
 * drive requests a restart of the chip (hal_restart), this occurs before the next step. */
void rig_power_cycle(rig_t *rig);

/* The flash pages in which the drive stores data, as octets of a file: two pages, words with the lower octet
 * first. rig_flash_load acts like a programmer; the drive uses the new content at the latest after
 * rig_power_cycle. false: wrong size, or a page has data in words that the simulation does not store (see
 * rig_error). */
#define RIG_FLASH_SIZE 131072u
void rig_flash_save(const rig_t *rig, uint8_t *octets);
bool rig_flash_load(rig_t *rig, const uint8_t *octets, size_t size);

/* Stop condition of rig_run for the value of a row, judged after each period. */
typedef enum { RIG_NEVER, RIG_EQUAL, RIG_NOT_EQUAL, RIG_ABOVE, RIG_BELOW } rig_compare_t;
bool rig_stop_when(rig_t *rig, uint32_t id, rig_compare_t compare, double value);

/* Makes the rig call rig_stop_at before this period. rig_stop_at is an empty function for a breakpoint. */
void rig_stop_before(rig_t *rig, uint32_t period);
void rig_stop_at(rig_t *rig, uint32_t period);

/* Saves and loads the whole state as bytes. After a load the rig continues exactly from the saved state, in
 * any rig of the same program. */
size_t rig_state_size(void);
void rig_save(const rig_t *rig, void *state);
bool rig_load(rig_t *rig, const void *state, size_t size);
uint64_t rig_hash(const rig_t *rig); /* of the state: equal states, equal hashes, in every build */

#endif
