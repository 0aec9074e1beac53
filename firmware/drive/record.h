/* The record of a period, from which the host runs the drive again: what the step received, and a checksum of
 * what it returned. It is four slots, which the capture (contract/capture.h) keeps like those of four
 * signals:
 *
 *     slot 0   bits 0..11 sensor a, 12..23 sensor b, 24..28 flags of the sample, 29..31 RECORD_CAME_... bits
 *     slot 1   bits 0..11 sensor c, 12..23 DC link, 24..31 lower octet of the encoder's count
 *     slot 2   bits 0..11 heat sink, 12..23 motor, 24..31 upper octet of the encoder's count
 *     slot 3   checksum of all commands so far
 *
 * The first three contain the codes of the converter, packed by the application, because the values in SI
 * units would need twice the space. */
#ifndef DRIVE_RECORD_H
#define DRIVE_RECORD_H

#include <stdbool.h>
#include <stdint.h>

#include "fast/fast.h"
#include "math/float_bits.h"

#define RECORD_COLUMNS 4u
#define RECORD_CODES   3u /* of them, the slots with the sample */

/* What happened between the sample of the last period and this one. */
#define RECORD_CAME_SETPOINT   UINT32_C(1) /* the medium task waits for a window: its setpoint is ready */
#define RECORD_CAME_BACKGROUND UINT32_C(2) /* the background has completed a cycle */
#define RECORD_CAME_TRIP       UINT32_C(4) /* the trip interrupt */
#define RECORD_CAME_PLACE      29u

typedef struct {
    uint32_t on;                    /* [-] 1: the capture keeps the records */
    uint32_t came;                  /* [-] RECORD_CAME_... since the last sample, except for the setpoint */
    uint32_t slots[RECORD_COLUMNS]; /* of the newest period */
} drive_record_t;

/* FNV-1a by whole slots instead of octets: a wrong bit of one command changes all later checksums. */
static inline uint32_t record_mix(uint32_t check, uint32_t bits)
{
    return (check ^ bits) * UINT32_C(16777619);
}

/* The record of a period: its sample, and the command that the step has returned. `ready`: the medium task
 * waited for a window. */
static inline void record_step(drive_record_t *record, const uint32_t codes[RECORD_CODES], bool ready,
                               const drive_command_t *command)
{
    const uint32_t came = record->came | (ready ? RECORD_CAME_SETPOINT : UINT32_C(0));
    record->came = 0u;
    record->slots[0] = codes[0] | came << RECORD_CAME_PLACE;
    record->slots[1] = codes[1];
    record->slots[2] = codes[2];
    uint32_t check = record_mix(record->slots[3], float_bits(command->duty.a));
    check = record_mix(check, float_bits(command->duty.b));
    check = record_mix(check, float_bits(command->duty.c));
    record->slots[3] = record_mix(check, (uint32_t)command->gates);
}

#endif
