/* The file of a record for a replay (rig_replay_begin): text, so that a person can read what it needs.
 *
 *     lagless replay 1               format
 *     firmware 0.1.0                 version of the drive's program
 *     tables lagless-1a2b3c4d        identity of its tables, as `lagless connect` shows it
 *     layout 5e6f7a8b                identity of the layout of its state
 *     board pm50rl1a060
 *     carrier 100000 ns              period of the carrier
 *     reason 13 overcurrent          of the fault; 0 none: another trigger
 *     period 10213                   of the trigger, by the drive's count
 *     set motor_pole_pairs = 4       the parameters with which the replay begins, one a line
 *     slots 4100
 *     0123abcd ...                   eight a line, 32 bits each, hexadecimal
 *     check 0123456789abcdef         FNV-1a, 64 bits, of all octets before this line
 *
 * The slots alone decide the replay; the lines before them repeat what they contain, and are compared with
 * it.
 */
#ifndef HOST_SIM_LAB_REPLAY_FILE_H
#define HOST_SIM_LAB_REPLAY_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host_sim/rig/rig.h"

#define REPLAY_FILE_FIRST "lagless replay " /* what the first line of such a file begins with */
#define REPLAY_FILE_WHY   512u

typedef struct {
    rig_record_t record;
    char tables[24];
    uint32_t count; /* [slots] */
    uint32_t *slots;
} replay_file_t;

/* Errors of the disk stay in the FILE. */
void replay_file_write(FILE *file, const char *tables, const uint32_t *slots, uint32_t count);

/* Identity of the drive's tables in this program, "lagless-1a2b3c4d". */
const char *replay_file_tables(char to[24]);

/* false: `why` names the line, the error and the accepted values. Whether the record is of another firmware
 * or board is checked by rig_replay_begin(), except for the tables. */
bool replay_file_read(const char *path, replay_file_t *to, char why[REPLAY_FILE_WHY]);
void replay_file_free(replay_file_t *file);

#endif
