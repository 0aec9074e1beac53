/* Recordings as files: content, names, refusals, and the reaction to a full disk or memory. */
#define _DEFAULT_SOURCE
#define _XOPEN_SOURCE 700

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "host_sim/lab/recorder.h"
#include "host_sim/rig/rig.h"
#include "math/float_bits.h"
#include "unity.h"

#define STATE    2001u /* an enumeration */
#define I_Q      2016u /* float, A */
#define ENCODER  2034u /* uint32_t */
#define U_DC     2024u /* float, V */
#define MEGABYTE (UINT32_C(1) << 20)

static char folder[32];
static recorder_options_t options;
static recorder_error_t error;

static const uint32_t three_ids[] = {I_Q, STATE, ENCODER};

void setUp(void)
{
    strcpy(folder, "recorder_XXXXXX");
    TEST_ASSERT_NOT_NULL(mkdtemp(folder));
    memset(&error, 0, sizeof error);
    options = (recorder_options_t){
        .folder = folder,
        .name = "run",
        .formats = RECORDER_CSV,
        .ids = three_ids,
        .count = 3,
        .every = 1,
        .isr_ticks = 1000,
        .meta = {.program = "lagless 0.1.0",
                 .commit = "abc123",
                 .scenario = "load_step.toml",
                 .scenario_text = "",
                 .title = "Load step",
                 .seed = 7},
    };
}

/* fsync() and rename() are replaced. They count how many files got their names, and how many of these had
 * been synced before. */
static struct stat last_synced;
static uint32_t named, named_after_sync;

int fsync(int descriptor)
{
    return fstat(descriptor, &last_synced) == 0 ? (int)syscall(SYS_fsync, descriptor) : -1;
}

