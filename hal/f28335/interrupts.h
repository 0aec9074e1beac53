/* PIE and CPU interrupts, SPRUFB0 ch. 6: INT1.1 SEQ1INT (end of the conversions), INT2.n of the leading
 * ePWMn (trip), INT9.1 SCIRXINTA (received octets) and INT14, raised by software (medium task). All call the
 * application's functions directly. INT14 does not pass the PIE, so that the medium task can be interrupted
 * without a change of PIEIER and PIEACK. Every other vector switches the gates off and returns without an
 * acknowledge of its group: no other interrupt is enabled, so its cause can only be a trap or a fault of the
 * chip. */
#ifndef HAL_F28335_INTERRUPTS_H
#define HAL_F28335_INTERRUPTS_H

#include "hal/hal.h"

#define INTERRUPTS_SAMPLE 1u /* PIE group */
#define INTERRUPTS_TRIP   2u
#define INTERRUPTS_SERIAL 9u
#define INTERRUPTS_MEDIUM 14u /* CPU interrupt of timer 2, whose own request stays off */

/* Sets vectors and enables; INTM remains set. */
void interrupts_init(const hal_config_t *config);

/* Acknowledges the group, which can interrupt again. It is the last access of an interrupt function. */
void interrupts_acknowledge(uint16_t group);

#endif
