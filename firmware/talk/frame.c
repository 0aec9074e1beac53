#include "talk/frame.h"

#include <string.h>

void frame_receiver_init(frame_receiver_t *receiver, uint32_t silence)
{
    memset(receiver, 0, sizeof *receiver);
    receiver->silence = silence;
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

static uint32_t length_of(const frame_receiver_t *receiver)
{
    return (uint32_t)receiver->octets[0] | (uint32_t)receiver->octets[1] << 8;
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
    if (receiver->count < FRAME_HEADER + length) {
        return false;
    }
    receiver->count = 0u;
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
}
