find_package(Python3 3.9 COMPONENTS Interpreter)

add_library(lagless_cli OBJECT
    cli/arguments.c
    cli/bench.c
    cli/board.c
    cli/campaign.c
    cli/commission.c
    cli/commission_page.c
    cli/commission_talk.c
    cli/connect.c
    cli/connect_edit.c
    cli/connect_record.c
    cli/connect_values.c
    cli/connect_words.c
    cli/explain.c
    cli/fault_table.c
    cli/flash_file.c
    cli/fmu.c
    cli/main.c
    cli/library.c
    cli/map.c
    cli/matrix.c
    cli/motors.c
    cli/output.c
    cli/paper.c
    cli/plot.c
    cli/replay.c
    cli/run.c
    cli/scope.c
    cli/serve.c
    cli/shell.c
    cli/stop.c
    cli/streams.c
    cli/tables.c
    cli/traces.c
)
desk_room(lagless_cli)
target_compile_definitions(lagless_cli PRIVATE _GNU_SOURCE LAGLESS_ANY_BOARD)
target_link_libraries(lagless_cli PRIVATE lagless_scope lagless_lab lagless_line)
add_executable(lagless $<TARGET_OBJECTS:lagless_cli>)
target_link_libraries(lagless PRIVATE lagless_scope lagless_lab lagless_line lagless_flags)
target_link_options(lagless PRIVATE ${LAGLESS_FAST_LINK})
target_compile_definitions(lagless_cli PRIVATE "LAGLESS_VERSION=\"${PROJECT_VERSION}\"")
# The folder of the scenarios that are known by name, and the version that a recording states.
execute_process(COMMAND git describe --always --dirty WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE LAGLESS_COMMIT
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT LAGLESS_COMMIT)
    set(LAGLESS_COMMIT "unknown")
endif()
set_source_files_properties(cli/library.c cli/replay.c cli/run.c cli/paper.c cli/connect_record.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_SCENARIOS=\"${CMAKE_SOURCE_DIR}/host_sim/scenarios\";LAGLESS_COMMIT=\"${LAGLESS_COMMIT}\"")
# The folder of the libraries of FMUs, which host_sim/fmu makes; the environment variable LAGLESS_FMU names another library.
set_source_files_properties(cli/fmu.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_FMU=\"${CMAKE_BINARY_DIR}/fmu\";LAGLESS_COMMIT=\"${LAGLESS_COMMIT}\"")
# Line editing of `lagless connect`: libedit, which is under a BSD licence. Without it lines are read as they come.
find_path(EDIT_INCLUDE_DIR editline/readline.h)
find_library(EDIT_LIBRARY edit)
if(EDIT_INCLUDE_DIR AND EDIT_LIBRARY)
    set_source_files_properties(cli/connect_edit.c PROPERTIES COMPILE_DEFINITIONS LAGLESS_HAS_EDIT INCLUDE_DIRECTORIES ${EDIT_INCLUDE_DIR})
    target_link_libraries(lagless PRIVATE ${EDIT_LIBRARY})
endif()
# The compiler and its options, which `lagless bench` prints with the counted instructions.
set_source_files_properties(cli/bench.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_BUILD=\"${CMAKE_C_COMPILER_ID} ${CMAKE_C_COMPILER_VERSION}, ${CMAKE_SYSTEM_PROCESSOR}, $<CONFIG>\"")
# The Python and the folder of the scripts that draw pictures; the environment variables LAGLESS_PYTHON and LAGLESS_TOOLS replace them.
set_source_files_properties(cli/output.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_PYTHON=\"${Python3_EXECUTABLE}\";LAGLESS_TOOLS=\"${CMAKE_SOURCE_DIR}/tools\"")
set_target_properties(lagless PROPERTIES LINKER_LANGUAGE CXX RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
