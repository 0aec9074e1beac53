# Builds for a simulated Cortex-M4F with hardware floating point: the board mps2-an386 of QEMU. Semihosting provides
# files, console and exit code.
include("${CMAKE_CURRENT_LIST_DIR}/need.cmake")
lagless_need(m4f arm-none-eabi-gcc gcc-arm-none-eabi)
lagless_need_library(m4f arm-none-eabi-gcc rdimon.specs libnewlib-arm-none-eabi)
lagless_need(m4f qemu-system-arm qemu-system-arm)
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR cortex-m4)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_C_FLAGS_INIT "-mcpu=cortex-m4 -mthumb -mfpu=fpv4-sp-d16 -mfloat-abi=hard -fcallgraph-info=su")
set(CMAKE_EXECUTABLE_SUFFIX_C .elf)
set(CMAKE_CROSSCOMPILING_EMULATOR qemu-system-arm -machine mps2-an386 -nodefaults -nographic -chardev stdio,id=console
    -semihosting-config enable=on,target=native,chardev=console -kernel)
set(LAGLESS_TARGET m4f)
set(LAGLESS_SWEEP 499) # tests/unit/sweep.h
