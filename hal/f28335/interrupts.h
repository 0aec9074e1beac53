/* PIE and CPU interrupts, SPRUFB0 ch. 6: INT1.1 SEQ1INT (end of the conversions), INT2.n of the leading
 * ePWMn (trip), INT9.1 SCIRXINTA (octets that came) and INT14, raised by software (medium task), all straight
 * to the application's functions. INT14 does not pass the PIE, so that the medium task can be interrupted
 * without touching PIEIER and PIEACK. Every other vector shuts the gates and returns, its group
 * unacknowledged: nothing else is enabled, so it can only be a trap or a fault of the chip. */
#ifndef HAL_F28335_INTERRUPTS_H
#define HAL_F28335_INTERRUPTS_H

#include "hal/hal.h"

#define INTERRUPTS_SAMPLE 1u /* PIE group */
#define INTERRUPTS_TRIP   2u
#define INTERRUPTS_SERIAL 9u
#define INTERRUPTS_MEDIUM 14u /* of the CPU: that of timer 2, whose own interrupt stays off */

/* Vectors and enables; INTM stays set. */
void interrupts_init(const hal_config_t *config);

/* The group may interrupt again. Last access of an interrupt function. */
void interrupts_acknowledge(uint16_t group);

#endif
