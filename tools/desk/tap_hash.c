/* Runs a scenario and prints one line per row of the tables signals, requests and truth: the row's name and
 * the 64-bit FNV-1a hash over its slot of every period, lowest octet first; then "edges", the same over tick
 * and value of every gate edge and trip. For tools/same-bits.
 *
 * usage: tap_hash FILE.toml [NAME=VALUE...]
 * Exit status: 0 the scenario ran to its end, also if an expectation failed; 2 the file or an override is
 * wrong; 3 the run was refused */
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "host_sim/lab/runner.h"

/* Number of rows that one run records; the remaining places of the tap are for the expectations of the
 * scenario. */
#define ROWS_A_RUN 32u
#define ROWS_MAX   256u

#define FNV_START UINT64_C(14695981039346656037)
#define FNV_PRIME UINT64_C(1099511628211)

typedef struct {
    uint64_t row[ROWS_A_RUN];
    uint64_t edges;
} hashes_t;

static uint64_t hash_word(uint64_t hash, uint32_t word)
{
    for (uint32_t shift = 0; shift < 32u; shift += 8u) {
        hash = (hash ^ (word >> shift & 0xFFu)) * FNV_PRIME;
    }
    return hash;
}

static void on_sample(void *context, uint32_t period, const uint32_t *slots, uint32_t count)
{
    hashes_t *hashes = context;
    (void)period;
    for (uint32_t n = 0; n < count; n++) {
        hashes->row[n] = hash_word(hashes->row[n], slots[n]);
    }
}

/* The edges that the motor receives. The times of interrupts are not included, because they are not values of
 * the drive. */
static void on_edge(void *context, uint64_t tick, uint32_t what, uint32_t value)
{
    hashes_t *hashes = context;
    if (what == RIG_EDGE_GATES || what == RIG_EDGE_TRIP) {
        hashes->edges = hash_word(hashes->edges, (uint32_t)tick);
        hashes->edges = hash_word(hashes->edges, (uint32_t)(tick >> 32));
        hashes->edges = hash_word(hash_word(hashes->edges, what), value);
    }
}

static uint32_t rows_to_hash(const table_row_t **rows)
{
    static const char *const names[] = {"signals", "requests", "truth"};
    uint32_t count = 0;
    for (uint32_t n = 0; n < rig_table_count(); n++) {
        const table_t *table = rig_table(n);
        for (size_t m = 0; m < sizeof names / sizeof names[0]; m++) {
            for (uint32_t k = 0; strcmp(table->name, names[m]) == 0 && k < table->count; k++) {
                if (count < ROWS_MAX) {
                    rows[count] = &table->rows[k];
                }
                count++;
            }
        }
    }
    return count;
}

/* These rows over the whole scenario, and the edges. */
static bool hash_rows(scenario_t *scenario, const table_row_t *const *rows, uint32_t count, hashes_t *hashes)
{
    uint32_t ids[ROWS_A_RUN];
    for (uint32_t n = 0; n < count; n++) {
        ids[n] = rows[n]->id;
        hashes->row[n] = FNV_START;
    }
    hashes->edges = FNV_START;
    const runner_options_t options = {
        .record = ids,
        .record_count = count,
        .record_every = 1u,
        .sink = on_sample,
        .sink_context = hashes,
        .edge_sink = on_edge,
        .edge_context = hashes,
    };
    runner_result_t result;
    const bool ran = runner_run(scenario, &options, &result);
    if (!ran) {
        char text[1200];
        fprintf(stderr, "tap_hash: %s\n", scenario_error_text(&result.error, text, sizeof text));
    }
    runner_result_free(&result);
    return ran;
}

static scenario_t *read_with(int argc, char **argv)
{
    char text[1200];
    scenario_error_t error;
    scenario_t *scenario = scenario_read(argv[1], &error);
    bool good = scenario != NULL;
    for (int n = 2; good && n < argc; n++) {
        good = scenario_override(scenario, argv[n], &error);
    }
    if (!good || !scenario_check(scenario, &error)) {
        fprintf(stderr, "tap_hash: %s\n", scenario_error_text(&error, text, sizeof text));
        if (scenario != NULL) {
            scenario_free(scenario);
        }
        return NULL;
    }
    return scenario;
}

int main(int argc, char **argv)
{
    if (argc < 2) {
        fputs("usage: tap_hash FILE.toml [NAME=VALUE...]\n", stderr);
        return 2;
    }
    const table_row_t *rows[ROWS_MAX];
    const uint32_t count = rows_to_hash(rows);
    if (count > ROWS_MAX) {
        fprintf(stderr, "tap_hash: more than %u rows\n", ROWS_MAX);
        return 2;
    }
    scenario_t *scenario = read_with(argc, argv);
    if (scenario == NULL) {
        return 2;
    }
    hashes_t hashes = {.edges = FNV_START};
    bool ran = true;
    for (uint32_t first = 0; ran && first < count; first += ROWS_A_RUN) {
        const uint32_t some = count - first < ROWS_A_RUN ? count - first : ROWS_A_RUN;
        ran = hash_rows(scenario, &rows[first], some, &hashes);
        for (uint32_t n = 0; ran && n < some; n++) {
            printf("%s %016" PRIx64 "\n", rows[first + n]->name, hashes.row[n]);
        }
    }
    if (ran) {
        printf("edges %016" PRIx64 "\n", hashes.edges);
    }
    scenario_free(scenario);
    return ran ? 0 : 3;
}
