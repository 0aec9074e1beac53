/* Position and speed of the rotor, electrical: the result of every source of position.
 *
 * Both belong to the same time, t_k of the period in which they were computed. theta_e is the angle of the d
 * axis (the flux of the magnet) relative to phase a, in [-pi, pi); mechanical values are these divided by the
 * pole pairs. */
#ifndef ESTIMATOR_POSITION_H
#define ESTIMATOR_POSITION_H

typedef struct {
    float theta_e; /* [rad], electrical, [-pi, pi) */
    float omega_e; /* [rad/s], electrical */
} position_t;

#endif
