/* Written by tools/projectspec. Part of the project in Code Composer Studio only, makes no code: it
 * stops a build whose options differ from those that the project's file cannot set. */
#ifndef HAL_GATE_ACTIVE_HIGH
#error "HAL_GATE_ACTIVE_HIGH: by the schematic, add it to the predefined symbols, 1 with active_high, 0 with active_low; no default is safe"
#elif HAL_GATE_ACTIVE_HIGH != 1 && HAL_GATE_ACTIVE_HIGH != 0
#error "HAL_GATE_ACTIVE_HIGH: accepted is 1 with active_high, 0 with active_low"
#endif
#ifndef LAGLESS_PER_FILE_OPTIONS
#error "makefile.defs was not read: give the files in it their options by hand, and exclude this one"
#endif
typedef int lagless_project_check; /* a file of C may not be empty */
