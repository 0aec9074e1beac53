/* The same work on several threads: a map or a page of figures is many rigs that know nothing of each other.
 */
#ifndef HOST_SIM_LAB_POOL_H
#define HOST_SIM_LAB_POOL_H

/* Runs `work_off(work)` on the calling thread and on up to threads - 1 more, and returns when all have come
 * back; work_off takes pieces until none is left. A thread that can not be had is done without. */
void pool_run(unsigned threads, void *(*work_off)(void *work), void *work);

#endif
