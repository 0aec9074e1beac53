#include "host_sim/cli/flash_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/cli/output.h"

struct flash_file {
    const char *path;
    uint8_t kept[RIG_FLASH_SIZE + 1u]; /* the content of the file; one more octet shows that it is too long */
    uint8_t now[RIG_FLASH_SIZE];
};

static bool load(flash_file_t *file, rig_t *rig)
{
    FILE *from = fopen(file->path, "rb");
    if (from == NULL && errno == ENOENT) {
        rig_flash_save(rig, file->kept);
        return true;
    }
    if (from == NULL) {
        fprintf(stderr, "lagless: --flash %s: %s\n", file->path, strerror(errno));
        return false;
    }
    const size_t size = fread(file->kept, 1, sizeof file->kept, from);
    const bool read = ferror(from) == 0;
    fclose(from);
    if (!read || size != RIG_FLASH_SIZE) {
        fprintf(stderr,
                "lagless: --flash %s: this file was not written by this option, because its size is not %u "
                "octets; give the name of a new file\n",
                file->path, RIG_FLASH_SIZE);
        return false;
    }
    if (!rig_flash_load(rig, file->kept, size)) {
        fprintf(stderr, "lagless: --flash %s: %s\n", file->path, rig_error(rig));
        return false;
    }
    rig_power_cycle(rig);
    return true;
}

flash_file_t *flash_file_open(const char *path, rig_t *rig)
{
    flash_file_t *file = malloc(sizeof *file);
    if (file == NULL) {
        fprintf(stderr, "lagless: not enough memory\n");
        return NULL;
    }
    file->path = path;
    if (!load(file, rig)) {
        free(file);
        return NULL;
    }
    return file;
}

bool flash_file_keep(flash_file_t *file, const rig_t *rig)
{
    if (file == NULL) {
        return true;
    }
    rig_flash_save(rig, file->now);
    if (memcmp(file->now, file->kept, sizeof file->now) == 0) {
        return true;
    }
    FILE *to = output_open_own(file->path);
    if (to != NULL) {
        (void)fwrite(file->now, 1, sizeof file->now, to);
    }
    if (!output_close(to, file->path)) {
        return false;
    }
    memcpy(file->kept, file->now, sizeof file->now);
    return true;
}

void flash_file_close(flash_file_t *file)
{
    free(file);
}
