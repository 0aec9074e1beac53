# Beside the sanitizers, the lines of firmware/ and hal/ that are executed. Target `coverage`: builds everything, runs the
# tests of both, prints their line coverage, and fails below the limit.   cmake --build --preset asan --target coverage
# The target `coverage_html` also writes a page for each file, line by line.
foreach(room lagless_core lagless_firmware lagless_app lagless_hal lagless_hal_active_low)
    if(TARGET ${room})
        # Plain counters: atomic ones take eight times as long. So nothing of the firmware runs in two threads at once in this build:
        # host_sim/lab/lab.cmake leaves its pool one.
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

# What CTest's own dashboard adds (Nightly, Experimental, ...) is not ours to build.
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
