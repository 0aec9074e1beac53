/* Text that is generated while it is read: the characters of one window are stored, all others are only
 * counted. In this way a file of any length can be sent in pieces. */
#ifndef TALK_TEXT_H
#define TALK_TEXT_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t at;       /* [characters] written so far */
    uint32_t from, to; /* [characters] the window */
    uint16_t *octets;  /* the characters of the window, one per word */
} text_t;

/* The window of this many characters from this position on; `octets` has space for them. */
static inline text_t text_window(uint32_t from, uint32_t count, uint16_t *octets)
{
    return (text_t){0u, from, from + count, octets};
}

static inline void text_put_octet(text_t *text, uint16_t octet)
{
    if (text->at >= text->from && text->at < text->to) {
        text->octets[text->at - text->from] = octet & 0xFFu;
    }
    text->at++;
}

void text_put(text_t *text, const char *string);

/* Writes the string in double quotes, with \ before quotes within it. */
void text_quoted(text_t *text, const char *string);

void text_whole(text_t *text, int64_t value);
void text_hex(text_t *text, uint32_t value, uint32_t digits); /* in lower case, without 0x */

/* Writes a finite float as the shortest decimal number that reads back as the same float. */
void text_float(text_t *text, float value);

#endif
