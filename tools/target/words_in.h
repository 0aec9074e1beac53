/* Reads a recording of 32-bit words, lowest octet first; take() supplies the next word. */
#ifndef TOOLS_TARGET_WORDS_IN_H
#define TOOLS_TARGET_WORDS_IN_H

#include <stdint.h>
#include <stdio.h>
#include <string.h>

/* The next word; each program has its own. */
static uint32_t take(void);

/* The next word of a file. */
static inline uint32_t recording_word(FILE *file)
{
    uint32_t word = 0u;
    for (unsigned n = 0; n < 4u; n++) {
        word |= (uint32_t)(getc(file) & 0xFF) << 8u * n;
    }
    return word;
}

static inline void take_words(void *slots, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        const uint32_t word = take();
        memcpy((char *)slots + 4u * n, &word, 4);
    }
}

#endif
