# The library in the archives that `lagless fmu` writes (docs/fmu.md). Like that of the Python package it only needs libc and libm at run time.
include(${CMAKE_SOURCE_DIR}/cmake/lagless_fmi.cmake)
if(NOT FMI_DIR OR LAGLESS_SANITIZE OR SKBUILD) # a master that is not sanitized cannot load it
    return()
endif()
add_library(lagless_fmu_objects OBJECT fmu/fmu.c fmu/fmu_none.c fmu/fmu_state.c)
desk_room(lagless_fmu_objects)
target_compile_definitions(lagless_fmu_objects PRIVATE _GNU_SOURCE LAGLESS_ANY_BOARD)
target_include_directories(lagless_fmu_objects SYSTEM PRIVATE ${FMI_DIR})
target_link_libraries(lagless_fmu_objects PRIVATE lagless_lab)
# It has no link-time optimisation, like the FMUs of the other boards and the Python library of a build. This optimisation would take 17 s of
# processor time in each build, for a library that a check runs for seconds.
add_library(lagless_fmu SHARED $<TARGET_OBJECTS:lagless_fmu_objects>)
target_link_libraries(lagless_fmu PRIVATE lagless_lab lagless_flags)
target_link_options(lagless_fmu PRIVATE ${LAGLESS_PLAIN_LINK} -Wl,--as-needed -Wl,--no-undefined -Wl,--exclude-libs,ALL -Wl,--strip-all
    -static-libgcc -static-libstdc++)
set_target_properties(lagless_fmu PROPERTIES OUTPUT_NAME lagless LINKER_LANGUAGE CXX PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/fmu)
