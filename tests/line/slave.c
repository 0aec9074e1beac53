#include "tests/line/slave.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define FIRST_PID 3u

static void pause_ms(uint32_t milliseconds)
{
    usleep(1000u * milliseconds);
}

static void put(uint8_t *at, uint32_t value, uint32_t octets)
{
    for (uint32_t n = 0; n < octets; n++) {
        at[n] = (uint8_t)(value >> 8u * n);
    }
}

static uint32_t take(const uint8_t *at, uint32_t octets)
{
    uint32_t value = 0;
    for (uint32_t n = 0; n < octets; n++) {
        value |= (uint32_t)at[n] << 8u * n;
    }
    return value;
}

static slave_slot_t *slot_at(slave_t *slave, uint32_t extension, uint32_t address)
{
    for (uint32_t n = 0; n < slave->slot_count; n++) {
        if (slave->slots[n].extension == extension && slave->slots[n].address == address) {
            return &slave->slots[n];
        }
    }
    return NULL;
}

void slave_put(slave_t *slave, uint32_t extension, uint32_t address, uint32_t bits)
{
    pthread_mutex_lock(&slave->lock);
    slave_slot_t *slot = slot_at(slave, extension, address);
    if (slot == NULL) {
        slot = &slave->slots[slave->slot_count++];
    }
    *slot = (slave_slot_t){extension, address, bits};
    pthread_mutex_unlock(&slave->lock);
}

uint32_t slave_get(slave_t *slave, uint32_t extension, uint32_t address)
{
    pthread_mutex_lock(&slave->lock);
    const slave_slot_t *slot = slot_at(slave, extension, address);
    const uint32_t bits = slot != NULL ? slot->bits : 0u;
    pthread_mutex_unlock(&slave->lock);
    return bits;
}

uint32_t slave_count(slave_t *slave, uint8_t command)
{
    uint32_t count = 0;
    pthread_mutex_lock(&slave->lock);
    for (uint32_t n = 0; n < slave->asked_count; n++) {
        count += slave->asked[n] == command ? 1u : 0u;
    }
    pthread_mutex_unlock(&slave->lock);
    return count;
}

/* ---- sending ---- */

static void send_octets(slave_t *slave, const uint8_t *octets, uint32_t count)
{
    const uint32_t part = slave->split != 0u ? slave->split : count;
    for (uint32_t at = 0; at < count; at += part) {
        const uint32_t size = count - at < part ? count - at : part;
        if (send(slave->descriptor, octets + at, size, MSG_NOSIGNAL) < 0) {
            return;
        }
        if (slave->split != 0u) {
            pause_ms(2);
        }
    }
}

/* Appends the fill octet and the sum of words by the standard; returns the number of octets of both. */
static uint32_t add_tail(uint8_t *frame, uint32_t count)
{
    uint32_t sum = 0;
    frame[count] = 0;
    const uint32_t even = count + count % 2u;
    for (uint32_t n = 0; n < even; n += 2u) {
        sum += take(frame + n, 2u);
    }
    put(frame + even, sum, 2u);
    return even + 2u - count;
}

static void send_frame(slave_t *slave, const uint8_t *packet, uint32_t length)
{
    uint8_t frame[4 + 256 + 3];
    put(frame, length, 2u);
    put(frame + 2, slave->counter++, 2u);
    memcpy(frame + 4, packet, length);
    send_octets(slave, frame, 4u + length + (slave->serial ? add_tail(frame, 4u + length) : 0u));
}

void slave_octets(slave_t *slave, const uint8_t *octets, uint32_t count)
{
    pthread_mutex_lock(&slave->lock);
    send_octets(slave, octets, count);
    pthread_mutex_unlock(&slave->lock);
}

