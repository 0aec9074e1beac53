# Counts the executed lines of firmware/ and hal/ in the build with the sanitizers. The target `coverage` builds everything, runs all
# tests, prints the line coverage, and fails below the limit:
#     cmake --build --preset asan --target coverage
# The target `coverage_html` also writes a page for each file, line by line.
foreach(room lagless_core lagless_firmware lagless_app lagless_hal lagless_hal_active_low)
    if(TARGET ${room})
        # The counters are not atomic, because atomic ones take eight times as long. Therefore the firmware must not run in two
        # threads at once in this build: host_sim/lab/lab.cmake gives the pool one thread.
        target_compile_options(${room} PRIVATE --coverage -fprofile-update=single)
    endif()
endforeach()

find_program(GCOVR gcovr)
if(NOT GCOVR)
    message(STATUS "gcovr is missing, so there is no target coverage: install gcovr (Debian, Ubuntu, pip), or run tools/setup")
    return()
endif()

function(lagless_all_targets folder result)
    get_property(targets DIRECTORY "${folder}" PROPERTY BUILDSYSTEM_TARGETS)
    get_property(inner DIRECTORY "${folder}" PROPERTY SUBDIRECTORIES)
    foreach(next IN LISTS inner)
        lagless_all_targets("${next}" more)
        list(APPEND targets ${more})
    endforeach()
    set(${result} "${targets}" PARENT_SCOPE)
endfunction()

# The targets that CTest's dashboard adds (Nightly, Experimental, ...) are not built.
lagless_all_targets("${CMAKE_SOURCE_DIR}" everything)
set(built)
foreach(target IN LISTS everything)
    get_target_property(type ${target} TYPE)
    get_target_property(left_out ${target} EXCLUDE_FROM_ALL)
    if(NOT left_out AND NOT type STREQUAL "UTILITY" AND NOT type STREQUAL "INTERFACE_LIBRARY")
        list(APPEND built ${target})
    endif()
endforeach()

foreach(target coverage coverage_html)
    string(REGEX MATCH "html" html ${target})
    add_custom_target(${target}
        COMMAND ${CMAKE_COMMAND} -DSOURCE=${CMAKE_SOURCE_DIR} -DBUILD=${CMAKE_BINARY_DIR} -DCTEST=${CMAKE_CTEST_COMMAND}
            -DGCOVR=${GCOVR} -DLIMIT=99 "-DHTML=${html}" -P ${CMAKE_CURRENT_LIST_DIR}/count_coverage.cmake
        WORKING_DIRECTORY ${CMAKE_SOURCE_DIR}
        DEPENDS ${built}
        USES_TERMINAL VERBATIM)
endforeach()
