/* The commands of the slave for pages: one segment, that of the parameters, with the
 * active set and the staged set. */
#include "talk/xcp_parts.h"

#define PAGE_OF_DRIVE  0x01u
#define PAGE_OF_CLIENT 0x02u
#define PAGE_OF_ALL    0x80u

/* Properties of a page, each with or without access by the other side: the drive runs with it, the client
 * reads it, the client writes it. */
#define PAGE_RUN   0x03u
#define PAGE_READ  0x0Cu
#define PAGE_WRITE 0x30u
#define PAGES      2u

static uint32_t set_page(xcp_call_t *call)
{
    const uint32_t mode = call->command[1];
    const uint32_t page = call->command[3];
    if ((mode & (PAGE_OF_DRIVE | PAGE_OF_CLIENT)) == 0u) {
        return XCP_MODE_NOT_VALID;
    }
    if (call->command[2] != 0u && (mode & PAGE_OF_ALL) == 0u) {
        return XCP_SEGMENT_NOT_VALID;
    }
    if (page > XCP_PAGE_STAGED || ((mode & PAGE_OF_DRIVE) != 0u && page != XCP_PAGE_ACTIVE)) {
        return XCP_PAGE_NOT_VALID; /* the drive accepts only a set that has been judged */
    }
    if ((mode & PAGE_OF_DRIVE) != 0u) {
        if (call->xcp->locked != 0u) {
            return XCP_ACCESS_LOCKED;
        }
        const uint32_t result = call->access->apply();
        if (result != XCP_OK) {
            return result;
        }
    }
    if ((mode & PAGE_OF_CLIENT) != 0u) {
        call->xcp->page = page;
    }
    return XCP_OK;
}

/* For the drive the page is 0 if the staged set equals the active one. */
static uint32_t get_page(xcp_call_t *call)
{
    const uint32_t mode = call->command[1];
    if (mode != PAGE_OF_DRIVE && mode != PAGE_OF_CLIENT) {
        return XCP_MODE_NOT_VALID;
    }
    if (call->command[2] != 0u) {
        return XCP_SEGMENT_NOT_VALID;
    }
    const uint32_t of_drive = call->access->applied() ? XCP_PAGE_ACTIVE : XCP_PAGE_STAGED;
    call->answer[3] = (uint16_t)(mode == PAGE_OF_DRIVE ? of_drive : call->xcp->page);
    call->length = 4u;
    return XCP_OK;
}

/* One segment; pages cannot be stored by freezing. */
static uint32_t get_processor_info(xcp_call_t *call)
{
    call->answer[1] = 1u;
    call->length = 3u;
    return XCP_OK;
}

/* 0: its address or length; 1: its properties; 2: there are no mappings. */
static uint32_t get_segment_info(xcp_call_t *call)
{
    const xcp_segment_t segment = call->access->segment();
    const uint32_t mode = call->command[1];
    if (call->command[2] != 0u) {
        return XCP_SEGMENT_NOT_VALID;
    }
    if (mode == 0u && call->command[3] <= 1u) {
        xcp_put_long(&call->answer[4], call->command[3] == 0u ? segment.address : segment.length);
        call->length = 8u;
        return XCP_OK;
    }
    if (mode == 1u) {
        call->answer[1] = PAGES;
        call->answer[2] = (uint16_t)segment.extension;
        call->length = 6u;
        return XCP_OK;
    }
    return XCP_OUT_OF_RANGE;
}

static uint32_t get_page_info(xcp_call_t *call)
{
    if (call->command[2] != 0u) {
        return XCP_SEGMENT_NOT_VALID;
    }
    if (call->command[3] >= PAGES) {
        return XCP_PAGE_NOT_VALID;
    }
    call->answer[1] = call->command[3] == XCP_PAGE_ACTIVE ? PAGE_RUN | PAGE_READ : PAGE_READ | PAGE_WRITE;
    call->length = 3u;
    return XCP_OK;
}

static const xcp_row_t rows[] = {
    {0xEB, 4u, "SET_CAL_PAGE", set_page},
    {0xEA, 3u, "GET_CAL_PAGE", get_page},
    {0xE9, 1u, "GET_PAG_PROCESSOR_INFO", get_processor_info},
    {0xE8, 5u, "GET_SEGMENT_INFO", get_segment_info},
    {0xE7, 4u, "GET_PAGE_INFO", get_page_info},
};
const xcp_commands_t xcp_page_commands = {rows, (uint32_t)(sizeof rows / sizeof rows[0])};
