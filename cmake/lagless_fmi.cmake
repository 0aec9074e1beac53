# The headers of FMI 2.0, from the first place that has them: FMI_DIR, the cache that tools/get-fmi fills. Without them all but the
# library of `lagless fmu` is built.
set(LAGLESS_FMI_CACHE "$ENV{XDG_CACHE_HOME}")
if(NOT LAGLESS_FMI_CACHE)
    set(LAGLESS_FMI_CACHE "$ENV{HOME}/.cache")
endif()
string(APPEND LAGLESS_FMI_CACHE "/lagless/fmi")

set(FMI_DIR "" CACHE PATH "Folder with fmi2Functions.h")
if(NOT FMI_DIR AND EXISTS "${LAGLESS_FMI_CACHE}/fmi2Functions.h")
    set(FMI_DIR "${LAGLESS_FMI_CACHE}" CACHE PATH "Folder with fmi2Functions.h" FORCE)
endif()
if(FMI_DIR AND NOT EXISTS "${FMI_DIR}/fmi2Functions.h")
    message(FATAL_ERROR "FMI_DIR=${FMI_DIR} holds no fmi2Functions.h; run tools/get-fmi and pass the folder it prints")
endif()
if(NOT FMI_DIR)
    message(STATUS "The headers of FMI 2.0 are not on this machine: `lagless fmu` is left out (tools/get-fmi brings them)")
endif()
