#include "talk/modbus.h"

#define CRC_BEGIN_16 UINT32_C(0xFFFF)
#define CRC_POLY_16  UINT32_C(0xA001) /* reflected */

#define FRAME_LEAST 4u /* [octets] address, function, CRC */
#define EXCEPTION   0x80u

/* A request after its address and function. `count` octets of the frame are stored. */
typedef struct {
    const uint16_t *octets; /* of the whole frame */
    uint32_t count;         /* [octets] of the whole frame with its CRC */
    uint16_t *answer;       /* its first two octets are set */
    uint32_t length;        /* [octets] of the answer so far */
} modbus_call_t;

static uint32_t crc_of(uint32_t crc, uint16_t octet)
{
    uint32_t next = crc ^ octet;
    for (uint32_t n = 0; n < 8u; n++) {
        next = (next & 1u) != 0u ? next >> 1 ^ CRC_POLY_16 : next >> 1;
    }
    return next;
}

static uint32_t word_at(const uint16_t *octets, uint32_t at)
{
    return (uint32_t)octets[at] << 8 | octets[at + 1u];
}

static void put_word(modbus_call_t *call, uint32_t value)
{
    call->answer[call->length] = (uint16_t)(value >> 8 & 0xFFu);
    call->answer[call->length + 1u] = (uint16_t)(value & 0xFFu);
    call->length += 2u;
}

static void begin(modbus_t *modbus)
{
    modbus->count = 0u;
    modbus->crc = CRC_BEGIN_16;
    modbus->spoilt = 0u;
}

void modbus_set(modbus_t *modbus, uint32_t address, uint32_t gap)
{
    modbus->address = address;
    modbus->gap = gap;
    begin(modbus);
}

float modbus_gap(float baud)
{
    return baud > 19200.0f ? 1.75e-3f : 3.5f * 11.0f / baud;
}

void modbus_take(modbus_t *modbus, uint16_t *store, uint16_t octet, uint32_t now)
{
    modbus->heard_at = now;
    modbus->crc = crc_of(modbus->crc, octet & 0xFFu);
    if (modbus->count < MODBUS_STORE_OCTETS) {
        store[modbus->count] = octet & 0xFFu;
    }
    modbus->count += modbus->count <= MODBUS_FRAME_MAX ? 1u : 0u;
}

void modbus_broken(modbus_t *modbus, uint32_t now)
{
    modbus->heard_at = now;
    modbus->spoilt = 1u;
}

/* ---- functions ---- */

static uint32_t read_registers(modbus_call_t *call, const modbus_access_t *access)
{
    const uint32_t first = word_at(call->octets, 2u);
    const uint32_t count = word_at(call->octets, 4u);
    uint32_t slot = 0u;
    if (count == 0u || count > MODBUS_READ_MOST) {
        return MODBUS_ILLEGAL_VALUE;
    }
    call->answer[2] = (uint16_t)(2u * count);
    call->length = 3u;
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t at = first + n;
        if (n == 0u || at % 2u == 0u) {
            const uint32_t result = access->read(at / 2u, &slot);
            if (result != MODBUS_OK) {
                return result;
            }
        }
        put_word(call, at % 2u == 0u ? slot >> 16 : slot);
    }
    return MODBUS_OK;
}

/* The lower register of a whole value, whose upper register follows from its sign. */
static uint32_t write_single(modbus_call_t *call, const modbus_access_t *access)
{
    const uint32_t at = word_at(call->octets, 2u);
    const uint32_t value = word_at(call->octets, 4u);
    const uint32_t slot = value >= UINT32_C(0x8000) ? UINT32_C(0xFFFF0000) | value : value;
    if (at % 2u == 0u || !access->whole(at / 2u)) {
        return MODBUS_ILLEGAL_ADDRESS;
    }
    put_word(call, at);
    put_word(call, value);
    return access->write(at / 2u, 1u, &slot);
}

