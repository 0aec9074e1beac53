/* A slave for tests of the master: a thread at the other end of a socket pair that keeps slots by address,
 * misbehaves on command, and records the requests that it got. Its answers are written here by hand from
 * the
 * standard's tables, not by the firmware's slave. */
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
    pthread_mutex_t lock; /* of all below */

    slave_slot_t slots[SLAVE_SLOTS];
    uint32_t slot_count;
    uint32_t epk_hash;
    uint32_t clock;     /* [periods] */
    uint8_t connect[8]; /* the answer to CONNECT */
    bool
        serial; /* frames have tails; wrong ones and those out of sequence are dropped; a write comes twice */
    uint32_t dropped; /* frames that were */

    /* misbehaviour */
    uint32_t mute;     /* answers that are not sent; SLAVE_MUTE and more: none ever again */
    uint32_t mute_at;  /* command whose next answer is not sent; 0: none */
    uint32_t late;     /* [ms] before the next answer, once */
    uint32_t busy;     /* times that the next command is answered by "busy" */
    uint32_t pending;  /* events "pending" before the next answer, 0.6 s apart */
    uint32_t error_at; /* command that is refused, with `error` */
    uint32_t error;
    uint32_t split;        /* [octets] of which an answer is sent at a time; 0: whole */
    uint32_t noise;        /* octets of rubbish before the next answer */
    uint32_t counter_jump; /* added to the frame counter before the next answer */
    uint32_t spoil;        /* bit of the next DOWNLOAD's value that acts inverted; 0: none */
    bool close_next;       /* closes the line at the next command */
    bool closed;

    /* samples */
    uint32_t rows; /* of the list that was written */
    uint32_t row_addresses[32];
    uint32_t entries[16]; /* rows of each packet */
    uint32_t lists;
    uint32_t prescaler;
    bool running;

    uint8_t asked[SLAVE_ASKED]; /* codes of the commands that came */
    uint32_t asked_count;
    uint16_t counter;
    uint32_t next;    /* counter of the master's next frame; above 16 bits: any */
    uint8_t once[64]; /* a command that has come once */
} slave_t;

/* Starts it; returns the master's end. */
int slave_start(slave_t *slave);
void slave_end(slave_t *slave);

void slave_put(slave_t *slave, uint32_t extension, uint32_t address, uint32_t bits);
uint32_t slave_get(slave_t *slave, uint32_t extension, uint32_t address);
uint32_t slave_count(slave_t *slave, uint8_t command); /* number of requests */

/* Sends a sample with this stamp, with `slots` as its plain octets. */
void slave_sample(slave_t *slave, uint32_t stamp, const uint32_t *slots);
void slave_octets(slave_t *slave, const uint8_t *octets, uint32_t count);

#endif
