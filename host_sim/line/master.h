/* An XCP master for this drive, over TCP or a serial device: values by the rows of the tables, orders,
 * samples of every period, the capture buffer, the fault log.
 *
 * The core does not wait. A poll loop uses master_descriptor, master_events and master_patience, and calls
 * master_work when one of them is due. master_work delivers answers and samples by call-backs. The calls that
 * wait (master_get and so on) are such a loop around one request, so that samples continue to arrive.
 *
 * Only one command is pending at a time. A command without an answer is repeated after SYNCH; after
 * MASTER_SYNCHS of these without an answer the connection counts as lost. While the line is idle the master
 * sends a request every MASTER_ALIVE seconds, so that command_timeout of the drive does not act. If the
 * drive's time runs faster than real time, these are seconds of the drive. Call-backs must not call functions
 * that wait. */
#ifndef HOST_SIM_LINE_MASTER_H
#define HOST_SIM_LINE_MASTER_H

#include <stdbool.h>
#include <stdint.h>

#include "contract/line.h"
#include "contract/table.h"

#define MASTER_PATIENCE (1e-3 * LINE_ANSWER) /* [s] for an answer */
/* On a serial line a frame may be lost, and the drive must receive the next one before its command_timeout
 * of 1 s. The waiting time is this value plus the time of 300 octets, at most MASTER_PATIENCE. */
#define MASTER_PATIENCE_SERIAL 0.3  /* [s] */
#define MASTER_PATIENCE_ORDER  30.0 /* [s] for the answer to an order: erasing flash takes long */
#define MASTER_SYNCHS          3u /* [-] consecutive SYNCH without an answer, after which the connection is lost */
#define MASTER_ALIVE           0.1 /* [s] longest time without a command */
#define MASTER_READ_MAX        60u /* [octets] of one read */
#define MASTER_DAQ_MAX         16u /* [-] rows of one set of samples */
#define MASTER_QUEUE           64u /* [-] questions that can be queued */

typedef struct {
    char text[640]; /* one line: the object, what is wrong, what to do */
} master_error_t;

/* Address extensions of the drive. Addresses count octets: 4 x id in the first four. */
typedef enum {
    MASTER_SIGNALS,
    MASTER_PARAMS, /* the staged set */
    MASTER_REQUESTS,
    MASTER_SERVICES,
    MASTER_CAPTURE,
    MASTER_A2L,
    MASTER_EPK,
    MASTER_FAULTS
} master_extension_t;

/* Result of a request: 0, the error code of the drive (1..255), or one of these. */
#define MASTER_OK           0
#define MASTER_BUSY         0x10
#define MASTER_OUT_OF_RANGE 0x22
#define MASTER_PROTECTED    0x23
#define MASTER_LOCKED       0x25
#define MASTER_LOST         (-1) /* the connection is lost, or the drive does not answer */
#define MASTER_NOT_SENT     (-2) /* the queue is full */

typedef struct master master_t;

/* ---- life ---- */

/* "tcp://127.0.0.1:5555", or a serial device "/dev/ttyUSB0" or "/dev/ttyUSB0:115200". Opens it, connects, and
 * compares the tables of the drive with those of this program. Waits for some seconds at most. NULL: `error`
 * has the message. */
master_t *master_open(const char *target, master_error_t *error);

/* The same over an open descriptor, which the master makes non-blocking and closes. lossless: octets are
 * neither lost nor changed (TCP). */
master_t *master_over(int descriptor, bool lossless, const char *name, master_error_t *error);

/* Stops the samples, disconnects and closes. The argument may be NULL. */
void master_close(master_t *master);

/* Unlocks a drive with its line_key. The key is stored for master_again. No effect on a drive that is not
 * locked. The drive ends the connection if the key is wrong. */
bool master_unlock(master_t *master, uint32_t key, master_error_t *error);

/* Connects again after a restart of the chip, with a new TCP connection if the old one has ended; tries for
 * up to `seconds`. Samples have stopped. */
bool master_again(master_t *master, double seconds, master_error_t *error);

const char *master_name(const master_t *master); /* the target */
const char *master_epk(const master_t *master);  /* "lagless-" and 8 hex digits: identity of the tables */

/* ---- the poll loop ---- */

int master_descriptor(const master_t *master);  /* -1: the line is lost */
short master_events(const master_t *master);    /* POLLIN, and POLLOUT while something is to be sent */
double master_patience(const master_t *master); /* [s] >= 0 until master_work must be called at the latest */
bool master_work(
    master_t *master); /* does everything that is possible without waiting; false: the connection is lost */