void slave_sample(slave_t *slave, uint32_t stamp, const uint32_t *slots)
{
    uint32_t at = 0;
    pthread_mutex_lock(&slave->lock);
    for (uint32_t list = 0; list < slave->lists; list++) {
        uint8_t packet[128] = {(uint8_t)(FIRST_PID + list)};
        uint32_t length = 1u;
        if (list == 0u) {
            put(packet + 1, stamp, 4u);
            length += 4u;
        }
        for (uint32_t n = 0; n < slave->entries[list]; n++) {
            put(packet + length, slots[at++], 4u);
            length += 4u;
        }
        send_frame(slave, packet, length);
    }
    pthread_mutex_unlock(&slave->lock);
}

/* ---- commands ---- */

typedef struct {
    uint32_t mta_extension, mta;
    uint32_t pointer_list;
} session_t;

static uint32_t error(uint8_t *answer, uint8_t code)
{
    answer[0] = 0xFE;
    answer[1] = code;
    return 2u;
}

static uint32_t upload(slave_t *slave, const uint8_t *command, uint8_t *answer)
{
    const uint32_t count = command[1];
    const uint32_t extension = command[3];
    const uint32_t address = take(command + 4, 4u);
    if (extension == 6u) {
        char epk[32];
        snprintf(epk, sizeof epk, "lagless-%08lx", (unsigned long)slave->epk_hash);
        memcpy(answer + 1, epk + address, count);
        return 1u + count;
    }
    for (uint32_t n = 0; n < count; n += 4u) {
        const slave_slot_t *slot = slot_at(slave, extension, address + n);
        if (slot == NULL) {
            return error(answer, 0x22);
        }
        put(answer + 1u + n, slot->bits, 4u);
    }
    return 1u + count;
}

static uint32_t download(slave_t *slave, session_t *session, const uint8_t *command, uint8_t *answer)
{
    slave_slot_t *slot = slot_at(slave, session->mta_extension, session->mta);
    if (slot == NULL) {
        return error(answer, 0x22);
    }
    if (session->mta_extension == 0u) {
        return error(answer, 0x23);
    }
    slot->bits = take(command + 2, 4u) ^ slave->spoil;
    slave->spoil = 0;
    session->mta += 4u;
    return 1u;
}

static uint32_t act(slave_t *slave, session_t *session, const uint8_t *command, uint8_t *answer)
{
    answer[0] = 0xFF;
    switch (command[0]) {
    case 0xFF:
        memcpy(answer, slave->connect, 8u);
        return 8u;
    case 0xFC:
        return error(answer, 0x00);
    case 0xF6:
        session->mta_extension = command[3];
        session->mta = take(command + 4, 4u);
        return 1u;
    case 0xF4:
        return upload(slave, command, answer);
    case 0xF0:
        return download(slave, session, command, answer);
    case 0xEA:
        answer[3] = 1u;
        return 4u;
    case 0xDC:
        put(answer + 4, slave->clock, 4u);
        return 8u;
    case 0xD9:
        memcpy(answer, (const uint8_t[]){0xFF, 4, 4, 0, 0, 0x54, 1, 0}, 8u);
        return 8u;
    case 0xD6:
        slave->lists = 0;
        slave->rows = 0;
        return 1u;
    case 0xD4:
        slave->lists = command[4];
        return 1u;
    case 0xD3:
        slave->entries[command[4]] = command[5];
        return 1u;
    case 0xE1:
        slave->row_addresses[slave->rows++] = take(command + 4, 4u);
        return 1u;
    case 0xE0:
        slave->prescaler = command[6];
        return 1u;
    case 0xDE:
        answer[1] = FIRST_PID;
        return 2u;
    case 0xDD:
        slave->running = command[1] == 1u;
        return 1u;
    default: /* ALLOC_DAQ, SET_DAQ_PTR and DISCONNECT need no action */
        return 1u;
    }
}

/* Over a serial line SET_MTA and DOWNLOAD must come twice; the first eight octets identify a command. */
static bool is_certain(slave_t *slave, const uint8_t *command)
{
    if (!slave->serial || (command[0] != 0xF6u && command[0] != 0xF0u)) {
        return true;
    }
    const uint32_t count = command[0] == 0xF6u ? 8u : 6u;
    const bool twice = memcmp(slave->once, command, count) == 0;
    memset(slave->once, 0, sizeof slave->once);
    memcpy(slave->once, command, twice ? 0u : count);
    return twice;
}

