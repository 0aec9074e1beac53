/* Included before every test of this target: RUN_TEST searches for a test in left_out.c before it runs the
 * test. */
#ifndef TARGET_LEFT_OUT_H
#define TARGET_LEFT_OUT_H

#define RUN_TEST(test) run_test_or_leave_out(test, #test, __LINE__)
void run_test_or_leave_out(void (*test)(void), const char *name, int line);

#endif
