/* Declarations that only the source files of fast.h use. */
#ifndef FAST_FAST_PARTS_H
#define FAST_FAST_PARTS_H

#include "fast/fast.h"

/* Updates the rotor's position and speed from the present source. */
void fast_update_rotor(fast_t *fast, const fast_tuning_t *tuning);

/* Evaluates the rows of the fault table of each period. true: control has left the encoder. */
bool fast_trip(fast_t *fast, fast_orders_t orders);

/* A period with the bridge off. */
void fast_rest(fast_t *fast, fast_orders_t orders, const drive_samples_t *samples);

/* Opens the bridge; `window` [windows] is the number of the window that contains the reason. */
void fast_open_bridge(fast_t *fast, uint32_t window);

/* The duties of an excitation, in place of current control. */
abc_t fast_excite(fast_t *fast, fast_orders_t orders);

#endif
