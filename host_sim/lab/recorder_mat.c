/* Samples as MAT v5, by matio. The file is uncompressed, because different versions of zlib compress the same
 *data to different octets.
 *
 * matio does not check its writes. Therefore the file is read back and compared bit for bit. */
#include "host_sim/lab/recorder_parts.h"

#include <matio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/times.h"

#define HEADER "MATLAB 5.0 MAT-file, lagless recording"

/* MATLAB's identifiers: letters, digits, underscores. */
static void identifier(char to[RECORDER_NAME_SIZE], const char *name)
{
    size_t n = 0;
    for (; name[n] != '\0' && n + 1u < RECORDER_NAME_SIZE; n++) {
        const char c = name[n];
        const bool fine = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        to[n] = fine ? c : '_';
    }
    to[n] = '\0';
}

/* UTF-8 to UTF-16; returns the number of units. A character that needs two units becomes U+FFFD, because
 * readers count such characters differently, and SciPy cannot read the file. */
static size_t utf16(uint16_t *to, const char *text)
{
    size_t units = 0;
    while (*text != '\0') {
        const uint32_t code = recorder_utf8(&text);
        to[units++] = (uint16_t)(code > 0xFFFFu ? RECORDER_NO_CHARACTER : code);
    }
    return units;
}

/* matio copies the text, although its parameter is not const. */
static matvar_t *text_variable(const char *text)
{
    const size_t length = strlen(text);
    bool ascii = true;
    for (size_t n = 0; n < length; n++) {
        ascii = ascii && (unsigned char)text[n] < 0x80u;
    }
    if (ascii) {
        size_t dims[2] = {length > 0u ? 1u : 0u, length};
        return Mat_VarCreate(NULL, MAT_C_CHAR, MAT_T_UTF8, 2, dims, (void *)(uintptr_t)text, 0);
    }
    uint16_t *units = malloc((length + 1u) * sizeof *units);
    if (units == NULL) {
        return NULL;
    }
    size_t dims[2] = {1u, utf16(units, text)};
    matvar_t *variable = Mat_VarCreate(NULL, MAT_C_CHAR, MAT_T_UTF16, 2, dims, units, 0);
    free(units);
    return variable;
}

static matvar_t *number_variable(double value)
{
    size_t dims[2] = {1u, 1u};
    return Mat_VarCreate(NULL, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, &value, 0);
}

static matvar_t *seed_variable(uint64_t value)
{
    size_t dims[2] = {1u, 1u};
    return Mat_VarCreate(NULL, MAT_C_UINT64, MAT_T_UINT64, 2, dims, &value, 0);
}

static matvar_t *structure(const char *name)
{
    size_t dims[2] = {1u, 1u};
    return Mat_VarCreateStruct(name, 2, dims, NULL, 0);
}

/* The structure owns the field from now on; false without memory. */
static bool add(matvar_t *to, const char *name, matvar_t *field)
{
    char field_name[RECORDER_NAME_SIZE];
    identifier(field_name, name);
    if (to == NULL || field == NULL || Mat_VarAddStructField(to, field_name) != 0) {
        Mat_VarFree(field);
        return false;
    }
    Mat_VarSetStructFieldByName(to, field_name, 0, field);
    return true;
}

/* All notes as one text; NULL without memory. */
static matvar_t *notes_variable(const recorder_t *recorder)
{
    size_t size = 1;
    for (uint32_t n = 0; n < recorder->note_count; n++) {
        const recorder_line_t *note = &recorder->notes[n];
        size += strlen(note->key) + strlen(note->name) + strlen(note->text) + 4u;
    }
    char *lines = malloc(size);
    if (lines == NULL) {
        return NULL;
    }
    size_t used = 0;
    lines[0] = '\0';
    for (uint32_t n = 0; n < recorder->note_count; n++) {
        const recorder_line_t *note = &recorder->notes[n];
        used += (size_t)snprintf(lines + used, size - used, "%s %s: %s\n", note->key, note->name, note->text);
    }
    matvar_t *variable = text_variable(lines);
    free(lines);
    return variable;
}

