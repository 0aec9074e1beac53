/* For clang as a 16-bit compiler, which brings no C library. */
#ifndef TARGET_ASSERT_H
#define TARGET_ASSERT_H

void abort(void);
#define assert(condition) ((condition) ? (void)0 : abort())

#endif
