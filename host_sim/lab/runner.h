/* Runs a scenario on a rig of its own, period by period, and judges it.
 *
 * Before period k: events of period k in the order of the file, then ramps under way (start + (end - start)
 * n/N after n of N periods, in double), then rig_step. A tap carries the rows that are recorded and those of
 * the expectations; their statistics are kept in double as the samples come, mean and deviation by Welford's
 * recurrence:
 *
 *     mean_n = mean_{n-1} + d/n,  M_n = M_{n-1} + d (x_n - mean_n),  d = x_n - mean_{n-1},  sd = sqrt(M_n/n)
 *
 * Same scenario, same seed: same bits. Nothing is looked up by name while the ring turns; a scenario without
 * expectations and recording costs two comparisons a period. A sample that is not a number makes its
 * statistic not a number, and that fails.
 *
 * Does not handle: writing files (host_sim/lab/recorder.h), printing. */
#ifndef HOST_SIM_LAB_RUNNER_H
#define HOST_SIM_LAB_RUNNER_H

#include <signal.h>
#include <stdbool.h>
#include <stdint.h>

#include "host_sim/lab/scenario.h"
#include "host_sim/rig/rig.h"

#define RUNNER_PROGRESS_PERIODS 1000u /* [periods] between two calls of progress */

typedef void (*runner_progress_t)(void *context, double fraction);

/* The drive's history (rig_history_held) of the last fault that the run came to, whether it was reset or not.
 */
typedef struct {
    uint32_t periods;      /* [periods] rows of `slots`; 0: there was no fault, or none while the drive ran */
    int32_t fault_reason;  /* [-] 0: there was no fault */
    uint32_t fault_period; /* [periods] when it came */
    uint32_t last_period;  /* [periods] of the last row */
    uint32_t columns;      /* [-] of a row */
    uint32_t rows[CAPTURE_COLUMNS]; /* [-] their ids */
    uint32_t slots[CAPTURE_SLOTS];  /* row after row, oldest first */
    /* with fault_record = replay, in their place: */
    uint32_t record_count;                            /* [slots] 0: none */
    uint32_t record[CAPTURE_SLOTS + RIG_RECORD_HEAD]; /* of rig_record */
} runner_history_t;

/* All zero: the scenario as it is, nothing recorded, nobody watching. */
typedef struct {
    bool has_seed; /* instead of the scenario's */
    uint64_t seed;
    /* The recording: these rows, every so many periods (0 counts as 1), go to the sink, as from rig_tap. */
    const uint32_t *record;
    uint32_t record_count;
    uint32_t record_every; /* [periods] */
    rig_sink_t sink;       /* NULL: no recording */
    void *sink_context;
    rig_edge_sink_t edge_sink; /* NULL: nobody; as from rig_watch_edges */
    void *edge_context;
    runner_history_t *history;  /* NULL: nobody */
    runner_progress_t progress; /* NULL: nobody */
    void *progress_context;
    const volatile sig_atomic_t *stop; /* NULL: never; not 0: stop after this period */
    bool has_stop_period;              /* rig_stop_at is called before this period, for the debugger */
    uint32_t stop_period;
} runner_options_t;

typedef enum {
    RUNNER_COMPLETE,
    RUNNER_INTERRUPTED, /* by options.stop */
    RUNNER_REFUSED      /* the rig refused a setting, or an option was wrong: see error */
} runner_end_t;

typedef enum {
    RUNNER_MET,
    RUNNER_FAILED,
    RUNNER_NOT_JUDGED, /* the run ended before the window did */
    RUNNER_MEASURED    /* it has no limit */
} runner_judgement_t;

typedef struct {
    const scenario_expect_t *expect; /* of the scenario */
    double value;                    /* [unit of the row] of the samples so far; NAN: none */
    uint32_t samples;
    runner_judgement_t judgement;
    bool never_on; /* failed for that, whatever its value */
} runner_verdict_t;

typedef struct {
    runner_end_t end;
    scenario_error_t error;     /* if refused */
    runner_verdict_t *verdicts; /* one for each expectation, in their order */
    uint32_t verdict_count;
    uint32_t failed; /* [-] verdicts that are RUNNER_FAILED or RUNNER_NOT_JUDGED, and one more for an
                        unexpected end */
    uint64_t seed;
    uint32_t periods;      /* [periods] run */
    int32_t state;         /* [-] of the drive at the end */
    int32_t fault_reason;  /* [-] 0: none latched at the end */
    uint32_t fault_period; /* [periods] when it came */
    int32_t refusal;       /* [-] 0: none at the end */
    bool never_on;         /* the bridge was to be on, and was not in any period */
    int32_t
        not_on; /* [-] reason, if never_on, or if the bridge is to be on at the end and is not; 0: neither */
    bool unexpected;   /* it ended with a fault or a lasting refusal that no expectation names: see below */
    uint64_t warnings; /* [-] bits of the fault table that warn at the end */
    int32_t manoeuvre; /* [-] of the drive at the end */
    uint64_t hash;     /* of the rig's whole state at the end */
    double seconds;    /* [s] on the wall, set-up left out */
} runner_result_t;

/* true: it ran to its end or to options.stop, whatever the verdicts. false: RUNNER_REFUSED; what was recorded
 * until then has gone to the sink. Either way runner_result_free is due. Judges the scenario again first
 * (scenario_check). */
bool runner_run(scenario_t *scenario, const runner_options_t *options, runner_result_t *result);

void runner_result_free(runner_result_t *result);

/* A complete run fails, whatever its limits are, if at its end
 *   - a fault is latched, or
 *   - the bridge is to be on and has not been on for RUNNER_LASTING,
 * unless an expectation names that end:
 *   - one of `fault_reason` (a fault) or `refusal` (a refusal) whose limits include the reason and exclude 0,
 *   - one of `state` whose limits include the state at the end and exclude operation_enabled,
 *   - one with needs_drive = "no", if the drive was never on.
 * The window of the first two must reach beyond the moment of the fault; for a refusal it must reach to the
 * end of the run. So an expectation of an earlier fault, which was reset, does not name a later one. */
#define RUNNER_LASTING 0.1 /* [s] longer than the offsets are measured for */

/* What the unexpected end is, "fault dc_undervoltage at 2.5010 s, which no expectation names"; "" if there is
 * none. Returns `to`. */
const char *runner_unexpected_text(const runner_result_t *result, char *to, size_t size);

/* "mean of true_omega_m - omega_m_ref from 1 s to 2 s: 0.02 r/min, at most 1 r/min"; the name first if there
 * is one. Returns `to`. */
const char *runner_verdict_text(const runner_verdict_t *verdict, char *to, size_t size);

#endif
