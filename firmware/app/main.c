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

/* A failed assertion: no voltage on the motor, then the watchdog resets the chip. */
void abort(void)
{
    hal_gates_off();
    for (;;) {
    }
}
