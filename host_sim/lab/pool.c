#include "host_sim/lab/pool.h"

#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

/* Largest number of threads, including the caller's: more than the cores of any usual machine; 1 in a build
 * that counts executed lines. */
#ifndef POOL_THREADS_MAX
#define POOL_THREADS_MAX 256u
#endif

typedef struct {
    const pool_t *pool;
    atomic_size_t next; /* next piece that no thread has begun */
    pthread_mutex_t lock;
    size_t done; /* the following fields are protected by the lock */
    bool failed; /* the same */
    char *why;   /* number of the first failed piece */
} queue_t;

static void *work_off(void *argument)
{
    queue_t *queue = argument;
    const pool_t *pool = queue->pool;
    for (size_t n = atomic_fetch_add(&queue->next, 1u); n < pool->count;
         n = atomic_fetch_add(&queue->next, 1u)) {
        char why[POOL_WHY];
        const bool done = pool->piece(pool->work, n, why);
        pthread_mutex_lock(&queue->lock);
        queue->done++;
        if (done && pool->progress != NULL && !queue->failed) {
            pool->progress(pool->work, queue->done);
        }
        if (!done && !queue->failed) {
            memcpy(queue->why, why, sizeof why);
            queue->failed = true;
            atomic_store(&queue->next, pool->count); /* the threads end */
        }
        pthread_mutex_unlock(&queue->lock);
    }
    return NULL;
}

bool pool_run(const pool_t *pool, unsigned threads, char why[POOL_WHY])
{
    pthread_t helpers[POOL_THREADS_MAX];
    const unsigned most = threads < POOL_THREADS_MAX ? threads : POOL_THREADS_MAX;
    unsigned helping = 0;
    queue_t queue = {.pool = pool, .why = why};
    atomic_init(&queue.next, 0u);
    pthread_mutex_init(&queue.lock, NULL);

    while (helping + 1u < most && pthread_create(&helpers[helping], NULL, work_off, &queue) == 0) {
        helping++;
    }
    (void)work_off(&queue);
    for (unsigned n = 0; n < helping; n++) {
        pthread_join(helpers[n], NULL);
    }
    pthread_mutex_destroy(&queue.lock);
    return !queue.failed;
}
