/* Runs a scenario on its own rig, period by period, and judges it.
 *
 * Before period k the runner executes the events of period k in the order of the file, then the active ramps
 * (start + (end - start) n/N after n of N periods, in double), then rig_step. A tap reads the rows of the
 * recording and of the expectations. The statistics are updated in double with each sample, mean and
 * deviation by Welford's recurrence:
 *
 *     mean_n = mean_{n-1} + d/n,  M_n = M_{n-1} + d (x_n - mean_n),  d = x_n - mean_{n-1},  sd = sqrt(M_n/n)
 *
 * The same scenario and seed give the same bits. Names are not used during the simulation; a scenario without
 * expectations and recording costs two comparisons a period. A sample that is NaN makes its statistic NaN,
 * and the expectation fails.
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

/* The drive's history (rig_history_held) of the last fault of the run, also if the fault was reset. */
typedef struct {
    uint32_t periods;               /* [periods] rows of `slots`; 0: there was no fault while the drive ran */
    int32_t fault_reason;           /* [-] 0: there was no fault */
    uint32_t fault_period;          /* [periods] when it came */
    uint32_t last_period;           /* [periods] of the last row */
    uint32_t columns;               /* [-] of a row */
    uint32_t rows[CAPTURE_COLUMNS]; /* [-] their ids */
    uint32_t slots[CAPTURE_SLOTS];  /* row after row, oldest first */
    /* with fault_record = replay, in their place: */
    uint32_t record_count;                            /* [slots] 0: none */
    uint32_t record[CAPTURE_SLOTS + RIG_RECORD_HEAD]; /* of rig_record */
} runner_history_t;

/* If all fields are zero, the scenario runs unchanged, without recording and call-backs. */
typedef struct {
    bool has_seed; /* `seed` replaces that of the scenario */
    uint64_t seed;
    /* The recording: `sink` receives these rows as from rig_tap, every record_every periods (0 counts as 1).
     */
    const uint32_t *record;
    uint32_t record_count;
    uint32_t record_every; /* [periods] */
    rig_sink_t sink;       /* NULL: no recording */
    void *sink_context;
    rig_edge_sink_t edge_sink; /* receives edges as from rig_watch_edges; may be NULL */
    void *edge_context;
    runner_history_t *history;  /* may be NULL */
    runner_progress_t progress; /* may be NULL */
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
    RUNNER_NOT_JUDGED, /* the run ended before the end of the window */
    RUNNER_MEASURED    /* it has no limit */
} runner_judgement_t;

typedef struct {
    const scenario_expect_t *expect; /* of the scenario */
    double value;                    /* [unit of the row] of the samples until now; NAN: there is none */
    uint32_t samples;
    runner_judgement_t judgement;
    bool never_on; /* failed because the drive never came on, independent of its value */
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
    bool never_on;         /* the bridge was commanded on, and was off in all periods */
    int32_t not_on;    /* [-] reason, if never_on, or if the bridge is commanded on at the end and is off; 0:
                          neither */
    bool unexpected;   /* it ended with a fault or a permanent refusal that no expectation names: see below */
    uint64_t warnings; /* [-] bits of the fault table that warn at the end */
    int32_t manoeuvre; /* [-] of the drive at the end */
    uint64_t hash;     /* of the rig's whole state at the end */
    double seconds;    /* [s] real time of the run without the preparation */
} runner_result_t;

/* Judges the scenario again (scenario_check), then runs it. true: it ran to its end or to options.stop,
 * independent of the verdicts. false: RUNNER_REFUSED; the sink has received the samples until then. In both
 * cases call runner_result_free. */
bool runner_run(scenario_t *scenario, const runner_options_t *options, runner_result_t *result);

void runner_result_free(runner_result_t *result);

/* A complete run fails, independent of its limits, if at its end
 *   - a fault is latched, or
 *   - the bridge is commanded on and has been off for RUNNER_LASTING,
 * unless an expectation names that end:
 *   - one of `fault_reason` (a fault) or `refusal` (a refusal) whose limits include the reason and exclude 0,
 *   - one of `state` whose limits include the state at the end and exclude operation_enabled,
 *   - one with needs_drive = "no", if the drive was never on.
 * The window of the first two must end after the fault; for a refusal it must reach to the end of the run.
 * Therefore an expectation of an earlier fault, which was reset, does not name a later one. */
#define RUNNER_LASTING 0.1 /* [s] longer than the measurement of the offsets */

/* Text of the unexpected end, "fault dc_undervoltage at 2.5010 s, which no expectation names"; "" if there is
 * none. Returns `to`. */
const char *runner_unexpected_text(const runner_result_t *result, char *to, size_t size);

/* "mean of true_omega_m - omega_m_ref from 1 s to 2 s: 0.02 r/min, at most 1 r/min"; the name first if there
 * is one. Returns `to`. */
const char *runner_verdict_text(const runner_verdict_t *verdict, char *to, size_t size);

#endif
