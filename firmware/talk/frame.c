#include "talk/frame.h"

#include <string.h>

#define CONNECT 0xFFu /* of two octets */
#define SYNCH   0xFCu /* of one octet */

/* [octets] of header, packet and fill. */
static uint32_t body(uint32_t length)
{
    return FRAME_HEADER + length + length % 2u;
}

/* The sum of all words of an even number of octets. */
static uint32_t sum_of(const uint16_t *octets, uint32_t count)
{
    uint32_t sum = 0u;
    for (uint32_t n = 0; n < count; n += 2u) {
        sum += (uint32_t)octets[n] | (uint32_t)octets[n + 1u] << 8;
    }
    return sum & 0xFFFFu;
}

void frame_receiver_init(frame_receiver_t *receiver, uint32_t silence)
{
    memset(receiver, 0, sizeof *receiver);
    receiver->silence = silence;
}

void frame_restart(frame_receiver_t *receiver)
{
    receiver->counted = 0u;
    receiver->count = 0u;
    receiver->dropping = 0u;
}

static void drop(frame_receiver_t *receiver)
{
    receiver->errors += receiver->dropping == 0u ? 1u : 0u;
    receiver->dropping = 1u;
    receiver->count = 0u;
}

void frame_broken(frame_receiver_t *receiver, uint32_t now)
{
    drop(receiver);
    receiver->heard_at = now;
}

void frame_listen(frame_receiver_t *receiver, uint32_t now)
{
    if (now - receiver->heard_at < receiver->silence) {
        return;
    }
    if (receiver->count != 0u) {
        drop(receiver);
    }
    receiver->dropping = 0u;
}

static uint32_t word_at(const frame_receiver_t *receiver, uint32_t at)
{
    return (uint32_t)receiver->octets[at] | (uint32_t)receiver->octets[at + 1u] << 8;
}

static uint32_t length_of(const frame_receiver_t *receiver)
{
    return word_at(receiver, 0u);
}

/* True if the master starts a new sequence, or has missed an answer. */
static bool begins_anew(const frame_receiver_t *receiver)
{
    const uint32_t length = length_of(receiver);
    const uint16_t code = receiver->octets[FRAME_HEADER];
    return (length == 2u && code == CONNECT) || (length == 1u && code == SYNCH);
}

/* True if this complete frame may be executed. */
static bool judge(frame_receiver_t *receiver)
{
    if (receiver->tail == 0u) {
        return true;
    }
    const uint32_t end = body(length_of(receiver));
    if (word_at(receiver, end) != sum_of(receiver->octets, end)) {
        drop(receiver);
        return false;
    }
    const uint32_t counter = word_at(receiver, 2u);
    const bool next = receiver->counted != 0u && counter == receiver->counter;
    if (!next && !begins_anew(receiver)) {
        receiver->errors++;
        return false;
    }
    receiver->counted = 1u;
    receiver->counter = (counter + 1u) & 0xFFFFu;
    return true;
}

bool frame_take(frame_receiver_t *receiver, uint16_t octet, uint32_t now)
{
    frame_listen(receiver, now);
    receiver->heard_at = now;
    if (receiver->dropping != 0u) {
        return false;
    }
    receiver->octets[receiver->count] = octet & 0xFFu;
    receiver->count++;
    if (receiver->count < 2u) {
        return false;
    }
    const uint32_t length = length_of(receiver);
    if (length == 0u || length > FRAME_MAX_CTO) {
        drop(receiver);
        return false;
    }
    const uint32_t whole = receiver->tail != 0u ? body(length) + FRAME_TAIL : FRAME_HEADER + length;
    if (receiver->count < whole) {
        return false;
    }
    receiver->count = 0u;
    if (!judge(receiver)) {
        return false;
    }
    receiver->frames++;
    return true;
}

frame_packet_t frame_packet(const frame_receiver_t *receiver)
{
    return (frame_packet_t){&receiver->octets[FRAME_HEADER], length_of(receiver)};
}

void frame_sender_init(frame_sender_t *sender)
{
    memset(sender, 0, sizeof *sender);
}

void frame_close(frame_sender_t *sender, uint32_t count)
{
    sender->octets[0] = (uint16_t)(count & 0xFFu);
    sender->octets[1] = (uint16_t)(count >> 8);
    sender->octets[2] = (uint16_t)(sender->counter & 0xFFu);
    sender->octets[3] = (uint16_t)(sender->counter >> 8);
    sender->counter = (sender->counter + 1u) & 0xFFFFu;
    sender->count = FRAME_HEADER + count;
    sender->sent = 0u;
    if (sender->tail != 0u) {
        const uint32_t end = body(count);
        sender->octets[FRAME_HEADER + count] = 0u; /* the fill octet, or an octet that the sum overwrites */
        const uint32_t sum = sum_of(sender->octets, end);
        sender->octets[end] = (uint16_t)(sum & 0xFFu);
        sender->octets[end + 1u] = (uint16_t)(sum >> 8);
        sender->count = end + FRAME_TAIL;
    }
}
