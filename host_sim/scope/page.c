#include "host_sim/scope/page.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Made from host_sim/scope/page/ by scope.cmake. */
extern const unsigned char page_html[], page_css[], page_js[];

#define PATH_MAX_HERE 4096

static char *read_whole(const char *path)
{
    char *text = NULL;
    size_t octets = 0;
    FILE *from = fopen(path, "rb");
    FILE *to = from != NULL ? open_memstream(&text, &octets) : NULL;
    char piece[4096];
    if (from == NULL || to == NULL) {
        if (from != NULL) {
            fclose(from);
        }
        return NULL;
    }
    for (size_t n = fread(piece, 1, sizeof piece, from); n > 0u; n = fread(piece, 1, sizeof piece, from)) {
        fwrite(piece, 1, n, to);
    }
    const int failed = ferror(from);
    fclose(from);
    if (fclose(to) != 0 || failed != 0) {
        free(text);
        return NULL;
    }
    return text;
}

static char *read_uplot(const char *file)
{
    char path[PATH_MAX_HERE];
    const char *folder = getenv("UPLOT_DIR");
    const char *cache = getenv("XDG_CACHE_HOME");
    const char *home = getenv("HOME");
    char *text = NULL;
    if (folder != NULL && folder[0] != '\0') {
        snprintf(path, sizeof path, "%s/%s", folder, file);
        text = read_whole(path);
    }
    if (text == NULL && cache != NULL && cache[0] != '\0') {
        snprintf(path, sizeof path, "%s/lagless/uplot/%s", cache, file);
        text = read_whole(path);
    } else if (text == NULL && home != NULL) {
        snprintf(path, sizeof path, "%s/.cache/lagless/uplot/%s", home, file);
        text = read_whole(path);
    }
    return text;
}

/* The text of the page, in which each {{name}} is replaced by the part with this name. */
static char *put_together(const char *uplot_style, const char *uplot_script, const char *licence,
                          size_t *octets)
{
    const struct {
        const char *name, *text;
    } parts[] = {{"{{uplot_style}}", uplot_style},
                 {"{{style}}", (const char *)page_css},
                 {"{{uplot_script}}", uplot_script},
                 {"{{script}}", (const char *)page_js},
                 {"{{licence}}", licence}};
    char *text = NULL;
    FILE *to = open_memstream(&text, octets);
    if (to == NULL) {
        return NULL;
    }
    const char *from = (const char *)page_html;
    for (const char *mark = strstr(from, "{{"); mark != NULL; mark = strstr(from, "{{")) {
        fwrite(from, 1, (size_t)(mark - from), to);
        from = mark + 2;
        for (size_t n = 0; n < sizeof parts / sizeof parts[0]; n++) {
            if (strncmp(mark, parts[n].name, strlen(parts[n].name)) == 0) {
                fputs(parts[n].text, to);
                from = mark + strlen(parts[n].name);
            }
        }
    }
    fputs(from, to);
    if (fclose(to) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

char *page_make(size_t *octets, char *why, size_t size)
{
    char *style = read_uplot("uPlot.min.css");
    char *script = read_uplot("uPlot.iife.min.js");
    char *licence = read_uplot("LICENSE");
    char *page = NULL;
    if (style == NULL || script == NULL || licence == NULL) {
        snprintf(
            why, size,
            "uPlot, which draws the page's plots, is missing: run tools/get-uplot, or set UPLOT_DIR to a "
            "folder with its files");
    } else {
        page = put_together(style, script, licence, octets);
        if (page == NULL) {
            snprintf(why, size, "the page: %s", strerror(errno));
        }
    }
    free(style);
    free(script);
    free(licence);
    return page;
}
