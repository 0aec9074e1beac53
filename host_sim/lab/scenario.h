/* clang-format off */
/* A run described in a TOML file: commands over time, and limits that the run must meet.
 *
 *   schema = 1
 *   title = "Load step at 500 r/min"       # one line, required
 *   text = "..."                           # optional
 *   board = "mosfet_48v_60a"               # optional: one of `lagless boards`, on which the scenario runs
 *   [run]
 *   duration = "2 s"                       # required, one period to 1 h
 *   seed = 1                               # of all noise
 *   record = ["i_q", "plant.inertia"]      # rows of any table
 *   every = 1                              # number of periods between samples of the recording
 *   [start]                                # the rotor's true mechanical motion at t = 0, both 0 if not given;
 *   speed = "500 r/min"                    # on a locked shaft only the angle
 *   angle = "30 deg"
 *   [motor]                                # fills params and plant from a data sheet (host_sim/lab/motor.h):
 *   name = "teknic-m2310p-ln-04k"          # one of `lagless motors` (motor = "NAME" for short), or
 *   file = "my_motor.toml"                 # a file beside this one; keys given here have priority over both
 *   [params] [requests] [plant] [rig]      # rows of these tables, set before t = 0; priority over [motor]
 *   [[at]]                                 # any number of events
 *   time = "0.5 s"
 *   ramp = "0.2 s"                         # optional: float rows change linearly from their present value
 *   plant.load_torque = "5 N m"            # any rows of params, requests, plant, rig
 *   [[profile]]                            # any number of profiles of one row each
 *   row = "plant.load_torque"              # of params, requests, plant, rig
 *   shape = "linear"                       # optional: straight from point to point, or "steps"
 *   points = [["0 s", "1 N m"], ["2 s", "5 N m"]]   # times do not decrease; the same time twice is a step
 *   [[expect]]                             # any number of verdicts
 *   signal = "true_omega_m"                # a row of any table
 *   minus = "omega_m_ref"                  # optional: the difference of the two is judged
 *   statistic = "mean"                     # mean, min, max, peak (largest magnitude), sd, rms or last
 *   from = "1 s"                           # the samples of periods with from <= t_k < to; default the whole run
 *   to = "2 s"
 *   at_least = "-1 r/min"                  # one of them or both
 *   at_most = "1 r/min"
 *   needs_drive = "no"                     # optional: may be met although the drive never came on
 *   name = "speed holds"                   # optional
 *   [[measure]]                            # any number of them: the same without limits; the number is printed
 *   signal = "true_i_a"                    # keys of [[expect]] but at_least, at_most, needs_drive
 *   statistic = "rms"
 *
 * Time is simulated time since power-on; period k begins at k x RIG_PERIOD_SECONDS, and times are rounded to the
 * nearest period. An event acts before the first period at or after its time; events of one time act in the order of
 * the file. The parameters of one event are staged and applied as one set. A ramp ends exactly at its
 * value after `ramp`; a later event on the same row ends it; rows that are not float change at once. A row
 * that acts once and reads 0 again (estimate_jump) has no ramp.
 *
 * A profile is a series of events: one at each point, with a ramp to the next one if it is linear. Before its
 * first point the row is unchanged, after the last one it keeps its value.
 *
 * Numbers are in the SI unit of their row; text has a unit that must fit it (host_sim/lab/units.h); rows with
 * choices take the choice's name; bool is wrong everywhere. A row name that two tables have is written
 * table.row.
 *
 * If `enable` commands the drive on, an expectation of a float row fails unless the drive was on for at least one
 * period; otherwise it could be met because nothing happened. Whole numbers and choices show the state of the drive,
 * and have no such condition.
 *
 * A run that ends with a latched fault or a permanent refusal fails unless an expectation names it; runner.h has the
 * rule.
 *
 * scenario_read judges everything that can be judged without running: names, types, units, ranges, the rules
 * between rows (on a rig that does not run, event by event; a ramp at its ends and at one point between),
 * times, windows. Not judged: what depends on the drive's state, such as a parameter that changes only while
 * the bridge is off; the runner reports that. */
/* clang-format on */
#ifndef HOST_SIM_LAB_SCENARIO_H
#define HOST_SIM_LAB_SCENARIO_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "contract/table.h"
#include "host_sim/lab/times.h"
#include "host_sim/rig/rig.h"

#define SCENARIO_SECONDS_MIN times_seconds(1u, RIG_PERIOD_TICKS) /* [s] a period, as it is printed */
#define SCENARIO_SECONDS_MAX 3600.0                              /* [s] */
#define SCENARIO_EVERY_MAX   100000                              /* [periods] */
#define SCENARIO_TITLE_MAX   200u                                /* [octets] */
#define SCENARIO_SPEED_MAX   1e4                                 /* [rad/s] of the start, mechanical */
#define SCENARIO_ANGLE_MAX   1e3                                 /* [rad] of the start, mechanical */

typedef struct {
    uint32_t line, column; /* [1..]; 0: the file as a whole, or not from a file */
} scenario_place_t;

typedef struct {
    char file[256];
    scenario_place_t place;
    char name[96];     /* the offending name */
    char message[640]; /* one line: what is wrong, what is accepted */
    char board[64];    /* set if only the board is wrong: the scenario is for this board; else "" */
} scenario_error_t;

typedef struct {
    const table_row_t *row;
    double value; /* [unit of the row] */
    scenario_place_t place;
} scenario_setting_t;

