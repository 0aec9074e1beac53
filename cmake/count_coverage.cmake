# The target `coverage` runs this script: it removes the counts of an earlier run, runs all tests of the preset asan, and lets
# gcovr add up the counts.
cmake_minimum_required(VERSION 3.21)
cmake_host_system_information(RESULT jobs QUERY NUMBER_OF_LOGICAL_CORES)

file(GLOB_RECURSE stale "${BUILD}/*.gcda")
if(stale)
    file(REMOVE ${stale})
endif()

math(EXPR at_once "${jobs} + 1") # Some tests wait for time-outs.
execute_process(COMMAND "${CTEST}" --preset asan --parallel ${at_once} --no-tests=error
    WORKING_DIRECTORY "${SOURCE}" RESULT_VARIABLE failed)
if(failed)
    message(FATAL_ERROR "coverage: the tests failed")
endif()

set(pages "")
if(HTML)
    file(MAKE_DIRECTORY "${BUILD}/html")
    set(pages --html-details "${BUILD}/html/index.html")
endif()
execute_process(COMMAND "${GCOVR}" --root "${SOURCE}" --filter "${SOURCE}/firmware/" --filter "${SOURCE}/hal/" -j ${jobs}
        ${pages} --txt --print-summary --json-summary "${BUILD}/coverage.json"
        --fail-under-line ${LIMIT} "${BUILD}"
    WORKING_DIRECTORY "${SOURCE}" RESULT_VARIABLE failed TIMEOUT 300)
if(failed EQUAL 2) # gcovr's exit code for a coverage below the limit
    message(FATAL_ERROR "coverage: fewer than ${LIMIT} % of the lines were reached")
elseif(failed)
    message(FATAL_ERROR "coverage: gcovr failed (${failed})")
endif()
file(READ "${BUILD}/coverage.json" summary)
string(JSON functions GET "${summary}" function_percent)
message(STATUS "functions reached: ${functions} %")
if(functions LESS LIMIT)
    message(FATAL_ERROR "coverage: fewer than ${LIMIT} % of the functions were reached")
endif()
if(HTML)
    message(STATUS "line by line: ${BUILD}/html/index.html")
endif()
