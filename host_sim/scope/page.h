/* The page. Its parts are in the program; uPlot is read from a file (tools/get-uplot). */
#ifndef HOST_SIM_SCOPE_PAGE_H
#define HOST_SIM_SCOPE_PAGE_H

#include <stddef.h>

/* The whole page; the caller frees it. uPlot is searched in $UPLOT_DIR, then in the cache ($XDG_CACHE_HOME or
 * ~/.cache)/lagless/uplot. NULL: *why, one line. */
char *page_make(size_t *octets, char *why, size_t size);

#endif
