/* A sweep over a function's arguments visits every point on the host, every seventh under the sanitizers, and
 * every SWEEP-th on a simulated target, where a point takes a thousand times as long: on the one with an FPU
 * every 499th, on the other one every 4999th. */
#ifndef TESTS_UNIT_SWEEP_H
#define TESTS_UNIT_SWEEP_H

#ifndef SWEEP
#define SWEEP 1
#endif

/* Of a loop with few but long points the sanitizers and the target with an FPU visit every seventh, the other
 * target every 29th; with many long ones the sanitizers visit every 49th. */
#define SWEEP_FEW  (SWEEP == 1 ? 1 : SWEEP < 1000 ? 7 : 29)
#define SWEEP_LONG (SWEEP == 7 ? 49 : SWEEP)

#endif
