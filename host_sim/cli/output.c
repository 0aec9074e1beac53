#include "host_sim/cli/output.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

double output_seconds(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static bool make_folder(const char *path)
{
    struct stat found;
    if (mkdir(path, 0777) == 0) {
        return true;
    }
    if (errno == EEXIST && stat(path, &found) == 0 && S_ISDIR(found.st_mode)) {
        return true;
    }
    fprintf(stderr, "lagless: cannot make folder %s: %s\n", path,
            strerror(errno == EEXIST ? ENOTDIR : errno));
    return false;
}

bool output_folder(const char *path)
{
    char part[PATH_SIZE];
    const size_t length = strlen(path);
    if (length == 0 || length >= sizeof part) {
        fprintf(stderr, "lagless: output folder: a path of 1 to %d octets is needed\n", PATH_SIZE - 1);
        return false;
    }
    for (size_t n = 1; n <= length; n++) {
        if (path[n] == '/' || path[n] == '\0') {
            memcpy(part, path, n);
            part[n] = '\0';
            if (!make_folder(part)) {
                return false;
            }
        }
    }
    return true;
}

bool output_path(char path[PATH_SIZE], const char *folder, const char *name)
{
    const int length = snprintf(path, PATH_SIZE, "%s/%s", folder, name);
    if (length < 0 || length >= PATH_SIZE) {
        fprintf(stderr, "lagless: path too long: %s/%s\n", folder, name);
        return false;
    }
    return true;
}

FILE *output_open(const char *path)
{
    FILE *file = fopen(path, "w");
    if (file == NULL) {
        fprintf(stderr, "lagless: cannot write %s: %s\n", path, strerror(errno));
    }
    return file;
}

FILE *output_open_in(char path[PATH_SIZE], const char *folder, const char *name)
{
    return output_path(path, folder, name) ? output_open(path) : NULL;
}

bool output_close(FILE *file, const char *path)
{
    if (file == NULL) {
        return false;
    }
    const bool written = ferror(file) == 0;
    if (fclose(file) != 0 || !written) {
        fprintf(stderr, "lagless: %s is not complete: %s\n", path, strerror(errno));
        return false;
    }
    return true;
}

static const char *setting(const char *variable, const char *standard)
{
    const char *value = getenv(variable);
    return value != NULL && value[0] != '\0' ? value : standard;
}

bool output_picture(const char *script, const char *data, const char *png, const char *title)
{
    char path[PATH_SIZE];
    char *python = strdup(setting("LAGLESS_PYTHON", LAGLESS_PYTHON));
    if (python == NULL || !output_path(path, setting("LAGLESS_TOOLS", LAGLESS_TOOLS), script)) {
        free(python);
        return false;
    }

    int status = -1;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        execlp(python, python, "-B", path, data, png, "--title", title,
               (char *)NULL); /* png NULL: ends there */
        fprintf(stderr, "lagless: cannot run Python (%s): %s\n", python, strerror(errno));
        _exit(127);
    }
    const bool drawn =
        child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    if (!drawn) {
        fprintf(stderr, "lagless: no picture was drawn; the data are in %s\n", data);
    }
    free(python);
    return drawn;
}

bool output_colours(FILE *file)
{
    const char *no = getenv("NO_COLOR");
    return (no == NULL || no[0] == '\0') && isatty(fileno(file));
}

void output_suggest(FILE *file, const char *near)
{
    if (near != NULL) {
        fprintf(file, "; did you mean %s?", near);
    }
}
