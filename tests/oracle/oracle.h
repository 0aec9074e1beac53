/* The expected results of the plant, computed by another method: matrix exponentials (Eigen) between
 * switching instants.
 *
 * Between effective gate edges each leg is a voltage source behind a resistor, a - r i. Its a and r depend
 * only on its gates and on the region of its current (above, inside or below the zone around zero). The
 * currents then obey a linear system with constant coefficients, in which voltage or EMF rotate as further
 * states. There are three frames:
 *
 *   stationary (L_d = L_q only): the states are i, the EMF and its harmonics, and 1
 *   flux (any L_d, L_q, saturation): not a linear system. The state of a classical Runge-Kutta step is the
 *     flux linkage of the windings, magnets included, in the stationary frame, psi' = u - R i; i follows
 *     from the inverse of the flux law in closed form
 *   rotor (any L_d, L_q): the states are i, the voltage, six times the angle, and 1. If the three r differ,
 *     they are held at the middle of the step. That is of second order, 0.1 mA at 2 us, so that the step
 *     is shorter
 *
 * The instants at which a current passes a border of the zone are searched for. The speed is constant within
 * sub-steps of ORACLE_STEP and follows the torque between them; that is the only other approximation, also of
 * second order.
 *
 * Gate delays, diode logic, drops, zone, friction, load and the rule for floating legs are implemented
 * here a second time from the descriptions in plant.h, without code of the plant. A soft DC link, broken
 * phases and a forced fault are refused. There is no protection and no averaged mode. */
#ifndef TESTS_ORACLE_ORACLE_H
#define TESTS_ORACLE_ORACLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host_sim/plant/plant_params.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ORACLE_STEP       2e-6   /* [s] stationary frame */
#define ORACLE_STEP_ROTOR 0.5e-6 /* [s] in the rotor frame */

#define ORACLE_STEP_FLUX 0.5e-6 /* [s] flux */

typedef enum { ORACLE_STATIONARY, ORACLE_ROTOR, ORACLE_FLUX } oracle_frame_t;

/* All six gate commands from this tick (1/150 MHz) on: bit 2n is the upper, bit 2n + 1 the lower switch of
 * leg n. */
typedef struct {
    uint64_t tick; /* in ascending order */
    uint32_t on;   /* [-] */
} oracle_edge_t;

typedef struct {
    double i_a, i_b, i_c; /* [A] */
    double theta_m;       /* [rad] unwrapped */
    double omega_m;       /* [rad/s] */
    double torque;        /* [N m] */
} oracle_sample_t;

/* Runs from tick 0 with all gates off, no current and the rotor at theta_m [rad] and omega_m [rad/s], and
 * writes a sample for each of sample_ticks (ascending). An edge that acts at the tick of a sample does not
 * change the sample, because currents are continuous. Returns false if the parameters need something that
 * is not handled: L_d != L_q in the stationary frame, saturation outside the flux frame, or EMF harmonics
 * in the flux frame. A sub-step of ORACLE_STEP or less takes about 5 us. */
bool oracle_run(const plant_params_t *params, oracle_frame_t frame, double theta_m, double omega_m,
                const oracle_edge_t *edges, size_t edge_count, const uint64_t *sample_ticks,
                size_t sample_count, oracle_sample_t *samples);

#ifdef __cplusplus
}
#endif

#endif
