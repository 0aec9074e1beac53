/* Broken scenario files: each is refused with file, line, column, the offending name and what would have been
 * accepted. And damaged ones: whatever is done to a good or broken one, it is read or refused in one line
 * with a name, and nothing else happens (the sanitizer build sees to that).
 *
 * LAGLESS_BROKEN is tests/lab/broken.txt, which says itself how it is read; LAGLESS_SCENARIOS the folder of
 * the shipped ones. */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host_sim/lab/scenario.h"
#include "host_sim/lab/toml_reader.h"
#include "unity.h"

#define LINE_SIZE 1200u
#define CASES     200u
#define CASE_SIZE 16384u
#define HEAD      "schema = 1\ntitle = \"broken\"\n[run]\nduration = \"1 s\"\n"
#define SEED      UINT64_C(0x9E3779B97F4A7C15) /* of the damage */
#define ROUNDS    10000u

static char folder[] = "/tmp/lagless_broken_XXXXXX";
static char path[512];

/* The broken ones, then the shipped ones. */
static struct {
    char text[CASE_SIZE];
    size_t octets;
} files[CASES];
static size_t broken_count, file_count;
static uint64_t state = SEED;

static void append(const char *text)
{
    TEST_ASSERT_TRUE(file_count > 0u && files[file_count - 1u].octets + strlen(text) < CASE_SIZE);
    strcpy(files[file_count - 1u].text + files[file_count - 1u].octets, text);
    files[file_count - 1u].octets += strlen(text);
}

static void load_broken(void)
{
    char line[LINE_SIZE];
    FILE *stream = fopen(LAGLESS_BROKEN, "r");
    TEST_ASSERT_NOT_NULL(stream);
    while (fgets(line, sizeof line, stream) != NULL) {
        const bool with_head = strncmp(line, "#: ", 3) == 0;
        if (with_head || strncmp(line, "#! ", 3) == 0) {
            TEST_ASSERT_TRUE(file_count < CASES);
            file_count++;
        } else if (file_count == 0u) {
            continue; /* what is said above the first */
        }
        append(line);
        append(with_head ? HEAD : "");
    }
    fclose(stream);
    broken_count = file_count;
}

static void load_shipped(void)
{
    DIR *directory = opendir(LAGLESS_SCENARIOS);
    TEST_ASSERT_NOT_NULL(directory);
    for (struct dirent *entry = readdir(directory); entry != NULL; entry = readdir(directory)) {
        if (strstr(entry->d_name, ".toml") == NULL) {
            continue;
        }
        TEST_ASSERT_TRUE(file_count < CASES);
        snprintf(path, sizeof path, "%s/%s", LAGLESS_SCENARIOS, entry->d_name);
        FILE *stream = fopen(path, "rb");
        TEST_ASSERT_NOT_NULL_MESSAGE(stream, path);
        files[file_count].octets = fread(files[file_count].text, 1, CASE_SIZE, stream);
        fclose(stream);
        file_count++;
    }
    closedir(directory);
}

static void expect_one_line(const char *text)
{
    for (const char *c = text; *c != '\0'; c++) {
        TEST_ASSERT_TRUE_MESSAGE((unsigned char)*c >= 0x20u && *c != 0x7F, text);
    }
}

/* The text begins and goes on like this, and has each of the parts, " & " between them. */
static void expect_message(const scenario_error_t *error, const char *file, const char *begin,
                           const char *parts)
{
    char text[LINE_SIZE];
    char all[LINE_SIZE];
    char start[LINE_SIZE];
    scenario_error_text(error, text, sizeof text);
    snprintf(start, sizeof start, "%s:%s", file, begin);
    TEST_ASSERT_EQUAL_STRING_LEN(start, text, strlen(start));
    snprintf(all, sizeof all, "%s", parts);
    for (char *part = all; part != NULL;) {
        char *next = strstr(part, " & ");
        if (next != NULL) {
            *next = '\0';
            next += 3;
        }
        if (strstr(text + strlen(start), part) == NULL) {
            fprintf(stderr, "expected: %s\n", part);
            TEST_FAIL_MESSAGE(text);
        }
        part = next;
    }
    expect_one_line(text);
}

static void expect_refusal(const char *file, const char *begin, const char *parts)
{
    scenario_error_t error;
    TEST_ASSERT_NULL_MESSAGE(scenario_read(file, &error), file);
    expect_message(&error, file, begin, parts);
}

static void test_every_broken_file_is_refused_with_place_name_and_reason(void)
{
    TEST_ASSERT_TRUE_MESSAGE(broken_count >= 90u, "broken files are there");
    for (size_t n = 0; n < broken_count; n++) {
        char line[LINE_SIZE];
        scenario_error_t error;
        snprintf(line, sizeof line, "%.*s", (int)strcspn(files[n].text, "\n"), files[n].text);
        char *place = strchr(line + 3, ' ');
        char *name = place != NULL ? strstr(place, ": ") : NULL;
        char *parts = name != NULL ? strstr(name + 2, ": ") : NULL;
        TEST_ASSERT_NOT_NULL_MESSAGE(parts, line);
        *place = *parts = '\0';
        TEST_ASSERT_NULL_MESSAGE(scenario_read_text(line + 3, files[n].text, files[n].octets, &error),
                                 line + 3);
        expect_message(&error, line + 3, place + 1, parts + 2);
    }
    printf("%zu broken files\n", broken_count);
}

