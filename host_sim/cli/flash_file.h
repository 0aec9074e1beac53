/* The drive's flash in a file: saved parameters remain after the program ends. */
#ifndef HOST_SIM_CLI_FLASH_FILE_H
#define HOST_SIM_CLI_FLASH_FILE_H

#include <stdbool.h>

#include "host_sim/rig/rig.h"

typedef struct flash_file flash_file_t;

/* If the file exists, the drive starts with its content. Otherwise the file is made when there is something
 * to store. NULL: the message is on stderr. */
flash_file_t *flash_file_open(const char *path, rig_t *rig);

/* Writes the whole file if the flash has changed. false: the message is on stderr. The argument may be NULL.
 */
bool flash_file_keep(flash_file_t *file, const rig_t *rig);

void flash_file_close(flash_file_t *file); /* NULL is accepted */

#endif
