/* A sweep over a function's arguments visits every point on the desk, every seventh under the sanitizers, and
 * every SWEEP-th on a simulated target, where a point takes a thousand times as long. */
#ifndef TESTS_UNIT_SWEEP_H
#define TESTS_UNIT_SWEEP_H

#ifndef SWEEP
#define SWEEP 1
#endif

/* Of a loop with few but long points a target visits every seventh. */
#define SWEEP_FEW (SWEEP == 1 ? 1 : 7)

#endif
