/* bus_wait() on silicon; on the host the virtual chip brings its own, and this file is not compiled.
 *
 * Waits by CPU timer 0, which hal_init starts first of all, so that the compiler's idea of a loop does not
 * matter. The loop is bounded by itself: a turn takes more than one cycle, so `cycles` turns are enough even
 * if the timer stood. */
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
