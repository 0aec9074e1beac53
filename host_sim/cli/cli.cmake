find_package(Python3 3.9 COMPONENTS Interpreter)
if(EXISTS ${CMAKE_SOURCE_DIR}/build/venv/bin/python)
    set(LAGLESS_PYTHON ${CMAKE_SOURCE_DIR}/build/venv/bin/python)
else()
    set(LAGLESS_PYTHON ${Python3_EXECUTABLE})
endif()

add_executable(lagless
    cli/bench.c
    cli/demo.c
    cli/main.c
    cli/output.c
)
desk_room(lagless)
target_compile_definitions(lagless PRIVATE _GNU_SOURCE)
target_link_libraries(lagless PRIVATE lagless_rig)
target_link_options(lagless PRIVATE ${LAGLESS_FAST_LINK})
# Where pictures are drawn; the environment variables LAGLESS_PYTHON and LAGLESS_TOOLS override both.
set_source_files_properties(cli/output.c PROPERTIES COMPILE_DEFINITIONS
    "LAGLESS_PYTHON=\"${LAGLESS_PYTHON}\";LAGLESS_TOOLS=\"${CMAKE_SOURCE_DIR}/tools\"")
set_target_properties(lagless PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR})
