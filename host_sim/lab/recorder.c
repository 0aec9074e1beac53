#include "host_sim/lab/recorder.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host_sim/lab/recorder_parts.h"
#include "host_sim/lab/times.h"

#define CHUNK_OCTETS  (UINT32_C(1) << 20)
#define EDGES_PLANNED UINT64_C(16) /* edges in a period: twelve gates, ADC, interrupt, and one in reserve */

static const struct {
    uint32_t format;
    const char *name, *ending;
    int (*write)(const recorder_t *recorder, recorder_out_t *out); /* NULL: the file is written by its path */
} kinds[RECORDER_FORMATS] = {{RECORDER_CSV, "csv", "csv", recorder_csv_write},
                             {RECORDER_MAT, "mat", "mat", NULL},
                             {RECORDER_VCD, "vcd", "vcd", recorder_vcd_write},
                             {RECORDER_MDF, "mdf", "mf4", recorder_mdf_write}};

uint32_t recorder_formats(const char *text)
{
    uint32_t formats = 0;
    for (const char *word = text; *word != '\0'; word += strspn(word, ",")) {
        const size_t length = strcspn(word, ",");
        uint32_t n = 0;
        while (n < RECORDER_FORMATS &&
               (strncmp(word, kinds[n].name, length) != 0 || kinds[n].name[length] != '\0')) {
            n++;
        }
        if (n == RECORDER_FORMATS) {
            return 0;
        }
        formats |= kinds[n].format;
        word += length;
    }
    return formats;
}

const char *recorder_ending(uint32_t n)
{
    return kinds[n].ending;
}

/* ---- store ---- */

static void store_init(recorder_store_t *store, uint32_t record_octets)
{
    store->record_octets = record_octets;
    store->chunk_records = CHUNK_OCTETS / record_octets;
}

static void store_free(recorder_store_t *store)
{
    for (uint32_t n = 0; n < store->chunk_count; n++) {
        free(store->chunks[n]);
    }
    free(store->chunks);
}

static bool store_grow(recorder_store_t *store, uint32_t *memory_left)
{
    if (*memory_left < CHUNK_OCTETS) {
        return false;
    }
    if (store->chunk_count == store->chunk_room) {
        const uint32_t room = store->chunk_room == 0u ? 16u : 2u * store->chunk_room;
        char **chunks = realloc(store->chunks, room * sizeof *chunks);
        if (chunks == NULL) {
            return false;
        }
        store->chunks = chunks;
        store->chunk_room = room;
    }
    char *chunk = malloc(CHUNK_OCTETS);
    if (chunk == NULL) {
        return false;
    }
    *memory_left -= CHUNK_OCTETS;
    store->chunks[store->chunk_count++] = chunk;
    store->next = chunk;
    store->left = store->chunk_records;
    return true;
}

/* NULL: no memory. */
static inline void *store_take(recorder_store_t *store, uint32_t *memory_left)
{
    if (store->left == 0u && !store_grow(store, memory_left)) {
        return NULL;
    }
    char *record = store->next;
    store->next += store->record_octets;
    store->left--;
    return record;
}

/* Keeps the first `count` records. */
static void store_cut(recorder_store_t *store, uint64_t count, uint32_t *memory_left)
{
    const uint32_t chunks = (uint32_t)((count + store->chunk_records - 1u) / store->chunk_records);
    while (store->chunk_count > chunks) {
        free(store->chunks[--store->chunk_count]);
        *memory_left += CHUNK_OCTETS;
    }
    store->left = (uint32_t)((uint64_t)chunks * store->chunk_records - count);
    store->next = chunks == 0u ? NULL
                               : store->chunks[chunks - 1u] +
                                     (size_t)(store->chunk_records - store->left) * store->record_octets;
}

/* ---- sinks ---- */

