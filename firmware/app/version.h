/* The version of the program, as one number: CMakeLists.txt has the same (tests/cli/test_replay.py). */
#ifndef APP_VERSION_H
#define APP_VERSION_H

#include <stdint.h>

#define APP_VERSION_MAJOR UINT32_C(0)
#define APP_VERSION_MINOR UINT32_C(1)
#define APP_VERSION_PATCH UINT32_C(0)
#define APP_VERSION       (APP_VERSION_MAJOR << 16 | APP_VERSION_MINOR << 8 | APP_VERSION_PATCH)

#endif