int rename(const char *from, const char *to)
{
    struct stat found;
    named++;
    named_after_sync += stat(from, &found) == 0 && found.st_ino == last_synced.st_ino && found.st_size > 0;
    return (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

static void path_of(char path[256], const char *name)
{
    snprintf(path, 256, "%s/%s", folder, name);
}

void tearDown(void)
{
    DIR *entries = opendir(folder);
    char path[256];
    for (struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
        if (entry->d_name[0] != '.') {
            snprintf(path, sizeof path, "%.31s/%.200s", folder, entry->d_name);
            remove(path);
        }
    }
    closedir(entries);
    rmdir(folder);
}

static bool exists(const char *name)
{
    char path[256];
    struct stat status;
    path_of(path, name);
    return lstat(path, &status) == 0;
}

static uint32_t files_left(void)
{
    uint32_t count = 0;
    DIR *entries = opendir(folder);
    for (struct dirent *entry = readdir(entries); entry != NULL; entry = readdir(entries)) {
        count += entry->d_name[0] != '.' ? 1u : 0u;
    }
    closedir(entries);
    return count;
}

/* The file as text; the caller frees it. */
static char *content(const char *name)
{
    char path[256];
    path_of(path, name);
    FILE *file = fopen(path, "rb");
    TEST_ASSERT_NOT_NULL_MESSAGE(file, path);
    fseek(file, 0, SEEK_END);
    const size_t size = (size_t)ftell(file);
    rewind(file);
    char *text = malloc(size + 1u);
    TEST_ASSERT_EQUAL(size, fread(text, 1, size, file));
    text[size] = '\0';
    fclose(file);
    return text;
}

static void expect_part(const char *text, const char *part)
{
    TEST_ASSERT_TRUE_MESSAGE(strstr(text, part) != NULL, part);
}

/* The file contains this text. */
static void expect_in(const char *name, const char *part)
{
    char *text = content(name);
    expect_part(text, part);
    free(text);
}

/* The samples of the CSV file are these lines. */
static void expect_lines(const char *lines)
{
    char *text = content("run.csv");
    TEST_ASSERT_EQUAL_STRING(lines, strchr(strstr(text, "time[s]"), '\n') + 1);
    free(text);
}

static recorder_t *opened(void)
{
    recorder_t *recorder = recorder_open(&options, &error);
    TEST_ASSERT_NOT_NULL_MESSAGE(recorder, error.text);
    return recorder;
}

static void expect_closed(recorder_t *recorder)
{
    named = named_after_sync = 0u;
    TEST_ASSERT_TRUE_MESSAGE(recorder_close(recorder, "complete", &error), error.text);
    TEST_ASSERT_EQUAL_STRING("", error.text);
    TEST_ASSERT_TRUE(named > 0u);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(named, named_after_sync,
                                     "a file got its name before its content was on the disk");
}

static void sample(recorder_t *recorder, uint32_t period, float i_q, int32_t state, uint32_t encoder)
{
    const uint32_t slots[] = {float_bits(i_q), (uint32_t)state, encoder};
    recorder_sink(recorder, period, slots, 3);
}

/* ---- CSV ---- */

static void test_csv_has_header_units_and_a_line_a_sample(void)
{
    recorder_t *recorder = opened();
    sample(recorder, 0, 0.5f, 1, 0);
    sample(recorder, 1, -1.25e-7f, -1, 4294967295u);
    sample(recorder, 12345, 10.000001f, 3, 9999);
    TEST_ASSERT_EQUAL_UINT64(3, recorder_samples(recorder));
    expect_closed(recorder);
    expect_in("run.csv", "\ntime[s],i_q[A],state[-],encoder_count[counts]\n");
    expect_lines("0.0000,0.5,1,0\n0.0001,-1.25e-7,-1,4294967295\n1.2345,10.000001,3,9999\n");
    TEST_ASSERT_EQUAL(1, files_left());
}

static void test_csv_begins_with_what_it_takes_to_run_it_again(void)
{
    const recorder_value_t values[] = {{"motor_resistance", (double)0.95f, "ohm"},
                                       {"plant.inertia", 0.003, "kg m^2"}};
    options.every = 5;
    options.meta.values = values;
    options.meta.value_count = 2;
    options.meta.scenario_text = "schema = 1\n\t\ntitle = \"a\\tb\"\r\nlast";
    recorder_t *recorder = opened();
    TEST_ASSERT_FALSE_MESSAGE(exists("run.csv"), "a file has its final name before the end");
    char what[] = "load_torque = 5 N m\nand more";
    TEST_ASSERT_TRUE(recorder_note(recorder, RECORDER_EVENT, "0.5 s", what));
    TEST_ASSERT_TRUE(recorder_note(recorder, RECORDER_VERDICT, "met", "dip: -52 r/min"));
    what[0] = 'L'; /* the recorder has copied the text */
    TEST_ASSERT_TRUE(recorder_close(recorder, "interrupted", &error));
    char *text = content("run.csv");
    char expected[1024];
    snprintf(expected, sizeof expected,
             "# lagless recording: 1\n"
             "# program: lagless 0.1.0\n"
             "# commit: abc123\n"
             "# tables: 0x%08x\n"
             "# scenario: load_step.toml\n"
             "# title: Load step\n"
             "# seed: 7\n"
             "# every: 5\n"
             "# period: 0.0001 s\n"
             "# ended: interrupted\n"
             "# choices state: %s\n"
             "# value motor_resistance: 0.95 ohm\n"
             "# value plant.inertia: 0.003 kg m^2\n"
             "# event 0.5 s: load_torque = 5 N m\\x0aand more\n"
             "# verdict met: dip: -52 r/min\n"
             "# text: schema = 1\n"
             "# text: \t\n"
             "# text: title = \"a\\\\tb\"\n"
             "# text: last\n"
             "time[s],i_q[A],state[-],encoder_count[counts]\n",
             (unsigned)rig_tables_hash(), rig_row(STATE)->choices);
    TEST_ASSERT_EQUAL_STRING(expected, text);
    free(text);
}

static void test_no_text_can_leave_its_comment(void)
{
    options.meta.title = "one\ntwo\x7f\\ \xc3\xa9";
    options.meta.commit = "\r1,2";
    recorder_t *recorder = opened();
    expect_closed(recorder);
    expect_in("run.csv", "# title: one\\x0atwo\\x7f\\\\ \xc3\xa9\n");
    expect_in("run.csv", "# commit: \\x0d1,2\n");
}

static void test_a_name_of_two_tables_is_qualified(void)
{
    /* Finds a row whose name occurs in two tables, so that the test does not depend on a certain row. */
    uint32_t ids[1] = {0};
    const table_t *owner = NULL;
    for (uint32_t t = 0; t < rig_table_count() && owner == NULL; t++) {
        for (uint32_t r = 0; r < rig_table(t)->count && owner == NULL; r++) {
            for (uint32_t other = t + 1u; other < rig_table_count(); other++) {
                if (table_by_name(rig_table(other), rig_table(t)->rows[r].name) != NULL) {
                    owner = rig_table(t);
                    ids[0] = owner->rows[r].id;
                }
            }
        }
    }
    if (owner == NULL) {
        TEST_IGNORE_MESSAGE("no two tables share a name");
    }
    char expected[128];
    snprintf(expected, sizeof expected, "time[s],%s.%s[", owner->name, rig_row(ids[0])->name);
    options.ids = ids;
    options.count = 1;
    recorder_t *recorder = opened();
    expect_closed(recorder);
    expect_in("run.csv", expected);
}

static void test_no_cell_of_a_header_needs_quotes(void)
{
    for (uint32_t t = 0; t < rig_table_count(); t++) {
        for (uint32_t r = 0; r < rig_table(t)->count; r++) {
            const table_row_t *row = &rig_table(t)->rows[r];
            TEST_ASSERT_TRUE_MESSAGE(strpbrk(row->name, ",\"[]\n#") == NULL, row->name);
            TEST_ASSERT_TRUE_MESSAGE(strpbrk(row->unit, ",\"[]\n#") == NULL, row->name);
        }
    }
}

static void test_same_samples_same_bytes(void)
{
    char *text[2];
    char *mat[2];
    char *mdf[2];
    options.formats = RECORDER_SAMPLED;
    struct stat status[2];
    struct stat status_mdf[2];
    for (int n = 0; n < 2; n++) {
        recorder_t *recorder = opened();
        for (uint32_t k = 0; k < 1000; k++) {
            sample(recorder, k, 0.1f * (float)k, (int32_t)k, k);
        }
        expect_closed(recorder);
        text[n] = content("run.csv");
        mat[n] = content("run.mat");
        char path[256];
        path_of(path, "run.mat");
        stat(path, &status[n]);
        mdf[n] = content("run.mf4");
        path_of(path, "run.mf4");
        stat(path, &status_mdf[n]);
    }
    TEST_ASSERT_EQUAL_STRING(text[0], text[1]);
    TEST_ASSERT_EQUAL(status[0].st_size, status[1].st_size);
    TEST_ASSERT_EQUAL_MEMORY(mat[0], mat[1], status[0].st_size);
    TEST_ASSERT_EQUAL(status_mdf[0].st_size, status_mdf[1].st_size);
    TEST_ASSERT_EQUAL_MEMORY(mdf[0], mdf[1], status_mdf[0].st_size);
    for (int n = 0; n < 2; n++) {
        free(text[n]);
        free(mat[n]);
        free(mdf[n]);
    }
}

static void test_chunks_join_without_a_seam(void)
{
    /* A sample has 4 words, so that 65536 samples fill a chunk of 1 MiB. */
    recorder_t *recorder = opened();
    for (uint32_t k = 0; k < 200000; k++) {
        sample(recorder, k, (float)k, 0, k);
    }
    expect_closed(recorder);
    char *text = content("run.csv");
    char *line = strstr(strstr(text, "time[s]"), "\n") + 1;
    for (uint32_t k = 0; k < 200000; k++) {
        char expected[64];
        snprintf(expected, sizeof expected, "%u.%04u,%u,0,%u\n", k / 10000u, k % 10000u, k, k);
        TEST_ASSERT_EQUAL_MEMORY(expected, line, strlen(expected));
        line += strlen(expected);
    }
    TEST_ASSERT_EQUAL('\0', *line);
    free(text);
}

static void test_going_back_in_time_takes_back_samples(void)
{
    recorder_t *recorder = opened();
    for (uint32_t k = 0; k < 200000; k += 10) {
        sample(recorder, k, 1.0f, 0, k);
    }
    for (uint32_t k = 30; k < 60; k += 10) {
        sample(recorder, k, 2.0f, 0, k);
    }
    sample(recorder, 60, 3.0f, 0, 60);
    sample(recorder, 60, 4.0f, 0, 60);
    expect_closed(recorder);
    expect_lines("0.0000,1,0,0\n0.0010,1,0,10\n0.0020,1,0,20\n"
                 "0.0030,2,0,30\n0.0040,2,0,40\n0.0050,2,0,50\n0.0060,4,0,60\n");
}

static void test_the_rigs_tap_feeds_it(void)
{
    rig_t *rig = rig_create(1);
    options.every = 3;
    recorder_t *recorder = opened();
    TEST_ASSERT_TRUE(rig_tap(rig, three_ids, 3, options.every, recorder_sink, recorder));
    rig_run(rig, 10);
    expect_closed(recorder);
    rig_free(rig);
    char *text = content("run.csv");
    const char *line = strstr(strstr(text, "time[s]"), "\n") + 1;
    static const char *const times[] = {"0.0000,", "0.0003,", "0.0006,", "0.0009,"};
    for (int n = 0; n < 4; n++) {
        TEST_ASSERT_EQUAL_MEMORY(times[n], line, 7);
        line = strstr(line, "\n") + 1;
    }
    TEST_ASSERT_EQUAL('\0', *line);
    free(text);
}

/* ---- MDF ---- */

/* The number that is stored in `octets` octets, the lowest first, at this place of the file. */
static uint64_t number_at(const char *file, uint64_t at, uint32_t octets)
{
    uint64_t value = 0;
    for (uint32_t n = 0; n < octets; n++) {
        value |= (uint64_t)(unsigned char)file[at + n] << 8u * n;
    }
    return value;
}

/* The address of the block to which link n of a block leads; that block must have this name. */
static uint64_t followed(const char *file, uint64_t block, uint32_t n, const char *name)
{
    const uint64_t at = number_at(file, block + 24u + 8u * n, 8);
    TEST_ASSERT_EQUAL_STRING_LEN(name, file + at, 4);
    return at;
}

/* tests/recorder/check_mdf.py checks the blocks, channels and samples. */
static void test_no_text_can_leave_the_comment_of_mdf(void)
{
    options.formats = RECORDER_MDF;
    options.meta.title = "a </TX> \x01 & \xff \xc3\xa9";
    recorder_t *recorder = opened();
    expect_closed(recorder);
    char *file = content("run.mf4");
    const char *comment = file + followed(file, 64, 5, "##MD") + 24u;
    expect_part(comment, "<TX>a &lt;/TX&gt; \\x01 &amp; \xef\xbf\xbd \xc3\xa9</TX>");
    expect_part(comment, "<e name=\"seed\">7</e>");
    free(file);
}

/* ---- VCD ---- */

/* A tick is 20/3 ns: 1 is rounded to 7 ns, 2 to 13 ns, 3 to 20 ns. */
static void test_vcd_shows_edges_in_nanoseconds(void)
{
    options.formats = RECORDER_VCD;
    options.count = 0;
    options.isr_ticks = 300; /* 2 us */
    recorder_t *recorder = opened();
    recorder_edge(recorder, 0, RIG_EDGE_TRIP, 7);
    recorder_edge(recorder, 0, RIG_EDGE_GATES, 0);
    recorder_edge(recorder, 1, RIG_EDGE_TRIP, 0);
    recorder_edge(recorder, 2, RIG_EDGE_GATES, 0x01); /* upper switch of a */
    recorder_edge(recorder, 3, RIG_EDGE_GATES, 0x2A); /* the three lower switches */
    /* Within one tick only the last level is shown: lower switch of c. */
    recorder_edge(recorder, 3, RIG_EDGE_GATES, 0x20);
    recorder_edge(recorder, 300, RIG_EDGE_ADC_START, 0);
    recorder_edge(recorder, 310, RIG_EDGE_ISR_ENTER, 32);
    recorder_edge(recorder, 310, RIG_EDGE_ISR_EXIT, 32);
    recorder_edge(recorder, 600, RIG_EDGE_GATES, 0x20); /* no change */
    recorder_edge(recorder, 900, RIG_EDGE_TRIP, 1);
    expect_closed(recorder);
    char *text = content("run.vcd");
    const char *definitions = strstr(text, "$timescale");
    TEST_ASSERT_NOT_NULL(definitions);
    TEST_ASSERT_EQUAL_STRING("$timescale 1 ns $end\n$scope module lagless $end\n"
                             "$var wire 1 ! upper_a $end\n$var wire 1 \" lower_a $end\n"
                             "$var wire 1 # upper_b $end\n$var wire 1 $ lower_b $end\n"
                             "$var wire 1 % upper_c $end\n$var wire 1 & lower_c $end\n"
                             "$var wire 1 ' isr $end\n$var wire 1 ( adc_start $end\n$var wire 1 ) trip $end\n"
                             "$upscope $end\n$enddefinitions $end\n"
                             "#0\n$dumpvars\n0!\n0\"\n0#\n0$\n0%\n0&\n0'\n0(\n1)\n$end\n"
                             "#7\n0)\n"      /* tick 1 */
                             "#13\n1!\n"     /* tick 2 */
                             "#20\n0!\n1&\n" /* tick 3 */
                             "#2000\n1(\n"   /* tick 300 */
                             "#2067\n1'\n"   /* tick 310 */
                             "#2200\n0(\n"   /* tick 330 = 300 + RECORDER_ADC_TICKS */
                             "#4067\n0'\n"   /* tick 610 */
                             "#6000\n1)\n",  /* tick 900 */
                             definitions);
    free(text);
}

/* Sequences of edges, and the edges that the file shows. */
static const struct {
    const char *name;
    uint32_t isr_ticks;
    struct {
        uint64_t tick;
        rig_edge_t what;
        uint32_t value;
    } edges[12];
    const char *shown;
    bool ends; /* the file ends with this edge */
} courses[] = {
    {"gates are unknown until the first edge",
     1000,
     {{15000, RIG_EDGE_GATES, 0}},
     "#0\n$dumpvars\nx!\nx\"\nx#\nx$\nx%\nx&\n0'\n0(\n0)\n$end\n#100000\n0!\n0\"\n0#\n0$\n0%\n0&\n",
     false},
    /* The interrupt waits for 600 ticks inside; two interrupts in succession last 60 ticks together; the
     * second of two interrupts waits. */
    {"an interrupt lasts until its exit",
     30,
     {{300, RIG_EDGE_ISR_ENTER, 32},
      {900, RIG_EDGE_ISR_EXIT, 32},
      {3000, RIG_EDGE_ISR_ENTER, 32},
      {3000, RIG_EDGE_ISR_EXIT, 32},
      {3003, RIG_EDGE_ISR_ENTER, 40},
      {3003, RIG_EDGE_ISR_EXIT, 40},
      {4500, RIG_EDGE_ISR_ENTER, 32},
      {4500, RIG_EDGE_ISR_EXIT, 32},
      {4503, RIG_EDGE_ISR_ENTER, 40},
      {4800, RIG_EDGE_ISR_EXIT, 40},
      {6000, RIG_EDGE_GATES, 0}},
     "$end\n#2000\n1'\n#6000\n0'\n#20000\n1'\n#20400\n0'\n#30000\n1'\n#32000\n0'\n#40000\n",
     false},
    {"a short interrupt ends before the mark of the ADC",
     3,
     {{300, RIG_EDGE_ADC_START, 0},
      {300, RIG_EDGE_ISR_ENTER, 32},
      {300, RIG_EDGE_ISR_EXIT, 32},
      {600, RIG_EDGE_GATES, 0}},
     "$end\n#2000\n1'\n1(\n#2020\n0'\n#2200\n0(\n#4000\n",
     false},
    {"after a step back in time an interrupt is shown once",
     300,
     {{1500, RIG_EDGE_ISR_ENTER, 32},
      {1500, RIG_EDGE_ISR_EXIT, 32},
      {3000, RIG_EDGE_GATES, 0},
      {1500, RIG_EDGE_ISR_ENTER, 32},
      {1500, RIG_EDGE_ISR_EXIT, 32},
      {3000, RIG_EDGE_GATES, 0}},
     "$end\n#10000\n1'\n#12000\n0'\n#20000\n",
     false},
    {"the file ends when the last interrupt has ended",
     300,
     {{1500, RIG_EDGE_ADC_START, 0}, {1500, RIG_EDGE_ISR_ENTER, 32}, {1500, RIG_EDGE_ISR_EXIT, 32}},
     "#10000\n1'\n1(\n#10200\n0(\n#12000\n0'\n",
     true},
};

static void test_vcd_shows_courses_of_edges(void)
{
    options.formats = RECORDER_VCD;
    options.count = 0;
    for (size_t n = 0; n < sizeof courses / sizeof courses[0]; n++) {
        options.isr_ticks = courses[n].isr_ticks;
        recorder_t *recorder = opened();
        for (size_t k = 0; k < 12u && courses[n].edges[k].tick != 0u; k++) {
            recorder_edge(recorder, courses[n].edges[k].tick, courses[n].edges[k].what,
                          courses[n].edges[k].value);
        }
        expect_closed(recorder);
        char *text = content("run.vcd");
        const char *shown = strstr(text, courses[n].shown);
        TEST_ASSERT_TRUE_MESSAGE(shown != NULL && (!courses[n].ends || strcmp(shown, courses[n].shown) == 0),
                                 courses[n].name);
        free(text);
    }
}

static void test_vcd_ends_with_the_last_samples_period(void)
{
    options.formats = RECORDER_VCD | RECORDER_CSV;
    recorder_t *recorder = opened();
    sample(recorder, 0, 1.0f, 0, 0);
    recorder_edge(recorder, 150, RIG_EDGE_GATES, 0x15);
    sample(recorder, 1, 1.0f, 0, 0);
    expect_closed(recorder);
    expect_in("run.vcd", "#1000\n1!\n0\"\n1#\n0$\n1%\n0&\n#200000\n");
    TEST_ASSERT_TRUE(exists("run.csv"));
}

static void test_vcd_going_back_in_time_takes_back_edges(void)
{
    options.formats = RECORDER_VCD;
    options.count = 0;
    recorder_t *recorder = opened();
    recorder_edge(recorder, 0, RIG_EDGE_GATES, 0);
    for (uint64_t tick = 150; tick < 150000; tick += 150) {
        recorder_edge(recorder, tick, RIG_EDGE_GATES, tick % 300u == 0u ? 1u : 2u);
    }
    recorder_edge(recorder, 300, RIG_EDGE_GATES, 0x20);
    expect_closed(recorder);
    char *text = content("run.vcd");
    expect_part(text, "0)\n$end\n#1000\n1\"\n#2000\n0\"\n1&\n");
    TEST_ASSERT_TRUE(strstr(text, "#3000\n") == NULL);
    free(text);
}

static void test_vcd_comment_cannot_be_ended_by_a_text(void)
{
    options.formats = RECORDER_VCD;
    options.count = 0;
    options.meta.scenario_text = "# $end\n";
    recorder_t *recorder = opened();
    expect_closed(recorder);
    expect_in("run.vcd", "text: # \\x24end\n$end\n$timescale");
    expect_in("run.vcd", "seed: 7\n");
}

/* ---- refusals, after which no file remains ---- */

static void expect_refused(const char *part)
{
    recorder_t *recorder = recorder_open(&options, &error);
    TEST_ASSERT_NULL(recorder);
    TEST_ASSERT_TRUE_MESSAGE(strstr(error.text, part) != NULL, error.text);
    TEST_ASSERT_EQUAL(0, files_left());
}

static void test_options_out_of_range_are_refused(void)
{
    const recorder_options_t good = options;
    options.formats = 0;
    expect_refused("CSV, MAT, VCD, MDF");
    options.formats = 1u << RECORDER_FORMATS;
    expect_refused("CSV, MAT, VCD, MDF");
    options = good;
    options.name = "";
    expect_refused("no name");
    options = good;
    options.count = 0;
    expect_refused("0 rows to record: accepted: 1 to 160");
    options.count = RIG_TAP_MAX + 1u;
    expect_refused("161 rows to record: accepted: 1 to 160");
    options = good;
    options.every = 0;
    expect_refused("accepted: 1 and more");
    options = good;
    options.memory = RECORDER_MEMORY_MIN - 1u;
    expect_refused("accepted: 4194304 to 1073741824");
    options.memory = RECORDER_MEMORY_MAX + 1u;
    expect_refused("accepted: 4194304 to 1073741824");
    options = good;
    options.formats = RECORDER_VCD;
    options.isr_ticks = 0;
    expect_refused("accepted: 1 and more");
}

static void test_rows_must_exist_and_differ(void)
{
    const uint32_t unknown[] = {I_Q, 999999u};
    options.ids = unknown;
    options.count = 2;
    expect_refused("999999");
    const uint32_t twice[] = {I_Q, U_DC, I_Q};
    options.ids = twice;
    options.count = 3;
    expect_refused("i_q is given twice");
}

static void test_settings_must_differ(void)
{
    const recorder_value_t values[] = {{"a", 1.0, "-"}, {"b", 1.0, "-"}, {"a", 2.0, "-"}};
    options.meta.values = values;
    options.meta.value_count = 3;
    expect_refused("two settings of the recording are called a");
}

static void test_missing_folder_is_named(void)
{
    options.folder = "recorder_nowhere";
    expect_refused("recorder_nowhere/run.csv.partial: No such file or directory");
}

static void test_one_file_that_cannot_be_made_takes_the_others_with_it(void)
{
    char path[256];
    path_of(path, "run.vcd.partial");
    TEST_ASSERT_EQUAL(0, mkdir(path, 0700));
    options.formats = RECORDER_CSV | RECORDER_MAT | RECORDER_VCD;
    TEST_ASSERT_NULL(recorder_open(&options, &error));
    TEST_ASSERT_TRUE_MESSAGE(strstr(error.text, "run.vcd.partial: Is a directory") != NULL, error.text);
    TEST_ASSERT_EQUAL(1, files_left());
}

static void test_plan_that_does_not_fit_is_refused_with_what_would(void)
{
    /* A sample has 16 octets: 65536 samples fit into 1 MiB, 262144 into 4 MiB. */
    options.memory = 4u * MEGABYTE;
    options.periods = 262144;
    recorder_abandon(opened());
    options.periods = 262145;
    expect_refused("3 rows of 262145 periods do not fit into 4 MiB: every 2 or more");
    options.every = 2;
    recorder_abandon(opened());
    options.periods = 524289;
    expect_refused("every 3 or more");
    options.periods = UINT32_MAX;
    options.every = UINT32_MAX;
    recorder_abandon(opened());
}

static void test_plan_counts_edges(void)
{
    /* 16 edges of 8 octets per period: 8192 periods fill 1 MiB. One further chunk is for the samples. */
    options.formats = RECORDER_CSV | RECORDER_VCD;
    options.memory = 4u * MEGABYTE;
    options.periods = 3u * 8192u;
    recorder_abandon(opened());
    options.periods = 4u * 8192u;
    expect_refused("the edges of 32768 periods do not fit into 4 MiB");
}

/* ---- trouble at the end ---- */

static void test_abandon_removes_everything(void)
{
    options.formats = RECORDER_SAMPLED | RECORDER_VCD;
    recorder_t *recorder = opened();
    TEST_ASSERT_EQUAL(4, files_left());
    sample(recorder, 0, 1.0f, 0, 0);
    recorder_abandon(recorder);
    TEST_ASSERT_EQUAL(0, files_left());
    recorder_abandon(NULL);
}

/* 262144 samples of 16 octets fit. The test records this number and then one more sample, whose time is
 * earlier or not. */
static void test_memory_that_is_used_up_is_reported_unless_the_loss_is_taken_back(void)
{
    static const struct {
        const char *name;
        uint32_t count, rounds, back; /* back 0: no further sample */
        const char *told;             /* text of the message; NULL if no sample is lost */
    } cases[] = {{"to the last octet", 262144u, 1u, 0u, NULL},
                 {"going back gives memory back", 262144u, 3u, 0u, NULL},
                 {"two are missing", 262146u, 1u, 0u, "2 samples from 26.2144 s on are missing"},
                 {"back before the loss", 262150u, 1u, 5u, NULL},
                 {"back after the loss", 262150u, 1u, 262147u, "from 26.2144 s on are missing"}};
    for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
        options.memory = RECORDER_MEMORY_MIN;
        recorder_t *recorder = opened();
        for (uint32_t k = 0; k < cases[n].rounds * cases[n].count; k++) {
            sample(recorder, k % cases[n].count, 1.0f, 0, k % cases[n].count);
        }
        if (cases[n].back != 0u) {
            sample(recorder, cases[n].back, 2.0f, 0, 5);
        }
        const bool good = recorder_close(recorder, "complete", &error);
        TEST_ASSERT_EQUAL_MESSAGE(cases[n].told == NULL, good, cases[n].name);
        TEST_ASSERT_EQUAL(good, exists("run.csv"));
        if (!good) {
            expect_part(error.text, cases[n].told);
            expect_in("run.csv.partial", "\n26.2143,1,0,262143\n");
        }
        if (cases[n].back == 5u) {
            expect_in("run.csv", "0.0004,1,0,4\n0.0005,2,0,5\n");
        }
        tearDown();
        setUp();
    }
}

static void test_lost_edges_are_reported_and_samples_kept(void)
{
    options.formats = RECORDER_CSV | RECORDER_VCD;
    options.memory = RECORDER_MEMORY_MIN;
    recorder_t *recorder = opened();
    sample(recorder, 0, 1.0f, 0, 0); /* one of the four chunks; the others hold 3 x 131072 edges */
    for (uint64_t tick = 1; tick <= 3u * 131072u + 1u; tick++) {
        recorder_edge(recorder, tick, RIG_EDGE_GATES, tick % 2u == 0u ? 1u : 2u);
    }
    TEST_ASSERT_FALSE(recorder_close(recorder, "complete", &error));
    expect_part(error.text, "1 edges from 0.0026 s on are missing"); /* tick 393217 is in period 26 */
    TEST_ASSERT_TRUE(exists("run.csv"));
    TEST_ASSERT_TRUE(exists("run.vcd.partial"));
    TEST_ASSERT_FALSE(exists("run.vcd"));
}

/* The disk accepts only the first `octets` of each file. */
static void expect_cut(uint32_t format, rlim_t octets, uint32_t samples)
{
    struct rlimit before;
    getrlimit(RLIMIT_FSIZE, &before);
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    options.formats = format;
    recorder_t *recorder = opened();
    for (uint32_t k = 0; k < samples; k++) {
        sample(recorder, k, 0.1f * (float)k, 0, k);
        recorder_edge(recorder, UINT64_C(15000) * k, RIG_EDGE_GATES, k % 2u);
    }
    const struct rlimit limit = {.rlim_cur = octets, .rlim_max = before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
    const bool good = recorder_close(recorder, "complete", &error);
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, handler);
    TEST_ASSERT_FALSE(good);
    expect_part(error.text, ".partial: ");
    TEST_ASSERT_EQUAL(1, files_left());
    TEST_ASSERT_TRUE(!exists("run.csv") && !exists("run.mat") && !exists("run.vcd") && !exists("run.mf4"));
}

static void test_a_disk_that_is_full_or_fills_up_is_reported(void)
{
    /* The disk accepts no octet, not even of a file smaller than any buffer; or it is full in the header,
     * in the middle, or in the last column of MAT. */
    static const rlim_t octets[] = {0, 1000, 100000, 250000};
    for (uint32_t n = 0; n < RECORDER_FORMATS; n++) {
        for (int m = 0; m < 4; m++) {
            expect_cut(1u << n, octets[m], m == 0 ? 1u : 20000u);
            tearDown();
            setUp();
        }
    }
}

static void test_a_final_name_that_is_taken_is_reported(void)
{
    char path[256];
    path_of(path, "run.csv");
    TEST_ASSERT_EQUAL(0, mkdir(path, 0700));
    recorder_t *recorder = opened();
    TEST_ASSERT_FALSE(recorder_close(recorder, "complete", &error));
    expect_part(error.text, "run.csv: Is a directory: it keeps the name ");
    TEST_ASSERT_TRUE(exists("run.csv.partial"));
}
