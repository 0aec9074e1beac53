/* A plugin of QEMU for tools/cost: records the blocks of instructions that a program enters, in their order.
 *It writes two files into FOLDER. blocks.txt has one line for each block that QEMU translates, with its
 *address. entered.bin has the number of each block that is entered, counted from 0, in 16 bits, lowest octet
 *first.
 *
 * -plugin FILE,folder=FOLDER[,range=FIRST-LAST]...   records the blocks that begin in one of the ranges;
 *                                                    without a range all blocks
 *
 * The declarations are copied from QEMU's plugin API (qemu-plugin.h), because the packages of QEMU do not
 * contain this header. */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORT __attribute__((visibility("default")))

typedef uint64_t qemu_plugin_id_t;
struct qemu_plugin_tb;
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t id,
                                           void (*call)(qemu_plugin_id_t, struct qemu_plugin_tb *));
void qemu_plugin_register_vcpu_tb_exec_cb(struct qemu_plugin_tb *tb, void (*call)(unsigned, void *),
                                          int flags, void *data);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t id, void (*call)(qemu_plugin_id_t, void *), void *data);
uint64_t qemu_plugin_tb_vaddr(const struct qemu_plugin_tb *tb);

EXPORT extern int qemu_plugin_version;
int qemu_plugin_version = PLUGIN_VERSION;

enum { RANGES = 1000, BLOCKS = 0xD800 }; /* the numbers that are complete characters of UTF-16 */

static struct {
    uint64_t first, last;
} ranges[RANGES];
static unsigned range_count, block_count;
static FILE *listing, *entered;

static bool wanted(uint64_t address)
{
    for (unsigned n = 0; n < range_count; n++) {
        if (address >= ranges[n].first && address <= ranges[n].last) {
            return true;
        }
    }
    return range_count == 0u;
}

static void on_entry(unsigned cpu, void *number)
{
    (void)cpu;
    const uintptr_t block = (uintptr_t)number;
    putc_unlocked((int)(block & 0xFFu), entered);
    putc_unlocked((int)(block >> 8), entered);
}

static void on_translation(qemu_plugin_id_t id, struct qemu_plugin_tb *tb)
{
    (void)id;
    if (!wanted(qemu_plugin_tb_vaddr(tb))) {
        return;
    }
    if (block_count == BLOCKS) {
        fprintf(stderr, "blocks: the program has more than %d blocks\n", BLOCKS);
        exit(1);
    }
    fprintf(listing, "%llu\n", (unsigned long long)qemu_plugin_tb_vaddr(tb));
    qemu_plugin_register_vcpu_tb_exec_cb(tb, on_entry, 0, (void *)(uintptr_t)block_count++);
}

static void on_end(qemu_plugin_id_t id, void *data)
{
    (void)id;
    (void)data;
    if (fclose(listing) != 0 || fclose(entered) != 0) {
        perror("blocks");
        exit(1);
    }
}

static FILE *made(const char *folder, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    if (file == NULL) {
        perror(path);
    }
    return file;
}

EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const void *info, int argc, char **argv);
EXPORT int qemu_plugin_install(qemu_plugin_id_t id, const void *info, int argc, char **argv)
{
    (void)info;
    const char *folder = ".";
    for (int n = 0; n < argc; n++) {
        if (strncmp(argv[n], "folder=", 7) == 0) {
            folder = argv[n] + 7;
        } else if (strncmp(argv[n], "range=", 6) == 0 && range_count < RANGES) {
            char *end;
            ranges[range_count].first = strtoull(argv[n] + 6, &end, 0);
            ranges[range_count++].last = strtoull(end + 1, NULL, 0);
        } else {
            fprintf(stderr, "blocks: %s: accepted: folder=FOLDER and up to %d times range=FIRST-LAST\n",
                    argv[n], RANGES);
            return 1;
        }
    }
    listing = made(folder, "blocks.txt");
    entered = made(folder, "entered.bin");
    if (listing == NULL || entered == NULL) {
        return 1;
    }
    qemu_plugin_register_vcpu_tb_trans_cb(id, on_translation);
    qemu_plugin_register_atexit_cb(id, on_end, NULL);
    return 0;
}
