# The library for the serial link to a drive, simulated or real: transports, frames, the XCP master.
add_library(lagless_line STATIC
    line/frames.c
    line/judge.c
    line/master.c
    line/master_calls.c
    line/master_daq.c
    line/serial.c
    line/transport.c
)
desk_room(lagless_line)
target_compile_definitions(lagless_line PRIVATE _GNU_SOURCE LAGLESS_ANY_BOARD)
target_link_libraries(lagless_line PUBLIC lagless_rig m)
