/* Long commands end in good order when they are asked to. */
#ifndef HOST_SIM_CLI_STOP_H
#define HOST_SIM_CLI_STOP_H

#include <signal.h>

/* From here on SIGINT (Ctrl+C) and SIGTERM make the returned 1; a second one of the same kind
 * ends the program. */
const volatile sig_atomic_t *stop_on_signal(void);

#endif
