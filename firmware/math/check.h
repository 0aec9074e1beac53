/* What must hold, or the program is wrong: CHECK(condition) is evaluated once, in every build; where it is
 * false, check_failed() hears the function and the line and does not return.
 *
 * Not the library's assert: that one prints, for which a chip has neither console nor heap, and ends in the
 * library's abort. One word, the function's name, costs little flash. Not for the interrupt: there is no way
 * on. */
#ifndef MATH_CHECK_H
#define MATH_CHECK_H

#include <stdint.h>

#define CHECK(condition) ((condition) ? (void)0 : check_failed(__func__, (uint16_t)__LINE__))

/* Each program brings its own. On the chip (app/main.c): no voltage on the motor, and the place is kept. On a
 * desk (host_sim/check_failed.c): a line on stderr, and abort. */
void check_failed(const char *function, uint16_t line);

#endif
