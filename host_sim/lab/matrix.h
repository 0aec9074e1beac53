/* The fault matrix: every fault that rig and plant can inject, in every manoeuvre, with and without the
 * encoder, on two shafts; what the drive promises to do about it, and whether it does.
 *
 * A cell is one fault in one manoeuvre with one source of the angle on one shaft. Faults, manoeuvres and
 * promises are data (matrix_table.h). A cell begins with the rig as it stands in its manoeuvre: brought there
 * once, by the state of the drive and not by the clock, and saved; each fault starts from that state. From
 * the injection on every period is watched for as long as the fault's row says, and what was seen is held
 * against the promise:
 *
 *   reaction  what the drive did at last, see matrix_reaction_t
 *   reason    latched, told in the warnings, or why the bridge stays off
 *   time      from the injection until the drive showed that it knows: gates off (all legs held by the trip
 *             zone, to the tick), quick stop begun, a warning of these reasons, the rotor caught anew. Out of
 *             manoeuvre off from the moment on at which the bridge is asked to come on.
 *   current   the largest of the three true phase currents, at the samples
 *   rotor     where it is at the end, over the last 50 ms or electrical turn; and that nothing drove it away:
 * never faster than 1.2 times what it turned or was asked, and 100 r/min, the bare rotor 400
 *
 * A cell that keeps all of it is green, else red. A cell that cannot occur is neither, and says why. Red
 * cells that are known are listed beside the promises, each with its reason: another red one is a surprise,
 * and so is one of these that has become green.
 *
 * Shafts: h is the paper's rig (the defaults), l the bare motor. Inverter and sensors have the errors that
 * calibration leaves. Same seed: same bits, in any number of threads. */
#ifndef HOST_SIM_LAB_MATRIX_H
#define HOST_SIM_LAB_MATRIX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/lab/pool.h"
#include "host_sim/lab/scenario.h"

/* What the drive did at last: one bit of these as seen, a set of them as promised. */
#define MATRIX_RIDES     1u  /* on, without an effect */
#define MATRIX_WARNS     2u  /* on, with a warning */
#define MATRIX_CATCHES   4u  /* on; the rotor was lost and caught, or the start was repeated */
#define MATRIX_REFUSES   8u  /* the bridge never came on, no fault is latched */
#define MATRIX_STOPS     16u /* braked by the drive's own quick stop, then the fault was latched */
#define MATRIX_OPENS     32u /* the bridge opened, the fault is latched */
#define MATRIX_REACTIONS 6u

/* The rotor at the end of the run, as bits. */
#define MATRIX_FOLLOWS 1u /* gates on, within 5 % or 10 r/min of the reference in force */
#define MATRIX_STRAYS  2u /* gates on, and it does not */
#define MATRIX_COASTS  4u /* gates off, turning */
#define MATRIX_STANDS  8u /* gates off, slower than 2 rad/s */
#define MATRIX_ROTORS  4u

/* Where a cell is: source of the angle and shaft. */
#define MATRIX_ENCODER_H    1u
#define MATRIX_ENCODER_L    2u
#define MATRIX_SENSORLESS_H 4u
#define MATRIX_SENSORLESS_L 8u
#define MATRIX_PLACES       4u

/* By what a cell is red. */
#define MATRIX_BY_REACTION 1u
#define MATRIX_BY_REASON   2u
#define MATRIX_BY_TIME     4u
#define MATRIX_BY_CURRENT  8u
#define MATRIX_BY_ROTOR    16u /* it is not where it should be, or was driven away */
#define MATRIX_BY_PROFILE  32u /* the manoeuvre was never come to: nothing could be injected */
#define MATRIX_KINDS       6u

/* Within which time: max(20 ms, a third of the turn of the currents), a second at most; see matrix_noticed().
 */
#define MATRIX_NOTICED (-1.0)
/* The same from half a turn on (a second at most, too): so long it may take until the fault shows at all. */
#define MATRIX_NOTICED_LATER (-2.0)

