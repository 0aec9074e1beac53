/* The input of a program on a simulated target: a file, or the octets of the AVR's simulator
 * (avr/simulator.c). */
#ifndef TOOLS_TARGET_TARGET_IN_H
#define TOOLS_TARGET_TARGET_IN_H

#include <stdbool.h>

#include "tools/target/words_in.h"

#ifdef REPLAY_FILE
static FILE *input;
#else
#include <avr/io.h> /* GPIOR2: the next octet of the simulator's input */
#endif

/* false: there is no file, as the message of this program says. */
static inline bool target_opens(const char *program)
{
#ifdef REPLAY_FILE
    input = fopen(REPLAY_FILE, "rb");
    if (input == NULL) {
        printf("%s: no file " REPLAY_FILE "; the preset host makes it\n", program);
        return false;
    }
#else
    (void)program;
#endif
    return true;
}

static uint32_t take(void)
{
#ifdef REPLAY_FILE
    return recording_word(input);
#else
    uint32_t word;
    unsigned char octets[sizeof word]; /* lowest first, as in the memory of the processor */
    for (unsigned n = 0; n < sizeof octets; n++) {
        octets[n] = GPIOR2;
    }
    memcpy(&word, octets, sizeof word);
    return word;
#endif
}

#endif
