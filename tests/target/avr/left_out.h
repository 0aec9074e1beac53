/* Goes before every test of this target, which is looked up in left_out.c before it is run. */
#ifndef TARGET_LEFT_OUT_H
#define TARGET_LEFT_OUT_H

#define RUN_TEST(test) run_test_or_leave_out(test, #test, __LINE__)
#define RUN_ONE_TEST   run_test_or_leave_out
void run_test_or_leave_out(void (*test)(void), const char *name, int line);

#endif
