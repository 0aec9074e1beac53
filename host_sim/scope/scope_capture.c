#include "host_sim/scope/scope_capture.h"

#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/json.h"
#include "host_sim/scope/scope_text.h"

bool scope_capture_begin(scope_capture_t *capture, master_t *master, master_error_t *error)
{
    if (capture->octets != NULL) {
        snprintf(error->text, sizeof error->text, "the drive's buffer is being read already");
        return false;
    }
    if (!master_capture_head(master, &capture->of, error)) {
        return false;
    }
    capture->wanted = 4u * capture->of.periods * capture->of.count;
    capture->done = 0u;
    capture->asking = false;
    capture->result = MASTER_OK;
    capture->octets = malloc(capture->wanted);
    if (capture->octets == NULL) {
        snprintf(error->text, sizeof error->text, "not enough memory for the drive's buffer");
    }
    return capture->octets != NULL;
}

static void take(void *context, int result, const uint8_t *data, uint32_t octets)
{
    scope_capture_t *capture = context;
    capture->asking = false;
    capture->result = result;
    if (result == MASTER_OK && capture->octets != NULL && octets <= capture->wanted - capture->done) {
        memcpy(capture->octets + capture->done, data, octets);
        capture->done += octets;
    }
}

void scope_capture_ask(scope_capture_t *capture, master_t *master)
{
    if (capture->octets != NULL && !capture->asking && !scope_capture_is_over(capture)) {
        const uint32_t left = capture->wanted - capture->done;
        capture->asking = true;
        master_ask_read(master, MASTER_CAPTURE, capture->done,
                        left < MASTER_READ_MAX ? left : MASTER_READ_MAX, take, capture);
    }
}

bool scope_capture_is_over(const scope_capture_t *capture)
{
    return capture->octets != NULL && !capture->asking &&
           (capture->done == capture->wanted || capture->result != MASTER_OK);
}

/* True if the buffer is still the one from which the pieces were read. */
static bool is_the_same(const scope_capture_t *capture, master_t *master, master_error_t *error)
{
    master_capture_t now;
    if (capture->result != MASTER_OK) {
        snprintf(error->text, sizeof error->text, "the drive's buffer could not be read: %s",
                 capture->result == MASTER_LOST ? "the link was lost" : "it is not held any more");
        return false;
    }
    if (!master_capture_head(master, &now, error)) {
        return false;
    }
    snprintf(error->text, sizeof error->text,
             "the drive's buffer was recorded again while it was read; read it again");
    return now.at == capture->of.at && now.after == capture->of.after && now.periods == capture->of.periods &&
           now.count == capture->of.count && memcmp(now.rows, capture->of.rows, sizeof now.rows) == 0;
}

void scope_capture_text(FILE *to, scope_capture_t *capture, master_t *master)
{
    master_error_t error;
    if (!is_the_same(capture, master, &error)) {
        fputs("{\"why\":", to);
        json_text(to, error.text);
        fputc('}', to);
        return;
    }
    const master_capture_t *of = &capture->of;
    fprintf(to, "{\"at\":%u,\"after\":%u,\"periods\":%u,\"signals\":[", (unsigned)of->at, (unsigned)of->after,
            (unsigned)of->periods);
    for (uint32_t n = 0; n < of->count; n++) {
        fprintf(to, "%s%u", n == 0u ? "" : ",", (unsigned)of->rows[n]->id);
    }
    fputs("],\"d\":\"", to);
    scope_base64(to, capture->octets, capture->wanted);
    fputs("\"}", to);
}

void scope_capture_end(scope_capture_t *capture)
{
    free(capture->octets);
    capture->octets = NULL;
}
