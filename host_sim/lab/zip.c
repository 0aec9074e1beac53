#include "host_sim/lab/zip.h"

#include <string.h>

#define VERSION 20u                       /* of the format, 2.0 */
#define DATE    0x0021u                   /* 1980-01-01 */
#define PLAIN   (UINT32_C(0100644) << 16) /* attributes of a plain file that all may read */

/* ISO 3309, bit by bit. */
static uint32_t crc32(const unsigned char *octets, size_t count)
{
    uint32_t crc = UINT32_C(0xFFFFFFFF);
    for (size_t n = 0; n < count; n++) {
        crc ^= octets[n];
        for (uint32_t bit = 0; bit < 8u; bit++) {
            crc = (crc & 1u) != 0u ? crc >> 1 ^ UINT32_C(0xEDB88320) : crc >> 1;
        }
    }
    return ~crc;
}

static void put(zip_t *zip, uint32_t value, uint32_t octets)
{
    for (uint32_t n = 0; n < octets; n++) {
        fputc((int)(value >> 8u * n & 0xFFu), zip->file);
    }
    zip->written += octets;
}

static void put_octets(zip_t *zip, const void *octets, uint32_t count)
{
    (void)!fwrite(octets, 1, count, zip->file);
    zip->written += count;
}

/* The fields that the header of a file and its directory entry have in common: version to the length of the
 * name. */
static void put_file(zip_t *zip, uint32_t n)
{
    put(zip, VERSION, 2);
    put(zip, 0, 4); /* flags; method 0: stored */
    put(zip, 0, 2); /* time */
    put(zip, DATE, 2);
    put(zip, zip->files[n].check, 4);
    put(zip, zip->files[n].octets, 4);
    put(zip, zip->files[n].octets, 4);
    put(zip, (uint32_t)strlen(zip->files[n].name), 2);
    put(zip, 0, 2); /* no extra field */
}

bool zip_add(zip_t *zip, const char *name, const void *octets, size_t count)
{
    const uint64_t after = (uint64_t)zip->written + count;
    if (zip->count == ZIP_FILES || strlen(name) >= ZIP_NAME || after > INT32_MAX) {
        return false;
    }
    const uint32_t n = zip->count++;
    strcpy(zip->files[n].name, name);
    zip->files[n].at = zip->written;
    zip->files[n].octets = (uint32_t)count;
    zip->files[n].check = crc32(octets, count);
    put(zip, UINT32_C(0x04034B50), 4);
    put_file(zip, n);
    put_octets(zip, name, (uint32_t)strlen(name));
    put_octets(zip, octets, (uint32_t)count);
    return true;
}

void zip_end(zip_t *zip)
{
    const uint32_t at = zip->written;
    for (uint32_t n = 0; n < zip->count; n++) {
        put(zip, UINT32_C(0x02014B50), 4);
        put(zip, 3u << 8 | VERSION, 2); /* made on UNIX */
        put_file(zip, n);
        put(zip, 0, 2); /* no comment */
        put(zip, 0, 4); /* first disk; no text */
        put(zip, PLAIN, 4);
        put(zip, zip->files[n].at, 4);
        put_octets(zip, zip->files[n].name, (uint32_t)strlen(zip->files[n].name));
    }
    const uint32_t octets = zip->written - at;
    put(zip, UINT32_C(0x06054B50), 4);
    put(zip, 0, 4); /* one disk */
    put(zip, zip->count, 2);
    put(zip, zip->count, 2);
    put(zip, octets, 4);
    put(zip, at, 4);
    put(zip, 0, 2); /* no comment */
}