bool master_wait(master_t *master, double seconds); /* waits and works; false: the line is lost */
const char *master_lost(const master_t *master);    /* the cause; "": not lost */

/* ---- questions that do not wait ---- */

/* `data` is valid during the call. A lost line answers all questions with MASTER_LOST. */
typedef void (*master_answer_t)(void *context, int result, const uint8_t *data, uint32_t octets);

void master_ask_read(master_t *master, master_extension_t extension, uint32_t address, uint32_t octets,
                     master_answer_t answer, void *context); /* octets <= MASTER_READ_MAX */
void master_ask_write(master_t *master, master_extension_t extension, uint32_t address, uint32_t bits,
                      master_answer_t answer, void *context); /* one slot */

/* ---- the same, waiting ---- */

bool master_read(master_t *master, master_extension_t extension, uint32_t address, uint8_t *to,
                 uint32_t octets, master_error_t *error); /* any number of octets */

/* Address of a row. false: a row of the simulation only (truth, plant, rig). */
bool master_place(const table_row_t *row, master_extension_t *extension, uint32_t *address);

/* Reads or sets a row of the drive; of a parameter the staged value (master_order "apply" activates it).
 * Requests and services act at once. A written value is read back, except for services. The message of a
 * refusal has row, value and accepted values. */
bool master_get(master_t *master, const table_row_t *row, double *value, master_error_t *error);
bool master_set(master_t *master, const table_row_t *row, double value, master_error_t *error);

/* Converts the slot of a row on the line (contract/line.h) to a value and back. false: the row does not
 * accept the value. */
double master_value_of(const table_row_t *row, uint32_t bits);
bool master_bits_of(const table_row_t *row, double value, uint32_t *bits);

/* Writes an order by its name in the row `order` ("apply", "save", ...), and waits until it is executed. */
typedef struct {
    int32_t reason;         /* [-] of the drive's table; 0: none was reported */
    const table_row_t *row; /* row of the refusal; NULL: none */
} master_refusal_t;
bool master_order(master_t *master, const char *order, master_refusal_t *refusal, master_error_t *error);

/* *staged: a parameter is staged and not applied. */
bool master_staged(master_t *master, bool *staged, master_error_t *error);

/* ---- samples ---- */

/* Called for each sample: its period by the drive's count, and the slots in the order of the rows. */
typedef void (*master_sink_t)(void *context, uint32_t period, const uint32_t *slots, uint32_t count);

typedef struct {
    uint64_t samples;        /* [-] received */
    uint64_t missing;        /* [-] missing between the received ones, by their time stamps */
    uint32_t gaps;           /* [-] number of such gaps */
    uint32_t frames_missing; /* [-] missing frames of any kind, found by their counter */
    uint32_t octets_dropped; /* [-] that were part of no frame */
} master_daq_t;

/* Signals, every `every`-th period (1..255), until master_daq_stop. */
bool master_daq_start(master_t *master, const table_row_t *const *rows, uint32_t count, uint32_t every,
                      master_sink_t sink, void *context, master_error_t *error);
bool master_daq_stop(master_t *master, master_error_t *error);
bool master_daq_running(const master_t *master);
master_daq_t master_daq(const master_t *master); /* since the start of the samples */

/* ---- capture buffer and fault log ---- */

#define MASTER_CAPTURE_MAX 12u
typedef struct {
    uint32_t count;                              /* [-] columns */
    const table_row_t *rows[MASTER_CAPTURE_MAX]; /* of the columns */
    uint32_t periods;                            /* [-] */
    uint32_t at;                                 /* [periods] of the trigger, by the drive's count */
    uint32_t after;                              /* [periods] kept after the trigger */
    uint32_t *slots;                             /* periods x count, oldest first; free() */
} master_capture_t;

/* Reads the stopped buffer; master_capture_head reads it without the slots, which are NULL. false: there is
 * no stopped buffer, or `error` has a message. */
bool master_capture_head(master_t *master, master_capture_t *capture, master_error_t *error);
bool master_capture(master_t *master, master_capture_t *capture, master_error_t *error);

/* The record for a replay, which the drive keeps with fault_record = replay: slots as rig_record gives them;
 * free(). NULL: none is held, or `error`. */
uint32_t *master_record(master_t *master, uint32_t *count, master_error_t *error);

typedef struct {
    int32_t reason;  /* [-] */
    uint32_t period; /* [periods] by the drive's count */
} master_fault_t;
#define MASTER_FAULTS_MAX 16u

/* The drive's last faults, newest first. */
bool master_faults(master_t *master, master_fault_t faults[MASTER_FAULTS_MAX], uint32_t *count,
                   master_error_t *error);

#endif
