/* Broken scenario files: each is refused with file, line, column, the offending name and what would have
 * been accepted. tests/fuzz/fuzz_readers.c tests damaged files. LAGLESS_BROKEN is tests/lab/broken.txt,
 * which describes its format in its first lines. */
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

static char folder[] = "/tmp/lagless_broken_XXXXXX";
static char path[512];

static struct {
    char text[CASE_SIZE];
    size_t octets;
} files[CASES];
static size_t file_count;

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
            continue; /* the description of the format, before the first case */
        }
        append(line);
        append(with_head ? HEAD : "");
    }
    fclose(stream);
}

static void expect_one_line(const char *text)
{
    for (const char *c = text; *c != '\0'; c++) {
        TEST_ASSERT_TRUE_MESSAGE((unsigned char)*c >= 0x20u && *c != 0x7F, text);
    }
}

/* The text begins with this, and it contains each of the parts, which " & " separates. */
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
    TEST_ASSERT_TRUE_MESSAGE(file_count >= 70u, "broken.txt has too few cases");
    for (size_t n = 0; n < file_count; n++) {
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
    printf("%zu broken files\n", file_count);
}

/* ---- files that do not exist, or cannot be in the repository ---- */

static void write_file(const char *name, const char *content, size_t octets)
{
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *stream = fopen(path, "wb");
    TEST_ASSERT_NOT_NULL(stream);
    TEST_ASSERT_TRUE(fwrite(content, 1, octets, stream) == octets);
    fclose(stream);
}

static void test_what_is_not_a_file_is_refused_and_does_not_block(void)
{
    char none[512];
    char fifo[512];
    snprintf(none, sizeof none, "%s/there_is_none.toml", folder);
    snprintf(fifo, sizeof fifo, "%s/fifo", folder);
    TEST_ASSERT_EQUAL_INT(0, mkfifo(fifo, 0600));
    expect_refusal(none, " it cannot be read", ": No such file");
    expect_refusal(folder, " it cannot be read", ", because it is a directory");
    expect_refusal("/dev/zero", " it cannot be read", ", because it is not a plain file");
    expect_refusal(fifo, " it cannot be read", ", because it is not a plain file");
    unlink(fifo);
}

static void test_file_without_permission(void)
{
    if (geteuid() == 0) {
        TEST_IGNORE_MESSAGE("the user root may read every file");
    }
    write_file("secret.toml", "schema = 1\n", 11u);
    chmod(path, 0);
    expect_refusal(path, " it cannot be read", ": Permission denied");
    unlink(path);
}

/* The first two files are empty. The others were found by fuzzing: toml++ 3.3 fails an assertion or has
 * undefined behaviour with them, so that these texts must not be passed to it. */
static void test_text_that_is_not_toml_is_refused_with_its_place(void)
{
    static const struct {
        const char *text, *told;
        size_t octets; /* number of octets; 0: up to the end of the text */
    } rows[] = {
        {"", "x:1:1: schema: it is missing", 0u},
        {"\0", "x:1:1: TOML: not TOML", 1u},
        {"a = 1\n[.]\n", "x:2:2: TOML: not TOML: something else is expected here", 0u},
        {"[[ =\n", "x:1:4: TOML: not TOML: something else is expected here", 0u},
        {"[[[a]]]\n", "x:1:3: a: not TOML: something else is expected here", 0u},
        {"schema\xEF\xBB\xBE"
         "1 = 1\n",
         "x:1:7: schema: not TOML: a character outside of ASCII", 0u},
        {"schema = 1\ntitle = \"\xE4\xF6\"\n", "x:2:9: title: not TOML", 0u},
        {"a = \"\xC3\xA4\xC3\xB6\" \xC3\xBC\n", "x:1:10: a: not TOML: a character outside of ASCII", 0u},
    };
    for (size_t n = 0; n < sizeof rows / sizeof rows[0]; n++) {
        char line[LINE_SIZE];
        scenario_error_t error;
        const size_t octets = rows[n].octets != 0u ? rows[n].octets : strlen(rows[n].text);
        TEST_ASSERT_NULL(scenario_read_text("x", rows[n].text, octets, &error));
        scenario_error_text(&error, line, sizeof line);
        TEST_ASSERT_EQUAL_STRING_LEN(rows[n].told, line, strlen(rows[n].told));
    }
}

/* Files with Windows line ends and a byte order mark, and files with brackets and dots in texts and
 * comments, where they have no meaning. */
static void test_files_of_other_editors_are_accepted(void)
{
    static const char *const texts[] = {
        "\xEF\xBB\xBFschema = 1\r\ntitle = \"t\"\r\n[run]\r\nduration = \"1 ms\"\r\n",
        "# [[[[[[[[[[[[[[[[[[ ......................................................................\n"
        "schema = 1\n"
        "title = \"[[[[[[[[[[[[[[[[[[ \\\" "
        "......................................................................\"\n"
        "text = '''\n"
        "{{{{{{{{{{{{{{{{{{ \" ' [[[[[[[[[[[[[[[[[[ .....................................................\n"
        "'''\n"
        "[run]\nduration = 0.001\n"};
    for (size_t n = 0; n < 2u; n++) {
        scenario_error_t error;
        scenario_t *scenario = scenario_read_text("text.toml", texts[n], strlen(texts[n]), &error);
        TEST_ASSERT_NOT_NULL_MESSAGE(scenario, error.message);
        scenario_free(scenario);
    }
}

static void test_file_that_is_too_large(void)
{
    const size_t octets = TOML_OCTETS_MAX + 1u;
    char *content = malloc(octets);
    TEST_ASSERT_NOT_NULL(content);
    memset(content, '#', octets);
    write_file("large.toml", content, octets);
    expect_refusal(path, " it is too large", "; accepted: up to 1048576 octets");
    write_file("large.toml", content, octets - 1u); /* one long comment without a setting */
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

/* Both texts would overflow the stack of the library when it frees the tree. */
static void test_deep_nesting_is_refused(void)
{
    const size_t octets = TOML_OCTETS_MAX;
    char *content = malloc(octets);
    TEST_ASSERT_NOT_NULL(content);
    memset(content, '[', octets);
    memcpy(content, "deep = ", 7u);
    expect_too_deep(content, octets, 7u + 17u); /* position of the 17th bracket */
    for (size_t n = 0; n < octets; n++) {
        content[n] = n % 2u == 0u ? 'a' : '.';
    }
    memcpy(content, "deep", 4u);
    content[4] = '.';
    /* Dots are at 4, 5, 7, 9, ...: the 65th is at 131, counted from 0. */
    expect_too_deep(content, octets, 132u);
    free(content);
}

/* Every entry has its whole path in its messages; the paths of all entries together would be 5 GB. */
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
    load_broken();
    UNITY_BEGIN();
    RUN_TEST(test_every_broken_file_is_refused_with_place_name_and_reason);
    RUN_TEST(test_what_is_not_a_file_is_refused_and_does_not_block);
    RUN_TEST(test_file_without_permission);
    RUN_TEST(test_text_that_is_not_toml_is_refused_with_its_place);
    RUN_TEST(test_files_of_other_editors_are_accepted);
    RUN_TEST(test_file_that_is_too_large);
    RUN_TEST(test_deep_nesting_is_refused);
    RUN_TEST(test_many_keys_below_a_long_one_fit_into_memory);
    const int failed = UNITY_END();
    rmdir(folder);
    return failed;
}
