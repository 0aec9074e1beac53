/* Checks of conditions that a correct program never violates: CHECK(condition) is evaluated once, in every
 * build; where it is false, check_failed() receives the function and the line and does not return.
 *
 * It replaces the assert of the library, which prints, for which a chip has neither console nor heap, and
 * ends in the library's abort. One word, the function's name, needs little flash. Not for the interrupt,
 * which could not continue. */
#ifndef MATH_CHECK_H
#define MATH_CHECK_H

#include <stdint.h>

#define CHECK(condition) ((condition) ? (void)0 : check_failed(__func__, (uint16_t)__LINE__))

/* Each program supplies its own. On the chip (app/main.c): no voltage on the motor, and the location is
 * stored. On the host (host_sim/check_failed.c): a line on stderr, and abort. */
void check_failed(const char *function, uint16_t line);

#endif
