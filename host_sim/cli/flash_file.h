/* The drive's flash in a file: what is saved outlives the program. */
#ifndef HOST_SIM_CLI_FLASH_FILE_H
#define HOST_SIM_CLI_FLASH_FILE_H

#include <stdbool.h>

#include "host_sim/rig/rig.h"

typedef struct flash_file flash_file_t;

/* If the file is there the drive begins anew with its content; else it is made when there is something to
 * keep. NULL: said why on stderr. */
flash_file_t *flash_file_open(const char *path, rig_t *rig);

/* Writes the file if the flash has changed, as a whole or not at all. false: said why on stderr. NULL:
 * nothing to do. */
bool flash_file_keep(flash_file_t *file, const rig_t *rig);

void flash_file_close(flash_file_t *file); /* NULL is fine */

#endif
