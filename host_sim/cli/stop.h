/* Interruption of long commands. */
#ifndef HOST_SIM_CLI_STOP_H
#define HOST_SIM_CLI_STOP_H

#include <signal.h>

/* Returns a variable that SIGINT (Ctrl+C) and SIGTERM set to 1 from now on. A second signal of the same kind
 * ends the program. */
const volatile sig_atomic_t *stop_on_signal(void);

#endif
