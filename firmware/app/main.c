/* On the target only: in the host simulation the rig executes the reset and the background loop. */
#include "app/app.h"
#include "math/check.h"

static app_t the_app;

int main(void)
{
    hal_boot();
    app = &the_app;
    app_start();
    for (;;) {
        app_background();
    }
}

typedef struct {
    const char *function;
    uint16_t line;
} check_failure_t;

/* The check that failed, for a debugger; null: no check has failed. */
static volatile check_failure_t check_failure;

/* Removes the voltage from the motor; interrupts are switched off one instruction before the gates, because
 * the next interrupt could switch them on again. The drive stays off until an external reset: the watchdog is
 * served, so that the place of the failure can still be read. */
void check_failed(const char *function, uint16_t line)
{
    hal_interrupts_off();
    hal_gates_off();
    check_failure.function = function;
    check_failure.line = line;
    for (;;) {
        hal_watchdog_feed();
    }
}
