/* Silicon only: on the desk the rig plays the reset and the background loop. */
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

/* The check that failed, for a debugger to print: null while none has. */
static volatile check_failure_t check_failure;

/* No voltage on the motor; interrupts are off one instruction before the gates, or the next one could turn
 * them on again. The drive stays off until a reset from outside: the watchdog is fed, so that the place is
 * still there when somebody looks. */
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
