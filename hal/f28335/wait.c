/* bus_wait() on silicon. On the host the virtual chip has its own, and this file is not compiled.
 *
 * Waits by CPU timer 0, which hal_init starts first, so that the time does not depend on the code that the
 * compiler makes of the loop. The loop is bounded: a pass takes more than one cycle, so that it ends after
 * `cycles` passes even if the timer is stopped. */
#include "hal/f28335/bus.h"

void bus_wait(uint32_t cycles)
{
    const uint32_t start = CPU_TIMER(0u)->TIM;
    uint32_t turn;

    for (turn = 0u; turn < cycles; turn++) {
        if (start - CPU_TIMER(0u)->TIM >= cycles) {
            break;
        }
    }
}
