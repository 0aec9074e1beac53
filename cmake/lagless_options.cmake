# Options for the compilation of every module. The contraction of floating-point operations is off, so that the same source computes the
# same bits on every machine.
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

if(NOT CMAKE_BUILD_TYPE)
    set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()

# The default build is optimised and has debug information and assertions, so that the optimised build also detects a programming error.
set(CMAKE_C_FLAGS_RELWITHDEBINFO "-O2 -g")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g")

# cmake/f28335.toolchain.cmake sets the flags of the chip's compiler, whose headers need its language extensions.
if(CMAKE_C_COMPILER_ID STREQUAL TI)
    set(CMAKE_C_EXTENSIONS ON)
    add_library(lagless_flags INTERFACE)
    target_include_directories(lagless_flags INTERFACE ${CMAKE_SOURCE_DIR})
    add_library(lagless_fast INTERFACE)
    return()
endif()

# ccache stores the results of compilations if it is installed. It stores objects only. Builds that need other files of the compiler do
# not use it: the counters of executed lines, and the call graphs of the target m4f, which tools/cost reads.
find_program(LAGLESS_CCACHE ccache)
mark_as_advanced(LAGLESS_CCACHE)
if(LAGLESS_CCACHE AND NOT CMAKE_C_COMPILER_LAUNCHER AND NOT LAGLESS_SANITIZE AND NOT CMAKE_CROSSCOMPILING)
    set(CMAKE_C_COMPILER_LAUNCHER "${LAGLESS_CCACHE}")
    set(CMAKE_CXX_COMPILER_LAUNCHER "${LAGLESS_CCACHE}")
endif()

option(LAGLESS_LONG "Also builds the programs that only tools/check --long runs: the boards at further carriers" OFF)
option(LAGLESS_SANITIZE "Address and undefined-behaviour sanitizers, and executed lines of firmware and hal counted" OFF)

# Selects the estimator that the drive and every experiment use. The float and the fixed-point estimator are both compiled in any case.
set(LAGLESS_ESTIMATOR float CACHE STRING "Arithmetic of the estimator: float or fixed")
set_property(CACHE LAGLESS_ESTIMATOR PROPERTY STRINGS float fixed)
if(NOT LAGLESS_ESTIMATOR MATCHES "^(float|fixed)$")
    message(FATAL_ERROR "LAGLESS_ESTIMATOR is ${LAGLESS_ESTIMATOR}; it can be float or fixed")
endif()

add_library(lagless_flags INTERFACE)
target_compile_options(lagless_flags INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror -ffp-contract=off
    $<$<COMPILE_LANGUAGE:C>:-Wstrict-prototypes -Wmissing-prototypes -Wvla>)
if(NOT LAGLESS_TARGET STREQUAL avr) # The GCC 5 of this target does not know the one option, and its double is not wider than float.
    target_compile_options(lagless_flags INTERFACE $<$<COMPILE_LANGUAGE:C>:-Wdouble-promotion> "-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=")
endif()
if(LAGLESS_TARGET STREQUAL avr) # Without these options the drive with the fixed-point estimator does not fit into 256 K of flash.
    target_compile_options(lagless_flags INTERFACE -Os)
endif()
if(CMAKE_C_COMPILER_ID STREQUAL GNU)
    # The straight-line vectoriser of GCC 12 fuses multiplication and addition if the processor can, even if contraction is off.
    target_compile_options(lagless_flags INTERFACE -fno-tree-slp-vectorize)
endif()
if(LAGLESS_TARGET STREQUAL m4f)
    # GCC keeps the fields of a struct in registers only if the function that returns it was inlined early. The function that computes
    # the quantities of the fault table is slightly longer than the default limit for this. Without this option all quantities are
    # written to memory in each period.
    target_compile_options(lagless_flags INTERFACE --param early-inlining-insns=30)
endif()
target_include_directories(lagless_flags INTERFACE ${CMAKE_SOURCE_DIR})
if(LAGLESS_SANITIZE)
    target_compile_options(lagless_flags INTERFACE -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all)
    target_link_options(lagless_flags INTERFACE -fsanitize=address,undefined --coverage)
endif()

# Sources that take a small part of the run time have line numbers for a trace of calls, but no variables for a debugger, which saves an
# eighth of their compile time; the preset debug has both. In the build with sanitizers they are not optimised, which halves it.
add_library(lagless_rare INTERFACE)
target_compile_options(lagless_rare INTERFACE $<$<CONFIG:RelWithDebInfo>:-g1>)
if(LAGLESS_SANITIZE)
    target_compile_options(lagless_rare INTERFACE -O0)
endif()

# Programs and the library for Python use the same objects. Hidden symbols and a TLS model that needs no call make thread-local data as
# fast in the library as in a program.
if(NOT LAGLESS_TARGET)
    set(CMAKE_POSITION_INDEPENDENT_CODE ON)
    set(CMAKE_C_VISIBILITY_PRESET hidden)
    set(CMAKE_CXX_VISIBILITY_PRESET hidden)
    set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
    target_compile_options(lagless_flags INTERFACE -ftls-model=initial-exec)
endif()

# The optimised build uses link-time optimisation for the command line tool, which makes it a sixth faster. The objects also contain
# normal machine code, so that the tests link quickly without this optimisation.
add_library(lagless_fast INTERFACE)
if(CMAKE_C_COMPILER_ID STREQUAL GNU AND NOT LAGLESS_TARGET AND NOT LAGLESS_SANITIZE)
    target_compile_options(lagless_fast INTERFACE "$<$<CONFIG:RelWithDebInfo,Release>:-O3;-flto=auto;-ffat-lto-objects>")
    set(LAGLESS_FAST_LINK $<$<CONFIG:RelWithDebInfo,Release>:-flto=auto>)
    set(LAGLESS_PLAIN_LINK $<$<CONFIG:RelWithDebInfo,Release>:-fno-lto>)
endif()
