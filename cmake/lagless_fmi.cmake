# Finds the headers of FMI 2.0 in FMI_DIR or in the cache that tools/get-fmi fills. Without them the library of `lagless fmu` is
# not built.
include("${CMAKE_CURRENT_LIST_DIR}/lagless_cached.cmake")
lagless_cached(FMI_DIR fmi fmi2Functions.h "Folder with fmi2Functions.h")
if(FMI_DIR AND NOT EXISTS "${FMI_DIR}/fmi2Functions.h")
    message(FATAL_ERROR "FMI_DIR=${FMI_DIR} holds no fmi2Functions.h; run tools/get-fmi and pass the folder it prints")
endif()
if(NOT FMI_DIR)
    message(STATUS "The headers of FMI 2.0 are not on this machine: `lagless fmu` is left out (tools/get-fmi downloads them)")
endif()
