/* A recording as panels: one page, PNG, SVG. tools/plot/look.py draws them. */
#ifndef HOST_SIM_CLI_PLOT_H
#define HOST_SIM_CLI_PLOT_H

#include <stdbool.h>

/* Is it a list of these, separated by commas? false: said why on stderr, as `lagless COMMAND`. */
bool plot_formats(const char *command, const char *formats);

/* Draws the recording (CSV or MAT) to folder/<its name>.html and so on; "NAME_fault.csv" beside it comes
 * along. folder NULL: beside the recording; quiet: does not tell where they are. Returns an exit code; what
 * went wrong was said on stderr. */
int plot_draw(const char *command, const char *recording, const char *folder, const char *formats,
              bool quiet);

#endif
