/* Text in XML. */
#ifndef HOST_SIM_LAB_XML_H
#define HOST_SIM_LAB_XML_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Replacement of a character that is markup, in text and in a quoted value; NULL: no replacement. */
const char *xml_entity(uint32_t code);

/* Writes one line of printable UTF-8. */
void xml_text(FILE *file, const char *text);

#endif
