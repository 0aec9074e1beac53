/* The same work on several threads: a map or a report consists of many independent rigs.
 */
#ifndef HOST_SIM_LAB_POOL_H
#define HOST_SIM_LAB_POOL_H

#include <stdbool.h>
#include <stddef.h>

#define POOL_WHY 320u

typedef struct {
    size_t count; /* [-] pieces */
    /* Does piece n; false: `why` gets the message, one line. */
    bool (*piece)(void *work, size_t n, char why[POOL_WHY]);
    /* Called after each piece, by one thread at a time; may be NULL. */
    void (*progress)(void *work, size_t done);
    void *work; /* context of both functions */
} pool_t;

/* Does all pieces in ascending order, on the calling thread and on up to threads - 1 more, or fewer if the
 * system does not provide them. false: a piece failed; `why` has the message of the first one, and the
 * remaining pieces were not begun. */
bool pool_run(const pool_t *pool, unsigned threads, char why[POOL_WHY]);

#endif
