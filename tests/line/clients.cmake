# The serial line with a client of other authors: pyxcp, not modified, connects to `lagless serve`. The tests are skipped if tools/setup has
# not put pyxcp into build/venv.
set(line_python "${CMAKE_SOURCE_DIR}/build/venv/bin/python3")
if(NOT EXISTS "${line_python}")
    set(line_python "${Python3_EXECUTABLE}")
endif()
function(line_pyxcp name seconds)
    add_test(NAME ${name} COMMAND "${Python3_EXECUTABLE}" -B "${CMAKE_CURRENT_SOURCE_DIR}/test_pyxcp.py" $<TARGET_FILE:lagless>
        "${line_python}" "${CMAKE_CURRENT_BINARY_DIR}/${name}" ${seconds})
    set_tests_properties(${name} PROPERTIES LABELS "line;${ARGN}" TIMEOUT 300 SKIP_RETURN_CODE 77)
endfunction()
if(NOT LAGLESS_SANITIZE)
    line_pyxcp(line_pyxcp 2)
    set_tests_properties(line_pyxcp PROPERTIES COST 60)
    line_pyxcp(line_pyxcp_whole 10 long grid)
endif()
