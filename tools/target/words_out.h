/* Writes a recording of 32-bit words, lowest octet first. */
#ifndef TOOLS_TARGET_WORDS_OUT_H
#define TOOLS_TARGET_WORDS_OUT_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static FILE *file;

static inline void put(uint32_t word)
{
    for (uint32_t shift = 0; shift < 32u; shift += 8u) {
        if (putc((int)(word >> shift & 0xFFu), file) == EOF) {
            perror("recording");
            exit(3);
        }
    }
}

static inline void put_words(const void *slots, uint32_t count)
{
    for (uint32_t n = 0; n < count; n++) {
        uint32_t word;
        memcpy(&word, (const char *)slots + 4u * n, 4);
        put(word);
    }
}

#endif