/* Removes the samples of this period and later ones. */
static void rewind_rows(recorder_t *recorder, uint32_t period)
{
    uint64_t low = 0;
    uint64_t high = recorder_store_count(&recorder->rows);
    while (low < high) {
        const uint64_t middle = low + (high - low) / 2u;
        const uint32_t *sample = recorder_store_at(&recorder->rows, middle);
        if (sample[0] < period) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    store_cut(&recorder->rows, low, &recorder->memory_left);
    if (period <= recorder->first_lost_period) {
        recorder->lost_rows = 0;
    }
}

static void rewind_edges(recorder_t *recorder, uint64_t tick)
{
    uint64_t low = 0;
    uint64_t high = recorder_store_count(&recorder->edges);
    while (low < high) {
        const uint64_t middle = low + (high - low) / 2u;
        const recorder_edge_t *edge = recorder_store_at(&recorder->edges, middle);
        if (*edge >> 16 < tick) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    store_cut(&recorder->edges, low, &recorder->memory_left);
    if (tick <= recorder->first_lost_tick) {
        recorder->lost_edges = 0;
    }
}

void recorder_sink(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    recorder_t *recorder = context;
    assert(count == recorder->column_count);
    if (period <= recorder->last_period &&
        recorder_store_count(&recorder->rows) + recorder->lost_rows != 0u) {
        rewind_rows(recorder, period);
    }
    recorder->last_period = period;
    /* After the first loss nothing more is stored, because the recording must not have a gap. */
    uint32_t *sample = recorder->lost_rows == 0u ? store_take(&recorder->rows, &recorder->memory_left) : NULL;
    if (sample == NULL) {
        if (recorder->lost_rows++ == 0u) {
            recorder->first_lost_period = period;
        }
        return;
    }
    sample[0] = period;
    memcpy(sample + 1, slots, count * sizeof *slots);
}

void recorder_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    recorder_t *recorder = context;
    assert(what <= RIG_EDGE_TRIP && value <= 0xFFu);
    if (tick < recorder->last_tick) {
        rewind_edges(recorder, tick);
    }
    recorder->last_tick = tick;
    recorder_edge_t *edge =
        recorder->lost_edges == 0u ? store_take(&recorder->edges, &recorder->memory_left) : NULL;
    if (edge == NULL) {
        if (recorder->lost_edges++ == 0u) {
            recorder->first_lost_tick = tick;
        }
        return;
    }
    *edge = tick << 16 | (uint64_t)what << 8 | value;
}

uint64_t recorder_samples(const recorder_t *recorder)
{
    return recorder_store_count(&recorder->rows);
}

/* ---- life ---- */

static bool refuse(recorder_error_t *error, const char *text)
{
    error->io = false;
    snprintf(error->text, sizeof error->text, "%s", text);
    return false;
}

static char *copied(const char *text)
{
    const size_t size = strlen(text) + 1u;
    char *copy = malloc(size);
    if (copy != NULL) {
        memcpy(copy, text, size);
    }
    return copy;
}

static void free_all(recorder_t *recorder)
{
    store_free(&recorder->rows);
    store_free(&recorder->edges);
    for (uint32_t n = 0; n < RECORDER_FORMATS; n++) {
        if (recorder->files[n].file != NULL) {
            fclose(recorder->files[n].file);
        }
        if (recorder->files[n].claim >= 0) {
            close(recorder->files[n].claim);
        }
        free(recorder->files[n].path);
        free(recorder->files[n].partial_path);
    }
    free(recorder->program);
    free(recorder->commit);
    free(recorder->scenario);
    free(recorder->scenario_text);
    free(recorder->title);
    for (uint32_t n = 0; n < recorder->value_count; n++) {
        free(recorder->values[n].name);
        free(recorder->values[n].unit);
    }
    free(recorder->values);
    for (uint32_t n = 0; n < recorder->note_count; n++) {
        free(recorder->notes[n].name);
        free(recorder->notes[n].text);
    }
    free(recorder->notes);
    free(recorder);
}

bool recorder_note(recorder_t *recorder, const char *key, const char *name, const char *text)
{
    recorder_line_t *notes = realloc(recorder->notes, (recorder->note_count + 1u) * sizeof *notes);
    if (notes == NULL) {
        return false;
    }
    recorder->notes = notes;
    recorder_line_t *note = &notes[recorder->note_count++];
    *note = (recorder_line_t){.key = key, .name = copied(name), .text = copied(text)};
    return note->name != NULL && note->text != NULL;
}

static bool check(const recorder_options_t *options, recorder_error_t *error)
{
    const uint32_t known = (1u << RECORDER_FORMATS) - 1u;
    const bool rows = (options->formats & RECORDER_SAMPLED) != 0u;
    char text[sizeof error->text];
    if (options->formats == 0u || (options->formats & ~known) != 0u) {
        return refuse(error, "a recording is CSV, MAT, VCD, MDF or several of these");
    }
    if (options->name[0] == '\0') {
        return refuse(error, "the recording has no name");
    }
    if (options->count > RIG_TAP_MAX || (rows && options->count == 0u)) {
        snprintf(text, sizeof text, "%u rows to record: accepted: 1 to %u", (unsigned)options->count,
                 RIG_TAP_MAX);
        return refuse(error, text);
    }
    if (options->every == 0u) {
        return refuse(error, "every 0: accepted: 1 and more periods");
    }
    if (options->memory != 0u &&
        (options->memory < RECORDER_MEMORY_MIN || options->memory > RECORDER_MEMORY_MAX)) {
        snprintf(text, sizeof text, "memory of %u octets for the recording: accepted: %u to %u",
                 (unsigned)options->memory, (unsigned)RECORDER_MEMORY_MIN, (unsigned)RECORDER_MEMORY_MAX);
        return refuse(error, text);
    }
    if ((options->formats & RECORDER_VCD) != 0u && options->isr_ticks == 0u) {
        return refuse(error, "an interrupt of 0 ticks would not be visible: accepted: 1 and more");
    }
    return true;
}

/* Columns with unique names. */
static bool name_columns(recorder_t *recorder, const recorder_options_t *options, recorder_error_t *error)
{
    char text[sizeof error->text];
    for (uint32_t c = 0; c < options->count; c++) {
        const uint32_t id = options->ids[c];
        const table_row_t *row = rig_row(id);
        if (row == NULL) {
            snprintf(text, sizeof text, "row %u to record: no table has a row of this id", (unsigned)id);
            return refuse(error, text);
        }
        const table_t *owner = NULL;
        bool shared = strcmp(row->name, "time") == 0 || strcmp(row->name, "meta") == 0;
        for (uint32_t t = 0; t < rig_table_count(); t++) {
            const table_row_t *other = table_by_name(rig_table(t), row->name);
            owner = other == row ? rig_table(t) : owner;
            shared = shared || (other != NULL && other != row);
        }
        recorder_column_t *column = &recorder->columns[c];
        column->row = row;
        snprintf(column->name, sizeof column->name, "%s%s%s", shared ? owner->name : "", shared ? "." : "",
                 row->name);
        for (uint32_t before = 0; before < c; before++) {
            if (options->ids[before] == id) {
                snprintf(text, sizeof text, "%s is given twice", column->name);
                return refuse(error, text);
            }
        }
    }
    recorder->column_count = options->count;
    return true;
}

static bool copy_meta(recorder_t *recorder, const recorder_meta_t *meta, recorder_error_t *error)
{
    recorder->tables_hash = rig_tables_hash();
    recorder->seed = meta->seed;
    recorder->program = copied(meta->program);
    recorder->commit = copied(meta->commit);
    recorder->scenario = copied(meta->scenario);
    recorder->scenario_text = copied(meta->scenario_text);
    recorder->title = copied(meta->title);
    recorder->values = calloc(meta->value_count + 1u, sizeof *recorder->values);
    bool good = recorder->program != NULL && recorder->commit != NULL && recorder->scenario != NULL &&
                recorder->scenario_text != NULL && recorder->title != NULL && recorder->values != NULL;
    for (uint32_t n = 0; n < meta->value_count && good; n++) {
        for (uint32_t before = 0; before < n; before++) {
            if (strcmp(meta->values[before].name, meta->values[n].name) == 0) {
                char text[sizeof error->text];
                snprintf(text, sizeof text, "two settings of the recording are called %s",
                         meta->values[n].name);
                return refuse(error, text);
            }
        }
        recorder->values[n] = (recorder_setting_t){.name = copied(meta->values[n].name),
                                                   .value = meta->values[n].value,
                                                   .unit = copied(meta->values[n].unit)};
        recorder->value_count = n + 1u;
        good = recorder->values[n].name != NULL && recorder->values[n].unit != NULL;
    }
    return good || refuse(error, "no memory for the recording");
}

/* true: the plan fits. false: the error has the accepted values. */
static bool check_plan(const recorder_t *recorder, const recorder_options_t *options, recorder_error_t *error)
{
    const uint64_t edges = (options->formats & RECORDER_VCD) != 0u
                               ? EDGES_PLANNED * sizeof(recorder_edge_t) * options->periods
                               : 0u;
    const uint64_t chunk_rows = options->count != 0u ? recorder->rows.chunk_records : 1u;
    const uint64_t rows =
        options->count != 0u ? (options->periods + (uint64_t)options->every - 1u) / options->every : 0u;
    const uint64_t edge_chunks = (edges + CHUNK_OCTETS - 1u) / CHUNK_OCTETS;
    const uint64_t chunks = recorder->memory_left / CHUNK_OCTETS;
    if (edge_chunks + (rows + chunk_rows - 1u) / chunk_rows <= chunks) {
        return true;
    }
    char text[sizeof error->text];
    if (edge_chunks >= chunks) {
        snprintf(text, sizeof text, "the edges of %u periods do not fit into %u MiB: record a shorter run",
                 (unsigned)options->periods, (unsigned)chunks);
    } else {
        const uint64_t fitting = (chunks - edge_chunks) * chunk_rows;
        snprintf(text, sizeof text,
                 "%u rows of %u periods do not fit into %u MiB: every %u or more, or fewer rows, would",
                 (unsigned)options->count, (unsigned)options->periods, (unsigned)chunks,
                 (unsigned)((options->periods + fitting - 1u) / fitting));
    }
    return refuse(error, text);
}

static bool no_file(recorder_error_t *error, const char *path, const char *why)
{
    snprintf(error->text, sizeof error->text, "%s: %s", path, why);
    error->io = true;
    return false;
}

/* Opens the partial file for this recording alone. It is emptied only after it is locked, because it may
 * belong to another process, or be left over from one that was killed. false: the reason has been printed. */
static bool claim(recorder_file_t *file, recorder_error_t *error)
{
    struct stat mine;
    struct stat there;
    for (;;) {
        file->claim = open(file->partial_path, O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
        if (file->claim < 0) {
            return no_file(error, file->partial_path, strerror(errno));
        }
        if (flock(file->claim, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            return no_file(error, file->partial_path, "another run is writing it; give another folder");
        }
        /* the previous owner may have renamed it between the two calls */
        if (fstat(file->claim, &mine) == 0 && stat(file->partial_path, &there) == 0 &&
            mine.st_ino == there.st_ino && mine.st_dev == there.st_dev) {
            break;
        }
        close(file->claim);
    }
    const bool empty = ftruncate(file->claim, 0) == 0 || !S_ISREG(mine.st_mode);
    const int descriptor = empty ? fcntl(file->claim, F_DUPFD_CLOEXEC, 0) : -1;
    file->file = descriptor >= 0 ? fdopen(descriptor, "wb") : NULL;
    return file->file != NULL || no_file(error, file->partial_path, strerror(errno));
}

static bool create_files(recorder_t *recorder, const recorder_options_t *options, recorder_error_t *error)
{
    const char *slash = options->folder[0] == '\0' ? "" : "/";
    const size_t size = strlen(options->folder) + strlen(options->name) + sizeof "/.csv.partial";
    for (uint32_t n = 0; n < RECORDER_FORMATS; n++) {
        if ((options->formats & kinds[n].format) == 0u) {
            continue;
        }
        recorder_file_t *file = &recorder->files[n];
        file->path = malloc(size);
        file->partial_path = malloc(size);
        if (file->path == NULL || file->partial_path == NULL) {
            return refuse(error, "no memory for the recording");
        }
        snprintf(file->path, size, "%s%s%s.%s", options->folder, slash, options->name, kinds[n].ending);
        snprintf(file->partial_path, size, "%s.partial", file->path);
        if (!claim(file, error)) {
            return false;
        }
        file->format = kinds[n].format;
    }
    return true;
}

recorder_t *recorder_open(const recorder_options_t *options, recorder_error_t *error)
{
    *error = (recorder_error_t){.text = ""};
    if (!check(options, error)) {
        return NULL;
    }
    recorder_t *recorder = calloc(1, sizeof *recorder);
    if (recorder == NULL) {
        refuse(error, "no memory for the recording");
        return NULL;
    }
    recorder->every = options->every;
    recorder->isr_ticks = options->isr_ticks;
    recorder->memory_left = options->memory != 0u ? options->memory : RECORDER_MEMORY_MAX;
    store_init(&recorder->rows, (1u + options->count) * (uint32_t)sizeof(uint32_t));
    store_init(&recorder->edges, sizeof(recorder_edge_t));
    for (uint32_t n = 0; n < RECORDER_FORMATS; n++) {
        recorder->files[n].claim = -1;
    }
    if (!name_columns(recorder, options, error) || !copy_meta(recorder, &options->meta, error) ||
        !check_plan(recorder, options, error) || !create_files(recorder, options, error)) {
        recorder_abandon(recorder);
        return NULL;
    }
    return recorder;
}

void recorder_abandon(recorder_t *recorder)
{
    if (recorder == NULL) {
        return;
    }
    for (uint32_t n = 0; n < RECORDER_FORMATS; n++) {
        if (recorder->files[n].format != 0u) {
            remove(recorder->files[n].partial_path);
        }
    }
    free_all(recorder);
}

/* ---- the end ---- */

/* Several errors may occur; all are reported. */
static void also(recorder_error_t *error, const char *text)
{
    const size_t used = strlen(error->text);
    snprintf(error->text + used, sizeof error->text - used, "%s%s", used != 0u ? "; " : "", text);
}

static bool write_stream(const recorder_t *recorder, recorder_file_t *file,
                         int (*write)(const recorder_t *recorder, recorder_out_t *out), recorder_error_t *why)
{
    recorder_out_t *out = malloc(sizeof *out);
    if (out == NULL) {
        snprintf(why->text, sizeof why->text, "%s: no memory left to write it", file->partial_path);
        return false;
    }
    out->file = file->file;
    out->used = 0;
    out->error = 0;
    int problem = write(recorder, out);
    free(out);
    errno = 0;
    if (fclose(file->file) != 0 && problem == 0) {
        problem = errno != 0 ? errno : EIO;
    }
    file->file = NULL;
    if (problem != 0) {
        snprintf(why->text, sizeof why->text, "%s: %s", file->partial_path, strerror(problem));
    }
    return problem == 0;
}

static bool write_file(const recorder_t *recorder, uint32_t n, recorder_file_t *file, recorder_error_t *why)
{
    if (kinds[n].write != NULL) {
        return write_stream(recorder, file, kinds[n].write, why);
    }
    fclose(file->file);
    file->file = NULL;
    return recorder_mat_write(recorder, file->partial_path, why);
}

/* The file is written to the disk before it is renamed, so that after a loss of power no file with the final
 * name is empty. */
static bool synced(const char *path)
{
    const int descriptor = open(path, O_RDONLY | O_CLOEXEC);
    const bool good = descriptor >= 0 && fsync(descriptor) == 0;
    if (descriptor >= 0) {
        close(descriptor);
    }
    return good;
}

bool recorder_close(recorder_t *recorder, const char *ended, recorder_error_t *error)
{
    bool good = true;
    *error = (recorder_error_t){.io = true};
    char text[sizeof error->text / 2u];
    if (recorder->lost_rows != 0u) {
        char when[TIMES_TEXT_SIZE];
        snprintf(text, sizeof text,
                 "the memory for the recording is used up: %llu samples from %s s on are missing",
                 (unsigned long long)recorder->lost_rows, times_text(when, recorder->first_lost_period));
        also(error, text);
    }
    if (recorder->lost_edges != 0u) {
        char when[TIMES_TEXT_SIZE];
        times_text(when, (uint32_t)(recorder->first_lost_tick / RIG_PERIOD_TICKS));
        snprintf(text, sizeof text,
                 "the memory for the recording is used up: %llu edges from %s s on are missing",
                 (unsigned long long)recorder->lost_edges, when);
        also(error, text);
    }
    recorder->ended = ended;
    for (uint32_t n = 0; n < RECORDER_FORMATS; n++) {
        recorder_file_t *file = &recorder->files[n];
        if (file->format == 0u) {
            continue;
        }
        recorder_error_t why = {.text = ""};
        const bool written = write_file(recorder, n, file, &why);
        const bool lost =
            file->format == RECORDER_VCD ? recorder->lost_edges != 0u : recorder->lost_rows != 0u;
        if (!written) {
            also(error, why.text);
        } else if (lost) {
            snprintf(text, sizeof text, "the samples until then are in %s", file->partial_path);
            also(error, text);
        } else if (!synced(file->partial_path) || rename(file->partial_path, file->path) != 0) {
            snprintf(text, sizeof text, "%s: %s: it keeps the name %s", file->path, strerror(errno),
                     file->partial_path);
            also(error, text);
        } else {
            continue;
        }
        good = false;
    }
    free_all(recorder);
    return good;
}
