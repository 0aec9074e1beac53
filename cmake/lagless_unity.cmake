# Unity, from the first place that has it: UNITY_DIR, an installed package, the cache that tools/get-unity fills, GitHub.
# Gives the target unity::framework.
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
