# Builds the image for the F28335: lagless.out, its map, an Intel hex file, and a report of the used part of each memory.
enable_language(ASM)

set(LAGLESS_GATES "" CACHE STRING "Level of a gate pin that turns its switch on: active_high or active_low")
# If a board file does not state the level of the gates, this variable must state it. If the file states it, no other level
# is accepted.
lagless_board_file("${LAGLESS_BOARD}" board_file)
get_filename_component(board_path "${board_file}" ABSOLUTE BASE_DIR "${CMAKE_SOURCE_DIR}")
file(STRINGS "${board_path}" board_gates REGEX "^#define BOARD_GATE_ACTIVE_HIGH")
if(LAGLESS_GATES MATCHES "^active_(high|low)$")
    string(COMPARE EQUAL "${LAGLESS_GATES}" active_high gate_active_high)
    target_compile_definitions(lagless_board INTERFACE HAL_GATE_ACTIVE_HIGH=${gate_active_high})
elseif(LAGLESS_GATES OR NOT board_gates)
    message(FATAL_ERROR "LAGLESS_GATES='${LAGLESS_GATES}': accepted: active_high (inverting stage in front of the "
        "module's inputs) and active_low. The board file leaves it open (docs/board.md, line 5): only the schematic can "
        "tell, the wrong one turns on both switches of every leg, so there is no default: -DLAGLESS_GATES=...")
endif()

find_package(Python3 3.9 COMPONENTS Interpreter REQUIRED)
set(linker_file "${CMAKE_SOURCE_DIR}/linker/f28335_flash.cmd")

# The user has to obtain TI's flash API, which this project does not distribute. Without it the image cannot erase or
# program flash.
set(LAGLESS_FLASH_API "" CACHE FILEPATH "TI's Flash28335_API_V210.lib, or an image that tools/flash-api linked of it")
set(flash_api hal/f28335/flash_api_none.c)
if(LAGLESS_FLASH_API)
    set(flash_api "${CMAKE_BINARY_DIR}/flash_api.c")
    add_custom_command(OUTPUT "${flash_api}"
        COMMAND "${Python3_EXECUTABLE}" -B "${CMAKE_SOURCE_DIR}/tools/flash-api" "${LAGLESS_FLASH_API}" --out "${flash_api}"
            --cl2000 "${CMAKE_C_COMPILER}"
        DEPENDS "${LAGLESS_FLASH_API}" tools/flash-api linker/flash_api.asm linker/flash_api.cmd VERBATIM)
endif()

# Sources for the chip only: the host simulation has its own reset, waiting and background loop.
add_executable(lagless
    hal/f28335/codestart.asm
    hal/f28335/debug.asm
    hal/f28335/boot.c
    ${flash_api}
    hal/f28335/memory.c
    hal/f28335/wait.c
    firmware/app/main.c
)
set_target_properties(lagless PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON SUFFIX .out LINK_DEPENDS "${linker_file}")
target_link_options(lagless PRIVATE
    --rom_model --entry_point=code_start --stack_size=0x700 --heap_size=0 --warn_sections --reread_libs --priority
    --search_path=${C2000_CGT}/lib --search_path=${C2000_FAST_RTS} ${linker_file})
target_link_libraries(lagless PRIVATE lagless_app lagless_flags)

set(hex_options --intel --memwidth=16 --romwidth=16 --outfile=lagless.hex)
add_custom_command(TARGET lagless POST_BUILD
    COMMAND "${C2000_HEX}" ${hex_options} lagless.out
    COMMAND "${Python3_EXECUTABLE}" -B "${CMAKE_SOURCE_DIR}/tools/size-report" lagless.map
    BYPRODUCTS lagless.hex lagless.map
    WORKING_DIRECTORY "${CMAKE_BINARY_DIR}" VERBATIM)

include(lagless_ccs)
