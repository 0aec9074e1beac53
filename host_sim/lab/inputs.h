/* The files that this program has read as its input, so that none of them is written over by its output.
 *
 * A file is known by its place on the disk and not by its name: a link to an input is that input. What is
 * read more than once is kept once. From any thread. */
#ifndef HOST_SIM_LAB_INPUTS_H
#define HOST_SIM_LAB_INPUTS_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

#define INPUTS_MAX 1024u /* [files] beyond it they are not kept */

/* Plain files only; others cannot be written over. */
void inputs_note(const char *path);
void inputs_note_descriptor(int descriptor);

bool inputs_have(const char *path);

#ifdef __cplusplus
}
#endif

#endif
