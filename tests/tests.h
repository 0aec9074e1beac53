/* Tests that no list names: TEST(test_of_something) { ... }, and `return RUN_TESTS();` in main() runs all of
 * its file, in their order. */
#ifndef TESTS_TESTS_H
#define TESTS_TESTS_H

#include "unity.h"

typedef struct test {
    void (*run)(void);
    const char *name;
    int line;
    struct test *next;
} test_t;

static test_t *tests_first;

/* By line: in which order a target calls constructors is its own affair. */
static inline void tests_add(test_t *test)
{
    test_t **at = &tests_first;
    while (*at != NULL && (*at)->line < test->line) {
        at = &(*at)->next;
    }
    test->next = *at;
    *at = test;
}

#define TEST(name)                                                                                           \
    static void name(void);                                                                                  \
    static test_t test_##name = {name, #name, __LINE__, NULL};                                               \
    __attribute__((constructor)) static void test_add_##name(void)                                           \
    {                                                                                                        \
        tests_add(&test_##name);                                                                             \
    }                                                                                                        \
    static void name(void)

#ifndef RUN_ONE_TEST /* a target may leave some out */
#define RUN_ONE_TEST UnityDefaultTestRun
#endif

static inline void tests_run(void)
{
    for (const test_t *test = tests_first; test != NULL; test = test->next) {
        RUN_ONE_TEST(test->run, test->name, test->line);
    }
}

#define RUN_TESTS() (UNITY_BEGIN(), tests_run(), UNITY_END())

#endif
