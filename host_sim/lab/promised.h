/* What is promised of a fault that shows in currents or angle, to those who judge it: in the matrix cell by
 * cell, in a campaign run by run. */
#ifndef HOST_SIM_LAB_PROMISED_H
#define HOST_SIM_LAB_PROMISED_H

#define PROMISED_CURRENT 25.0        /* [A] what no phase may ever carry, with the pm50rl1a060's board */
#define PROMISED_NOTICE  20e-3       /* [s] it is noticed by then, or ... */
#define PROMISED_TURN    (1.0 / 3.0) /* [-] ... in so much of an electrical turn, whichever is longer */

#endif