/* A row of the faults. */
typedef struct {
    const char *name;
    const char *text;
    bool from_start; /* wrong from the beginning, before the bridge comes on: wiring and wrong data */
    double watch;    /* [s] from the injection to the end */
    double lasts;    /* [s] then all of it is taken back; 0: for good */
    struct {
        const char *row; /* of plant, rig, params; NULL: no more */
        double factor;   /* [-] its value times this ... */
        double shift;    /* ... plus this [unit of the row] */
    } changes[3];
} matrix_fault_t;

/* A row of the manoeuvres. */
typedef struct {
    const char *name;
    const char *text;
    const char *missing; /* why there is none with the encoder; NULL: there is */
    bool enabled;        /* false: the bridge is asked to come on only after the injection */
    double turning;      /* [r/min] the rotor when the bridge comes on */
    double reference;    /* [r/min] */
    double load;         /* [N m] passive, put on gently while it runs */
    double settle;       /* [s] of running, load included; 0: not waited for */
    double then;         /* [r/min] the next reference; NAN: none */
    const char *until;   /* the row to wait for; NULL: none */
    const char *choice;  /* until it is this; NULL: */
    double below;        /* ... until it is below this [unit of the row] */
    double delay;        /* [s] more, then the fault comes */
} matrix_manoeuvre_t;

/* A row of the promises. The last one that speaks of a cell counts. */
typedef struct {
    uint32_t fault;      /* [-] index of the faults */
    uint32_t manoeuvres; /* [-] bits of theirs */
    uint32_t places;     /* [-] MATRIX_ENCODER_H ... */
    uint32_t reactions;  /* [-] MATRIX_RIDES ...; 0: the cell cannot occur */
    const char *reasons; /* names, blanks between; "": none */
    double within;       /* [s] or MATRIX_NOTICED; NAN: no time is promised */
    double current;      /* [A] */
    uint32_t rotor;      /* [-] MATRIX_FOLLOWS ... */
    const char *because; /* why it is like this, where it is not plain; "" */
} matrix_promise_t;

/* A cell whose promise stands and is not kept yet. */
typedef struct {
    const char *cell;    /* its whole name; NULL: no more */
    const char *because; /* what is seen instead, and why */
} matrix_not_yet_t;

extern const matrix_fault_t matrix_faults[];
extern const size_t matrix_fault_count;
extern const matrix_manoeuvre_t matrix_manoeuvres[];
extern const size_t matrix_manoeuvre_count;
extern const matrix_promise_t matrix_promises[];
extern const size_t matrix_promise_count;
extern const matrix_not_yet_t matrix_not_yet[];

/* What was seen. */
typedef struct {
    uint32_t reaction; /* [-] MATRIX_RIDES ... */
    int32_t reason;    /* [-] reason_t: latched, or of the refusal; 0: none */
    uint64_t warnings; /* [-] bits of the fault table that warned at any time */
    double noticed;    /* [s] until the reaction began; NAN: none */
    double gates_off;  /* [s] until the gates were off; NAN: they were on to the end */
    double current;    /* [A] largest true phase current */
    uint32_t rotor;    /* [-] MATRIX_FOLLOWS ... */
    double speed;      /* [rad/s] at the end, mechanical, mean */
    double reference;  /* [rad/s] in force at the end */
    double fastest;    /* [rad/s] largest magnitude of the true speed */
    double started;    /* [rad/s] true speed at the injection */
    double turning;    /* [rad/s] mean electrical speed until it was noticed: of the rotor, or of a forced
                          frame if that has turned by more */
} matrix_seen_t;

/* A scenario in the place of a manoeuvre. */
typedef struct {
    scenario_t *scenario;
    double at; /* [s] of its course: then the fault comes */
} matrix_user_t;

typedef struct {
    const matrix_user_t *user;       /* NULL: the manoeuvre itself; else what stands in its place */
    uint32_t fault;                  /* [-] index */
    uint32_t manoeuvre;              /* [-] index */
    uint32_t place;                  /* [-] index, 0 .. MATRIX_PLACES - 1 */
    const matrix_promise_t *promise; /* never NULL */
    bool occurs;                     /* [-] false: `because` of the promise, or missing, says why not */
    double within;                   /* [s] the promised time of this very cell; NAN: none */
    matrix_seen_t seen;
    uint32_t red;        /* [-] MATRIX_BY_...; 0: green */
    const char *not_yet; /* why it is known to be red; NULL: it shall be green */
} matrix_cell_t;

