# Finds the test framework Unity in the first place that has it: UNITY_DIR, an installed package, the cache that tools/get-unity fills,
# GitHub. Defines the target unity::framework, and the function lagless_runner(), which makes the main() of a file of tests.
# lagless_runner(out source [MODULE name]): `out` is a C file that includes `source` and runs each of its tests, as a program or as one
# module of a test program with several. The include directories of its target must contain the top folder of the project.
find_package(Python3 3.9 COMPONENTS Interpreter QUIET)
set(LAGLESS_RUNNER "${CMAKE_CURRENT_LIST_DIR}/unity_runner.py")
function(lagless_runner out source)
    get_filename_component(source "${source}" ABSOLUTE)
    file(RELATIVE_PATH short "${CMAKE_SOURCE_DIR}" "${source}")
    if(ARGC GREATER 3)
        set(runner "${CMAKE_CURRENT_BINARY_DIR}/run_${ARGV3}.c")
        lagless_made_by_runner("${runner}" "module ${ARGV3} ${short}" "${source}")
    else()
        string(REPLACE "/" "_" name "${short}")
        set(runner "${CMAKE_CURRENT_BINARY_DIR}/run_${name}")
        lagless_made_by_runner("${runner}" "test ${short}" "${source}")
    endif()
    set(${out} "${runner}" PARENT_SCOPE)
endfunction()

# Registers a C file of this folder that unity_runner.py makes with these arguments from these sources. A single command makes all
# files of a folder with one start of Python. CMake writes this command when it has read the whole folder.
function(lagless_made_by_runner file words) # SOURCE...
    get_property(files DIRECTORY PROPERTY LAGLESS_RUNNER_FILES)
    if(file IN_LIST files)
        return()
    endif()
    if(NOT files)
        cmake_language(DEFER CALL lagless_write_runners)
    endif()
    set_property(DIRECTORY APPEND PROPERTY LAGLESS_RUNNER_FILES "${file}")
    set_property(DIRECTORY APPEND PROPERTY LAGLESS_RUNNER_SOURCES ${ARGN})
    set_property(DIRECTORY APPEND_STRING PROPERTY LAGLESS_RUNNER_LINES "${file}\t${words}\n")
endfunction()
function(lagless_write_runners)
    get_property(files DIRECTORY PROPERTY LAGLESS_RUNNER_FILES)
    get_property(sources DIRECTORY PROPERTY LAGLESS_RUNNER_SOURCES)
    get_property(lines DIRECTORY PROPERTY LAGLESS_RUNNER_LINES)
    set(list "${CMAKE_CURRENT_BINARY_DIR}/runners.txt")
    file(CONFIGURE OUTPUT "${list}" CONTENT "${lines}" @ONLY)
    add_custom_command(OUTPUT ${files} DEPENDS ${sources} "${list}" "${LAGLESS_RUNNER}" WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
        COMMAND "${Python3_EXECUTABLE}" -B "${LAGLESS_RUNNER}" "${list}" COMMENT "Runners of tests" VERBATIM)
endfunction()

include("${CMAKE_CURRENT_LIST_DIR}/lagless_cached.cmake")
lagless_cached(UNITY_DIR unity unity.c "Folder with unity.c and unity.h")

if(NOT UNITY_DIR)
    find_package(unity CONFIG QUIET)
    if(TARGET unity::framework)
        return()
    endif()
    include(FetchContent)
    if(POLICY CMP0135)
        cmake_policy(SET CMP0135 NEW)
    endif()
    FetchContent_Declare(unity_source
        URL https://github.com/ThrowTheSwitch/Unity/archive/refs/tags/v2.6.1.tar.gz
        URL_HASH SHA256=b41a66d45a6b99758fb3202ace6178177014d52fc524bf1f72687d93e9867292
        SOURCE_SUBDIR none) # Unity's own CMakeLists.txt is not used.
    message(STATUS "Unity is not on this machine: fetching it from GitHub (where that fails: tools/get-unity)")
    FetchContent_MakeAvailable(unity_source)
    set(UNITY_DIR "${unity_source_SOURCE_DIR}/src")
endif()
if(NOT EXISTS "${UNITY_DIR}/unity.c")
    message(FATAL_ERROR "UNITY_DIR=${UNITY_DIR} holds no unity.c; run tools/get-unity and pass the folder it prints")
endif()

add_library(lagless_unity STATIC "${UNITY_DIR}/unity.c")
target_include_directories(lagless_unity SYSTEM PUBLIC "${UNITY_DIR}")
target_compile_definitions(lagless_unity PUBLIC UNITY_INCLUDE_DOUBLE UNITY_SUPPORT_64)
add_library(unity::framework ALIAS lagless_unity)
