#include "talk/xcp.h"

#include <string.h>

#include "contract/line.h"
#include "math/crc.h"
#include "talk/xcp_parts.h"

#define PID_ANSWER 0xFFu
#define PID_ERROR  0xFEu
#define PID_EVENT  0xFDu

#define RESOURCE_CALIBRATION 0x01u
#define RESOURCE_DAQ         0x04u
#define COMM_OPTIONAL        0x80u /* GET_COMM_MODE_INFO exists; Intel order and BYTE granularity are 0 */
#define STATUS_DAQ_RUNNING   0x40u
#define CHECKSUM_CRC_32      0x09u
#define EVENT_DAQ_OVERLOAD   0x06u
#define DRIVER_VERSION       0x10u

/* ---- session ---- */

static uint32_t connect(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    const uint32_t seed = xcp->seed;
    daq_clear(call->daq);
    xcp_init(xcp, xcp->serial);
    xcp->connected = 1u;
    xcp->seed = seed; /* the next command differs from it */
    xcp->locked = call->access->key() != 0u ? UINT32_C(1) : UINT32_C(0);
    call->answer[1] = RESOURCE_CALIBRATION | RESOURCE_DAQ;
    call->answer[2] = COMM_OPTIONAL;
    call->answer[3] = FRAME_MAX_CTO;
    xcp_put_word(&call->answer[4], FRAME_MAX_DTO);
    call->answer[6] = XCP_VERSION;
    call->answer[7] = XCP_VERSION;
    call->length = 8u;
    return XCP_OK;
}

static uint32_t disconnect(xcp_call_t *call)
{
    daq_clear(call->daq);
    call->xcp->connected = 0u;
    return XCP_OK;
}

static uint32_t get_status(xcp_call_t *call)
{
    call->answer[1] = call->daq->running != 0u ? STATUS_DAQ_RUNNING : 0u;
    call->answer[2] = call->xcp->locked != 0u ? RESOURCE_CALIBRATION : 0u;
    call->length = 6u; /* no configuration is stored */
    return XCP_OK;
}

/* Commands that the master sent before may be lost: the address must be set
 * again, as the standard requires. */
static uint32_t synch(xcp_call_t *call)
{
    call->xcp->extension = XCP_EXTENSION_NONE;
    call->xcp->once = 0u;
    return XCP_CMD_SYNCH;
}

static uint32_t get_comm_mode_info(xcp_call_t *call)
{
    call->answer[7] = DRIVER_VERSION;
    call->length = 8u;
    return XCP_OK;
}

/* Types of GET_ID: 0 ASCII text, 1 name of the A2L file, 4 the A2L file itself, 5 its EPK. Other types
 * have no data, which is no error. */
static uint32_t get_id(xcp_call_t *call)
{
    static const char name[] = "lagless";
    const uint32_t type = call->command[1];
    uint32_t length = 0u;
    call->length = 8u;
    if (type <= 1u) {
        length = (uint32_t)strlen(name);
        call->answer[1] = 1u; /* the data is in the answer */
        for (uint32_t n = 0; n < length; n++) {
            call->answer[8u + n] = (uint16_t)name[n];
        }
        call->length += length;
    } else if (type == 4u || type == 5u) {
        call->xcp->extension = type == 4u ? XCP_EXTENSION_A2L : XCP_EXTENSION_EPK;
        call->xcp->address = 0u;
        length = call->access->text_length(call->xcp->extension);
    }
    xcp_put_long(&call->answer[4], length);
    return XCP_OK;
}

/* ---- seed and key ---- */

#define KEY_OCTETS 4u

/* The seed of a resource that is not locked has no octets. */
static uint32_t get_seed(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    const uint16_t resource = call->command[2];
    if (call->command[1] != 0u) {
        return XCP_SEQUENCE; /* the seed has no further part */
    }
    if (resource == 0u || (resource & (resource - 1u)) != 0u || resource > 0x10u) {
        return XCP_OUT_OF_RANGE;
    }
    call->length = 2u;
    if (resource != RESOURCE_CALIBRATION || xcp->locked == 0u) {
        return XCP_OK;
    }
    const uint32_t clock = call->access->clock();
    uint32_t crc = crc_add(CRC_BEGIN, (uint16_t)(xcp->seed & 0xFFFFu));
    crc = crc_add(crc, (uint16_t)(xcp->seed >> 16));
    crc = crc_add(crc, (uint16_t)(clock & 0xFFFFu));
    xcp->seed = crc_end(crc_add(crc, (uint16_t)(clock >> 16)));
    xcp->seeded = 1u;
    call->answer[1] = KEY_OCTETS;
    xcp_put_long(&call->answer[2], xcp->seed);
    call->length = 2u + KEY_OCTETS;
    return XCP_OK;
}

