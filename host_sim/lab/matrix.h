/* The fault matrix: every fault that rig and plant can inject, in every manoeuvre, with and without the
 * encoder, on two shafts. It compares the reaction of the drive with the promised reaction.
 *
 * A cell is one fault in one manoeuvre with one source of the angle on one shaft. Faults, manoeuvres and
 * promises are data (matrix_table.h). The rig is brought into each manoeuvre once and its state is saved. The
 * state of the drive, not a fixed time, decides when the manoeuvre is reached. Each fault starts from the
 * saved state. From the injection on every period is observed for the time in the fault's row. The
 * observation is compared with the promise:
 *
 *     reaction  the last reaction of the drive, MATRIX_RIDES and the following
 *     reason    the latched reason, a warning, or the reason of the refusal
 *     time      from the injection to the first reaction: gates off (all legs held by the trip zone, exact to
 *               the tick), begin of the quick stop, a warning of these reasons, or the rotor caught again. In
 *               the manoeuvre "off" the time begins when the bridge is commanded on.
 *     current   the largest true phase current at the samples
 *     rotor     its state at the end, over the last 50 ms or electrical turn; its speed never exceeds 1.2
 *               times the initial or requested speed plus 100 r/min (bare rotor: 400 r/min)
 *
 * A cell that keeps the whole promise is green, otherwise red. A cell that cannot occur is neither, and
 * contains the reason. Known failures are listed next to the promises, each with its reason. Another red
 * cell
 * is unexpected, and so is a listed cell that is green.
 *
 * Shafts: h is the paper's rig (the defaults), l the bare motor. Inverter and sensors have the errors that
 * remain after calibration. The same seed gives the same bits with any number of threads. */
#ifndef HOST_SIM_LAB_MATRIX_H
#define HOST_SIM_LAB_MATRIX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/lab/pool.h"
#include "host_sim/lab/scenario.h"

/* The last reaction of the drive. An observation is one of these bits, a promise is a set of them. */
#define MATRIX_RIDES 1u /* the drive continues, without an effect */
#define MATRIX_WARNS 2u /* the drive continues, with a warning */
#define MATRIX_CATCHES                                                                                       \
    4u                      /* the drive continues; the rotor was lost and caught, or the start was repeated \
                             */
#define MATRIX_REFUSES   8u /* the bridge never came on, no fault is latched */
#define MATRIX_STOPS     16u /* the drive braked with a quick stop, then the fault was latched */
#define MATRIX_OPENS     32u /* the bridge opened, the fault is latched */
#define MATRIX_REACTIONS 6u

/* The rotor at the end of the run, as bits. */
#define MATRIX_FOLLOWS 1u /* gates on, speed within 5 % or 10 r/min of the reference in use */
#define MATRIX_STRAYS  2u /* gates on, speed outside these limits */
#define MATRIX_COASTS  4u /* gates off, turning */
#define MATRIX_STANDS  8u /* gates off, slower than 2 rad/s */
#define MATRIX_ROTORS  4u

/* Place of a cell: source of the angle and shaft. */
#define MATRIX_ENCODER_H    1u
#define MATRIX_ENCODER_L    2u
#define MATRIX_SENSORLESS_H 4u
#define MATRIX_SENSORLESS_L 8u
#define MATRIX_PLACES       4u

/* Causes for which a cell is red. */
#define MATRIX_BY_REACTION 1u
#define MATRIX_BY_REASON   2u
#define MATRIX_BY_TIME     4u
#define MATRIX_BY_CURRENT  8u
#define MATRIX_BY_ROTOR    16u /* its state at the end is wrong, or its speed was too high */
#define MATRIX_BY_PROFILE  32u /* the drive did not reach the manoeuvre, so that nothing was injected */
#define MATRIX_KINDS       6u

/* Promised time max(20 ms, a third of the turn of the currents), at most 1 s; see matrix_noticed(). */
#define MATRIX_NOTICED (-1.0)
/* The same plus half a turn, at most 1 s: the fault may have no effect during half a turn. */
#define MATRIX_NOTICED_LATER (-2.0)

#define MATRIX_CHANGES 4u /* largest number of rows that a fault changes */

