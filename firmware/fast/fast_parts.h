/* What the files of fast.h share; nobody else. */
#ifndef FAST_FAST_PARTS_H
#define FAST_FAST_PARTS_H

#include "fast/fast.h"

/* Where the rotor is, and how fast it turns, by the source in force. */
void fast_update_rotor(fast_t *fast, const fast_tuning_t *tuning);

/* The rows of the fault table that are judged in each period. true: the encoder has been left. */
bool fast_trip(fast_t *fast, fast_orders_t orders);

/* The bridge opens; `window` [windows]: the number of the one that has the reason. */
void fast_open_bridge(fast_t *fast, uint32_t window);

#endif
