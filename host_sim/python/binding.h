/* Interface of the Python package: plain functions and flat structs, which a foreign-function interface can
 * describe. The shared library exports only these symbols.
 *
 * lagless/_library.py describes the same structs; it compares binding_layout() to detect a library of another
 * version. All values are in the SI unit of their row. A `why` is one line, cut at WHY_SIZE. Only one thread
 * at a time may use an object; different objects are independent.
 *
 * Does not handle: files of recordings (host_sim/lab/recorder.h), printing. */
#ifndef HOST_SIM_PYTHON_BINDING_H
#define HOST_SIM_PYTHON_BINDING_H

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/lab/boards.h"
#include "host_sim/lab/commission.h"
#include "host_sim/lab/runner.h"
#include "host_sim/lab/scenario.h"
#include "host_sim/plant/plant.h"
#include "host_sim/rig/rig.h"

#define BINDING __attribute__((visibility("default")))

#define WHY_SIZE 1200u

/* ---- tables ---- */

typedef struct {
    uint32_t id;
    uint32_t kind;   /* slot_kind_t */
    uint32_t access; /* table_access_t */
    const char *table, *name;
    const char *key; /* unique: "i_q", or "plant.inertia" where two tables have the name */
    const char *unit, *text, *choices;
    double initial, min, max; /* [unit]; 0 for a row that cannot be set */
} binding_row_t;

/* One number from the sizes of the structs below and the hash of the tables, for comparison. */
BINDING uint32_t binding_layout(void);
BINDING double binding_period(void);       /* [s] */
BINDING const char *binding_version(void); /* of the project in CMakeLists.txt */

/* binding_board: the board of this library. binding_boards: the n-th of all boards; NULL: n is too large.
 * binding_no_board: message if no board has this name, else "". */
BINDING const char *binding_board(void);
BINDING const board_facts_t *binding_boards(uint32_t n);
BINDING void binding_no_board(const char *name, char why[WHY_SIZE]);

/* The n-th row of all tables; false: n is too large. */
BINDING bool binding_row(uint32_t n, binding_row_t *row);

/* Converts a text with a unit to a number [unit of the row]. */
BINDING bool binding_value(uint32_t id, const char *text, double *value, char why[WHY_SIZE]);

/* Name, text and remedy of a reason; false: no such number. */
BINDING bool binding_reason(int32_t number, const char **name, const char **text, const char **remedy);

/* Beginning of each of these periods [s], as in recordings. */
BINDING void binding_seconds(const uint32_t *periods, double *seconds, uint64_t count);

/* ---- samples ---- */

/* Buffer for the samples of a tap: `slots` [room x columns], one sample after the other. Samples that do not
 * fit are only counted. */
typedef struct {
    uint32_t *slots;
    uint32_t *periods; /* [room] */
    uint64_t room, used;
} binding_samples_t;

/* ---- the rig ---- */

BINDING rig_t *binding_rig_create(uint64_t seed);
BINDING void binding_rig_free(rig_t *rig);
BINDING uint32_t binding_rig_run(rig_t *rig, uint32_t periods);
BINDING uint32_t binding_rig_period(const rig_t *rig);
BINDING bool binding_rig_get(rig_t *rig, uint32_t id, double *value);
BINDING bool binding_rig_set(rig_t *rig, uint32_t id, double value);
BINDING bool binding_rig_apply(rig_t *rig);
BINDING void binding_rig_set_motion(rig_t *rig, double theta_m, double omega_m);
BINDING void binding_rig_power_cycle(rig_t *rig);
BINDING bool binding_rig_stop_when(rig_t *rig, uint32_t id, uint32_t compare, double value);
BINDING bool binding_rig_tap(rig_t *rig, const uint32_t *ids, uint32_t count, uint32_t every,
                             binding_samples_t *samples);
BINDING const char *binding_rig_error(const rig_t *rig);
BINDING uint64_t binding_rig_state_size(void);
BINDING void binding_rig_save(const rig_t *rig, void *state);
BINDING bool binding_rig_load(rig_t *rig, const void *state, uint64_t size);
BINDING uint64_t binding_rig_hash(const rig_t *rig);

/* ---- scenarios ---- */

/* Reads a scenario from `text`, or from the file `path` if text is NULL. After the last override call
 * binding_scenario_check, which judges everything that overrides can correct. Returns NULL for a wrong
 * scenario; `why` has the message and `error` the place in the file. */
BINDING scenario_t *binding_scenario_read(const char *path, const char *text, uint64_t octets,
                                          scenario_error_t *error, char why[WHY_SIZE]);
BINDING void binding_scenario_free(scenario_t *scenario);

/* "NAME=VALUE" (scenario_override). */
BINDING bool binding_scenario_override(scenario_t *scenario, const char *assignment, scenario_error_t *error,
                                       char why[WHY_SIZE]);

BINDING bool binding_scenario_check(scenario_t *scenario, scenario_error_t *error, char why[WHY_SIZE]);

typedef struct {
    const char *title, *source;
    const char *unsuited; /* scenario_t */
    uint64_t seed;
    uint32_t periods, every; /* [periods] */
    const uint32_t *record;  /* ids */
    uint32_t record_count, expect_count;
} binding_scenario_t;
BINDING void binding_scenario_about(const scenario_t *scenario, binding_scenario_t *about);

/* Value at t = 0 of a row that can be set. */
BINDING double binding_scenario_initial(const scenario_t *scenario, uint32_t id);

typedef struct {
    uint64_t seed;
    const uint32_t *record; /* ids */
    uint32_t record_count;  /* 0: no recording */
    uint32_t record_every;  /* [periods] */
    binding_samples_t *samples;
    int (*progress)(
        double fraction); /* called every RUNNER_PROGRESS_PERIODS, may be NULL; result not 0: stop */
} binding_ask_t;

