# What every room is compiled with. Contraction is off so that the same source gives the same bits on every machine.
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()

option(LAGLESS_COVERAGE "Count executed lines" OFF)
option(LAGLESS_SANITIZE "Address and undefined-behaviour sanitizers" OFF)

add_library(lagless_flags INTERFACE)
target_compile_options(lagless_flags INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror -ffp-contract=off
    $<$<COMPILE_LANGUAGE:C>:-Wdouble-promotion -Wstrict-prototypes -Wmissing-prototypes -Wvla>
    "-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=")
target_include_directories(lagless_flags INTERFACE ${CMAKE_SOURCE_DIR})
if(LAGLESS_SANITIZE)
    target_compile_options(lagless_flags INTERFACE -fsanitize=address,undefined -fno-sanitize-recover=all)
    target_link_options(lagless_flags INTERFACE -fsanitize=address,undefined)
endif()
if(LAGLESS_COVERAGE)
    target_compile_options(lagless_flags INTERFACE --coverage)
    target_link_options(lagless_flags INTERFACE --coverage)
endif()
