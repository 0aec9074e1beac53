#include "talk/daq.h"

#include <string.h>

void daq_clear(daq_t *daq)
{
    const uint32_t lost = daq->lost;
    daq->running = 0u;
    memset(daq, 0, sizeof *daq);
    daq->lost = lost;
    daq->told = lost;
    for (uint32_t n = 0; n < DAQ_ENTRIES; n++) {
        daq->offsets[n] = DAQ_NO_OFFSET;
    }
}

daq_result_t daq_alloc_lists(daq_t *daq, uint32_t count)
{
    if (daq->running != 0u) {
        return DAQ_ACTIVE;
    }
    if (daq->stage != (uint32_t)DAQ_FREE) {
        return DAQ_SEQUENCE;
    }
    if (count > DAQ_LISTS) {
        return DAQ_OVERFLOW;
    }
    daq->lists = count;
    daq->stage = (uint32_t)DAQ_HAS_LISTS;
    for (uint32_t n = 0; n < count; n++) {
        daq->list[n].prescaler = 1u;
    }
    return DAQ_DONE;
}

daq_result_t daq_alloc_odts(daq_t *daq, uint32_t list, uint32_t count)
{
    if (daq->running != 0u) {
        return DAQ_ACTIVE;
    }
    if (daq->stage != (uint32_t)DAQ_HAS_LISTS && daq->stage != (uint32_t)DAQ_HAS_ODTS) {
        return DAQ_SEQUENCE;
    }
    if (list >= daq->lists) {
        return DAQ_OUT_OF_RANGE;
    }
    if (daq->list[list].odts != 0u) {
        return DAQ_SEQUENCE;
    }
    if (count > DAQ_ODTS - daq->odts_used) {
        return DAQ_OVERFLOW;
    }
    daq->list[list].odt_first = daq->odts_used;
    daq->list[list].odts = count;
    daq->odts_used += count;
    daq->stage = (uint32_t)DAQ_HAS_ODTS;
    return DAQ_DONE;
}

daq_result_t daq_alloc_entries(daq_t *daq, uint32_t list, uint32_t odt, uint32_t count)
{
    if (daq->running != 0u) {
        return DAQ_ACTIVE;
    }
    if (daq->stage != (uint32_t)DAQ_HAS_ODTS && daq->stage != (uint32_t)DAQ_HAS_ENTRIES) {
        return DAQ_SEQUENCE;
    }
    if (list >= daq->lists || odt >= daq->list[list].odts) {
        return DAQ_OUT_OF_RANGE;
    }
    daq_odt_t *table = &daq->odt[daq->list[list].odt_first + odt];
    if (table->entries != 0u) {
        return DAQ_SEQUENCE;
    }
    if (count > DAQ_ENTRIES - daq->entries_used) {
        return DAQ_OVERFLOW;
    }
    table->first = daq->entries_used;
    table->entries = count;
    daq->entries_used += count;
    daq->stage = (uint32_t)DAQ_HAS_ENTRIES;
    return DAQ_DONE;
}

bool daq_has_entry(const daq_t *daq, uint32_t list, uint32_t odt, uint32_t entry)
{
    return list < daq->lists && odt < daq->list[list].odts &&
           entry < daq->odt[daq->list[list].odt_first + odt].entries;
}

daq_result_t daq_write(daq_t *daq, uint32_t list, uint32_t odt, uint32_t entry, uint32_t offset)
{
    if (!daq_has_entry(daq, list, odt, entry)) {
        return DAQ_OUT_OF_RANGE;
    }
    if ((daq->running >> list & 1u) != 0u) {
        return DAQ_ACTIVE;
    }
    daq->offsets[daq->odt[daq->list[list].odt_first + odt].first + entry] = offset;
    return DAQ_DONE;
}

daq_result_t daq_set_prescaler(daq_t *daq, uint32_t list, uint32_t prescaler)
{
    if (list >= daq->lists || prescaler > 255u) {
        return DAQ_OUT_OF_RANGE;
    }
    if ((daq->running >> list & 1u) != 0u) {
        return DAQ_ACTIVE;
    }
    daq->list[list].prescaler = prescaler > 0u ? prescaler : 1u; /* the standard defines that 0 means 1 */
    return DAQ_DONE;
}

