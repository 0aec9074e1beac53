/* The reader on damaged files: whatever is done to a good or broken one, it is read or refused in one line
 * with a name, and nothing else happens (the sanitizer build sees to that). Mutations from a fixed seed:
 * octets changed, left out, doubled, parts of other files put in.
 *
 * LAGLESS_BROKEN and LAGLESS_SCENARIOS are the folders whose files are damaged. */
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host_sim/lab/scenario.h"
#include "unity.h"

#define SEED            UINT64_C(0x9E3779B97F4A7C15)
#define ROUNDS          10000u
#define FILES           200u
#define FILE_OCTETS_MAX 16384u

static struct {
    char *text;
    size_t octets;
} files[FILES];
static size_t file_count;
static uint64_t state = SEED;

void setUp(void)
{
}

void tearDown(void)
{
}

/* xorshift64* */
static uint32_t any(uint32_t below)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (uint32_t)((state * UINT64_C(2685821657736338717)) >> 33) % below;
}

static void load(const char *folder)
{
    DIR *directory = opendir(folder);
    TEST_ASSERT_NOT_NULL_MESSAGE(directory, folder);
    for (struct dirent *entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        char path[1024];
        if (strstr(entry->d_name, ".toml") == NULL) {
            continue;
        }
        TEST_ASSERT_TRUE(file_count < FILES);
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        FILE *stream = fopen(path, "rb");
        TEST_ASSERT_NOT_NULL_MESSAGE(stream, path);
        files[file_count].text = malloc(FILE_OCTETS_MAX);
        TEST_ASSERT_NOT_NULL(files[file_count].text);
        files[file_count].octets = fread(files[file_count].text, 1, FILE_OCTETS_MAX, stream);
        fclose(stream);
        file_count++;
    }
    closedir(directory);
}

/* One damage; returns the new size. `text` has room for twice FILE_OCTETS_MAX. */
static size_t damage(char *text, size_t octets)
{
    static const char *const pieces[] = {"nan",
                                         "inf",
                                         "-",
                                         "1e999",
                                         "[[at]]\n",
                                         "[plant]\n",
                                         "\"",
                                         "= ",
                                         "true",
                                         "\n",
                                         "\\u0000",
                                         "[",
                                         "{",
                                         "'''",
                                         "99999999999999999999",
                                         "time = -1\n",
                                         "\xff",
                                         "\xEF\xBB\xBF",
                                         "."};
    const size_t at = any((uint32_t)octets + 1u);
    const size_t rest = octets - at;
    const char *piece = pieces[any(sizeof pieces / sizeof pieces[0])];
    size_t length = strlen(piece);
    switch (any(4)) {
    case 0: /* an octet becomes another */
        text[at < octets ? at : 0u] = (char)any(256);
        return octets;
    case 1: /* some are left out */
        length = rest == 0u ? 0u : 1u + any((uint32_t)(rest < 20u ? rest : 20u));
        memmove(text + at, text + at + length, rest - length);
        return octets - length;
    case 2: { /* a part of another file */
        const size_t other = any((uint32_t)file_count);
        const size_t from = files[other].octets == 0u ? 0u : any((uint32_t)files[other].octets);
        length = files[other].octets - from < 60u ? files[other].octets - from : 60u;
        piece = files[other].text + from;
        break;
    }
    default: /* something that has a meaning */
        break;
    }
    memmove(text + at + length, text + at, rest);
    memcpy(text + at, piece, length);
    return octets + length;
}

static void test_damaged_files_are_read_or_refused_in_one_line(void)
{
    char *text = malloc(2u * FILE_OCTETS_MAX);
    unsigned accepted = 0;
    unsigned refused = 0;
    TEST_ASSERT_NOT_NULL(text);
    load(LAGLESS_SCENARIOS);
    const size_t good_count = file_count;
    load(LAGLESS_BROKEN);
    for (size_t n = 0; n < ROUNDS; n++) {
        const size_t which = n % 2u == 0u ? any((uint32_t)good_count) : any((uint32_t)file_count);
        size_t octets = files[which].octets;
        memcpy(text, files[which].text, octets);
        for (uint32_t times = 1u + any(4); times > 0u && octets > 0u; times--) {
            octets = damage(text, octets);
        }
        scenario_error_t error;
        scenario_t *scenario = scenario_read_text("damaged.toml", text, octets, &error);
        if (scenario != NULL) {
            TEST_ASSERT_TRUE(scenario->periods > 0u && scenario->title[0] != '\0');
            scenario_free(scenario);
            accepted++;
            continue;
        }
        char line[1200];
        scenario_error_text(&error, line, sizeof line);
        TEST_ASSERT_TRUE_MESSAGE(error.name[0] != '\0' && error.message[0] != '\0', line);
        TEST_ASSERT_EQUAL_STRING("damaged.toml", error.file);
        TEST_ASSERT_TRUE_MESSAGE(error.place.line > 0u && error.place.column > 0u, line);
        for (const char *c = line; *c != '\0'; c++) {
            TEST_ASSERT_TRUE_MESSAGE((unsigned char)*c >= 0x20u && *c != 0x7F, line);
        }
        refused++;
    }
    printf("seed %llx: %u accepted, %u refused\n", (unsigned long long)SEED, accepted, refused);
    /* both ways were gone: some damages hit a comment or a number that stays in its range */
    TEST_ASSERT_TRUE(accepted > 100u && refused > 5000u);
    for (size_t n = 0; n < file_count; n++) {
        free(files[n].text);
    }
    free(text);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_damaged_files_are_read_or_refused_in_one_line);
    return UNITY_END();
}
