/* Editing of lines with history and completion, by libedit where CMake has found it. */
#ifndef HOST_SIM_CLI_CONNECT_EDIT_H
#define HOST_SIM_CLI_CONNECT_EDIT_H

#include <stdbool.h>

bool connect_edit_has(void); /* false: the other functions have no effect */

/* Each whole line goes to `line`, which returns whether another line follows. `wait` waits until a key is
 * pressed; false: the input has ended. */
void connect_edit_begin(bool (*line)(void *context, const char *line), bool (*wait)(void *context),
                        void *context);
void connect_edit_read(void); /* stdin has something */
bool connect_edit_goes_on(void);
void connect_edit_end(void);

#endif
