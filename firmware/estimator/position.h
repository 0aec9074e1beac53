/* Where the rotor is and how fast it turns, electrical: what every source of position gives and every user
 * takes.
 *
 * Both belong to the same instant, t_k of the period in which they were made. theta_e is the angle of the d
 * axis (the magnet's flux) seen from phase a, in [-pi, pi); mechanical values are these divided by the pole
 * pairs. */
#ifndef ESTIMATOR_POSITION_H
#define ESTIMATOR_POSITION_H

typedef struct {
    float theta_e; /* [rad], electrical, [-pi, pi) */
    float omega_e; /* [rad/s], electrical */
} position_t;

#endif
