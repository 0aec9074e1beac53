# A processor with 16-bit int and 32-bit double, as the C28x has them, simulated: an ATmega2560 with 64 K of RAM and 512 K of flash, which
# tools/target/avr/simulator.c plays; the preset `host` builds it.
include("${CMAKE_CURRENT_LIST_DIR}/need.cmake")
lagless_need(avr avr-gcc gcc-avr)
lagless_need_library(avr avr-gcc libc.a avr-libc)
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR avr)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_COMPILER avr-gcc)
# The drive takes more than 256 K of flash, though it is built without what it does not call, with short calls, and with one copy of what functions begin and end with.
set(CMAKE_C_FLAGS_INIT "-mmcu=atmega2560 -ffunction-sections -mcall-prologues")
set(CMAKE_EXE_LINKER_FLAGS_INIT "-mrelax -Wl,--gc-sections")
set(CMAKE_EXECUTABLE_SUFFIX_C .elf)
set(CMAKE_CROSSCOMPILING_EMULATOR "${CMAKE_CURRENT_LIST_DIR}/../../build/host/tests/target/avr_simulator")
get_property(trying GLOBAL PROPERTY IN_TRY_COMPILE)
if(NOT trying AND NOT EXISTS "${CMAKE_CROSSCOMPILING_EMULATOR}")
    message(WARNING "preset avr: its simulator is not there, and its tests will fail: cmake --preset host && cmake --build --preset "
        "host --target avr_simulator (with libsimavr-dev and libelf-dev, or after tools/setup)")
endif()
set(LAGLESS_TARGET avr)
set(LAGLESS_SWEEP 4999) # tests/unit/sweep.h
