/* Values as JSON. */
#ifndef HOST_SIM_LAB_JSON_H
#define HOST_SIM_LAB_JSON_H

#include <stdio.h>

/* Text as a string, quotes included; NULL: null. */
void json_text(FILE *file, const char *text);

/* A number; null if it is not finite. */
void json_number(FILE *file, double number);

#endif
