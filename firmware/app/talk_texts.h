/* Texts that the drive sends over the serial link: its description, its identification, the name of its
 * event. Only talk_values.c uses it. */
#ifndef APP_TALK_TEXTS_H
#define APP_TALK_TEXTS_H

#include <stdbool.h>
#include <stdint.h>

/* True for XCP_EXTENSION_A2L, _EPK and _EVENT. */
bool talk_is_text(uint32_t extension);

uint32_t talk_text_length(uint32_t extension); /* [octets] */

/* Octets of the text from this address on, one per word. XCP_OK, or XCP_OUT_OF_RANGE beyond its end. */
uint32_t talk_read_text(uint32_t extension, uint32_t address, uint32_t count, uint16_t *octets);

#endif
