# This file selects TI's C28x compiler for the F28335. Two variables of the environment name its folders:
#   C2000_CGT_ROOT   the code generation tools: bin/cl2000, lib/, include/
#   C2000WARE_ROOT   C2000Ware, for the fast run-time library of the FPU
foreach(root C2000_CGT_ROOT C2000WARE_ROOT)
    if(NOT DEFINED ENV{${root}})
        message(FATAL_ERROR "${root} is not set: docs/chip.md lists what to install")
    endif()
endforeach()
set(C2000_CGT "$ENV{C2000_CGT_ROOT}")
set(C2000_FAST_RTS "$ENV{C2000WARE_ROOT}/libraries/math/FPUfastRTS/c28/lib")
foreach(file "${C2000_CGT}/bin/cl2000" "${C2000_FAST_RTS}/rts2800_fpu32_fast_supplement_eabi.lib")
    if(NOT EXISTS "${file}")
        message(FATAL_ERROR "${file} is missing: C2000_CGT_ROOT or C2000WARE_ROOT names another folder")
    endif()
endforeach()

set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR TMS320F28335)
set(CMAKE_C_COMPILER "${C2000_CGT}/bin/cl2000")
set(CMAKE_ASM_COMPILER "${C2000_CGT}/bin/cl2000")
set(CMAKE_ASM_COMPILER_ID TI)
set(CMAKE_AR "${C2000_CGT}/bin/ar2000")
set(C2000_HEX "${C2000_CGT}/bin/hex2000")

# A program does not link without a linker command file.
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

# Every command line states ABI and FPU, also that of the linker. The defaults depend on the version: COFF before 25.11,
# EABI from 25.11 on, and no FPU.
set(chip "-v28 -ml -mt --abi=eabi --float_support=fpu32")
set(CMAKE_C_FLAGS_INIT "${chip} --include_path=${C2000_CGT}/include --gen_func_subsections=on --display_error_number \
--diag_warning=225 --diag_wrap=off")
set(CMAKE_ASM_FLAGS_INIT "${chip}")

# The libraries come last on the command line, and the fast one before the standard one: its division takes 24 cycles,
# the standard division 222.
set(CMAKE_C_STANDARD_LIBRARIES_INIT "--library=rts2800_fpu32_fast_supplement_eabi.lib --library=rts2800_fpu32_eabi.lib")