/* Returns true if a frame of the master is correct. */
static bool is_good(slave_t *slave, const uint8_t *frame, uint32_t length)
{
    uint8_t again[4 + 64 + 3];
    if (!slave->serial) {
        return true;
    }
    memcpy(again, frame, 4u + length);
    const uint32_t tail = add_tail(again, 4u + length);
    const uint32_t counter = take(frame + 2, 2u);
    const bool good = memcmp(again, frame, 4u + length + tail) == 0 &&
                      (counter == slave->next || frame[4] == 0xFFu || frame[4] == 0xFCu);
    slave->next = good ? (counter + 1u) & 0xFFFFu : slave->next;
    slave->dropped += good ? 0u : 1u;
    return good;
}

/* Answers one command. The caller holds the lock. */
static void answer_command(slave_t *slave, session_t *session, const uint8_t *command)
{
    static const uint8_t rubbish[64] = {0x80, 0x00, 0x12, 0x34, 0xFF, 0xFF, 0x07};
    uint8_t answer[128] = {0};
    slave->asked[slave->asked_count++ % SLAVE_ASKED] = command[0];
    if (slave->close_next) {
        shutdown(slave->descriptor, SHUT_RDWR);
        slave->closed = true;
        return;
    }
    uint32_t length;
    if (slave->busy != 0u) {
        slave->busy--;
        length = error(answer, 0x10);
    } else if (!is_certain(slave, command)) {
        length = error(answer, 0x10);
    } else if (slave->error_at == command[0]) {
        length = error(answer, (uint8_t)slave->error);
    } else {
        length = act(slave, session, command, answer);
    }
    if (slave->mute_at == command[0]) {
        slave->mute_at = 0;
        return;
    }
    if (slave->mute != 0u) {
        slave->mute -= slave->mute < SLAVE_MUTE ? 1u : 0u;
        return;
    }
    pause_ms(slave->late);
    slave->late = 0;
    for (; slave->pending != 0u; slave->pending--) {
        send_frame(slave, (const uint8_t[]){0xFD, 0x05}, 2u);
        pause_ms(600);
    }
    send_octets(slave, rubbish, slave->noise);
    slave->noise = 0;
    slave->counter = (uint16_t)(slave->counter + slave->counter_jump);
    slave->counter_jump = 0;
    send_frame(slave, answer, length);
}

static void *live(void *context)
{
    slave_t *slave = context;
    session_t session = {0};
    uint8_t octets[4096];
    uint32_t count = 0;
    for (;;) {
        const ssize_t got = read(slave->descriptor, octets + count, sizeof octets - count);
        if (got <= 0) {
            return NULL;
        }
        count += (uint32_t)got;
        while (count >= 4u) {
            const uint32_t length = take(octets, 2u);
            const uint32_t size = 4u + length + (slave->serial ? length % 2u + 2u : 0u);
            if (count < size) {
                break;
            }
            pthread_mutex_lock(&slave->lock);
            if (is_good(slave, octets, length)) {
                answer_command(slave, &session, octets + 4);
            }
            pthread_mutex_unlock(&slave->lock);
            memmove(octets, octets + size, count - size);
            count -= size;
        }
    }
}

int slave_start(slave_t *slave)
{
    int ends[2];
    static const uint8_t connect[8] = {0xFF, 0x05, 0x80, 64, 128, 0, 1, 1};
    memset(slave, 0, sizeof *slave);
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends) != 0) {
        return -1;
    }
    slave->descriptor = ends[1];
    slave->next = UINT32_MAX;
    memcpy(slave->connect, connect, sizeof connect);
    pthread_mutex_init(&slave->lock, NULL);
    pthread_create(&slave->thread, NULL, live, slave);
    return ends[0];
}

void slave_end(slave_t *slave)
{
    shutdown(slave->descriptor, SHUT_RDWR);
    pthread_join(slave->thread, NULL);
    close(slave->descriptor);
    pthread_mutex_destroy(&slave->lock);
}
