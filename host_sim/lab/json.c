#include "host_sim/lab/json.h"

#include <math.h>

void json_text(FILE *file, const char *text)
{
    if (text == NULL) {
        fputs("null", file);
        return;
    }
    fputc('"', file);
    for (const unsigned char *c = (const unsigned char *)text; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\') {
            fprintf(file, "\\%c", *c);
        } else if (*c < 0x20u) {
            fprintf(file, "\\u%04x", *c);
        } else {
            fputc(*c, file);
        }
    }
    fputc('"', file);
}

void json_number(FILE *file, double number)
{
    if (isfinite(number)) {
        fprintf(file, "%.9g", number);
    } else {
        fputs("null", file);
    }
}