/* A row of the faults. */
typedef struct {
    const char *name;
    const char *text;
    bool from_start; /* true: present from the beginning, before the bridge comes on (wiring, wrong data) */
    double watch;    /* [s] from the injection to the end */
    double lasts;    /* [s] after this time the changes end; 0: permanent */
    struct {
        const char *row; /* of plant, rig, params; NULL: end of the list */
        double factor;   /* [-] the value is multiplied by this factor, ... */
        double shift;    /* ... then this is added [unit of the row] */
    } changes[MATRIX_CHANGES];
} matrix_fault_t;

/* A row of the manoeuvres. */
typedef struct {
    const char *name;
    const char *text;
    const char *missing; /* why the manoeuvre does not exist with the encoder; NULL: it exists */
    bool enabled;        /* false: the bridge is commanded on only after the injection */
    double turning;      /* [r/min] speed of the rotor when the bridge comes on */
    double reference;    /* [r/min] */
    double load;         /* [N m] passive load, increased slowly while the motor runs */
    double settle;       /* [s] time of running with the load before the injection; 0: none */
    double then;         /* [r/min] the next reference; NAN: none */
    const char *until;   /* row whose value is awaited; NULL: none */
    const char *choice;  /* awaited choice; NULL: see `below` */
    double below;        /* the value must be below this [unit of the row] */
    double delay;        /* [s] from the event that `until` awaits to the injection */
} matrix_manoeuvre_t;

/* A row of the promises. The last row that contains a cell is valid for it. */
typedef struct {
    uint32_t fault;      /* [-] index of the faults */
    uint32_t manoeuvres; /* [-] bits of the manoeuvres */
    uint32_t places;     /* [-] MATRIX_ENCODER_H ... */
    uint32_t reactions;  /* [-] MATRIX_RIDES ...; 0: the cell cannot occur */
    const char *reasons; /* names separated by blanks; "": none */
    double within;       /* [s] or MATRIX_NOTICED; NAN: no time is promised */
    double current;      /* [A] */
    uint32_t rotor;      /* [-] MATRIX_FOLLOWS ... */
    const char *because; /* reason of the promise, if it is not obvious; "": none */
} matrix_promise_t;

/* A cell whose promise is not kept yet. */
typedef struct {
    const char *cell;    /* its whole name; NULL: end of the list */
    const char *because; /* the observed reaction, and its cause */
} matrix_not_yet_t;

extern const matrix_fault_t matrix_faults[];
extern const size_t matrix_fault_count;
extern const matrix_manoeuvre_t matrix_manoeuvres[];
extern const size_t matrix_manoeuvre_count;
extern const matrix_promise_t matrix_promises[];
extern const size_t matrix_promise_count;
extern const matrix_not_yet_t matrix_not_yet[];

/* The observation of a cell. */
typedef struct {
    uint32_t reaction; /* [-] MATRIX_RIDES ... */
    int32_t reason;    /* [-] reason_t: latched, or of the refusal; 0: none */
    uint64_t warnings; /* [-] bits of the fault table that warned at any time */
    double noticed;    /* [s] until the reaction began; NAN: none */
    double gates_off;  /* [s] until the gates were off; NAN: they were on until the end */
    double current;    /* [A] largest true phase current */
    uint32_t rotor;    /* [-] MATRIX_FOLLOWS ... */
    double speed;      /* [rad/s] at the end, mechanical, mean */
    double reference;  /* [rad/s] reference in use at the end */
    double fastest;    /* [rad/s] largest magnitude of the true speed */
    double started;    /* [rad/s] true speed at the injection */
    double turning; /* [rad/s] mean electrical speed until the reaction, of the rotor, or of the forced frame
                       if it has turned by more */
} matrix_seen_t;

/* A scenario that replaces a manoeuvre. */
typedef struct {
    scenario_t *scenario;
    double at; /* [s] time of the injection in the scenario */
} matrix_user_t;

typedef struct {
    const matrix_user_t *user;       /* scenario that replaces the manoeuvre; NULL: none */
    uint32_t fault;                  /* [-] index */
    uint32_t manoeuvre;              /* [-] index */
    uint32_t place;                  /* [-] index, 0 .. MATRIX_PLACES - 1 */
    const matrix_promise_t *promise; /* never NULL */
    bool occurs;   /* [-] false: it cannot occur; the reason is in the promise or in `missing` */
    double within; /* [s] the promised time of this cell; NAN: none */
    matrix_seen_t seen;
    uint32_t red;        /* [-] MATRIX_BY_...; 0: green */
    const char *not_yet; /* reason of a known failure; NULL: the cell must be green */
} matrix_cell_t;