/* Which cells: those of one fault, of a name, or a share of all. All zero: every cell. */
typedef struct {
    const char *only; /* fault; NULL: all */
    const char *cell; /* "fault/manoeuvre/source/shaft" or its beginning; NULL: all */
    double share;     /* [-] of the cells that occur, drawn one by one; 0: all */
    uint64_t seed;    /* of the drawing */
} matrix_choice_t;

/* "encoder" or "sensorless", "h" or "l". */
const char *matrix_source_name(uint32_t place);
const char *matrix_shaft_name(uint32_t place);

/* "open_phase_a/run_fast/sensorless/h". Returns `to`. */
#define MATRIX_NAME_SIZE 96u
const char *matrix_cell_name(char to[MATRIX_NAME_SIZE], const matrix_cell_t *cell);

/* Of one bit: "rides", ...; "follows", ...; "reaction", .... */
const char *matrix_reaction_name(uint32_t reaction);
const char *matrix_rotor_name(uint32_t rotor);
const char *matrix_kind_name(uint32_t kind);

/* Names of a set, "stops or opens"; "" for none. Returns `to`. */
const char *matrix_set_text(char to[MATRIX_NAME_SIZE], uint32_t set, const char *(*name)(uint32_t));

/* Why the cell cannot occur. */
const char *matrix_never(const matrix_cell_t *cell);

/* The cells of a scenario: each fault that can come under way, `only` one if that is not NULL. Source and
 * speed of its drive at that time say which promise is held against it: that of run_fast, or below 300 r/min
 * run_slow, on shaft h, with as much more current as its overcurrent_trip is more than that of the paper's
 * rig. The faults are as large for its motor as those of the table for the paper's (matrix_scaled). Faults
 * that are wrong from the beginning are none: they belong into the file. A fault is watched for as long as
 * its row says, while the scenario's course goes on. Returns how many. `cells` as below. false in *good: the
 * drive is not at work at that time, `error` says so. */
size_t matrix_around(const matrix_user_t *user, const char *only, matrix_cell_t *cells, bool *good,
                     scenario_error_t *error);

/* The run of a board that is not the paper's rig: the library's motor with the largest current of those for
 * which this board is proposed, at 0.3 of its top speed with 0.6 of its rated torque. *at [s]: the faults
 * come. NULL: `error`. */
scenario_t *matrix_of_board(double *at, scenario_error_t *error);

/* What an absolute value of a fault's row is on this rig, which stands in a scenario: of brakes, currents,
 * voltages, temperatures as large for its motor, link and limits as the table's value is for the paper's. */
double matrix_scaled(rig_t *rig, const char *row, double value);

/* The value of a row on the paper's rig, whatever board this program simulates. */
double matrix_standard(const char *row);

/* How many cells there are at most. */
size_t matrix_size(void);

/* The chosen cells, in the order of faults, manoeuvres, places; returns how many. `cells` has room for
 * matrix_size(). Cells that cannot occur are among them unless a share is drawn. */
size_t matrix_lay_out(const matrix_choice_t *choice, matrix_cell_t *cells);

/* [s] in which a fault must be noticed at this electrical speed [rad/s]: 20 ms or a third of a turn,
 * whichever is longer, after the share of a turn in which it does not show; a second at most: a rotor that
 * stands has no turn. */
double matrix_noticed(double omega_e, double hidden);

/* [A] that the cell's promise allows. */
double matrix_current(const matrix_cell_t *cell);

/* Holds what was seen against the promise: the cell's `within` and `red`. */
void matrix_judge(matrix_cell_t *cell);

/* Is a cell that was run red though it shall be green, or green though it is listed as not yet kept? */
bool matrix_surprises(const matrix_cell_t *cell);

/* Is this reason among the names of a promise? */
bool matrix_accepts(const char *accepted, int32_t reason);

/* Runs and judges the cells in so many threads. progress (may be NULL) after each piece, of so many pieces.
 * false: `why` says what the rig refused. */
bool matrix_run(matrix_cell_t *cells, size_t count, unsigned threads,
                void (*progress)(void *context, double fraction), void *context, char why[POOL_WHY]);

#endif
