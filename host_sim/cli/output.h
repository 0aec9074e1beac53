/* What several commands write: a folder, a picture drawn from a data file. */
#ifndef HOST_SIM_CLI_OUTPUT_H
#define HOST_SIM_CLI_OUTPUT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define PATH_SIZE 4096

/* Wall clock [s] from some fixed instant, for durations. */
double output_seconds(void);

/* Makes the folder with all that lead to it. false: said why on stderr. */
bool output_folder(const char *path);

/* Makes a new folder parent/name, or parent/name_2 and so on where that is there already, and `path` its
 * name. false: said why on stderr. */
bool output_fresh_folder(char path[PATH_SIZE], const char *parent, const char *name);

/* As output_folder, and the folder is this program's until it ends: another one that claims it is refused, so
 * that no two mix what they write there. false: said why on stderr. */
bool output_claim(const char *path);

/* path = folder/name; false: too long (said on stderr). */
bool output_path(char path[PATH_SIZE], const char *folder, const char *name);

/* The rule for every command that writes, looked at before the work: no file that this program has read as
 * its input (host_sim/lab/inputs.h), and no other file that exists, unless --force was given. What is no
 * plain file (a terminal, /dev/null) is none. false: said why on stderr. The second form: FOLDER/NAMEending.
 */
bool output_allowed(const char *path);
bool output_allowed_in(const char *folder, const char *name, const char *ending);
/* The same for the files of a recording (host_sim/lab/recorder.h). */
bool output_allowed_recording(const char *folder, const char *name, uint32_t formats);

/* --force: files that exist are replaced, inputs never. */
void output_force(void);
bool output_forced(void);

/* Pictures FOLDER/NAME.KIND of these formats, "html,png". */
bool output_allowed_pictures(const char *folder, const char *name, const char *formats);

/* Opens for writing as PATH.partial, which output_close gives its name: what stood there stays until then. A
 * path that is no plain file is opened itself. NULL: said why on stderr; also what output_allowed refuses. */
FILE *output_open(const char *path);

/* The same for a file that is this program's own state, which it has read and keeps up to date. */
FILE *output_open_own(const char *path);

/* Opens path = folder/name for writing, as output_open. */
FILE *output_open_in(char path[PATH_SIZE], const char *folder, const char *name);

/* Closes what output_open has opened and judges what was written; false: the disk did not take it all (said
 * on stderr), or file is NULL, so that a file that could not be opened was not written. */
bool output_close(FILE *file, const char *path);

/* Closes it and takes it away: what stood there stays. NULL is fine. */
void output_abandon(FILE *file, const char *path);

/* Does this stream want colours: a terminal, and NO_COLOR is not set. */
bool output_colours(FILE *file);

/* A bar with the time that is left, for what takes longer than one cares to wait without a sign: on stderr if
 * that is a terminal, else nothing at all. All long work shows its progress by this. */
typedef struct {
    double started; /* [s] as output_seconds() has it */
    double drawn;   /* [s] of the same clock, the last time */
    bool wanted, shown;
} output_progress_t;
output_progress_t output_progress_begin(void);
void output_progress(void *progress, double fraction); /* an output_progress_t; 0..1 done */
void output_progress_end(output_progress_t *progress); /* takes it away */

/* "did you mean NAME?" after a message; nothing without a near name. */
void output_suggest(FILE *file, const char *near);

/* Runs tools/SCRIPT with these arguments, a NULL behind the last; it reads `input` on its stdin, which is
 * rewound first (NULL: nothing). A script that takes long writes the fractions done, a line each, to the
 * descriptor whose number is in LAGLESS_PROGRESS. Returns its exit code, EXIT_INTERNAL if it could not be run
 * or was killed; then, or by the script, it was said why on stderr. */
int output_script(const char *script, const char *const *arguments, FILE *input);

/* Runs tools/SCRIPT DATA PNG --title TITLE, or tools/SCRIPT DATA if png is NULL. false: no picture; said why
 * on stderr, the data stay. */
bool output_picture(const char *script, const char *data, const char *png, const char *title);

#endif
