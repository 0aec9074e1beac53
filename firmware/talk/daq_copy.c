#include "talk/daq.h"

/* The background may read the queue at any time: it reads the present value of `put`. */
static void copy(daq_t *daq, uint32_t number, const void *base, uint32_t period)
{
    const daq_list_t *list = &daq->list[number];
    if (daq->put - daq->got >= DAQ_CELLS) {
        daq->lost++;
        return;
    }
    daq_cell_t *cell = &daq->cells[daq->put % DAQ_CELLS];
    const uint32_t *offset = &daq->slots[list->first];
    cell->list = number;
    cell->stamp = period;
    for (uint32_t n = 0; n < list->entries; n++) {
        cell->slots[n] = tap_slot_at(base, (size_t)offset[n]);
    }
    daq->put++;
}

void daq_copy(daq_t *daq, const void *base, uint32_t period)
{
    for (uint32_t n = 0; n < DAQ_LISTS; n++) {
        daq_list_t *list = &daq->list[n];
        if ((daq->running >> n & 1u) != 0u) {
            list->countdown--;
            if (list->countdown == 0u) {
                list->countdown = list->prescaler;
                copy(daq, n, base, period);
            }
        }
    }
}