/* ---- files that are none, or can not stand in the repository ---- */

static void write_file(const char *name, const char *content, size_t octets)
{
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *stream = fopen(path, "wb");
    TEST_ASSERT_NOT_NULL(stream);
    TEST_ASSERT_TRUE(fwrite(content, 1, octets, stream) == octets);
    fclose(stream);
}

static void test_missing_file(void)
{
    snprintf(path, sizeof path, "%s/there_is_none.toml", folder);
    expect_refusal(path, " file: ", "cannot be read: No such file");
}

static void test_folder_instead_of_a_file(void)
{
    expect_refusal(folder, " file: ", "cannot be read: it is a directory");
}

static void test_device_instead_of_a_file(void)
{
    expect_refusal("/dev/zero", " file: ", "cannot be read: it is not a plain file");
}

static void test_fifo_does_not_block(void)
{
    snprintf(path, sizeof path, "%s/fifo", folder);
    TEST_ASSERT_EQUAL_INT(0, mkfifo(path, 0600));
    expect_refusal(path, " file: ", "cannot be read: it is not a plain file");
    unlink(path);
}

static void test_file_without_permission(void)
{
    if (geteuid() == 0) {
        TEST_IGNORE_MESSAGE("root may read everything");
    }
    write_file("secret.toml", "schema = 1\n", 11u);
    chmod(path, 0);
    expect_refusal(path, " file: ", "cannot be read: Permission denied");
    unlink(path);
}

static void test_empty_file(void)
{
    write_file("empty.toml", "", 0u);
    expect_refusal(path, "1:1: schema: ", "it is missing & schema = 1");
    unlink(path);
}

static void test_file_of_nothing_but_a_nul(void)
{
    write_file("nul.toml", "\0", 1u);
    expect_refusal(path, "1:1: TOML: ", "not TOML");
    unlink(path);
}

static void expect_text_refused(const char *text, const char *expected)
{
    char line[LINE_SIZE];
    scenario_error_t error;
    TEST_ASSERT_NULL(scenario_read_text("x", text, strlen(text), &error));
    scenario_error_text(&error, line, sizeof line);
    TEST_ASSERT_EQUAL_STRING_LEN(expected, line, strlen(expected));
}

/* Found by fuzzing: on these toml++ 3.3 fails an assertion or runs into undefined behaviour. */
static void test_what_the_parser_can_not_stand_is_kept_from_it(void)
{
    expect_text_refused("a = 1\n[.]\n", "x:2:2: TOML: not TOML: something else is expected here");
    expect_text_refused("[[ =\n", "x:1:4: TOML: not TOML: something else is expected here");
    expect_text_refused("[[[a]]]\n", "x:1:3: a: not TOML: something else is expected here");
    expect_text_refused("schema\xEF\xBB\xBE"
                        "1 = 1\n",
                        "x:1:7: schema: not TOML: a character outside of ASCII");
    expect_text_refused("schema = 1\ntitle = \"\xE4\xF6\"\n", "x:2:9: title: not TOML");
    expect_text_refused("a = \"\xC3\xA4\xC3\xB6\" \xC3\xBC\n",
                        "x:1:10: a: not TOML: a character outside of ASCII");
}

