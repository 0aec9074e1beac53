#include "host_sim/cli/output.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "host_sim/cli/cli.h"
#include "host_sim/lab/inputs.h"
#include "host_sim/lab/recorder.h"

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
        fprintf(stderr, "lagless: output folder: accepted: a path of 1 to %d bytes\n", PATH_SIZE - 1);
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

bool output_fresh_folder(char path[PATH_SIZE], const char *parent, const char *name)
{
    if (!output_folder(parent)) {
        return false;
    }
    for (unsigned n = 1;; n++) {
        char fresh[300];
        snprintf(fresh, sizeof fresh, n == 1u ? "%.255s" : "%.255s_%u", name, n);
        if (!output_path(path, parent, fresh)) {
            return false;
        }
        if (mkdir(path, 0777) == 0) {
            return true;
        }
        if (errno != EEXIST) {
            fprintf(stderr, "lagless: cannot make folder %s: %s\n", path, strerror(errno));
            return false;
        }
    }
}

bool output_claim(const char *path)
{
    if (!output_folder(path)) {
        return false;
    }
    const int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC); /* held until the program ends */
    if (folder >= 0 && flock(folder, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
        fprintf(stderr, "lagless: %s: another lagless writes there; wait for it, or give another folder\n",
                path);
        close(folder);
        return false;
    }
    return true;
}

bool output_path(char path[PATH_SIZE], const char *folder, const char *name)
{
    const int length = snprintf(path, PATH_SIZE, "%s/%s", folder, name);
    if (length < 0 || length >= PATH_SIZE) {
        fprintf(stderr, "lagless: the path %s/%s is too long; accepted: up to %d bytes\n", folder, name,
                PATH_SIZE - 1);
        return false;
    }
    return true;
}

/* The name of a file while it is written; the path itself if it is no plain file. */
static const char *partial(char to[PATH_SIZE + 16], const char *path)
{
    struct stat found;
    const bool plain = lstat(path, &found) != 0 || S_ISREG(found.st_mode);
    snprintf(to, PATH_SIZE + 16, "%s%s", path, plain ? ".partial" : "");
    return to;
}

static bool forced;

void output_force(void)
{
    forced = true;
}

bool output_forced(void)
{
    return forced;
}

bool output_allowed(const char *path)
{
    struct stat found;
    if (stat(path, &found) != 0 || !S_ISREG(found.st_mode)) {
        return true;
    }
    if (inputs_have(path)) {
        fprintf(stderr, "lagless: %s is an input of this command and is not overwritten; give another name\n",
                path);
        return false;
    }
    if (!forced) {
        fprintf(stderr, "lagless: %s exists; --force replaces it\n", path);
    }
    return forced;
}

bool output_allowed_in(const char *folder, const char *name, const char *ending)
{
    char file[PATH_SIZE];
    char path[PATH_SIZE];
    snprintf(file, sizeof file, "%s%s", name, ending);
    return output_path(path, folder, file) && output_allowed(path);
}

bool output_allowed_recording(const char *folder, const char *name, uint32_t formats)
{
    bool good = true;
    for (uint32_t n = 0; good && n < RECORDER_FORMATS; n++) {
        char ending[16];
        snprintf(ending, sizeof ending, ".%s", recorder_ending(n));
        good = (formats >> n & 1u) == 0u || output_allowed_in(folder, name, ending);
    }
    return good;
}

bool output_allowed_pictures(const char *folder, const char *name, const char *formats)
{
    bool good = true;
    for (const char *word = formats; good && *word != '\0'; word += strspn(word, ",")) {
        char ending[16];
        const int length = (int)strcspn(word, ",");
        snprintf(ending, sizeof ending, ".%.*s", length, word);
        good = output_allowed_in(folder, name, ending);
        word += length;
    }
    return good;
}

/* ---- a signal while a file is written ---- */

#define UNFINISHED 8u
static char unfinished[UNFINISHED][PATH_SIZE + 16]; /* partial files; "" where there is none */

/* Removes them, prints a message, and ends like the signal. */
static void take_away(int number)
{
    static const char text[] = "\nlagless: stopped; nothing is written\n";
    for (size_t n = 0; n < UNFINISHED; n++) {
        if (unfinished[n][0] != '\0') {
            (void)unlink(unfinished[n]);
        }
    }
    const ssize_t ignored = write(STDERR_FILENO, text, sizeof text - 1u);
    (void)ignored;
    (void)signal(number, SIG_DFL);
    (void)raise(number);
}

