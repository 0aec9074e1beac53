#include "host_sim/lab/pool.h"

#include <pthread.h>

/* More than any machine that this runs on has cores. */
#define THREADS_MAX 256u

void pool_run(unsigned threads, void *(*work_off)(void *work), void *work)
{
    pthread_t helpers[THREADS_MAX];
    unsigned helping = 0;
    while (helping + 1u < threads && helping < THREADS_MAX &&
           pthread_create(&helpers[helping], NULL, work_off, work) == 0) {
        helping++;
    }
    (void)work_off(work);
    for (unsigned n = 0; n < helping; n++) {
        pthread_join(helpers[n], NULL);
    }
}
