/* A sweep visits the values of a function's arguments in steps of SWEEP. The step is 1 on the host and 7
 * under the sanitizers. On a simulated target, where a point takes a thousand times as long, it is 499
 * with an FPU and 4999 without one. */
#ifndef TESTS_UNIT_SWEEP_H
#define TESTS_UNIT_SWEEP_H

#ifndef SWEEP
#define SWEEP 1
#endif

/* SWEEP_FEW is the step of a loop with few but long points: 7 under the sanitizers and on the target with
 * an FPU, 29 on the other target. SWEEP_LONG, for many long points, is 49 under the sanitizers. */
#define SWEEP_FEW  (SWEEP == 1 ? 1 : SWEEP < 1000 ? 7 : 29)
#define SWEEP_LONG (SWEEP == 7 ? 49 : SWEEP)

#endif