static void test_windows_lines_and_byte_order_mark_are_fine(void)
{
    const char content[] = "\xEF\xBB\xBFschema = 1\r\ntitle = \"t\"\r\n[run]\r\nduration = \"1 ms\"\r\n";
    scenario_error_t error;
    scenario_t *scenario = scenario_read_text("crlf.toml", content, sizeof content - 1u, &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(scenario, error.message);
    scenario_free(scenario);
}

static void test_file_that_is_too_large(void)
{
    const size_t octets = TOML_OCTETS_MAX + 1u;
    char *content = malloc(octets);
    TEST_ASSERT_NOT_NULL(content);
    memset(content, '#', octets);
    write_file("large.toml", content, octets);
    expect_refusal(path, " file: ", "is too large & accepted up to 1048576 octets");
    write_file("large.toml", content, octets - 1u); /* one long comment: nothing in it */
    expect_refusal(path, "1:1: schema: ", "it is missing");
    unlink(path);
    free(content);
}

static void expect_too_deep(const char *content, size_t octets, uint32_t column)
{
    scenario_error_t error;
    TEST_ASSERT_NULL(scenario_read_text("deep.toml", content, octets, &error));
    TEST_ASSERT_EQUAL_UINT32(1u, error.place.line);
    TEST_ASSERT_EQUAL_UINT32(column, error.place.column);
    TEST_ASSERT_EQUAL_STRING_LEN("deep", error.name, 4);
    TEST_ASSERT_NOT_NULL(strstr(error.message, "nested too deeply; accepted: up to 16 brackets"));
}

/* Either would overflow the stack of whoever takes the tree apart. */
static void test_deep_nesting_is_refused(void)
{
    const size_t octets = TOML_OCTETS_MAX;
    char *content = malloc(octets);
    TEST_ASSERT_NOT_NULL(content);
    memset(content, '[', octets);
    memcpy(content, "deep = ", 7u);
    expect_too_deep(content, octets, 7u + 17u); /* the 17th bracket */
    for (size_t n = 0; n < octets; n++) {
        content[n] = n % 2u == 0u ? 'a' : '.';
    }
    memcpy(content, "deep", 4u);
    content[4] = '.';
    expect_too_deep(content, octets, 132u); /* dots at 4, 5, 7, 9, ...: the 65th at 131, counted from 0 */
    free(content);
}

static void test_brackets_and_dots_in_texts_and_comments_do_not_count(void)
{
    const char content[] =
        "# [[[[[[[[[[[[[[[[[[ ......................................................................\n"
        "schema = 1\n"
        "title = \"[[[[[[[[[[[[[[[[[[ \\\" "
        "......................................................................\"\n"
        "text = '''\n"
        "{{{{{{{{{{{{{{{{{{ \" ' [[[[[[[[[[[[[[[[[[ .....................................................\n"
        "'''\n"
        "[run]\nduration = 0.001\n";
    scenario_error_t error;
    scenario_t *scenario = scenario_read_text("text.toml", content, sizeof content - 1u, &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(scenario, error.message);
    scenario_free(scenario);
}

/* Each of these entries has the whole path in its messages; the paths of all would be 5 GB. */
static void test_many_keys_below_a_long_one_fit_into_memory(void)
{
    const size_t octets = TOML_OCTETS_MAX;
    char *content = malloc(octets + 16u);
    TEST_ASSERT_NOT_NULL(content);
    memset(content, 'a', octets / 2u);
    content[0] = '[';
    memcpy(content + octets / 2u, "]\n", 2u);
    size_t used = octets / 2u + 2u;
    for (unsigned n = 0; used + 16u < octets; n++) {
        used += (size_t)snprintf(content + used, 16u, "k%u=1\n", n);
    }
    scenario_error_t error;
    TEST_ASSERT_NULL(scenario_read_text("long.toml", content, used, &error));
    TEST_ASSERT_EQUAL_UINT32(1u, error.place.line);
    TEST_ASSERT_NOT_NULL(strstr(error.message, "no such table"));
    free(content);
}

/* ---- damaged files ---- */

/* xorshift64* */
static uint32_t any(uint32_t below)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (uint32_t)((state * UINT64_C(2685821657736338717)) >> 33) % below;
}

/* One damage; returns the new size. `text` has room for twice CASE_SIZE. */
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
    char *text = malloc(2u * CASE_SIZE);
    unsigned accepted = 0;
    unsigned refused = 0;
    TEST_ASSERT_NOT_NULL(text);
    for (size_t n = 0; n < ROUNDS; n++) {
        const size_t which = n % 2u == 0u
                                 ? (uint32_t)broken_count + any((uint32_t)(file_count - broken_count))
                                 : any((uint32_t)file_count);
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
        expect_one_line(line);
        refused++;
    }
    printf("seed %llx: %u accepted, %u refused\n", (unsigned long long)SEED, accepted, refused);
    /* both ways were gone: some damages hit a comment or a number that stays in its range */
    TEST_ASSERT_TRUE(accepted > 100u && refused > 5000u);
    free(text);
}

int main(void)
{
    if (mkdtemp(folder) == NULL) {
        perror("mkdtemp");
        return 1;
    }
    load_broken();
    load_shipped();
    UNITY_BEGIN();
    RUN_TEST(test_every_broken_file_is_refused_with_place_name_and_reason);
    RUN_TEST(test_missing_file);
    RUN_TEST(test_folder_instead_of_a_file);
    RUN_TEST(test_device_instead_of_a_file);
    RUN_TEST(test_fifo_does_not_block);
    RUN_TEST(test_file_without_permission);
    RUN_TEST(test_empty_file);
    RUN_TEST(test_file_of_nothing_but_a_nul);
    RUN_TEST(test_what_the_parser_can_not_stand_is_kept_from_it);
    RUN_TEST(test_windows_lines_and_byte_order_mark_are_fine);
    RUN_TEST(test_file_that_is_too_large);
    RUN_TEST(test_deep_nesting_is_refused);
    RUN_TEST(test_brackets_and_dots_in_texts_and_comments_do_not_count);
    RUN_TEST(test_many_keys_below_a_long_one_fit_into_memory);
    RUN_TEST(test_damaged_files_are_read_or_refused_in_one_line);
    const int failed = UNITY_END();
    rmdir(folder);
    return failed;
}
