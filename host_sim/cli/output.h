/* Output of several commands: folders, files, pictures drawn from a data file. false or NULL: the message is
 * on stderr. */
#ifndef HOST_SIM_CLI_OUTPUT_H
#define HOST_SIM_CLI_OUTPUT_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define PATH_SIZE 4096

/* Real time [s] from a fixed instant, for durations. */
double output_seconds(void);

/* Makes the folder and its parents. */
bool output_folder(const char *path);

/* Makes a new folder parent/name, or parent/name_2 and so on if it exists already. `path` gets its name. */
bool output_fresh_folder(char path[PATH_SIZE], const char *parent, const char *name);

/* As output_folder, and locks the folder for this program until it ends, so that two programs cannot mix
 * their files. */
bool output_claim(const char *path);

/* path = folder/name; false: too long. */
bool output_path(char path[PATH_SIZE], const char *folder, const char *name);

/* The rule for every command that writes, checked before the work. A file that this program has read as its
 * input (host_sim/lab/inputs.h) is never overwritten; any other existing file only with --force. The rule
 * does not concern terminals, /dev/null and the like. The second form is for FOLDER/NAMEending. */
bool output_allowed(const char *path);
bool output_allowed_in(const char *folder, const char *name, const char *ending);
/* The same for the files of a recording (host_sim/lab/recorder.h). */
bool output_allowed_recording(const char *folder, const char *name, uint32_t formats);

/* --force: existing files are replaced, inputs never. */
void output_force(void);
bool output_forced(void);

/* Pictures FOLDER/NAME.KIND of these formats, "html,png". */
bool output_allowed_pictures(const char *folder, const char *name, const char *formats);

/* Opens PATH.partial for writing. output_close renames it; until then an existing file PATH remains. A path
 * that is not a plain file is opened directly. NULL also if output_allowed refuses the path. */
FILE *output_open(const char *path);

/* The same for a file with the state of this program, which the program has read itself. */
FILE *output_open_own(const char *path);

/* Opens path = folder/name for writing, as output_open. */
FILE *output_open_in(char path[PATH_SIZE], const char *folder, const char *name);

/* Closes and renames a file of output_open. false: it could not be written completely, or `file` is NULL
 * because it could not be opened. */
bool output_close(FILE *file, const char *path);

/* Closes and removes the new file; an existing file PATH remains. `file` may be NULL. */
void output_abandon(FILE *file, const char *path);

/* true: the stream is a terminal, and NO_COLOR is not set. */
bool output_colours(FILE *file);

/* A progress bar with the remaining time for long work. It is drawn on stderr if this is a terminal. */
typedef struct {
    double started; /* [s] as output_seconds() has it */
    double drawn;   /* [s] of the same clock, the last time */
    bool wanted, shown;
} output_progress_t;
output_progress_t output_progress_begin(void);
void output_progress(void *progress, double fraction); /* an output_progress_t; 0..1 done */
void output_progress_end(output_progress_t *progress); /* removes the bar */

/* Prints "did you mean NAME?" after a message, or nothing if there is no similar name. */
void output_suggest(FILE *file, const char *near);

/* Runs tools/SCRIPT with these arguments, of which the last is followed by NULL. The script reads `input`
 * from stdin, from its beginning (NULL: nothing). A long script writes its progress, one fraction per line,
 * to the descriptor with the number in LAGLESS_PROGRESS. Returns the exit code of the script, or
 * EXIT_INTERNAL if it could not run or was killed. In both cases the message is on stderr. */
int output_script(const char *script, const char *const *arguments, FILE *input);

/* Runs tools/SCRIPT DATA PNG --title TITLE, or tools/SCRIPT DATA if png is NULL. false: no picture was drawn;
 * the data remain. */
bool output_picture(const char *script, const char *data, const char *png, const char *title);

#endif
