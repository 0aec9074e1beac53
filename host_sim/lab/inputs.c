#include "host_sim/lab/inputs.h"

#include <pthread.h>
#include <stddef.h>
#include <sys/stat.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct {
    dev_t device;
    ino_t node;
} inputs[INPUTS_MAX];
static size_t count;

static bool known(const struct stat *file)
{
    for (size_t n = 0; n < count; n++) {
        if (inputs[n].device == file->st_dev && inputs[n].node == file->st_ino) {
            return true;
        }
    }
    return false;
}

static void note(const struct stat *file)
{
    pthread_mutex_lock(&lock);
    if (S_ISREG(file->st_mode) && count < INPUTS_MAX && !known(file)) {
        inputs[count].device = file->st_dev;
        inputs[count].node = file->st_ino;
        count++;
    }
    pthread_mutex_unlock(&lock);
}

void inputs_note(const char *path)
{
    struct stat file;
    if (stat(path, &file) == 0) {
        note(&file);
    }
}

void inputs_note_descriptor(int descriptor)
{
    struct stat file;
    if (fstat(descriptor, &file) == 0) {
        note(&file);
    }
}

bool inputs_have(const char *path)
{
    struct stat file;
    if (stat(path, &file) != 0) {
        return false;
    }
    pthread_mutex_lock(&lock);
    const bool have = known(&file);
    pthread_mutex_unlock(&lock);
    return have;
}