typedef struct binding_run binding_run_t;

/* NULL: refused, see `why` and `error`. The scenario must exist as long as the run. */
BINDING binding_run_t *binding_run(scenario_t *scenario, const binding_ask_t *ask, scenario_error_t *error,
                                   char why[WHY_SIZE]);
BINDING void binding_run_free(binding_run_t *run);

/* Result of a run. */
typedef struct {
    uint64_t seed, hash;
    double seconds;  /* [s] real time of the run */
    uint32_t end;    /* runner_end_t */
    uint32_t failed; /* [-] expectations that are not met, and one more for an unexpected end */
    uint32_t periods, fault_period;
    int32_t state, fault_reason, refusal, not_on, manoeuvre;
} binding_outcome_t;
/* `unexpected`: text of an unexpected end, "" if there is none. */
BINDING void binding_outcome(const binding_run_t *run, binding_outcome_t *outcome, char unexpected[WHY_SIZE]);

typedef struct {
    const char *name, *statistic;
    double value, at_least, at_most, from, to; /* [unit of the row], [s] */
    uint32_t id, minus;                        /* rows; minus 0: none */
    uint32_t samples;
    uint32_t judgement; /* runner_judgement_t */
    uint32_t measure;   /* 1: of [[measure]] */
} binding_verdict_t;
BINDING void binding_verdict(const binding_run_t *run, uint32_t n, binding_verdict_t *verdict,
                             char text[WHY_SIZE]);

/* The drive's history of the run's last fault (runner_history_t); false: there was none. */
typedef struct {
    const uint32_t *rows, *slots; /* ids [columns]; row after row [periods x columns], oldest first */
    uint32_t columns, periods;
    uint32_t first_period; /* [periods] of the first row, counted as in a recording */
    int32_t fault_reason;
} binding_history_t;
BINDING bool binding_history(const binding_run_t *run, binding_history_t *history);

/* ---- the plant alone ---- */

typedef struct binding_plant binding_plant_t;

typedef struct {
    plant_truth_t truth;
    double i_a, i_b, i_c; /* [A] measured by the sensors, with noise and errors */
    double u_dc;          /* [V] measured by the sensor */
    int64_t encoder;      /* [counts] */
    double seconds;       /* [s] since creation */
} binding_plant_now_t;

/* NULL: there is no memory. `ticks`: length of a carrier period; `dead`: length of the dead band [1/150 MHz].
 */
BINDING binding_plant_t *binding_plant_create(uint64_t seed, uint32_t ticks, uint32_t dead, bool averaged);
BINDING void binding_plant_free(binding_plant_t *plant);
/* Sets rows of the table `plant`, as a set. false: refused. */
BINDING bool binding_plant_set(binding_plant_t *plant, const uint32_t *ids, const double *values,
                               uint32_t count, char why[WHY_SIZE]);
BINDING bool binding_plant_get(const binding_plant_t *plant, uint32_t id, double *value);
BINDING void binding_plant_set_motion(binding_plant_t *plant, double theta_m, double omega_m);

/* One carrier period with these duties, each limited to 0..1; NULL: all gates off. The period begins and ends
 * in the middle of the lower zero vector, at which binding_plant_now reads the values. */
BINDING void binding_plant_step(binding_plant_t *plant, const double duties[3]);
BINDING void binding_plant_now(binding_plant_t *plant, binding_plant_now_t *now);

/* ---- commissioning ---- */

typedef struct {
    uint64_t seed;
    commission_plate_t plate; /* a value of 0: that of the scenario's parameters */
    uint32_t skip;            /* bits of commission_do_t: steps that are not requested */
    uint32_t chosen;          /* 1: the steps are named one by one */
    /* Called before each try of a step (done 0), after it (1), and every 2.5 ms during it (2). Result 0:
     * stop. */
    uint32_t (*progress)(uint32_t step, uint32_t done);
    double link;      /* of the DC link by a meter [V]; 0: not known */
    double direction; /* answer of the user, 1 or -1; 0: none */
    double turns;     /* the same, of the shaft; 0: none */
} binding_commission_t;

/* Name and text of the n-th step of commissioning; NULL: n is too large. */
BINDING const char *binding_commission_step(uint32_t n, const char **text);

/* The answer to a question ("direction", "turn") that a text means; 0: it is not an accepted answer.
 * *accepted: the accepted texts; NULL: there is no such question. */
BINDING double binding_commission_answer(const char *question, const char *answer, const char **accepted);

/* Runs the steps on the scenario's motor. At the end `how` has the plate. false: see `why`. */
BINDING bool binding_commission(const scenario_t *scenario, binding_commission_t *how,
                                commission_result_t *result, char why[WHY_SIZE]);

/* ---- campaigns ---- */

typedef struct {
    uint64_t seed;
    double seconds; /* [s] of each run */
    uint32_t runs, shard, shards, threads;
    /* Receives each finished run: its line, and the scenario of a violation, else NULL. Result not 0: stop.
     * Called from any thread, by one at a time. */
    int (*keep)(uint32_t run, const char *line, const char *scenario);
} binding_campaign_t;

/* Writes the first line of its results into `line`. false: a value is out of range; `line` has the message.
 */
BINDING bool binding_campaign_head(const binding_campaign_t *campaign, char line[WHY_SIZE]);
BINDING bool binding_campaign(const binding_campaign_t *campaign, char why[WHY_SIZE]);

/* The summary of result lines, of which the first is the head. Free it with binding_free. NULL: see `why`. */
BINDING char *binding_campaign_summary(const char *lines, bool json, char why[WHY_SIZE]);
BINDING void binding_free(void *memory);

#endif
