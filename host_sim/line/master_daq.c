/* Samples: uses one list of the drive and one event; the time stamps are numbers of periods. */
#include <string.h>

#include "host_sim/line/master_parts.h"

#define PID_OCTETS   1u
#define STAMP_OCTETS 4u

/* Slots that a packet takes: the first has the stamp. */
static uint32_t packet_slots(const master_t *master, uint32_t packet)
{
    return (master->sample_max - PID_OCTETS - (packet == 0u ? STAMP_OCTETS : 0u)) / 4u;
}

/* ---- receiving ---- */

static void count_gap(daq_t *daq)
{
    if (daq->sum.samples != 0u && daq->period - daq->last != daq->every) {
        const uint32_t late = daq->period - daq->last;
        daq->sum.gaps++;
        daq->sum.missing += late > daq->every && late < UINT32_C(0x80000000) ? late / daq->every - 1u : 0u;
    }
    daq->last = daq->period;
    daq->sum.samples++;
}

void master_daq_packet(master_t *master, const uint8_t *packet, uint32_t length)
{
    daq_t *daq = &master->daq;
    const uint32_t number = (uint32_t)packet[0] - daq->first_pid;
    if (!daq->running || packet[0] < daq->first_pid || number >= daq->lists) {
        return;
    }
    if (number == 0u) {
        daq->next = 0;
        daq->taken = 0;
    }
    if (number != daq->next) {
        return; /* a packet of this sample was lost, which the missing time stamp will show */
    }
    const uint32_t head = PID_OCTETS + (number == 0u ? STAMP_OCTETS : 0u);
    const uint32_t room = packet_slots(master, number);
    const uint32_t slots = daq->count - daq->taken < room ? daq->count - daq->taken : room;
    if (length != head + 4u * slots) {
        return;
    }
    if (number == 0u) {
        daq->period = master_take(packet + PID_OCTETS, STAMP_OCTETS);
    }
    for (uint32_t n = 0; n < slots; n++) {
        daq->slots[daq->taken++] = master_take(packet + head + 4u * n, 4u);
    }
    daq->next++;
    if (daq->next == daq->lists) {
        count_gap(daq);
        daq->sink(daq->context, daq->period, daq->slots, daq->count);
    }
}

/* ---- setting up ---- */

static bool ask(master_t *master, const uint8_t *packet, uint32_t length, uint8_t *data,
                master_error_t *error)
{
    question_t question = master_question(packet[0], length, MASTER_ANY, NULL, NULL);
    memcpy(question.packets[0], packet, length);
    const int result = master_asked(master, question, data, NULL);
    return result == MASTER_OK || master_fail_result(master, error, "setting up the samples", result);
}

static bool check_stamps(master_t *master, master_error_t *error)
{
    uint8_t data[MASTER_READ_MAX];
    const uint8_t packet[] = {XCP_GET_DAQ_RESOLUTION_INFO};
    return ask(master, packet, sizeof packet, data, error) &&
           ((data[4] & 0x07u) == STAMP_OCTETS ||
            master_fail(error, "%s: its samples have no time stamps of 4 octets: this is not a lagless drive",
                        master->name));
}