/* Without a lock any key is good: the answer to the one that opened it may be lost. */
static uint32_t unlock(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    if (xcp->locked != 0u && xcp->seeded == 0u) {
        return XCP_SEQUENCE;
    }
    const uint32_t expected = line_unlocks(xcp->seed, call->access->key());
    xcp->seeded = 0u;
    if (xcp->locked != 0u && (call->command[1] != KEY_OCTETS || call->count < 2u + KEY_OCTETS ||
                              xcp_long(&call->command[2]) != expected)) {
        (void)disconnect(call);
        return XCP_ACCESS_LOCKED;
    }
    xcp->locked = 0u;
    call->length = 2u; /* no resource is locked */
    return XCP_OK;
}

/* ---- memory ---- */

/* True if this command has been received twice where that is required. */
static bool is_certain(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    if (xcp->serial == 0u) {
        return true;
    }
    uint32_t crc = crc_add(CRC_BEGIN, (uint16_t)xcp->extension);
    crc = crc_add(crc, (uint16_t)(xcp->address & 0xFFFFu));
    crc = crc_add(crc, (uint16_t)(xcp->address >> 16));
    for (uint32_t n = 0; n < call->count; n++) {
        crc = crc_add(crc, call->command[n]);
    }
    const bool certain = xcp->once != 0u && xcp->once_check == crc_end(crc);
    xcp->once = certain ? UINT32_C(0) : UINT32_C(1);
    xcp->once_check = crc_end(crc);
    return certain;
}

static void take_mta(xcp_call_t *call)
{
    call->xcp->extension = call->command[3];
    call->xcp->address = xcp_long(&call->command[4]);
}

static uint32_t set_mta(xcp_call_t *call)
{
    if (call->access->writable(call->command[3]) && !is_certain(call)) {
        return XCP_CMD_BUSY;
    }
    take_mta(call);
    return XCP_OK;
}

static bool uploads(const xcp_call_t *call)
{
    return call->command[1] != 0u && call->command[1] <= FRAME_MAX_CTO - 1u;
}

static uint32_t upload(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    const uint32_t count = call->command[1];
    if (!uploads(call)) {
        return XCP_OUT_OF_RANGE;
    }
    const uint32_t result = call->access->read(xcp->extension, xcp->address, count, &call->answer[1]);
    if (result == XCP_OK) {
        xcp->address += count;
        call->length = 1u + count;
    }
    return result;
}

static uint32_t short_upload(xcp_call_t *call)
{
    if (!uploads(call)) {
        return XCP_OUT_OF_RANGE; /* if it was the second part of a SET_MTA, no address is set */
    }
    take_mta(call); /* its address is at the same place */
    return upload(call);
}

/* A download of one slot that does nothing but stop the motor. */
static bool only_stops(const xcp_call_t *call)
{
    const xcp_t *xcp = call->xcp;
    return call->command[1] == 4u && call->count >= 6u && xcp->address % 4u == 0u &&
           call->access->stops(xcp->extension, xcp->address, xcp_long(&call->command[2]));
}

static uint32_t download(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    uint32_t slots[FRAME_MAX_CTO / 4u];
    const uint32_t octets = call->command[1];
    if (xcp->locked != 0u && !only_stops(call)) {
        return XCP_ACCESS_LOCKED;
    }
    if (octets > FRAME_MAX_CTO - 2u || call->count < 2u + octets) {
        return XCP_CMD_SYNTAX;
    }
    if (octets == 0u || octets % 4u != 0u || xcp->address % 4u != 0u) {
        return XCP_OUT_OF_RANGE; /* slots are written as a whole */
    }
    for (uint32_t n = 0; n < octets / 4u; n++) {
        slots[n] = xcp_long(&call->command[2u + 4u * n]);
    }
    if (!call->access->coded(xcp->extension, xcp->address, octets / 4u, slots) && !is_certain(call)) {
        return XCP_CMD_BUSY;
    }
    const uint32_t result = call->access->write(xcp->extension, xcp->address, octets / 4u, slots);
    if (result == XCP_OK) {
        xcp->address += octets;
    }
    return result;
}

#define CHECKSUM_PIECE 64u /* [octets] read at once */

/* CRC-32 over the block at the memory transfer address. For a block that is too long the error answer
 * contains the largest length, as the standard requires. */