/* Selection of cells: those of one fault, of a name, or a share of all. All zero: every cell. */
typedef struct {
    const char *only; /* fault; NULL: all */
    const char *cell; /* "fault/manoeuvre/source/shaft" or its beginning; NULL: all */
    double share;     /* [-] share of the cells that can occur, selected at random; 0: all */
    uint64_t seed;    /* of the random selection */
} matrix_choice_t;

/* "encoder" or "sensorless", "h" or "l". */
const char *matrix_source_name(uint32_t place);
const char *matrix_shaft_name(uint32_t place);

/* "open_phase_a/run_fast/sensorless/h". Returns `to`. */
#define MATRIX_NAME_SIZE 96u
extern const char *const matrix_scenario; /* the name of the manoeuvre of cells in a user's run */
const char *matrix_cell_name(char to[MATRIX_NAME_SIZE], const matrix_cell_t *cell);

/* Name of one bit: "rides", ...; "follows", ...; "reaction", .... */
const char *matrix_reaction_name(uint32_t reaction);
const char *matrix_rotor_name(uint32_t rotor);
const char *matrix_kind_name(uint32_t kind);

/* Names of the bits of a set, "stops or opens"; "" for an empty set. Returns `to`. */
const char *matrix_set_text(char to[MATRIX_NAME_SIZE], uint32_t set, const char *(*name)(uint32_t));

/* The reason for which the cell cannot occur. */
const char *matrix_never(const matrix_cell_t *cell);

/* Lists the cells of a scenario: each fault that can occur during operation, or only the fault `only` if it
 * is not NULL. The promise is that of run_fast on shaft h, or of run_slow below 300 r/min, with the source of
 * the angle at the injection. Its current is scaled with the scenario's overcurrent_trip relative to the
 * default. The faults are scaled to the motor (matrix_scaled). Faults that are present from the beginning are
 * not included; they must be written into the scenario. A fault is observed for the time in its row, while
 * the scenario continues. Returns the number of cells; `cells` as below. *good is false if the drive does not
 * run at that time; `error` then has the message. */
size_t matrix_around(const matrix_user_t *user, const char *only, matrix_cell_t *cells, bool *good,
                     scenario_error_t *error);

/* The run of a board that is not the paper's rig: the library's motor with the largest current of those for
 * which this board is proposed, at 0.3 of its top speed with 0.6 of its rated torque. *at [s]: the time at
 * which the faults occur. NULL: see `error`. */
scenario_t *matrix_of_board(double *at, scenario_error_t *error);

/* Scales an absolute value of a fault (brake, current, voltage, temperature) from the paper's motor, link and
 * limits to those of this rig, which is in a scenario. */
double matrix_scaled(rig_t *rig, const char *row, double value);

/* The value of a row on the paper's rig, independent of the board that this program simulates. */
double matrix_standard(const char *row);

/* Largest number of cells. */
size_t matrix_size(void);

/* Lists the selected cells in the order of faults, manoeuvres, places, and returns their number. `cells` has
 * room for matrix_size() cells. Cells that cannot occur are included unless a share is selected. */
size_t matrix_lay_out(const matrix_choice_t *choice, matrix_cell_t *cells);

/* [s] in which the drive must react to a fault at this electrical speed [rad/s]: 20 ms or a third of a turn,
 * whichever is longer, plus the share `hidden` of a turn in which the fault has no effect. At most 1 s,
 * because a rotor at standstill has no turn. */
double matrix_noticed(double omega_e, double hidden);

/* [A] largest current that the promise of the cell allows. */
double matrix_current(const matrix_cell_t *cell);

/* Compares the observation with the promise, and sets `within` and `red` of the cell. */
void matrix_judge(matrix_cell_t *cell);

/* true: the result of a cell that was run is unexpected. It is red and not listed as a known failure, or
 * green and listed. */
bool matrix_surprises(const matrix_cell_t *cell);

/* true: the names of a promise contain this reason. */
bool matrix_accepts(const char *accepted, int32_t reason);

/* Runs and judges the cells with this number of threads. Calls progress (may be NULL) after each part of the
 * work. false: the rig refused something; `why` has the message. */
bool matrix_run(matrix_cell_t *cells, size_t count, unsigned threads,
                void (*progress)(void *context, double fraction), void *context, char why[POOL_WHY]);

#endif
