#include "host_sim/cli/streams.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host_sim/cli/cli.h"
#include "host_sim/lab/json.h"

#define MESSAGE_SIZE 4096u
#define PLACE_SIZE   512u

static struct {
    bool json;
    uint64_t written; /* [octets] on stdout, with --json */
    char message[MESSAGE_SIZE];
    size_t length;
    char file[PLACE_SIZE], name[PLACE_SIZE];
    uint32_t line, column;
} streams;

/* ---- with --json both streams are redirected to these functions ---- */

static ssize_t to_descriptor(int descriptor, const char *octets, size_t count)
{
    size_t done = 0;
    while (done < count) {
        const ssize_t part = write(descriptor, octets + done, count - done);
        if (part < 0 && errno != EINTR) {
            return 0; /* how a stream reports an error; errno is that of write() */
        }
        done += part > 0 ? (size_t)part : 0u;
    }
    return (ssize_t)count;
}

static ssize_t write_output(void *cookie, const char *octets, size_t count)
{
    (void)cookie;
    streams.written += count;
    return to_descriptor(STDOUT_FILENO, octets, count);
}

static ssize_t write_message(void *cookie, const char *octets, size_t count)
{
    (void)cookie;
    const size_t room = sizeof streams.message - 1u - streams.length;
    const size_t kept = count < room ? count : room;
    memcpy(streams.message + streams.length, octets, kept);
    streams.length += kept;
    (void)to_descriptor(STDERR_FILENO, octets, count);
    return (ssize_t)count;
}

static void pass_through(void)
{
    FILE *output = fopencookie(NULL, "w", (cookie_io_functions_t){.write = write_output});
    FILE *messages = fopencookie(NULL, "w", (cookie_io_functions_t){.write = write_message});
    if (output == NULL || messages == NULL) {
        return; /* the message is printed as without --json */
    }
    setvbuf(messages, NULL, _IONBF, 0);
    stdout = output;
    stderr = messages;
    streams.json = true;
}

/* ---- the end ---- */

static void print_error(int exit_code)
{
    char *message = streams.message;
    streams.message[streams.length] = '\0';
    while (streams.length > 0u && message[streams.length - 1u] == '\n') {
        message[--streams.length] = '\0';
    }
    printf("{\"error\": {\"exit_code\": %d, \"message\": ", exit_code);
    json_text(stdout, message);
    printf(", \"file\": ");
    json_text(stdout, streams.file[0] != '\0' ? streams.file : NULL);
    printf(streams.line > 0u ? ", \"line\": %u, \"column\": %u" : ", \"line\": null, \"column\": null",
           (unsigned)streams.line, (unsigned)streams.column);
    printf(", \"name\": ");
    json_text(stdout, streams.name[0] != '\0' ? streams.name : NULL);
    printf("}}\n");
}

static void at_end(int exit_code, void *nothing)
{
    (void)nothing;
    errno = 0;
    bool lost = fflush(stdout) != 0;
    if (!lost && streams.json && streams.written == 0u && exit_code >= EXIT_USAGE) {
        print_error(exit_code);
    }
    lost = ferror(stdout) != 0 || lost;
    lost = fclose(stdout) != 0 || lost;
    if (lost) {
        dprintf(STDERR_FILENO, "lagless: standard output could not be written%s%s\n", errno != 0 ? ": " : "",
                errno != 0 ? strerror(errno) : "");
        _exit(EXIT_INTERNAL);
    }
}

/* ---- the beginning ---- */

static bool wants_json(int argc, char **argv)
{
    for (int n = 1; n < argc && strcmp(argv[n], "--") != 0; n++) {
        const size_t length = strlen(argv[n]);
        if ((length > 2u && strncmp(argv[n], "--json", length) == 0) || strcmp(argv[n], "-j") == 0) {
            return true;
        }
    }
    return false;
}

void streams_begin(int argc, char **argv)
{
    for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; descriptor++) {
        if (fcntl(descriptor, F_GETFD) == -1 && errno == EBADF) {
            /* open() returns the lowest free number, which is that of this stream; it is opened for reading,
             * so that writes fail
             */
            (void)open("/dev/null", descriptor == STDOUT_FILENO ? O_RDONLY : O_RDWR);
        }
    }
    if (wants_json(argc, argv)) {
        pass_through();
    }
    on_exit(at_end, NULL);
}

void streams_at(const char *file, uint32_t line, uint32_t column, const char *name)
{
    snprintf(streams.file, sizeof streams.file, "%s", file);
    snprintf(streams.name, sizeof streams.name, "%s", name);
    streams.line = line;
    streams.column = column;
}
