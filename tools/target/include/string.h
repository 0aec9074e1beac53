/* For clang as a 16-bit compiler, which has no C library: the functions of it that firmware and hal may
 * use. */
#ifndef TARGET_STRING_H
#define TARGET_STRING_H

#include <stddef.h>

void *memcpy(void *to, const void *from, size_t size);
void *memset(void *to, int value, size_t size);
size_t strlen(const char *text);
char *strchr(const char *text, int character);
int strcmp(const char *one, const char *other);
int strncmp(const char *one, const char *other, size_t size);

#endif
