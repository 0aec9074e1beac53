/* Inputs and outputs of a drive's interrupt, for a replay on another machine. A file of 32-bit words, lowest
 * octet first:
 *
 *     head         RECORDING_MAGIC, hash over the tables params, requests and signals, number of parts
 *     each part    its name, RECORDING_NAME words of four characters
 *                  number of periods
 *                  1: a worst case that has to fit the interrupt; 0: for information
 *                  all slots of the parameters with which the drive is made, because a part is a power-on
 *     each period  1, all slots of the parameters whose tuning is offered to this step and was not before,
 * and the assumed values; or 0 all slots of the active requests samples all slots of the signals after the
 * step command: duties, gates, outputs
 *
 * Slots are in the order of their table; a float is its bits. The magic number identifies the estimator of
 * the drive. The first part is an ordinary second; the others force rare events. */
#ifndef TESTS_TARGET_RECORDING_H
#define TESTS_TARGET_RECORDING_H

#include "drive/drive.h"
#include "settings/signals.h"

#ifdef LAGLESS_ESTIMATOR_FIXED
#define RECORDING_MAGIC     UINT32_C(0x534C474C)
#define RECORDING_ESTIMATOR "fixed-point estimator"
#else
#define RECORDING_MAGIC     UINT32_C(0x334C474C)
#define RECORDING_ESTIMATOR "float estimator"
#endif

#define RECORDING_NAME  8u  /* [words] */
#define RECORDING_PARTS 16u /* at most */

static inline uint32_t recording_tables(void)
{
    return table_hash(&signals_table, table_hash(&requests_table, table_hash(&params_table, 0u)));
}

/* Samples and command as words, and back: the structs are made of 32-bit slots on every target. */
#define RECORDING_SAMPLES ((uint32_t)(sizeof(drive_samples_t) / sizeof(uint32_t)))
#define RECORDING_COMMAND ((uint32_t)(sizeof(drive_command_t) / sizeof(uint32_t)))

_Static_assert(sizeof(assumed_t) % sizeof(uint32_t) == 0u &&
                   sizeof(drive_samples_t) % sizeof(uint32_t) == 0u &&
                   sizeof(drive_command_t) % sizeof(uint32_t) == 0u,
               "a slot is not of 32 bits");

#endif
