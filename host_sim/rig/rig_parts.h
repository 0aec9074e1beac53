/* Data and functions that the sources of the rig share. Included by host_sim/rig/.c files only. */
#ifndef HOST_SIM_RIG_RIG_PARTS_H
#define HOST_SIM_RIG_RIG_PARTS_H

#include "host_sim/rig/rig_part.h"
#include "host_sim/rig/rig_state.h"

/* Tables by their order, which is also that of rig_table(). */
typedef enum { PARAMS, REQUESTS, SIGNALS, SERVICES, TRUTH, PLANT, CONDITIONS, TABLES } table_number_t;

typedef struct {
    table_number_t table;
    const table_row_t *row;
    const char *base; /* struct that holds the slot */
} place_t;

/* A replay in progress (rig_replay.c). */
typedef struct {
    bool on;
    const uint32_t *slots; /* of the record */
    rig_record_t record;
    uint32_t event;          /* [-] number of the next one */
    drive_samples_t samples; /* of the coming interrupt */
    bool due;                /* that interrupt has handed a window over */
    uint32_t done;           /* [windows] values for drive_t.done and opens when the medium task has ended */
    int32_t opens;
    uint32_t begin, periods, windows, tunings, requests;
    bool differs;
    uint32_t wrong;
} rig_replay_t;

/* The values that the parts of the ring exchange (rig_part.h). */
typedef struct {
#define EXCHANGE_FLOAT(id, name, unit, initial, min, max, text) float name;   /* [unit of its row] */
#define EXCHANGE_WHOLE(id, name, unit, initial, max, text)      int32_t name; /* [unit of its row] */
#define EXCHANGE_ENUM(id, name, choices, text)                  int32_t name; /* [-] */
    RIG_COMMAND(EXCHANGE_FLOAT, EXCHANGE_WHOLE, EXCHANGE_ENUM)
    RIG_SAMPLE(EXCHANGE_FLOAT, EXCHANGE_WHOLE, EXCHANGE_ENUM)
#undef EXCHANGE_FLOAT
#undef EXCHANGE_WHOLE
#undef EXCHANGE_ENUM
} rig_exchange_t;

typedef struct {
    uint64_t tripped;        /* [ticks] the module last tripped */
    int32_t part;            /* [-] rig_part_t */
    uint32_t waits;          /* [-] 1: the plant has taken a sample, and waits for the command */
    rig_exchange_t exchange; /* the last values of both directions */
} rig_cut_t;

struct rig {
    rig_state_t state;
    rig_replay_t replay;
    rig_cut_t cut;
    chip_world_t world;
    /* observers, which do not change the simulation */
    size_t tap_offsets[RIG_TAP_MAX]; /* [octets] in the state */
    uint32_t tap_count;
    uint32_t tap_every;
    rig_sink_t tap_sink;
    void *tap_context;
    rig_line_t line; /* read NULL: the chip's */
    rig_edge_sink_t edge_sink;
    void *edge_context;
    place_t stop_place;
    rig_compare_t stop_compare;
    double stop_value;
    bool stop_hook_set;
    uint32_t stop_hook_period;
    uint32_t error_id;
    int32_t error_reason;
    double error_value, error_min,
        error_max; /* accepted range; if the limits are in the wrong order there is none */
    char error[512];
};

/* rig.c */
void rig_pass(rig_t *rig, uint64_t until); /* [ticks] lets time pass while software runs */

/* rig_values.c */
bool rig_refuse(rig_t *rig, uint32_t id, int32_t reason, const char *text);
bool rig_refuse_id(rig_t *rig, uint32_t id);
bool rig_find(const rig_t *rig, uint32_t id, place_t *place);

/* rig_rows.c */
double rig_row_get(const table_row_t *row, const void *base);
void rig_row_put(const table_row_t *row, void *base, double value); /* accepted by the row */
/* Writes a value with four digits, or more if it would leave the range. Returns `to`. */
const char *rig_advice_text(char to[RIG_NUMBER_SIZE], double advice, double min, double max);

/* rig_part.c */
/* Of the drive: the sample that the other part has taken, and the command for it. */
void rig_part_take(const rig_t *rig, drive_samples_t *samples);
void rig_part_give(rig_t *rig, const drive_command_t *command);

/* rig_world.c */
chip_world_t rig_world(rig_t *rig);
void rig_drive_enable_input(rig_t *rig); /* the pin as its row requires */
void rig_follow_fault_line(rig_t *rig);  /* call it after a change of the plant without a gate edge */

/* The plant follows the outputs of brake chopper and holding brake, at its present tick. */
void rig_follow_outputs(rig_t *rig);

/* rig_software.c */
void rig_software_bind(rig_t *rig);
void rig_exact_samples(const rig_state_t *state,
                       drive_samples_t *samples); /* the true values at t_k, of ideal sensors */
uint64_t rig_section(void *context);              /* [ticks] that a section with interrupts off takes */
bool rig_background_is_free(const rig_t *rig);    /* neither CPU nor background itself is busy */
bool rig_background(rig_t *rig); /* runs the background; false: the CPU or the background is busy */
/* The functions that app_interrupt and app_medium call in the simulation instead of drive_step,
 * drive_medium_step and
 * drive_medium_took (rig.cmake). */
bool desk_drive_step(drive_t *drive, const drive_samples_t *samples, drive_command_t *command);
void desk_drive_medium_step(drive_t *drive);
void desk_drive_medium_took(drive_t *drive, uint32_t cycles);

/* rig_estimator.c */
/* Adds this jump [rad], |jump| <= pi, to the angle of the loop; EMF and speed are unchanged. */
void rig_turn_estimate(chosen_t *est, float jump);

/* rig_bench.c */
double rig_clock_seconds(void); /* [s] of this machine, from an arbitrary zero */
void rig_timing_pause(
    const rig_t *rig); /* the time until the next call does not count as time of the interrupt */
void rig_timing_go_on(const rig_t *rig);

#endif
