/* The slave's commands of data acquisition. */
#include "talk/xcp_parts.h"

/* Of the processor: lists are dynamic, have a prescaler and stamps; what is lost is told by an event. */
#define PROPERTY_DYNAMIC   0x01u
#define PROPERTY_PRESCALER 0x02u
#define PROPERTY_STAMPS    0x10u
#define PROPERTY_EVENT     0x80u

#define STAMP_OCTETS 4u
#define STAMP_FIXED  0x08u /* they cannot be switched off */

#define EVENT_CHANNEL 0u
#define EVENT_FOR_DAQ 0x84u /* all that is copied in a period belongs together */
#define PRIORITY_MAX  0xFFu

/* Modes of lists: what of them is not offered. */
#define MODE_ALTERNATING 0x01u
#define MODE_STIM        0x02u
#define MODE_NO_PID      0x20u

static uint32_t error_of(daq_result_t result)
{
    switch (result) {
    case DAQ_DONE:
        return XCP_OK;
    case DAQ_ACTIVE:
        return XCP_DAQ_ACTIVE;
    case DAQ_OUT_OF_RANGE:
        return XCP_OUT_OF_RANGE;
    case DAQ_SEQUENCE:
        return XCP_SEQUENCE;
    case DAQ_OVERFLOW:
        return XCP_MEMORY_OVERFLOW;
    case DAQ_INCOMPLETE:
        break;
    }
    return XCP_DAQ_CONFIG;
}

/* A time as the standard writes it: so many of a unit, 0: 1 ns, and each next one ten times it. */
typedef struct {
    uint32_t count;
    uint32_t unit;
} span_t;

static span_t span_of(uint32_t nanoseconds)
{
    span_t span = {nanoseconds, 0u};
    while (span.count % 10u == 0u && span.unit < 9u) {
        span.count /= 10u;
        span.unit++;
    }
    return span;
}

/* The same in an octet, rounded where it must be. */
static span_t rough(span_t span)
{
    while (span.count > 255u) {
        span.count = (span.count + 5u) / 10u;
        span.unit++;
    }
    return span;
}

static uint32_t get_processor_info(xcp_call_t *call)
{
    call->answer[1] = PROPERTY_DYNAMIC | PROPERTY_PRESCALER | PROPERTY_STAMPS | PROPERTY_EVENT;
    xcp_put_word(&call->answer[2], call->daq->lists);
    xcp_put_word(&call->answer[4], 1u); /* event channels; no list is predefined; absolute ODT numbers */
    call->length = 8u;
    return XCP_OK;
}

static uint32_t get_resolution_info(xcp_call_t *call)
{
    const span_t stamp = span_of(call->access->period);
    call->answer[1] = DAQ_ENTRY_SIZE;
    call->answer[2] = DAQ_ENTRY_SIZE;
    call->answer[3] = 1u; /* of stimulation, which there is not: granularity must be something */
    call->answer[5] = (uint16_t)(STAMP_OCTETS | STAMP_FIXED | stamp.unit << 4);
    xcp_put_word(&call->answer[6], stamp.count);
    call->length = 8u;
    return XCP_OK;
}

static uint32_t get_event_info(xcp_call_t *call)
{
    if (xcp_word(&call->command[2]) != EVENT_CHANNEL) {
        return XCP_OUT_OF_RANGE;
    }
    const span_t cycle = rough(span_of(call->access->period));
    call->answer[1] = EVENT_FOR_DAQ;
    call->answer[2] = DAQ_LISTS;
    call->answer[3] = (uint16_t)call->access->text_length(XCP_EXTENSION_EVENT);
    call->answer[4] = (uint16_t)cycle.count;
    call->answer[5] = (uint16_t)cycle.unit;
    call->answer[6] = PRIORITY_MAX;
    call->xcp->extension = XCP_EXTENSION_EVENT;
    call->xcp->address = 0u;
    call->length = 7u;
    return XCP_OK;
}

static uint32_t get_clock(xcp_call_t *call)
{
    xcp_put_long(&call->answer[4], call->access->clock());
    call->length = 8u;
    return XCP_OK;
}

static uint32_t free_daq(xcp_call_t *call)
{
    daq_clear(call->daq);
    return XCP_OK;
}

