/* A recording as panels: one page, PNG, SVG. tools/plot/look.py draws them. */
#ifndef HOST_SIM_CLI_PLOT_H
#define HOST_SIM_CLI_PLOT_H

#include <stdbool.h>

/* true: `formats` is a list of html, png, svg, separated by commas. false: the message of `lagless COMMAND`
 * is on stderr. */
bool plot_formats(const char *command, const char *formats);

/* Draws the recording (CSV or MAT) to folder/<its name>.html and so on, together with "NAME_fault.csv" if
 * this exists. folder = NULL: the folder of the recording; quiet: the names of the files are not printed.
 * Returns an exit code; messages are on stderr. */
int plot_draw(const char *command, const char *recording, const char *folder, const char *formats,
              bool quiet);

#endif
