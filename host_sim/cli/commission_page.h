/* The page of `lagless commission --plot`: the measured points as curves, beside the values that follow from
 * them. tools/plot/commission.py draws it. */
#ifndef HOST_SIM_CLI_COMMISSION_PAGE_H
#define HOST_SIM_CLI_COMMISSION_PAGE_H

#include <stdbool.h>

#include "host_sim/cli/commission_talk.h"

typedef struct {
    const char *of; /* the scenario or the drive, for the title */
    const commission_plate_t *plate;
    const commission_sheet_t *sheet;
    const commission_result_t *result;
} commission_page_t;

/* Makes the folder (*folder NULL: a new one below runs, whose name is returned in it), and returns whether
 * commission.KIND of all formats, "html,png", may be written there. The message is on stderr. */
bool commission_page_folder(const char **folder, const char *formats);

/* Draws the page into the folder. Returns an exit code; messages and the names of the files are on stderr. */
int commission_page_draw(const commission_page_t *page, const char *folder, const char *formats);

#endif
