/* The name that was meant: nearest by Damerau-Levenshtein distance (optimal string alignment: a swapped pair
 * counts once), upper and lower case alike.
 *
 *     names_search_t search = names_search("moter_resistance");
 *     for each candidate: names_consider(&search, candidate);
 *     names_found(&search)   gives "motor_resistance", or NULL
 *
 * A candidate is near if the distance is at most a third of the longer name. If none is, one that begins or
 * ends with the given name, at a word's border, is taken ("torque" for "load_torque"). Of equals the first
 * wins. */
#ifndef HOST_SIM_LAB_NAMES_H
#define HOST_SIM_LAB_NAMES_H

#include <stddef.h>

#include "contract/table.h"

#define NAMES_LENGTH_MAX 63u /* [chars] longer names are near to nothing */

typedef struct {
    char name[NAMES_LENGTH_MAX + 1u];  /* that was given; "" if it is too long */
    char found[NAMES_LENGTH_MAX + 1u]; /* nearest so far; "": none */
    size_t distance;                   /* [-] of `found` */
} names_search_t;

names_search_t names_search(const char *name);
void names_consider(names_search_t *search, const char *candidate);
void names_consider_table(names_search_t *search, const table_t *table);  /* names of all rows */
void names_consider_choices(names_search_t *search, const char *choices); /* "off|on|quick_stop" */

/* NULL: none is near. Valid as long as the search is. */
const char *names_found(const names_search_t *search);

/* Edits from one name to the other; SIZE_MAX if one is longer than NAMES_LENGTH_MAX. */
size_t names_distance(const char *a, const char *b);

#endif