static uint32_t write_multiple(modbus_call_t *call, const modbus_access_t *access)
{
    uint32_t slots[MODBUS_WRITE_MOST / 2u];
    const uint32_t at = word_at(call->octets, 2u);
    const uint32_t count = word_at(call->octets, 4u);
    if (count == 0u || count > MODBUS_WRITE_MOST || call->octets[6] != 2u * count ||
        call->count != 9u + 2u * count) {
        return MODBUS_ILLEGAL_VALUE;
    }
    if (at % 2u != 0u || count % 2u != 0u) {
        return MODBUS_ILLEGAL_ADDRESS; /* slots are written as a whole */
    }
    for (uint32_t n = 0; n < count / 2u; n++) {
        slots[n] = word_at(call->octets, 7u + 4u * n) << 16 | word_at(call->octets, 9u + 4u * n);
    }
    put_word(call, at);
    put_word(call, count);
    return access->write(at / 2u, count / 2u, slots);
}

/* ---- frames ---- */

static uint32_t carry_out(modbus_call_t *call, const modbus_access_t *access)
{
    const uint16_t function = call->octets[1];
    const bool reads = function == MODBUS_READ_HOLDING || function == MODBUS_READ_INPUT;
    if (!reads && function != MODBUS_WRITE_SINGLE && function != MODBUS_WRITE_MULTIPLE) {
        return MODBUS_ILLEGAL_FUNCTION;
    }
    if (function == MODBUS_WRITE_MULTIPLE) {
        return call->count < 9u ? MODBUS_ILLEGAL_VALUE : write_multiple(call, access);
    }
    if (call->count != 8u) {
        return MODBUS_ILLEGAL_VALUE;
    }
    return reads ? read_registers(call, access) : write_single(call, access);
}

static uint32_t close_answer(modbus_call_t *call)
{
    uint32_t crc = CRC_BEGIN_16;
    for (uint32_t n = 0; n < call->length; n++) {
        crc = crc_of(crc, call->answer[n]);
    }
    call->answer[call->length] = (uint16_t)(crc & 0xFFu); /* the lower octet first */
    call->answer[call->length + 1u] = (uint16_t)(crc >> 8);
    return call->length + 2u;
}

/* True if this complete frame is a good request to this drive. */
static bool judge(modbus_t *modbus, const uint16_t *store)
{
    if (modbus->spoilt != 0u || modbus->crc != 0u || modbus->count < FRAME_LEAST ||
        modbus->count > MODBUS_FRAME_MAX) {
        modbus->errors++;
        return false;
    }
    /* A function of 0x80 and more is an answer: an exception of another server or an echo. */
    return (store[0] == MODBUS_BROADCAST || store[0] == modbus->address) && store[1] < EXCEPTION;
}

modbus_result_t modbus_listen(modbus_t *modbus, const uint16_t *store, const modbus_access_t *access,
                              uint32_t now, uint16_t *answer)
{
    modbus_result_t result = {false, 0u};
    if ((modbus->count == 0u && modbus->spoilt == 0u) || now - modbus->heard_at < modbus->gap) {
        return result;
    }
    const uint32_t count = modbus->count;
    const bool good = judge(modbus, store);
    begin(modbus);
    if (!good) {
        return result;
    }
    const bool broadcast = store[0] == MODBUS_BROADCAST;
    const bool reads = store[1] == MODBUS_READ_HOLDING || store[1] == MODBUS_READ_INPUT;
    if (broadcast && reads) {
        return result;
    }
    result.heard = true;
    modbus->frames++;
    modbus_call_t call = {store, count, answer, 2u};
    answer[0] = store[0];
    answer[1] = store[1];
    const uint32_t outcome = carry_out(&call, access);
    if (outcome != MODBUS_OK) {
        answer[1] = (uint16_t)(store[1] | EXCEPTION);
        answer[2] = (uint16_t)outcome;
        call.length = 3u;
    }
    result.count = broadcast ? 0u : close_answer(&call);
    return result;
}
