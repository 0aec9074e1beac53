/* Checks of conditions that a correct program never violates: CHECK(condition) is evaluated once, in every
 * build; where it is false, check_failed() receives the function and the line and does not return.
 *
 * It replaces the assert of the library, which prints and then calls abort; a chip has neither a console nor
 * a heap for that. Only the function's name is stored, which needs little flash. It is not for the interrupt,
 * which could not continue. */
#ifndef MATH_CHECK_H
#define MATH_CHECK_H

#include <stdint.h>

#define CHECK(condition) ((condition) ? (void)0 : check_failed(__func__, (uint16_t)__LINE__))

/* Each program supplies its own. On the chip (app/main.c): removes the voltage from the motor, and stores the
 * location. On the host (host_sim/check_failed.c): prints a line on stderr, and calls abort. */
void check_failed(const char *function, uint16_t line);

#endif