static uint32_t alloc_daq(xcp_call_t *call)
{
    return error_of(daq_alloc_lists(call->daq, xcp_word(&call->command[2])));
}

static uint32_t alloc_odt(xcp_call_t *call)
{
    return error_of(daq_alloc_odts(call->daq, xcp_word(&call->command[2]), call->command[4]));
}

static uint32_t alloc_odt_entry(xcp_call_t *call)
{
    return error_of(
        daq_alloc_entries(call->daq, xcp_word(&call->command[2]), call->command[4], call->command[5]));
}

static uint32_t set_daq_ptr(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    const uint32_t list = xcp_word(&call->command[2]);
    if (!daq_has_entry(call->daq, list, call->command[4], call->command[5])) {
        return XCP_OUT_OF_RANGE;
    }
    xcp->daq_list = list;
    xcp->daq_odt = call->command[4];
    xcp->daq_entry = call->command[5];
    return XCP_OK;
}

static uint32_t write_daq(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    uint32_t offset = 0u;
    if (call->command[1] != 0xFFu || call->command[2] != DAQ_ENTRY_SIZE) {
        return XCP_OUT_OF_RANGE; /* whole slots, no single bits */
    }
    uint32_t result = call->access->measurable(call->command[3], xcp_long(&call->command[4]), &offset);
    if (result == XCP_OK) {
        result = error_of(daq_write(call->daq, xcp->daq_list, xcp->daq_odt, xcp->daq_entry, offset));
    }
    if (result == XCP_OK) {
        xcp->daq_entry++;
    }
    return result;
}

static uint32_t set_list_mode(xcp_call_t *call)
{
    if ((call->command[1] & (MODE_ALTERNATING | MODE_STIM | MODE_NO_PID)) != 0u) {
        return XCP_MODE_NOT_VALID;
    }
    if (xcp_word(&call->command[4]) != EVENT_CHANNEL) {
        return XCP_OUT_OF_RANGE;
    }
    return error_of(daq_set_prescaler(call->daq, xcp_word(&call->command[2]), call->command[6]));
}

/* 0 stop, 1 start, 2 select. The answer is the number of the list's first ODT. */
static uint32_t start_stop_list(xcp_call_t *call)
{
    daq_t *daq = call->daq;
    const uint32_t mode = call->command[1];
    const uint32_t list = xcp_word(&call->command[2]);
    if (list >= daq->lists) {
        return XCP_OUT_OF_RANGE;
    }
    if (mode > 2u) {
        return XCP_MODE_NOT_VALID;
    }
    const uint32_t bit = UINT32_C(1) << list;
    daq_result_t result = DAQ_DONE;
    if (mode == 0u) {
        daq_stop(daq, bit);
    } else if (mode == 1u) {
        result = daq_start(daq, bit);
    } else {
        result = daq_select(daq, list);
    }
    call->answer[1] = (uint16_t)daq->list[list].odt_first;
    call->length = 2u;
    return error_of(result);
}

/* 0 stop all, 1 start selected, 2 stop selected, 3 prepare selected (which a start does by itself). */
static uint32_t start_stop_synch(xcp_call_t *call)
{
    switch (call->command[1]) {
    case 0u:
        daq_stop(call->daq, ~UINT32_C(0));
        return XCP_OK;
    case 1u:
        return error_of(daq_start(call->daq, daq_selected(call->daq)));
    case 2u:
        daq_stop(call->daq, daq_selected(call->daq));
        return XCP_OK;
    case 3u:
        return XCP_OK;
    default:
        return XCP_MODE_NOT_VALID;
    }
}

static const xcp_row_t rows[] = {
    {0xE2, 6u, set_daq_ptr},        {0xE1, 8u, write_daq},           {0xE0, 8u, set_list_mode},
    {0xDE, 4u, start_stop_list},    {0xDD, 2u, start_stop_synch},    {0xDC, 1u, get_clock},
    {0xDA, 1u, get_processor_info}, {0xD9, 1u, get_resolution_info}, {0xD7, 4u, get_event_info},
    {0xD6, 1u, free_daq},           {0xD5, 4u, alloc_daq},           {0xD4, 5u, alloc_odt},
    {0xD3, 6u, alloc_odt_entry},
};
const xcp_commands_t xcp_daq_commands = {rows, (uint32_t)(sizeof rows / sizeof rows[0])};
