/* A sweep over a function's arguments visits every point on the desk, and every SWEEP-th on a simulated
 * target, where a point takes a thousand times as long. */
#ifndef TESTS_UNIT_SWEEP_H
#define TESTS_UNIT_SWEEP_H

#ifndef SWEEP
#define SWEEP 1
#endif

#endif
