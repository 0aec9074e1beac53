/* Theory of the paper's loops and observers: in double, from the equations, independent of the
 * firmware.
 *
 * The rig is Table I's, with the inertia and the friction that the paper's accelerations imply (erratum 13).
 * Angles [rad], electrical; periods are the paper's. */
#ifndef HOST_SIM_LAB_PAPER_THEORY_H
#define HOST_SIM_LAB_PAPER_THEORY_H

#include <stdbool.h>
#include <stdint.h>

#define PAPER_PERIOD_TICKS UINT64_C(15000) /* [1/150 MHz] the paper's PWM has 10 kHz */

typedef struct {
    double pole_pairs;    /* [-] */
    double resistance;    /* R [ohm] */
    double inductance;    /* L [H] */
    double flux_linkage;  /* psi_f [Wb] */
    double inertia;       /* of all that turns [kg m^2] */
    double friction;      /* dry [N m] */
    double current_limit; /* of the speed control [A] */
} paper_machine_t;

extern const paper_machine_t paper_machine;

/* ---- PLL ---- */

/* k_p [rad/s], k_i [rad/s^2] of the loop (22) with damping 1 and this -3 dB bandwidth [rad/s]. false: there
 * is no such loop, because omega_c is too large. */
bool paper_loop(double bandwidth, double omega_c, double *kp, double *ki);

/* Gain [-] and phase [rad] of this loop's filter k_p + k_i/s at omega [rad/s]. There must be such a loop. */
void paper_loop_filter(double bandwidth, double omega_c, double omega, double *gain, double *phase);

/* Error of a conventional loop that tracks this electrical acceleration [rad/s^2]: (20) with the detector's
 * sine. NAN: the loop cannot track it. */
double paper_tracking_error(double ki, double acceleration);

/* The same at the current limit, where the error reduces the torque: k_i sin e = (p/J) (T_m cos e + braking).
 * `braking` is the torque of friction and load [N m], positive while decelerating and negative while
 * accelerating. NAN: there is no such error. */
double paper_tracking_error_at_limit(double ki, double braking);

/* ---- observer ---- */

/* f(x) = tanh(x/2), x in amperes, and f(x)/x [1/A] of eq. (12); the sign's is capped at 10^6. */
double paper_sigmoid(double x);
double paper_sigmoid_gain(double x);
double paper_sign_gain(double x);

/* Lag of the sampled observer with one sigmoid per axis and no filter, negative for positive omega_e [rad/s]:
 * k_f by its describing function, voltages held over a period. */
double paper_lag_sampled(double gain, double slope, double omega_e);

/* Eq. (14) with (13) as printed and the same k_f. */
double paper_lag_printed(double gain, double slope, double omega_e);

#endif
