#include "host_sim/lab/names.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define PART_OF_IT (SIZE_MAX - 1u) /* distance of a name that has the given one as a part */
#define NOT_NEAR   SIZE_MAX

/* Converts ASCII letters only, independent of the locale. */
static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

size_t names_distance(const char *a, const char *b)
{
    const size_t a_length = strlen(a);
    const size_t b_length = strlen(b);
    if (a_length > NAMES_LENGTH_MAX || b_length > NAMES_LENGTH_MAX) {
        return NOT_NEAR;
    }
    /* rows i - 2, i - 1, i of the table of distances between the first i of a and the first j of b */
    size_t rows[3][NAMES_LENGTH_MAX + 1u];
    for (size_t j = 0; j <= b_length; j++) {
        rows[0][j] = j;
    }
    for (size_t i = 1; i <= a_length; i++) {
        size_t *now = rows[i % 3u];
        const size_t *before = rows[(i + 2u) % 3u];
        const size_t *two_before = rows[(i + 1u) % 3u];
        now[0] = i;
        for (size_t j = 1; j <= b_length; j++) {
            const bool same = lower(a[i - 1u]) == lower(b[j - 1u]);
            now[j] = least(least(before[j] + 1u, now[j - 1u] + 1u), before[j - 1u] + (same ? 0u : 1u));
            if (i > 1u && j > 1u && lower(a[i - 1u]) == lower(b[j - 2u]) &&
                lower(a[i - 2u]) == lower(b[j - 1u])) {
                now[j] = least(now[j], two_before[j - 2u] + 1u);
            }
        }
    }
    return rows[a_length % 3u][b_length];
}

/* True if the longer name begins or ends with the shorter one, up to a '_' or '.'. */
static bool is_part(const char *shorter, const char *longer)
{
    const size_t length = strlen(shorter);
    const size_t rest = strlen(longer) - length;
    if (length < 3u || strlen(longer) <= length) {
        return false;
    }
    const bool first =
        strncmp(longer, shorter, length) == 0 && (longer[length] == '_' || longer[length] == '.');
    const bool last =
        strcmp(longer + rest, shorter) == 0 && (longer[rest - 1u] == '_' || longer[rest - 1u] == '.');
    return first || last;
}

names_search_t names_search(const char *name)
{
    names_search_t search = {.name = "", .found = "", .distance = NOT_NEAR};
    if (strlen(name) <= NAMES_LENGTH_MAX) {
        snprintf(search.name, sizeof search.name, "%s", name);
    }
    return search;
}

static size_t judge(const char *name, const char *candidate)
{
    const size_t distance = names_distance(name, candidate);
    const size_t longer = strlen(name) > strlen(candidate) ? strlen(name) : strlen(candidate);
    if (name[0] == '\0' || distance == NOT_NEAR) {
        return NOT_NEAR;
    }
    if (3u * distance <= longer) {
        return distance;
    }
    return is_part(name, candidate) ? PART_OF_IT : NOT_NEAR;
}

void names_consider(names_search_t *search, const char *candidate)
{
    const size_t distance = judge(search->name, candidate);
    if (distance < search->distance) {
        search->distance = distance;
        snprintf(search->found, sizeof search->found, "%s", candidate);
    }
}

void names_consider_table(names_search_t *search, const table_t *table)
{
    for (uint32_t n = 0; n < table->count; n++) {
        names_consider(search, table->rows[n].name);
    }
}

void names_consider_choices(names_search_t *search, const char *choices)
{
    while (*choices != '\0') {
        char choice[NAMES_LENGTH_MAX + 1u];
        const size_t length = strcspn(choices, "|");
        snprintf(choice, sizeof choice, "%.*s", (int)least(length, NAMES_LENGTH_MAX), choices);
        names_consider(search, choice);
        choices += length + (choices[length] == '|' ? 1u : 0u);
    }
}

const char *names_found(const names_search_t *search)
{
    return search->found[0] != '\0' ? search->found : NULL;
}
