/* Runs the copy of samples by the interrupt on a simulated target, where tools/cost counts the instructions:
 * three floats as over the serial line, twelve as over TCP, and the largest request of two lists that are due
 * in the same period. Exit status: 0 if the queue contained all samples. */
#include <stdio.h>
#include <string.h>

#include "talk/daq.h"

#define PERIODS 3u

static daq_t daq;
static uint32_t slots[DAQ_ENTRIES];

/* Lists of this number of entries each, in one table per list; then some periods, in which the background
 * sends all samples.
 */
static bool sample(uint32_t lists, uint32_t entries)
{
    uint16_t packet[5u + 4u * DAQ_ENTRIES];
    bool good = true;
    daq_clear(&daq);
    good = daq_alloc_lists(&daq, lists) == DAQ_DONE;
    for (uint32_t n = 0; n < lists; n++) {
        good = daq_alloc_odts(&daq, n, 1u) == DAQ_DONE && good;
    }
    for (uint32_t n = 0; n < lists; n++) {
        good = daq_alloc_entries(&daq, n, 0u, entries) == DAQ_DONE && good;
    }
    for (uint32_t n = 0; n < lists * entries; n++) {
        const uint32_t offset = (uint32_t)((const char *)&slots[n] - (const char *)slots);
        good = daq_write(&daq, n / entries, 0u, n % entries, offset) == DAQ_DONE && good;
    }
    good = daq_start(&daq, (UINT32_C(1) << lists) - 1u) == DAQ_DONE && good;
    for (uint32_t period = 1u; period <= PERIODS; period++) {
        daq_sample(&daq, slots, period);
        for (uint32_t n = 0; n < lists; n++) {
            good = daq_next(&daq, daq.put, packet) == 5u + 4u * entries && good;
        }
    }
    return good && daq.lost == 0u && daq_next(&daq, daq.put, packet) == 0u;
}

int main(void)
{
    for (uint32_t n = 0; n < DAQ_ENTRIES; n++) {
        slots[n] = n;
    }
    const bool few = sample(1u, 3u);
    const bool many = sample(1u, 12u);
    const bool most = sample(DAQ_LISTS, DAQ_ENTRIES / DAQ_LISTS);
    printf("%s\n", few && many && most ? "copied" : "lost");
    return few && many && most ? 0 : 1;
}
