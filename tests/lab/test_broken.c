/* Broken scenario files: each is refused with file, line, column, the offending name and what would have been
 * accepted.
 *
 * The first line of each file of tests/lab/broken says what is expected: `# LINE:COLUMN: NAME: PART & PART`,
 * where each part is somewhere in the message. LAGLESS_BROKEN is that folder. */
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

static char folder[] = "/tmp/lagless_broken_XXXXXX";
static char path[512];

void setUp(void)
{
}

void tearDown(void)
{
}

/* Refused, and the text begins and goes on like this. */
static void expect_refusal(const char *file, const char *begin, const char *parts)
{
    char text[LINE_SIZE];
    char all[LINE_SIZE];
    char start[LINE_SIZE];
    scenario_error_t error;
    scenario_t *scenario = scenario_read(file, &error);
    if (scenario != NULL) {
        scenario_free(scenario);
        TEST_FAIL_MESSAGE(file);
    }
    scenario_error_text(&error, text, sizeof text);
    snprintf(start, sizeof start, "%s:%s", file, begin);
    if (strncmp(text, start, strlen(start)) != 0) {
        fprintf(stderr, "expected %s\n", start);
        TEST_FAIL_MESSAGE(text);
    }
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
    for (const char *c = text; *c != '\0'; c++) {
        TEST_ASSERT_TRUE_MESSAGE((unsigned char)*c >= 0x20u, "one line");
    }
}

/* "# 7:1: name: part & part" */
static void check_file(const char *file)
{
    char line[LINE_SIZE];
    FILE *stream = fopen(file, "r");
    TEST_ASSERT_NOT_NULL_MESSAGE(stream, file);
    TEST_ASSERT_NOT_NULL(fgets(line, sizeof line, stream));
    fclose(stream);
    line[strcspn(line, "\n")] = '\0';
    char *name = strstr(line, ": ");
    char *parts = name != NULL ? strstr(name + 2, ": ") : NULL;
    TEST_ASSERT_TRUE_MESSAGE(strncmp(line, "# ", 2) == 0 && parts != NULL, file);
    *parts = '\0';
    expect_refusal(file, line + 2, parts + 2);
}

static int is_toml(const struct dirent *entry)
{
    const size_t length = strlen(entry->d_name);
    return length > 5u && strcmp(entry->d_name + length - 5u, ".toml") == 0;
}

static void test_every_broken_file_is_refused_with_place_name_and_reason(void)
{
    struct dirent **entries;
    const int count = scandir(LAGLESS_BROKEN, &entries, is_toml, alphasort);
    TEST_ASSERT_TRUE_MESSAGE(count >= 60, "broken files are there");
    for (int n = 0; n < count; n++) {
        snprintf(path, sizeof path, "%s/%s", LAGLESS_BROKEN, entries[n]->d_name);
        check_file(path);
        free(entries[n]);
    }
    free(entries);
    printf("%d broken files\n", count);
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

int main(void)
{
    if (mkdtemp(folder) == NULL) {
        perror("mkdtemp");
        return 1;
    }
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
    rmdir(folder);
    return UNITY_END();
}
