/* Silicon only: on the desk the rig plays the reset and the background loop. */
#include "app/app.h"

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

/* Takes the place of the C library's, where a failed assertion ends: no voltage on the motor, then the
 * watchdog resets the chip. */
void abort(void);
void abort(void)
{
    hal_gates_off();
    for (;;) {
    }
}
