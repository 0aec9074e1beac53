# Builds for a simulated processor with 16-bit int and 32-bit double, like those of the C28x: an ATmega2560 with 64 K of RAM and 512 K of flash.
# tools/target/avr/simulator.c simulates it; the preset `host` builds this simulator.
include("${CMAKE_CURRENT_LIST_DIR}/need.cmake")
lagless_need(avr avr-gcc gcc-avr)
lagless_need_library(avr avr-gcc libc.a avr-libc)
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR avr)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_COMPILER avr-gcc)
# The drive needs more than 256 K of flash, although these options remove unused functions, shorten calls, and share the code for the begin and
# end of functions.
set(CMAKE_C_FLAGS_INIT "-mmcu=atmega2560 -ffunction-sections -mcall-prologues")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-mrelax -Wl,--gc-sections")
set(CMAKE_EXECUTABLE_SUFFIX_C .elf)
set(CMAKE_CROSSCOMPILING_EMULATOR "${CMAKE_CURRENT_LIST_DIR}/../../build/host/tests/target/avr_simulator")
get_property(trying GLOBAL PROPERTY IN_TRY_COMPILE)
if(NOT trying AND NOT EXISTS "${CMAKE_CROSSCOMPILING_EMULATOR}")
    message(WARNING "preset avr: its simulator is not built, and its tests will fail; build it with cmake --preset host && cmake --build --preset "
        "host --target avr_simulator (with libsimavr-dev and libelf-dev, or after tools/setup)")
endif()
set(LAGLESS_TARGET avr)
set(LAGLESS_SWEEP 4999) # tests/unit/sweep.h
