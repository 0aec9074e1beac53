# Unity, from the first place that has it: UNITY_DIR, an installed package, the cache that tools/get-unity fills, GitHub.
# Gives the target unity::framework, and lagless_runner(), which gives a file of tests its main().
# lagless_runner(out source [module name]): `out` is a C file that includes `source` and runs each of its tests: a program, or
# a module of a room. Its compiler needs the folder of the project among its include directories.
find_package(Python3 3.9 COMPONENTS Interpreter QUIET)
set(LAGLESS_RUNNER "${CMAKE_CURRENT_LIST_DIR}/unity_runner.py")
function(lagless_runner out source)
    get_filename_component(source "${source}" ABSOLUTE)
    file(RELATIVE_PATH short "${CMAKE_SOURCE_DIR}" "${source}")
    if(ARGC GREATER 3)
        set(kind module ${ARGV3})
        set(name "${ARGV3}.c")
    else()
        set(kind test)
        string(REPLACE "/" "_" name "${short}")
    endif()
    set(runner "${CMAKE_CURRENT_BINARY_DIR}/run_${name}")
    get_property(made GLOBAL PROPERTY "LAGLESS_RUNNER_${runner}")
    if(NOT made)
        add_custom_command(OUTPUT "${runner}" DEPENDS "${source}" "${LAGLESS_RUNNER}" WORKING_DIRECTORY "${CMAKE_SOURCE_DIR}"
            COMMAND "${Python3_EXECUTABLE}" -B "${LAGLESS_RUNNER}" ${kind} "${short}" > "${runner}" VERBATIM)
        set_property(GLOBAL PROPERTY "LAGLESS_RUNNER_${runner}" YES)
    endif()
    set(${out} "${runner}" PARENT_SCOPE)
endfunction()

set(LAGLESS_UNITY_CACHE "$ENV{XDG_CACHE_HOME}")
if(NOT LAGLESS_UNITY_CACHE)
    set(LAGLESS_UNITY_CACHE "$ENV{HOME}/.cache")
endif()
string(APPEND LAGLESS_UNITY_CACHE "/lagless/unity")

set(UNITY_DIR "" CACHE PATH "Folder with unity.c and unity.h")
if(NOT UNITY_DIR AND EXISTS "${LAGLESS_UNITY_CACHE}/unity.c")
    set(UNITY_DIR "${LAGLESS_UNITY_CACHE}" CACHE PATH "Folder with unity.c and unity.h" FORCE)
endif()

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
        SOURCE_SUBDIR none) # its own CMakeLists.txt is not wanted
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
