add_library(lagless_chip STATIC
    ${CMAKE_CURRENT_LIST_DIR}/adc.c
    ${CMAKE_CURRENT_LIST_DIR}/bus.c
    ${CMAKE_CURRENT_LIST_DIR}/carrier.c
    ${CMAKE_CURRENT_LIST_DIR}/chip.c
    ${CMAKE_CURRENT_LIST_DIR}/eqep.c
    ${CMAKE_CURRENT_LIST_DIR}/epwm.c
    ${CMAKE_CURRENT_LIST_DIR}/gpio.c
    ${CMAKE_CURRENT_LIST_DIR}/names.c
    ${CMAKE_CURRENT_LIST_DIR}/outputs.c
    ${CMAKE_CURRENT_LIST_DIR}/pie.c
    ${CMAKE_CURRENT_LIST_DIR}/sysctrl.c
    ${CMAKE_CURRENT_LIST_DIR}/timebase.c
    ${CMAKE_CURRENT_LIST_DIR}/timer.c
    ${CMAKE_CURRENT_LIST_DIR}/trigger.c
    ${CMAKE_CURRENT_LIST_DIR}/watchdog.c
)
desk_room(lagless_chip)
