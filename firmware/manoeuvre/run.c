#include "manoeuvre/run.h"

/* Of the speed control that is slowed down because it oscillates [-]. */
#define CALMER     0.5f /* each time */
#define CALM_LEAST 0.25f

void run_init(run_t *run, const run_tuning_t *tuning)
{
    run->tuning = *tuning;
    run->calm = 1.0f;
    run->low_kept = 1.0f;
    speed_control_init(&run->speed, &tuning->speed);
    run_limit(run, -tuning->speed.current_limit, tuning->speed.current_limit);
    run_enter(run, (dq_t){0.0f, 0.0f}, 0.0f);
}

void run_enter(run_t *run, dq_t current, float omega_m)
{
    const float kept = run->low_kept * run->tuning.low_current;
    run->omega_m_ref = omega_m;
    run->i_d = current.d;
    run->i_d_mtpa = 0.0f;
    if (run->tuning.saliency > 0.0f) {
        run->i_d_low = current.d < 0.0f ? -bounds_clamp(current.d, kept) : 0.0f;
        run->i_d_left = current.d + run->i_d_low;
    } else {
        run->i_d_low = bounds_clamp(current.d, kept);
        run->i_d_left = current.d;
    }
    speed_control_reset(&run->speed, run_torque(run) * current.q, omega_m);
}

void run_calm(run_t *run, bool whole)
{
    const float calmer = CALMER * run->calm;
    run->calm = whole ? 1.0f : calmer > CALM_LEAST ? calmer : CALM_LEAST;
    const speed_control_tuning_t speed = speed_control_slower(&run->tuning.speed, run->calm);
    speed_control_take(&run->speed, &speed, run->omega_m_ref);
}