static matvar_t *meta_variable(const recorder_t *recorder)
{
    char tables[16];
    snprintf(tables, sizeof tables, "0x%08x", (unsigned)recorder->tables_hash);
    matvar_t *units = structure(NULL);
    matvar_t *choices = structure(NULL);
    bool good = add(units, "time", text_variable("s"));
    for (uint32_t c = 0; c < recorder->column_count; c++) {
        const recorder_column_t *column = &recorder->columns[c];
        good = add(units, column->name, text_variable(column->row->unit)) && good;
        if (column->row->kind == SLOT_ENUM) {
            good = add(choices, column->name, text_variable(column->row->choices)) && good;
        }
    }
    matvar_t *values = structure(NULL);
    matvar_t *value_units = structure(NULL);
    for (uint32_t n = 0; n < recorder->value_count; n++) {
        const recorder_setting_t *value = &recorder->values[n];
        good = add(values, value->name, number_variable(value->value)) && good;
        good = add(value_units, value->name, text_variable(value->unit)) && good;
    }
    matvar_t *meta = structure("meta");
    good = add(meta, "format", number_variable(1.0)) && good;
    good = add(meta, "program", text_variable(recorder->program)) && good;
    good = add(meta, "commit", text_variable(recorder->commit)) && good;
    good = add(meta, "tables", text_variable(tables)) && good;
    good = add(meta, "scenario", text_variable(recorder->scenario)) && good;
    good = add(meta, "title", text_variable(recorder->title)) && good;
    good = add(meta, "seed", seed_variable(recorder->seed)) && good;
    good = add(meta, "every", number_variable((double)recorder->every)) && good;
    good = add(meta, "period", number_variable(RIG_PERIOD_SECONDS)) && good;
    good = add(meta, "ended", text_variable(recorder->ended)) && good;
    good = add(meta, "units", units) && good;
    good = add(meta, "choices", choices) && good;
    good = add(meta, "values", values) && good;
    good = add(meta, "value_units", value_units) && good;
    good = add(meta, "notes", notes_variable(recorder)) && good;
    good = add(meta, "text", text_variable(recorder->scenario_text)) && good;
    if (!good) {
        Mat_VarFree(meta);
        return NULL;
    }
    return meta;
}

/* Variable n of the file: time, the columns, meta. `data` has room for 8 octets a sample and must live as
 * long. */
static matvar_t *variable(const recorder_t *recorder, uint32_t n, void *data)
{
    const uint64_t count = recorder_store_count(&recorder->rows);
    size_t dims[2] = {(size_t)count, 1u};
    if (n == 0u) {
        double *time = data;
        for (uint64_t k = 0; k < count; k++) {
            const uint32_t *sample = recorder_store_at(&recorder->rows, k);
            time[k] = times_seconds(sample[0], RIG_PERIOD_TICKS);
        }
        return Mat_VarCreate("time", MAT_C_DOUBLE, MAT_T_DOUBLE, 2, dims, time, MAT_F_DONT_COPY_DATA);
    }
    if (n > recorder->column_count) {
        return meta_variable(recorder);
    }
    uint32_t *slots = data;
    for (uint64_t k = 0; k < count; k++) {
        const uint32_t *sample = recorder_store_at(&recorder->rows, k);
        slots[k] = sample[n];
    }
    char name[RECORDER_NAME_SIZE];
    identifier(name, recorder->columns[n - 1u].name);
    switch (recorder->columns[n - 1u].row->kind) {
    case SLOT_FLOAT:
        return Mat_VarCreate(name, MAT_C_SINGLE, MAT_T_SINGLE, 2, dims, slots, MAT_F_DONT_COPY_DATA);
    case SLOT_UINT:
        return Mat_VarCreate(name, MAT_C_UINT32, MAT_T_UINT32, 2, dims, slots, MAT_F_DONT_COPY_DATA);
    case SLOT_INT:
    case SLOT_ENUM:
        return Mat_VarCreate(name, MAT_C_INT32, MAT_T_INT32, 2, dims, slots, MAT_F_DONT_COPY_DATA);
    case SLOT_KINDS:
        break;
    }
    return NULL;
}

