/* A ZIP archive, every file stored as it is. The same files give the same octets: no file has a date but the
 * first one that the format knows, 1980-01-01. */
#ifndef HOST_SIM_LAB_ZIP_H
#define HOST_SIM_LAB_ZIP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define ZIP_FILES 8u   /* [-] at most */
#define ZIP_NAME  100u /* [octets] of a name with its 0, at most */

/* All zero but the file: an empty archive. */
typedef struct {
    FILE *file;       /* open for writing, at its begin */
    uint32_t written; /* [octets] */
    uint32_t count;   /* [-] files */
    struct {
        char name[ZIP_NAME];
        uint32_t at, octets, check; /* [octets] place of its head, size; CRC-32 */
    } files[ZIP_FILES];
} zip_t;

/* Adds a file. Errors of the disk stay in the FILE. false: the archive has no room for it. */
bool zip_add(zip_t *zip, const char *name, const void *octets, size_t count);

/* Writes the directory; the FILE stays open. */
void zip_end(zip_t *zip);

#endif
