/* The commands of the slave for data acquisition. */
#include "talk/xcp_parts.h"

/* Properties of the processor: lists are dynamic and have a prescaler and stamps;
 * an event reports lost samples. */
#define PROPERTY_DYNAMIC   0x01u
#define PROPERTY_PRESCALER 0x02u
#define PROPERTY_STAMPS    0x10u
#define PROPERTY_EVENT     0x80u

#define STAMP_OCTETS 4u
#define STAMP_FIXED  0x08u /* they cannot be switched off */

#define EVENT_FOR_DAQ 0x84u /* all values that are copied in a period belong together */

/* Modes of lists: those that are not supported. */
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

xcp_span_t xcp_span(uint32_t nanoseconds)
{
    xcp_span_t span = {nanoseconds, 0u};
    while (span.count % 10u == 0u && span.unit + 1u < XCP_UNITS) {
        span.count /= 10u;
        span.unit++;
    }
    return span;
}

xcp_span_t xcp_span_rough(xcp_span_t span)
{
    while (span.count > 255u) {
        span.count = (span.count + 5u) / 10u;
        span.unit++;
    }
    return span;
}

const char *xcp_unit(uint32_t unit)
{
    static const char *const names[XCP_UNITS] = {"UNIT_1NS",   "UNIT_10NS",  "UNIT_100NS", "UNIT_1US",
                                                 "UNIT_10US",  "UNIT_100US", "UNIT_1MS",   "UNIT_10MS",
                                                 "UNIT_100MS", "UNIT_1S"};
    return names[unit];
}

static uint32_t get_processor_info(xcp_call_t *call)
{
    call->answer[1] = PROPERTY_DYNAMIC | PROPERTY_PRESCALER | PROPERTY_STAMPS | PROPERTY_EVENT;
    xcp_put_word(&call->answer[2], call->daq->lists);
    xcp_put_word(&call->answer[4],
                 XCP_EVENTS); /* event channels; no list is predefined; absolute ODT numbers */
    call->length = 8u;
    return XCP_OK;
}

static uint32_t get_resolution_info(xcp_call_t *call)
{
    const xcp_span_t stamp = xcp_span(call->access->period);
    call->answer[1] = DAQ_ENTRY_SIZE;
    call->answer[2] = DAQ_ENTRY_SIZE;
    call->answer[3] = 1u; /* for stimulation, which is not supported: the standard requires a granularity */
    call->answer[5] = (uint16_t)(STAMP_OCTETS | STAMP_FIXED | stamp.unit << 4);
    xcp_put_word(&call->answer[6], stamp.count);
    call->length = 8u;
    return XCP_OK;
}

static uint32_t get_event_info(xcp_call_t *call)
{
    if (xcp_word(&call->command[2]) != XCP_EVENT_CHANNEL) {
        return XCP_OUT_OF_RANGE;
    }
    const xcp_span_t cycle = xcp_span_rough(xcp_span(call->access->period));
    call->answer[1] = EVENT_FOR_DAQ;
    call->answer[2] = DAQ_LISTS;
    call->answer[3] = (uint16_t)call->access->text_length(XCP_EXTENSION_EVENT);
    call->answer[4] = (uint16_t)cycle.count;
    call->answer[5] = (uint16_t)cycle.unit;
    call->answer[6] = XCP_EVENT_PRIORITY;
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
    if (xcp_word(&call->command[4]) != XCP_EVENT_CHANNEL) {
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

/* 0 stop all, 1 start selected, 2 stop selected, 3 prepare selected (a start does this by itself). */
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
    {0xE2, 6u, "SET_DAQ_PTR", set_daq_ptr},
    {0xE1, 8u, "WRITE_DAQ", write_daq},
    {0xE0, 8u, "SET_DAQ_LIST_MODE", set_list_mode},
    {0xDE, 4u, "START_STOP_DAQ_LIST", start_stop_list},
    {0xDD, 2u, "START_STOP_SYNCH", start_stop_synch},
    {0xDC, 1u, "GET_DAQ_CLOCK", get_clock},
    {0xDA, 1u, "GET_DAQ_PROCESSOR_INFO", get_processor_info},
    {0xD9, 1u, "GET_DAQ_RESOLUTION_INFO", get_resolution_info},
    {0xD7, 4u, "GET_DAQ_EVENT_INFO", get_event_info},
    {0xD6, 1u, "FREE_DAQ", free_daq},
    {0xD5, 4u, "ALLOC_DAQ", alloc_daq},
    {0xD4, 5u, "ALLOC_ODT", alloc_odt},
    {0xD3, 6u, "ALLOC_ODT_ENTRY", alloc_odt_entry},
};
const xcp_commands_t xcp_daq_commands = {rows, (uint32_t)(sizeof rows / sizeof rows[0])};