/* True if kind, shape and octets of all fields are equal. A structure in a structure is a tree that
 * meta_variable made, two levels deep. */
static bool same(matvar_t *a, matvar_t *b)
{
    if (a->class_type != b->class_type || a->rank != 2 || b->rank != 2 || a->dims[0] != b->dims[0] ||
        a->dims[1] != b->dims[1]) {
        return false;
    }
    if (a->class_type != MAT_C_STRUCT) {
        return a->nbytes == b->nbytes && (a->nbytes == 0u || memcmp(a->data, b->data, a->nbytes) == 0);
    }
    const unsigned fields = Mat_VarGetNumberOfFields(a);
    if (fields != Mat_VarGetNumberOfFields(b)) {
        return false;
    }
    for (unsigned n = 0; n < fields; n++) {
        matvar_t *x = Mat_VarGetStructFieldByIndex(a, n, 0);
        matvar_t *y = Mat_VarGetStructFieldByIndex(b, n, 0);
        if (x == NULL || y == NULL || x->name == NULL || y->name == NULL || strcmp(x->name, y->name) != 0 ||
            !same(x, y)) {
            return false;
        }
    }
    return true;
}

static bool failed(recorder_error_t *error, const char *path, const char *why)
{
    snprintf(error->text, sizeof error->text, "%s: %s", path, why);
    return false;
}

static bool write_all(const recorder_t *recorder, const char *path, void *data, recorder_error_t *error)
{
    mat_t *mat = Mat_CreateVer(path, HEADER, MAT_FT_MAT5);
    if (mat == NULL) {
        return failed(error, path, "cannot be written");
    }
    bool memory = true;
    bool written = true;
    for (uint32_t n = 0; n <= recorder->column_count + 1u && memory && written; n++) {
        matvar_t *next = variable(recorder, n, data);
        memory = next != NULL;
        written = !memory || Mat_VarWrite(mat, next, MAT_COMPRESSION_NONE) == 0;
        Mat_VarFree(next);
    }
    written = Mat_Close(mat) == 0 && written;
    if (!memory) {
        return failed(error, path, "no memory left to write it");
    }
    return written ||
           failed(error, path, "the file could not be written completely; check the free space of the disk");
}

static bool read_all(const recorder_t *recorder, const char *path, void *data, recorder_error_t *error)
{
    mat_t *mat = Mat_Open(path, MAT_ACC_RDONLY);
    bool good = mat != NULL;
    for (uint32_t n = 0; n <= recorder->column_count + 1u && good; n++) {
        matvar_t *expected = variable(recorder, n, data);
        matvar_t *read = Mat_VarReadNext(mat);
        good = expected != NULL && read != NULL && strcmp(expected->name, read->name) == 0 &&
               same(expected, read);
        Mat_VarFree(expected);
        Mat_VarFree(read);
    }
    if (mat != NULL) {
        Mat_Close(mat);
    }
    return good || failed(error, path,
                          "the file could not be written completely: the file differs when it is read again");
}

bool recorder_mat_write(const recorder_t *recorder, const char *path, recorder_error_t *error)
{
    const uint64_t count = recorder_store_count(&recorder->rows);
    void *data = malloc((size_t)(count > 0u ? count : 1u) * sizeof(double));
    if (data == NULL) {
        return failed(error, path, "no memory left to write it");
    }
    const bool good = write_all(recorder, path, data, error) && read_all(recorder, path, data, error);
    free(data);
    return good;
}