static uint32_t build_checksum(xcp_call_t *call)
{
    xcp_t *xcp = call->xcp;
    const uint32_t octets = xcp_long(&call->command[4]);
    if (octets > XCP_CHECKSUM_MAX) {
        xcp_put_long(&call->answer[4], XCP_CHECKSUM_MAX);
        call->length = 8u;
        return XCP_OUT_OF_RANGE;
    }
    if (octets == 0u || octets % 4u != 0u) {
        return XCP_OUT_OF_RANGE;
    }
    uint32_t crc = CRC_BEGIN;
    for (uint32_t n = 0; n < octets; n += CHECKSUM_PIECE) {
        uint16_t piece[CHECKSUM_PIECE];
        const uint32_t rest = octets - n;
        const uint32_t length = rest < CHECKSUM_PIECE ? rest : CHECKSUM_PIECE;
        const uint32_t result = call->access->read(xcp->extension, xcp->address + n, length, piece);
        if (result != XCP_OK) {
            return result;
        }
        for (uint32_t at = 0; at < length; at += 2u) {
            crc = crc_add(crc, (uint16_t)xcp_word(&piece[at]));
        }
    }
    xcp->address += octets;
    call->answer[1] = CHECKSUM_CRC_32;
    xcp_put_long(&call->answer[4], crc_end(crc));
    call->length = 8u;
    return XCP_OK;
}

/* ---- all of them ---- */

static const xcp_row_t *among(const xcp_commands_t *commands, uint16_t code)
{
    for (uint32_t n = 0; n < commands->count; n++) {
        if (commands->rows[n].code == code) {
            return &commands->rows[n];
        }
    }
    return NULL;
}

const xcp_commands_t *xcp_commands(uint32_t part)
{
    static const xcp_row_t rows[] = {
        {0xFF, 2u, NULL, connect},
        {0xFE, 1u, NULL, disconnect},
        {0xFD, 1u, NULL, get_status},
        {0xFC, 1u, NULL, synch},
        {0xFB, 1u, "GET_COMM_MODE_INFO", get_comm_mode_info},
        {0xFA, 2u, "GET_ID", get_id},
        {0xF8, 3u, "GET_SEED", get_seed},
        {0xF7, 2u, "UNLOCK", unlock},
        {0xF6, 8u, "SET_MTA", set_mta},
        {0xF5, 2u, "UPLOAD", upload},
        {0xF4, 8u, "SHORT_UPLOAD", short_upload},
        {0xF3, 8u, "BUILD_CHECKSUM", build_checksum},
        {0xF0, 2u, "DOWNLOAD", download},
    };
    static const xcp_commands_t own = {rows, (uint32_t)(sizeof rows / sizeof rows[0])};
    switch (part) {
    case 0u:
        return &own;
    case 1u:
        return &xcp_page_commands;
    default:
        return &xcp_daq_commands;
    }
}

static const xcp_row_t *row_of(uint16_t code)
{
    const xcp_row_t *row = NULL;
    for (uint32_t n = 0; row == NULL && n < XCP_COMMAND_PARTS; n++) {
        row = among(xcp_commands(n), code);
    }
    return row;
}

void xcp_init(xcp_t *xcp, uint32_t serial)
{
    memset(xcp, 0, sizeof *xcp);
    xcp->page = XCP_PAGE_STAGED;
    xcp->serial = serial;
    xcp->extension = XCP_EXTENSION_NONE;
}

static uint32_t carry_out(const xcp_row_t *row, xcp_call_t *call)
{
    if (row == NULL) {
        return XCP_CMD_UNKNOWN;
    }
    return call->count < row->octets ? XCP_CMD_SYNTAX : row->act(call);
}

uint32_t xcp_command(xcp_t *xcp, daq_t *daq, const xcp_access_t *access, frame_packet_t command,
                     uint16_t *answer)
{
    const xcp_row_t *row = row_of(command.octets[0]);
    if (xcp->connected == 0u && (row == NULL || row->act != connect)) {
        return 0u;
    }
    xcp_call_t call = {xcp, daq, access, command.octets, command.count, answer, 1u};
    for (uint32_t n = 0; n < 8u; n++) {
        answer[n] = 0u;
    }
    answer[0] = PID_ANSWER;
    const uint32_t result = carry_out(row, &call);
    if (result != XCP_OK) {
        answer[0] = PID_ERROR;
        answer[1] = (uint16_t)result;
        return call.length > 2u ? call.length : 2u; /* longer only where the standard requires it */
    }
    return call.length;
}

uint32_t xcp_overload(uint16_t *octets)
{
    octets[0] = PID_EVENT;
    octets[1] = EVENT_DAQ_OVERLOAD;
    return 2u;
}
