/* Brings a sensorless drive to steady state at a speed and a load, without a start. A dynamometer turns the
 * rotor until the encoder has started the estimator and the drive makes the torque of the load. Then the
 * speed control continues from this current. A load step would stall the rotor at 100 r/min. */
#ifndef HOST_SIM_LAB_DYNAMOMETER_H
#define HOST_SIM_LAB_DYNAMOMETER_H

#include <stdbool.h>

#include "host_sim/rig/rig.h"

#define DYNAMOMETER_READY 1.0 /* [s] time within which the drive measures its offsets */

/* Runs from power-on until the drive is ready. false: rig_error(). */
bool dynamometer_wait(rig_t *rig);

typedef struct {
    double speed;   /* [rad/s] mechanical */
    double load;    /* [N m] against the rotation */
    double current; /* i_q that carries the load [A] */
    bool estimate;  /* [-] control uses the estimate afterwards */
} dynamometer_t;

/* The current i_q [A] that carries load [N m] and friction [N m], with the sign of the speed and at most the
 * limit [A]. */
double dynamometer_current(double load, double friction, double torque_per_ampere, double limit,
                           double speed);

/* Call it when the drive is ready with the bridge off and the encoder as position_source. Afterwards the
 * rotor is free. false: rig_error(). */
bool dynamometer_begin(rig_t *rig, const dynamometer_t *to);

#endif