/* A command that ends in order after a signal has its own handler, which is not replaced. */
static void note_unfinished(const char *name)
{
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t n = 0; n < UNFINISHED; n++) {
        if (unfinished[n][0] == '\0') {
            snprintf(unfinished[n], sizeof unfinished[n], "%s", name);
            break;
        }
    }
    for (size_t n = 0; n < sizeof signals / sizeof signals[0]; n++) {
        struct sigaction now;
        if (sigaction(signals[n], NULL, &now) == 0 && now.sa_handler == SIG_DFL) {
            (void)signal(signals[n], take_away);
        }
    }
}

static void forget_unfinished(const char *name)
{
    for (size_t n = 0; n < UNFINISHED; n++) {
        if (strcmp(unfinished[n], name) == 0) {
            unfinished[n][0] = '\0';
        }
    }
}

FILE *output_open(const char *path)
{
    return output_allowed(path) ? output_open_own(path) : NULL;
}

FILE *output_open_own(const char *path)
{
    char name[PATH_SIZE + 16];
    FILE *file = fopen(partial(name, path), "w");
    if (file == NULL) {
        fprintf(stderr, "lagless: cannot write %s: %s\n", path, strerror(errno));
    } else if (strcmp(name, path) != 0) {
        note_unfinished(name);
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
    char name[PATH_SIZE + 16];
    forget_unfinished(partial(name, path));
    /* written to the disk before it gets its name: after a loss of power no file with the final name is empty
     */
    const bool synced = strcmp(name, path) == 0 || (fflush(file) == 0 && fsync(fileno(file)) == 0);
    const bool written = ferror(file) == 0 && synced;
    if (fclose(file) != 0 || !written) {
        fprintf(stderr, "lagless: %s is incomplete, it could not be written to its end: %s\n",
                partial(name, path), strerror(errno));
        return false;
    }
    if (strcmp(partial(name, path), path) != 0 && rename(name, path) != 0) {
        fprintf(stderr, "lagless: cannot write %s: %s: it keeps the name %s\n", path, strerror(errno), name);
        return false;
    }
    return true;
}

#define PATIENCE 2.0 /* [s] longer work shows its progress */
#define REDRAW   0.1 /* [s] at least from one picture of the bar to the next */
#define BAR      30  /* [columns] */

output_progress_t output_progress_begin(void)
{
    return (output_progress_t){.started = output_seconds(), .wanted = isatty(STDERR_FILENO) != 0};
}

/* "12 s", "3 min 20 s" */
static const char *duration_text(char to[40], double seconds)
{
    const unsigned whole = (unsigned)(seconds + 0.5);
    if (whole < 100u) {
        snprintf(to, 40, "%u s", whole);
    } else {
        snprintf(to, 40, "%u min %u s", whole / 60u, whole % 60u);
    }
    return to;
}

void output_progress(void *context, double fraction)
{
    output_progress_t *progress = context;
    const double now = output_seconds();
    const double elapsed = now - progress->started;
    /* The bar is shown if the whole work will take longer than this. */
    const bool quick = !progress->shown && (elapsed < 0.2 || elapsed < PATIENCE * fraction);
    if (!progress->wanted || quick || (progress->shown && now - progress->drawn < REDRAW)) {
        return;
    }
    char bar[BAR + 1];
    char left[40] = "";
    memset(bar, '.', BAR);
    memset(bar, '#', (size_t)(fraction * BAR));
    bar[BAR] = '\0';
    if (fraction > 0.0) {
        duration_text(left, elapsed / fraction - elapsed);
    }
    /* not through the stream: it is no message, and with --json the stream stores messages */
    dprintf(STDERR_FILENO, "\r[%s] %3.0f %%  %s%s  ", bar, 100.0 * fraction, left,
            left[0] != '\0' ? " left" : "");
    progress->shown = true;
    progress->drawn = now;
}

void output_progress_end(output_progress_t *progress)
{
    if (progress->shown) {
        dprintf(STDERR_FILENO, "\r%60s\r", "");
    }
    progress->shown = false;
}

void output_abandon(FILE *file, const char *path)
{
    char name[PATH_SIZE + 16];
    if (file != NULL) {
        fclose(file);
        if (strcmp(partial(name, path), path) != 0) {
            (void)remove(name);
            forget_unfinished(name);
        }
    }
}

static const char *setting(const char *variable, const char *standard)
{
    const char *value = getenv(variable);
    return value != NULL && value[0] != '\0' ? value : standard;
}

/* Output of the script about its progress, until it ends. */
static void follow(int descriptor)
{
    output_progress_t progress = output_progress_begin();
    FILE *lines = fdopen(descriptor, "r");
    double fraction = 0.0;
    while (lines != NULL && fscanf(lines, "%lf", &fraction) == 1 && fraction >= 0.0 && fraction <= 1.0) {
        output_progress(&progress, fraction);
    }
    output_progress_end(&progress);
    if (lines != NULL) {
        fclose(lines);
    } else {
        close(descriptor);
    }
}

/* In the child: the descriptor that the script finds by its environment. */
static void offer(int descriptor)
{
    char number[16];
    snprintf(number, sizeof number, "%d", descriptor);
    setenv("LAGLESS_PROGRESS", number, 1);
    fcntl(descriptor, F_SETFD, 0);
}

#define ARGUMENTS_MAX 12u

/* In the child process: starts the script, or prints the reason for its failure. */
static void become(const char *python, const char *path, const char *const *arguments, FILE *input)
{
    const char *words[ARGUMENTS_MAX + 4u] = {python, "-B", path};
    for (size_t n = 0; n < ARGUMENTS_MAX && arguments[n] != NULL; n++) {
        words[3u + n] = arguments[n];
    }
    const int from = input != NULL ? fileno(input) : open("/dev/null", O_RDONLY);
    if (input != NULL) {
        (void)lseek(from, 0, SEEK_SET);
    }
    (void)dup2(from, STDIN_FILENO);
    execvp(python, (char *const *)(uintptr_t)words); /* which has no const for historical reasons */
    fprintf(
        stderr,
        "lagless: cannot run Python (%s): %s; install Python 3.9 or later, or name it in LAGLESS_PYTHON\n",
        python, strerror(errno));
    fflush(stderr);
    _exit(EXIT_INTERNAL);
}

/* LAGLESS_PYTHON of the environment, else that of build/venv, into which tools/setup installs the packages
 * for plots, also after the build; else the Python that CMake found. */
static char *interpreter(void)
{
    char venv[PATH_SIZE];
    const bool installed =
        output_path(venv, setting("LAGLESS_TOOLS", LAGLESS_TOOLS), "../build/venv/bin/python") &&
        access(venv, X_OK) == 0;
    return strdup(setting("LAGLESS_PYTHON", installed ? venv : LAGLESS_PYTHON));
}

int output_script(const char *script, const char *const *arguments, FILE *input)
{
    char path[PATH_SIZE];
    char *python = interpreter();
    if (python == NULL || !output_path(path, setting("LAGLESS_TOOLS", LAGLESS_TOOLS), script)) {
        free(python);
        return EXIT_INTERNAL;
    }
    int status = -1;
    int ends[2] = {-1, -1};
    const bool followed = isatty(STDERR_FILENO) != 0 && pipe2(ends, O_CLOEXEC) == 0;
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        if (followed) {
            offer(ends[1]);
        }
        become(python, path, arguments, input);
    }
    if (followed) {
        close(ends[1]);
        follow(ends[0]);
    }
    const bool ended = child > 0 && waitpid(child, &status, 0) == child && WIFEXITED(status);
    if (!ended) {
        fprintf(stderr, "lagless: %s was stopped by a signal or could not be started\n", path);
    }
    free(python);
    return ended ? WEXITSTATUS(status) : EXIT_INTERNAL;
}

bool output_picture(const char *script, const char *data, const char *png, const char *title)
{
    const char *const arguments[] = {data, png, "--title", title, NULL}; /* png NULL: ends there */
    const bool drawn = output_script(script, arguments, NULL) == EXIT_DONE;
    if (!drawn) {
        fprintf(stderr, "lagless: no picture was drawn; the data are in %s\n", data);
    }
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
