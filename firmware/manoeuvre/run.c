#include "manoeuvre/run.h"

void run_init(run_t *run, const run_tuning_t *tuning)
{
    run->tuning = *tuning;
    run->low_kept = 1.0f;
    speed_control_init(&run->speed, &tuning->speed);
    run_limit(run, -tuning->speed.current_limit, tuning->speed.current_limit);
    run_enter(run, (dq_t){0.0f, 0.0f}, 0.0f);
}

void run_enter(run_t *run, dq_t current, float omega_m)
{
    speed_control_reset(&run->speed, current.q, omega_m);
    run->omega_m_ref = omega_m;
    run->i_d_left = current.d;
    run->i_d_low = bounds_clamp(current.d, run->low_kept * run->tuning.low_current);
}
