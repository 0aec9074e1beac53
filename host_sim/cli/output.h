/* What several commands write: a folder, a picture drawn from a data file. */
#ifndef HOST_SIM_CLI_OUTPUT_H
#define HOST_SIM_CLI_OUTPUT_H

#include <stdbool.h>
#include <stdio.h>

#define PATH_SIZE 4096

/* Wall clock [s] from some fixed instant, for durations. */
double output_seconds(void);

/* Makes the folder with all that lead to it. false: said why on stderr. */
bool output_folder(const char *path);

/* path = folder/name; false: too long (said on stderr). */
bool output_path(char path[PATH_SIZE], const char *folder, const char *name);

/* Opens for writing; NULL: said why on stderr. */
FILE *output_open(const char *path);

/* Opens path = folder/name for writing, likewise. */
FILE *output_open_in(char path[PATH_SIZE], const char *folder, const char *name);

/* Closes and judges what was written; false: the disk did not take it all (said on stderr), or file is NULL,
 * so that a file that could not be opened was not written. */
bool output_close(FILE *file, const char *path);

/* Does this stream want colours: a terminal, and NO_COLOR is not set. */
bool output_colours(FILE *file);

/* "did you mean NAME?" after a message; nothing without a near name. */
void output_suggest(FILE *file, const char *near);

/* Runs tools/SCRIPT DATA PNG --title TITLE, or tools/SCRIPT DATA if png is NULL. false: no picture; said why
 * on stderr, the data stay. */
bool output_picture(const char *script, const char *data, const char *png, const char *title);

#endif
