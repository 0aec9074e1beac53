#include "host_sim/lab/xml.h"

const char *xml_entity(uint32_t code)
{
    switch (code) {
    case '&':
        return "&amp;";
    case '<':
        return "&lt;";
    case '>':
        return "&gt;";
    case '"':
        return "&quot;";
    default:
        return NULL;
    }
}

void xml_text(FILE *file, const char *text)
{
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; c++) {
        const char *entity = xml_entity(*c);
        if (entity != NULL) {
            fputs(entity, file);
        } else {
            fputc(*c, file);
        }
    }
}
