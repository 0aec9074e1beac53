find_package(Python3 3.9 COMPONENTS Interpreter)
if(EXISTS ${CMAKE_SOURCE_DIR}/build/venv/bin/python)
    set(LAGLESS_PYTHON ${CMAKE_SOURCE_DIR}/build/venv/bin/python)
else()
    set(LAGLESS_PYTHON ${Python3_EXECUTABLE})
endif()

add_executable(lagless
    cli/arguments.c
    cli/bench.c
    cli/demo.c
    cli/explain.c
    cli/fault_table.c
    cli/main.c
    cli/library.c
    cli/map.c
    cli/output.c
    cli/paper.c
    cli/run.c
    cli/shell.c
    cli/tables.c
)
desk_room(lagless)
target_compile_definitions(lagless PRIVATE _GNU_SOURCE)
target_link_libraries(lagless PRIVATE lagless_lab)
target_link_options(lagless PRIVATE ${LAGLESS_FAST_LINK})
# The scenarios known by name, and what a recording says it was made with.
execute_process(COMMAND git describe --always --dirty WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE LAGLESS_COMMIT
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT LAGLESS_COMMIT)
    set(LAGLESS_COMMIT "unknown")
endif()
set_source_files_properties(cli/library.c cli/run.c cli/paper.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_SCENARIOS=\"${CMAKE_SOURCE_DIR}/host_sim/scenarios\";LAGLESS_COMMIT=\"${LAGLESS_COMMIT}\"")
# What the instructions that bench counts are those of.
set_source_files_properties(cli/bench.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_BUILD=\"${CMAKE_C_COMPILER_ID} ${CMAKE_C_COMPILER_VERSION}, ${CMAKE_SYSTEM_PROCESSOR}, $<CONFIG>\"")
# Where pictures are drawn; the environment variables LAGLESS_PYTHON and LAGLESS_TOOLS override both.
set_source_files_properties(cli/output.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_PYTHON=\"${LAGLESS_PYTHON}\";LAGLESS_TOOLS=\"${CMAKE_SOURCE_DIR}/tools\"")
set_target_properties(lagless PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