/* Rows that change at one time. */
typedef struct {
    double time;                  /* [s] as written */
    double ramp;                  /* [s] as written; 0: at once */
    uint32_t period;              /* [periods] before which it acts */
    uint32_t ramp_periods;        /* [periods] */
    scenario_setting_t *settings; /* in an order that the rig accepts; parameters follow each other */
    uint32_t count;               /* [-] */
    scenario_place_t time_place, ramp_place;
} scenario_event_t;

typedef enum {
    STATISTIC_MEAN,
    STATISTIC_MIN,
    STATISTIC_MAX,
    STATISTIC_PEAK, /* largest magnitude */
    STATISTIC_SD,   /* about the mean, divided by n */
    STATISTIC_RMS,
    STATISTIC_LAST,
    STATISTICS
} statistic_t;
#define STATISTIC_NAMES "mean|min|max|peak|sd|rms|last"

typedef struct {
    const char *name; /* "" if none was given */
    const table_row_t *row;
    const table_row_t *minus; /* NULL: none */
    statistic_t statistic;
    double from, to;        /* [s] as written */
    bool to_the_end;        /* `to` was not given */
    bool measure;           /* of [[measure]]: no limits, nothing can fail */
    bool needs_drive;       /* it fails if the drive was commanded on and never came on */
    bool needs_none;        /* the file has needs_drive = "no": a drive that is never on is expected */
    uint32_t begin, end;    /* [periods] begin <= k < end */
    double at_least;        /* [unit of the row]; -INFINITY: no limit */
    double at_most;         /* [unit of the row]; INFINITY: no limit */
    scenario_place_t place; /* of [[expect]] */
    scenario_place_t from_place, to_place;
} scenario_expect_t;

/* For reading only. */
typedef struct {
    const char *path;   /* of the file */
    const char *source; /* the whole file, 0 at its end */
    const char *title;
    const char *text;     /* "" if there is none */
    const char *unsuited; /* reason for which the motor does not suit the board, with suitable boards; "" if
                             it suits, or without [motor] */
    double duration;      /* [s] as written */
    uint32_t periods;     /* [periods] >= 1 */
    uint64_t seed;
    uint32_t every;               /* [periods] of the recording, >= 1 */
    uint32_t record[RIG_TAP_MAX]; /* ids */
    uint32_t record_count;
    bool has_start;             /* [start] is given */
    bool has_start_speed;       /* start.speed is given */
    double start_angle;         /* [rad] mechanical */
    double start_speed;         /* [rad/s] mechanical */
    scenario_event_t *events;   /* [0]: settings before t = 0; the others in the order of time */
    uint32_t event_count;       /* [-] >= 1 */
    scenario_expect_t *expects; /* [[expect]], then [[measure]], in the order of the file */
    uint32_t expect_count;
    scenario_place_t duration_place, start_place;
    struct scenario_memory *memory; /* of everything above */
} scenario_t;

/* Reads and judges a file. NULL: the file is wrong; `error` has the message. It takes about 0.2 ms. */
scenario_t *scenario_read(const char *path, scenario_error_t *error);

/* The same from memory; `path` is for messages. */
scenario_t *scenario_read_text(const char *path, const char *text, size_t octets, scenario_error_t *error);

/* The same, if scenario_override follows. It can replace the values before t = 0, those of [start], and those
 * of [run] except record. A wrong one of these values is stored as refused and is no error yet. The rules
 * between rows are not judged. The caller must call scenario_check, which reports the values that are still
 * wrong. */
scenario_t *scenario_read_to_mend(const char *path, scenario_error_t *error);
scenario_t *scenario_read_text_to_mend(const char *path, const char *text, size_t octets,
                                       scenario_error_t *error);

void scenario_free(scenario_t *scenario);

/* "NAME=VALUE", for the command line: a row of params, requests, plant or rig before t = 0, or run.duration,
 * run.seed, run.every, start.speed, start.angle. A row name that two of the tables have is given as
 * table.row. false: `error`; the scenario is as it was. Name, unit and range are judged at once, the rules
 * between rows by scenario_check: call it after the last override. */
bool scenario_override(scenario_t *scenario, const char *assignment, scenario_error_t *error);

/* Judges the rules between rows, as scenario_read does, and sorts the settings of each event into an order
 * that the rig accepts. */
bool scenario_check(scenario_t *scenario, scenario_error_t *error);

/* A row of any table by "row" or "table.row". NULL: there is none; `error` has a message with the nearest
 * name (place and file are empty). */
const table_row_t *scenario_row(const char *name, scenario_error_t *error);

/* "row", or "table.row" where two tables have the name. */
void scenario_row_name(const table_row_t *row, char *to, size_t size);

/* The name of a scenario or motor from its file: "teknic" for "folder/teknic.toml". */
void scenario_file_name(const char *path, char *to, size_t size);

/* Value at t = 0 [unit of the row] of a row of params, requests, plant or rig. */
double scenario_initial(const scenario_t *scenario, const table_row_t *row);

/* Sets the rows on a rig, in their order; parameters are applied as a set. false: see rig_error. */
bool scenario_set(rig_t *rig, const scenario_setting_t *settings, uint32_t count);

/* Fills `error` from a rig's refusal of one of these settings. */
void scenario_refused(const scenario_t *scenario, rig_t *rig, const scenario_setting_t *settings,
                      uint32_t count, scenario_error_t *error);

/* The table of the rig that contains the row; NULL: none. */
const table_t *scenario_table_of(const table_row_t *row);
bool scenario_is_param(const table_row_t *row);

const char *statistic_text(statistic_t statistic);

/* FILE:LINE:COL: name: message. Returns `to`. */
const char *scenario_error_text(const scenario_error_t *error, char *to, size_t size);

#endif
