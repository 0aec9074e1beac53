/* A ZIP archive without compression. The same files give the same octets, because all files have the date
 * 1980-01-01, the first one of the format. */
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
        uint32_t at, octets, check; /* [octets] place of its header, and its size; CRC-32 */
    } files[ZIP_FILES];
} zip_t;

/* Adds a file. The FILE stores errors of the disk. false: the archive has no room for the file. */
bool zip_add(zip_t *zip, const char *name, const void *octets, size_t count);

/* Writes the directory; the FILE stays open. */
void zip_end(zip_t *zip);

#endif
