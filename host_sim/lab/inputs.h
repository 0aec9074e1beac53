/* The list of the files that this program has read, so that its output cannot overwrite one of them.
 *
 * A file is identified by its place on the disk, not by its name; a link to an input counts as this input. A
 * file that is read several times is listed once. The functions may be called from any thread. */
#ifndef HOST_SIM_LAB_INPUTS_H
#define HOST_SIM_LAB_INPUTS_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

#define INPUTS_MAX 1024u /* [files] further ones are not listed */

/* Adds a plain file to the list; other files cannot be overwritten. */
void inputs_note(const char *path);
void inputs_note_descriptor(int descriptor);

bool inputs_have(const char *path);

#ifdef __cplusplus
}
#endif

#endif
