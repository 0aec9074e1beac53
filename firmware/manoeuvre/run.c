#include "manoeuvre/run.h"

void run_init(run_t *run, const run_tuning_t *tuning)
{
    run_take(run, tuning);
    run_reset(run);
}

void run_reset(run_t *run)
{
    speed_control_reset(&run->speed, 0.0f);
}
