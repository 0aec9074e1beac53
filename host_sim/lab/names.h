/* Finds the candidate that is nearest to a wrong name, by the Damerau-Levenshtein distance (optimal string
 * alignment: a swapped pair counts once), without regard to upper and lower case.
 *
 *     names_search_t search = names_search("moter_resistance");
 *     for each candidate: names_consider(&search, candidate);
 *     names_found(&search)   gives "motor_resistance", or NULL
 *
 * A candidate is near if the distance is at most a third of the longer name. If there is none, a candidate
 * that begins or ends with the given name at a word boundary is used ("torque" for "load_torque"). Of equally
 * near candidates the first one is used. */
#ifndef HOST_SIM_LAB_NAMES_H
#define HOST_SIM_LAB_NAMES_H

#include <stddef.h>

#include "contract/table.h"

#define NAMES_LENGTH_MAX 63u /* [chars] longer names are not compared */

typedef struct {
    char name[NAMES_LENGTH_MAX + 1u];  /* the wrong name; "" if it is too long */
    char found[NAMES_LENGTH_MAX + 1u]; /* nearest candidate until now; "": none */
    size_t distance;                   /* [-] of `found` */
} names_search_t;

names_search_t names_search(const char *name);
void names_consider(names_search_t *search, const char *candidate);
void names_consider_table(names_search_t *search, const table_t *table);  /* names of all rows */
void names_consider_choices(names_search_t *search, const char *choices); /* "off|on|quick_stop" */

/* The nearest name, valid as long as the search; NULL: none is near. */
const char *names_found(const names_search_t *search);

/* Distance of two names; SIZE_MAX if one is longer than NAMES_LENGTH_MAX. */
size_t names_distance(const char *a, const char *b);

#endif
