/* The page: its parts are in the program, uPlot (tools/get-uplot) is read where it is found. */
#ifndef HOST_SIM_SCOPE_PAGE_H
#define HOST_SIM_SCOPE_PAGE_H

#include <stddef.h>

/* The whole page, to be freed. uPlot is looked for in $UPLOT_DIR, then in the cache ($XDG_CACHE_HOME or
 * ~/.cache)/lagless/uplot. NULL: *why, one line. */
char *page_make(size_t *octets, char *why, size_t size);

#endif
