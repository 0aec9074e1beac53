#include "manoeuvre/run.h"

void run_init(run_t *run, const run_tuning_t *tuning)
{
    run_take(run, tuning);
    run_reset(run);
}

void run_take(run_t *run, const run_tuning_t *tuning)
{
    run->flux_linkage = tuning->flux_linkage;
    speed_control_take(&run->speed, &tuning->speed);
}

void run_reset(run_t *run)
{
    speed_control_reset(&run->speed, 0.0f);
}

demand_t run_step(run_t *run, const run_wish_t *wish, float omega_e, float omega_m)
{
    demand_t demand = {{0.0f, 0.0f}, {0.0f, omega_e * run->flux_linkage}, 0.0f};
    switch (wish->mode) {
    case RUN_ZERO:
        break;
    case RUN_CURRENT:
        speed_control_reset(&run->speed, wish->current.q);
        demand.current = wish->current;
        demand.omega_m_ref = omega_m;
        break;
    case RUN_SPEED:
        demand.current.d = wish->current.d;
        demand.current.q = speed_control_step(&run->speed, wish->omega_m_ref, omega_m);
        demand.omega_m_ref = wish->omega_m_ref;
        break;
    }
    return demand;
}
