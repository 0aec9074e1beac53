/* The data of a window: its sums begin with its first period, and its last period hands over all of them to
 * the medium task. */
#include "fast/fast_parts.h"

#include "settings/reasons.h"

/* Assigned field by field, because the compiler would call a library routine to clear a struct. */
void fast_begin_sums(window_sums_t *sum)
{
    const ab_t none = {0.0f, 0.0f};
    sum->periods = 0u;
    sum->tracked = 0u;
    sum->unsound = 0u;
    sum->limited = 0u;
    sum->chopped = 0u;
    sum->scatter = 0.0f;
    sum->voltage = none;
    sum->current = none;
    sum->emf = none;
    sum->emf_hat = none;
    sum->reference = (dq_t){0.0f, 0.0f};
}

static inline dq_t pair_dq(const dq_t *pair)
{
    return (dq_t){pair->d, pair->q};
}

static inline ab_t pair_ab(const ab_t *pair)
{
    return (ab_t){pair->alpha, pair->beta};
}

/* The state at the last period, assigned field by field, because the compiler would clear a whole struct
 * first or copy it twice; and the structs of two numbers number by number, because it would compute the
 * addresses of all of them first. */
static void snapshot(const fast_t *fast, window_t *window)
{
    window->measured = fast->measure.measured;
    window->estimate = fast->estimator.estimate;
    window->current_err = pair_ab(&fast->estimator.observed.current_err);
    window->encoder = (position_t){fast->shaft.position.theta_e, fast->shaft.position.omega_e};
    window->frame = fast->demand.frame;
    window->rotor = fast->rotor;
    window->omega_m = fast->omega_m;
    window->current = pair_dq(&fast->control.current);
    window->reference = pair_dq(&fast->demand.current);
    window->voltage = pair_dq(&fast->current_control.voltage_ref);
    window->omega_m_ref = fast->demand.omega_m_ref;
    window->link.mean = fast->acted.link;
    window->bounds = (bounds_t){fast->bounds.lower, fast->bounds.upper};
    window->link.slow = fast->link.slow;
    window->link.limits = fast->link.limits;
}

void fast_close(fast_t *fast, const setpoint_t *setpoint, window_t *window)
{
    window->number = fast->report.number;
    window->period = fast->period;
    window->setpoint = setpoint->number;
    window->sum = fast->sum;
    snapshot(fast, window);
    window->catching.outcome = fast->reference.outcome;
    window->catching.seen = fast->reference.catching.seen;
    window->sensors.calibration = fast->report.calibration;
    window->sensors.offsets = fast->report.offsets;
    window->sensors.still[0] = fast->still_watch.still[0];
    window->sensors.still[1] = fast->still_watch.still[1];
    window->sensors.still[2] = fast->still_watch.still[2];
    window->sensors.noise = measure_noise(&fast->measure);
    window->estimating = fast->estimating;
    window->tracking = fast->reference.tracking;
    window->bridge = (int32_t)(fast->bridge.on < FAST_ON     ? BRIDGE_OFF
                               : fast->bridge.charging != 0u ? BRIDGE_CHARGES
                                                             : BRIDGE_ON);
    window->report = fast->report.window;
    if (setpoint->excite.kind != (int32_t)EXCITE_NONE) {
        excite_close(&fast->control.excite, &window->excite);
    }
    fast->report.number++;
    fast->report.offsets = 0u;
    fast->report.window.failed = fault_set_none();
    fast->report.window.left = (int32_t)JUMP_IGNORED;
    fast->report.window.stop.reason = (int32_t)REASON_NONE;
}

void fast_miss(fast_t *fast)
{
    fast_begin_sums(&fast->sum);
    fast->sum.unsound = 1u;
    fast->given.overdue = (fast->given.late & FAST_LATE_WINDOWS) != 0u ? UINT32_C(1) : UINT32_C(0);
    fast->given.late = fast->given.late << 1 | 1u;
    fast->bridge.outputs.permitted =
        fast->given.overdue != 0u ? 0u : fast->bridge.outputs.permitted; /* no watch runs */
}
