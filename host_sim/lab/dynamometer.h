/* How a sensorless drive is brought to a speed and a load in steady state, without a start: a dynamometer
 * turns the rotor until the encoder, which starts the estimator, has followed and the drive gives the torque
 * that the load asks for; then the speed control takes over from this current. A load that fell on the rotor
 * all at once would stall it at 100 r/min. */
#ifndef HOST_SIM_LAB_DYNAMOMETER_H
#define HOST_SIM_LAB_DYNAMOMETER_H

#include <stdbool.h>

#include "host_sim/rig/rig.h"

#define DYNAMOMETER_READY 1.0 /* [s] offsets are measured by then, or never */

/* From power-on until the drive is ready. false: rig_error(). */
bool dynamometer_wait(rig_t *rig);

typedef struct {
    double speed;   /* [rad/s] mechanical */
    double load;    /* [N m] against the rotation */
    double current; /* i_q that holds it [A] */
    bool estimate;  /* [-] control turns with it from then on */
} dynamometer_t;

/* The current i_q [A] that holds load [N m] and friction [N m] besides: no more than the limit [A], and with
 * the sign of the speed. */
double dynamometer_current(double load, double friction, double torque_per_ampere, double limit,
                           double speed);

/* The rig's drive is ready, the bridge off, position_source the encoder. The rotor is free afterwards. false:
 * rig_error(). */
bool dynamometer_begin(rig_t *rig, const dynamometer_t *to);

#endif
