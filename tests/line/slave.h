/* A slave for the tests of the master: a thread at the other end of a socket pair. It keeps values by
 * address, misbehaves on command, and records the requests that it received. Its answers are written here
 * from the tables of the standard, without the slave of the firmware. */
#ifndef TESTS_LINE_SLAVE_H
#define TESTS_LINE_SLAVE_H

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

#define SLAVE_SLOTS 64u
#define SLAVE_ASKED 512u
#define SLAVE_MUTE  1000000u

typedef struct {
    uint32_t extension, address, bits;
} slave_slot_t;

typedef struct {
    int descriptor;
    pthread_t thread;
    pthread_mutex_t lock; /* protects all fields below */

    slave_slot_t slots[SLAVE_SLOTS];
    uint32_t slot_count;
    uint32_t epk_hash;
    uint32_t clock;     /* [periods] */
    uint8_t connect[8]; /* the answer to CONNECT */
    /* Frames have tails; wrong frames and frames out of sequence are dropped; a write must come twice. */
    bool serial;
    uint32_t dropped; /* number of dropped frames */

    /* misbehaviour */
    uint32_t mute; /* number of answers that are not sent; from SLAVE_MUTE on no answer is ever sent again */
    uint32_t mute_at;  /* the next answer to this command is not sent; 0: none */
    uint32_t late;     /* [ms] delay of the next answer */
    uint32_t busy;     /* number of times that the next command is answered by "busy" */
    uint32_t pending;  /* number of "pending" events before the next answer, 0.6 s apart */
    uint32_t error_at; /* this command is refused with `error` */
    uint32_t error;
    uint32_t split;        /* [octets] an answer is sent in pieces of this length; 0: whole */
    uint32_t noise;        /* number of meaningless octets before the next answer */
    uint32_t counter_jump; /* added to the frame counter before the next answer */
    uint32_t spoil;        /* this bit of the value of the next DOWNLOAD is inverted; 0: none */
    bool close_next;       /* closes the line at the next command */
    bool closed;

    /* samples */
    uint32_t rows; /* rows of the list that was written */
    uint32_t row_addresses[32];
    uint32_t entries[16]; /* number of rows in each packet */
    uint32_t lists;
    uint32_t prescaler;
    bool running;

    uint8_t asked[SLAVE_ASKED]; /* codes of the received commands */
    uint32_t asked_count;
    uint16_t counter;
    uint32_t next;    /* counter of the master's next frame; values above 16 bits accept any */
    uint8_t once[64]; /* a command that has come once so far */
} slave_t;

/* Starts the slave; returns the socket for the master. */
int slave_start(slave_t *slave);
void slave_end(slave_t *slave);

void slave_put(slave_t *slave, uint32_t extension, uint32_t address, uint32_t bits);
uint32_t slave_get(slave_t *slave, uint32_t extension, uint32_t address);
uint32_t slave_count(slave_t *slave, uint8_t command); /* number of received commands with this code */

/* Sends a sample with this stamp; its octets are those of `slots`. */
void slave_sample(slave_t *slave, uint32_t stamp, const uint32_t *slots);
void slave_octets(slave_t *slave, const uint8_t *octets, uint32_t count);

#endif
