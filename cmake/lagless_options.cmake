# What every room is compiled with. Contraction is off so that the same source gives the same bits on every machine.
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()

# Optimised, with debug info and with assertions: a programming error must not pass because the build is fast.
set(CMAKE_C_FLAGS_RELWITHDEBINFO "-O2 -g")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g")

# The chip's compiler has flags of its own: cmake/f28335.toolchain.cmake. Its headers are written for its extensions.
if(CMAKE_C_COMPILER_ID STREQUAL TI)
    set(CMAKE_C_EXTENSIONS ON)
    add_library(lagless_flags INTERFACE)
    target_include_directories(lagless_flags INTERFACE ${CMAKE_SOURCE_DIR})
    add_library(lagless_fast INTERFACE)
    return()
endif()

# Compilations are remembered where ccache is installed. It keeps objects only: the counters of executed lines and the call graphs of the
# target m4f, which tools/cost reads, would be missing.
find_program(LAGLESS_CCACHE ccache)
mark_as_advanced(LAGLESS_CCACHE)
if(LAGLESS_CCACHE AND NOT CMAKE_C_COMPILER_LAUNCHER AND NOT LAGLESS_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
    set(CMAKE_C_COMPILER_LAUNCHER "${LAGLESS_CCACHE}")
    set(CMAKE_CXX_COMPILER_LAUNCHER "${LAGLESS_CCACHE}")
endif()

option(LAGLESS_LONG "Also builds what only tools/check --long runs: the boards at further carriers" OFF)
option(LAGLESS_SANITIZE "Address and undefined-behaviour sanitizers, and executed lines of firmware and hal counted" OFF)

# The estimator that the drive and every experiment run on; both twins are always compiled.
set(LAGLESS_ESTIMATOR float CACHE STRING "Arithmetic of the estimator: float or fixed")
set_property(CACHE LAGLESS_ESTIMATOR PROPERTY STRINGS float fixed)
if(NOT LAGLESS_ESTIMATOR MATCHES "^(float|fixed)$")
    message(FATAL_ERROR "LAGLESS_ESTIMATOR is ${LAGLESS_ESTIMATOR}; it can be float or fixed")
endif()

add_library(lagless_flags INTERFACE)
target_compile_options(lagless_flags INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror -ffp-contract=off
    $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes -Wmissing-prototypes -Wvla>)
if(NOT LAGLESS_TARGET STREQUAL avr) # its GCC 5 lacks the one option, and has no wider double
    target_compile_options(lagless_flags INTERFACE $<$<COMPILE_LANGUAGE:C>:-Wdouble-promotion> "-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=")
endif()
if(LAGLESS_TARGET STREQUAL avr) # 256 K of flash hold the whole drive on the fixed-point estimator only so
    target_compile_options(lagless_flags INTERFACE -Os)
endif()
if(CMAKE_C_COMPILER_ID STREQUAL GNU)
    # GCC 12's straight-line vectoriser fuses multiply and add where the machine can, whatever is said about contraction.
    target_compile_options(lagless_flags INTERFACE -fno-tree-slp-vectorize)
endif()
if(LAGLESS_TARGET STREQUAL m4f)
    # GCC takes a struct apart into registers only where its maker was inlined early. The quantities of the fault table are just
    # beyond what it inlines early by itself; without this all of them are put into memory in each period.
    target_compile_options(lagless_flags INTERFACE --param early-inlining-insns=30)
endif()
target_include_directories(lagless_flags INTERFACE ${CMAKE_SOURCE_DIR})
if(LAGLESS_SANITIZE)
    target_compile_options(lagless_flags INTERFACE -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all)
    target_link_options(lagless_flags INTERFACE -fsanitize=address,undefined --coverage)
endif()

# What runs a small part of the time: under the sanitizers it is compiled unoptimised, in half the time.
add_library(lagless_rare INTERFACE)
if(LAGLESS_SANITIZE)
    target_compile_options(lagless_rare INTERFACE -O0)
endif()

# The same objects go into programs and into the library that Python calls, and cost the same in both: nobody outside a library
# sees its symbols, and what a thread has of its own is found without a call.
if(NOT LAGLESS_TARGET)
    set(CMAKE_POSITION_INDEPENDENT_CODE ON)
    set(CMAKE_C_VISIBILITY_PRESET hidden)
    set(CMAKE_CXX_VISIBILITY_PRESET hidden)
    set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
    target_compile_options(lagless_flags INTERFACE -ftls-model=initial-exec)
endif()

# The optimised build links the command line tool across rooms (a sixth faster). Objects carry both forms, so that tests
# link the plain one in no time.
add_library(lagless_fast INTERFACE)
if(CMAKE_C_COMPILER_ID STREQUAL GNU AND NOT LAGLESS_TARGET AND NOT LAGLESS_SANITIZE)
    target_compile_options(lagless_fast INTERFACE "$<$<CONFIG:RelWithDebInfo,Release>:-O3;-flto=auto;-ffat-lto-objects>")
    set(LAGLESS_FAST_LINK $<$<CONFIG:RelWithDebInfo,Release>:-flto=auto>)
    set(LAGLESS_PLAIN_LINK $<$<CONFIG:RelWithDebInfo,Release>:-fno-lto>)
endif()