static bool write_list(master_t *master, const table_row_t *const *rows, uint32_t count,
                       master_error_t *error)
{
    daq_t *daq = &master->daq;
    const uint8_t free_daq[] = {XCP_FREE_DAQ};
    const uint8_t alloc_daq[] = {XCP_ALLOC_DAQ, 0, 1, 0};
    daq->lists = 0;
    for (uint32_t left = count; left != 0u; daq->lists++) {
        const uint32_t room = packet_slots(master, daq->lists);
        left -= left < room ? left : room;
    }
    const uint8_t alloc_odt[] = {XCP_ALLOC_ODT, 0, 0, 0, (uint8_t)daq->lists};
    bool good = ask(master, free_daq, sizeof free_daq, NULL, error) &&
                ask(master, alloc_daq, sizeof alloc_daq, NULL, error) &&
                ask(master, alloc_odt, sizeof alloc_odt, NULL, error);
    uint32_t left = count;
    for (uint32_t n = 0; good && n < daq->lists; n++) {
        const uint32_t room = packet_slots(master, n);
        const uint32_t entries = left < room ? left : room;
        const uint8_t alloc[] = {XCP_ALLOC_ODT_ENTRY, 0, 0, 0, (uint8_t)n, (uint8_t)entries};
        left -= entries;
        good = ask(master, alloc, sizeof alloc, NULL, error);
    }
    uint32_t at = 0;
    for (uint32_t n = 0; good && n < daq->lists; n++) {
        const uint8_t pointer[] = {XCP_SET_DAQ_PTR, 0, 0, 0, (uint8_t)n, 0};
        good = ask(master, pointer, sizeof pointer, NULL, error);
        for (uint32_t room = packet_slots(master, n); good && room != 0u && at < count; room--) {
            uint8_t entry[8] = {XCP_WRITE_DAQ, 0xFF, 4, MASTER_SIGNALS};
            master_put(entry + 4, 4u * rows[at++]->id, 4u);
            good = ask(master, entry, sizeof entry, NULL, error);
        }
    }
    return good;
}

static bool check_rows(const table_row_t *const *rows, uint32_t count, uint32_t every, master_error_t *error)
{
    if (count == 0u || count > MASTER_DAQ_MAX) {
        return master_fail(error, "%u rows to sample: accepted: 1 to %u", (unsigned)count, MASTER_DAQ_MAX);
    }
    if (every == 0u || every > 255u) {
        return master_fail(error, "every %u periods: accepted: 1 to 255", (unsigned)every);
    }
    for (uint32_t n = 0; n < count; n++) {
        master_extension_t extension;
        uint32_t address;
        if (!master_place(rows[n], &extension, &address) || extension != MASTER_SIGNALS) {
            return master_fail(error, "%s: only signals are sampled; `lagless signals` lists them",
                               rows[n]->name);
        }
    }
    return true;
}

bool master_daq_start(master_t *master, const table_row_t *const *rows, uint32_t count, uint32_t every,
                      master_sink_t sink, void *context, master_error_t *error)
{
    uint8_t data[MASTER_READ_MAX] = {0};
    if (master->daq.running) {
        return master_fail(error, "sampling is active already: stop it first");
    }
    if (!check_rows(rows, count, every, error)) {
        return false;
    }
    daq_t *daq = &master->daq;
    *daq = (daq_t){.count = count, .every = every, .sink = sink, .context = context};
    const uint8_t mode[] = {XCP_SET_DAQ_LIST_MODE, 0x10, 0, 0, 0, 0, (uint8_t)every, 0}; /* with stamps */
    const uint8_t choose[] = {XCP_START_STOP_DAQ_LIST, 2, 0, 0};
    const uint8_t start[] = {XCP_START_STOP_SYNCH, 1};
    if (!check_stamps(master, error) || !write_list(master, rows, count, error) ||
        !ask(master, mode, sizeof mode, NULL, error) || !ask(master, choose, sizeof choose, data, error)) {
        return false;
    }
    daq->first_pid = data[0];
    daq->frames_missing = master->in.missing;
    daq->octets_dropped = master->in.dropped;
    daq->running = true; /* the first sample may come before the answer */
    daq->running = ask(master, start, sizeof start, NULL, error);
    return daq->running;
}

bool master_daq_stop(master_t *master, master_error_t *error)
{
    const uint8_t stop[] = {XCP_START_STOP_SYNCH, 0};
    if (!master->daq.running) {
        return true;
    }
    const bool good = ask(master, stop, sizeof stop, NULL, error);
    master->daq.sum = master_daq(master);
    master->daq.running = false;
    return good;
}

bool master_daq_running(const master_t *master)
{
    return master->daq.running;
}

master_daq_t master_daq(const master_t *master)
{
    master_daq_t sum = master->daq.sum;
    if (master->daq.running) {
        sum.frames_missing = master->in.missing - master->daq.frames_missing;
        sum.octets_dropped = master->in.dropped - master->daq.octets_dropped;
    }
    return sum;
}
