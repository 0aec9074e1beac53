/* Goes before every test of this target: RUN_TEST looks a test up in left_out.c before it runs it. */
#ifndef TARGET_LEFT_OUT_H
#define TARGET_LEFT_OUT_H

#define RUN_TEST(test) run_test_or_leave_out(test, #test, __LINE__)
void run_test_or_leave_out(void (*test)(void), const char *name, int line);

#endif
