/* Simulated time as text and number, the same octets on every machine.
 *
 * Period k begins k x period_ticks [1/150 MHz] after period 0. Its time is written with the fewest decimals
 * that are exact for every period: 4 at 10 kHz (0.1 ms), 5 at 20 kHz. A tick is 20/3 ns. If the number of
 * ticks of a period is not divisible by 3, no number of decimals is exact. Then there are 9 decimals, with an
 * error of at most half a nanosecond. */
#ifndef HOST_SIM_LAB_TIMES_H
#define HOST_SIM_LAB_TIMES_H

#include <stddef.h>
#include <stdint.h>

#define TIMES_TEXT_SIZE 24u /* [octets] longest text, with its closing 0 */

/* [ns] nearest to a tick [1/150 MHz]; because of the thirds it is always unique. */
uint64_t times_nanoseconds(uint64_t tick);

/* Begin of a period [s]: writes it without closing 0 and returns its length. */
size_t times_write(char *to, uint32_t period, uint64_t period_ticks);

/* Begin of a period of the rig [s], "1.2345"; returns `to`. */
const char *times_text(char to[TIMES_TEXT_SIZE], uint32_t period);

/* The double nearest to that decimal [s]. */
double times_seconds(uint32_t period, uint64_t period_ticks);

/* Length of a period [s], exact or with 18 decimals, so that the product with a number of periods is exact:
 * "0.0001". Returns `to`. */
const char *times_period_text(char to[TIMES_TEXT_SIZE], uint64_t period_ticks);

#endif
