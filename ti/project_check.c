/* Written by tools/projectspec. Only the project in Code Composer Studio contains this file. It makes no code: it
 * stops a build whose options differ from those that the project's file cannot set. */
#ifndef HAL_GATE_ACTIVE_HIGH
#error "HAL_GATE_ACTIVE_HIGH is not defined: add it to the predefined symbols of the project, 1 with active_high, 0 with active_low; the schematic of the board decides which, and no default is safe"
#elif HAL_GATE_ACTIVE_HIGH != 1 && HAL_GATE_ACTIVE_HIGH != 0
#error "HAL_GATE_ACTIVE_HIGH: accepted: 1 with active_high, 0 with active_low"
#endif
#ifndef LAGLESS_PER_FILE_OPTIONS
#error "makefile.defs was not read: set the options that it contains in the properties of these files, and exclude this file from the build"
#endif
typedef int lagless_project_check; /* a C file must not be empty */
