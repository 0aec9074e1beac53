/* Prints a failed CHECK on stderr, in the host simulation and on simulated targets. */
#include <stdio.h>
#include <stdlib.h>

#include "math/check.h"

void check_failed(const char *function, uint16_t line)
{
    fprintf(stderr, "%s, line %u: check failed\n", function, (unsigned)line);
    abort();
}
