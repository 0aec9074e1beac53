/* Promises about faults that affect currents or angle. The matrix checks them in each cell, and the campaign
 * in each run. */
#ifndef HOST_SIM_LAB_PROMISED_H
#define HOST_SIM_LAB_PROMISED_H

#define PROMISED_CURRENT 25.0        /* [A] largest phase current with the board pm50rl1a060 */
#define PROMISED_NOTICE  20e-3       /* [s] time within which a fault is detected, or ... */
#define PROMISED_TURN    (1.0 / 3.0) /* [-] ... share of an electrical turn, whichever is longer */

#endif