daq_result_t daq_select(daq_t *daq, uint32_t list)
{
    if (list >= daq->lists) {
        return DAQ_OUT_OF_RANGE;
    }
    daq->list[list].selected = 1u;
    return DAQ_DONE;
}

uint32_t daq_selected(const daq_t *daq)
{
    uint32_t lists = 0u;
    for (uint32_t n = 0; n < DAQ_LISTS; n++) {
        lists |= daq->list[n].selected << n;
    }
    return lists;
}

/* Places its entries one after the other, starting here; false: an entry has no
 * slot, or there are no entries. */
static bool lay_out(daq_t *daq, daq_list_t *list, uint32_t first)
{
    list->first = first;
    list->entries = 0u;
    for (uint32_t n = 0; n < list->odts; n++) {
        const daq_odt_t *odt = &daq->odt[list->odt_first + n];
        for (uint32_t m = 0; m < odt->entries; m++) {
            const uint32_t offset = daq->offsets[odt->first + m];
            if (offset == DAQ_NO_OFFSET) {
                return false;
            }
            daq->slots[first + list->entries] = offset;
            list->entries++;
        }
    }
    return list->entries != 0u;
}

daq_result_t daq_start(daq_t *daq, uint32_t lists)
{
    const uint32_t anew = lists & ~daq->running;
    uint32_t first = 0u;
    for (uint32_t n = 0; n < DAQ_LISTS; n++) {
        daq_list_t *list = &daq->list[n];
        if ((anew >> n & 1u) != 0u) {
            if (n >= daq->lists) {
                return DAQ_OUT_OF_RANGE;
            }
            if (!lay_out(daq, list, first)) {
                return DAQ_INCOMPLETE;
            }
            list->countdown = 1u;
        }
        /* each list has a place of its own, even if it does not run: a running list is not moved */
        for (uint32_t m = 0; m < list->odts; m++) {
            first += daq->odt[list->odt_first + m].entries;
        }
    }
    for (uint32_t n = 0; n < DAQ_LISTS; n++) {
        daq->list[n].selected &= ~(lists >> n) & 1u;
    }
    daq->running |= anew; /* a single store: from here on the interrupt copies */
    return DAQ_DONE;
}

void daq_stop(daq_t *daq, uint32_t lists)
{
    daq->running &= ~lists;
    for (uint32_t n = 0; n < DAQ_LISTS; n++) {
        daq->list[n].selected &= ~(lists >> n) & 1u;
    }
}

/* 32 bits as four octets, the lowest first. */
static uint32_t put(uint16_t *octets, uint32_t bits)
{
    for (uint32_t n = 0; n < 4u; n++) {
        octets[n] = (uint16_t)(bits >> (8u * n) & 0xFFu);
    }
    return 4u;
}

uint32_t daq_next(daq_t *daq, uint32_t written, uint16_t *octets)
{
    if (written == daq->got) {
        return 0u;
    }
    const daq_cell_t *cell = &daq->cells[daq->got % DAQ_CELLS];
    const daq_list_t *list = &daq->list[cell->list];
    const daq_odt_t *odt = &daq->odt[list->odt_first];
    uint32_t slot = 0u;
    for (uint32_t n = 0; n < daq->next_odt; n++) {
        slot += odt[n].entries;
    }
    uint32_t count = 1u;
    octets[0] = (uint16_t)(list->odt_first + daq->next_odt);
    if (daq->next_odt == 0u) {
        count += put(&octets[count], cell->stamp);
    }
    for (uint32_t n = 0; n < odt[daq->next_odt].entries; n++) {
        count += put(&octets[count], cell->slots[slot + n]);
    }
    daq->next_odt++;
    if (daq->next_odt >= list->odts) {
        daq->next_odt = 0u;
        daq->got++; /* last statement: from here on the interrupt may write there again */
    }
    return count;
}

bool daq_overloaded(daq_t *daq, uint32_t lost)
{
    const bool overloaded = lost != daq->told;
    daq->told = lost;
    return overloaded;
}
