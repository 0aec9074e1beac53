# A processor with 16-bit int and 32-bit double, as the C28x has them, simulated: an ATmega2560 with 64 K of RAM, which
# tests/target/avr/simulator.c plays; the preset `host` builds it.
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR avr)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_COMPILER avr-gcc)
set(CMAKE_C_FLAGS_INIT "-mmcu=atmega2560")
set(CMAKE_EXECUTABLE_SUFFIX_C .elf)
set(CMAKE_CROSSCOMPILING_EMULATOR "${CMAKE_CURRENT_LIST_DIR}/../../build/host/tests/target/avr_simulator")
set(LAGLESS_TARGET avr)
set(LAGLESS_SWEEP 4999) # tests/unit/sweep.h
