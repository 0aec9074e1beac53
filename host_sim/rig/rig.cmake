add_library(lagless_rig STATIC
    rig/rig.c
    rig/rig_bench.c
    rig/rig_estimator.c
    rig/rig_part.c
    rig/rig_replay.c
    rig/rig_rows.c
    rig/rig_software.c
    rig/rig_tables.c
    rig/rig_values.c
    rig/rig_world.c
)
desk_room(lagless_rig)
target_compile_definitions(lagless_rig PRIVATE _POSIX_C_SOURCE=200809L)
target_link_libraries(lagless_rig PUBLIC lagless_app lagless_hal lagless_chip lagless_plant)
# The one place where the simulation acts between two functions of the firmware: the interrupts' calls of drive_step,
# drive_medium_step and drive_medium_took go through desk_... (rig_software.c).
target_compile_definitions(lagless_app PRIVATE
    drive_step=desk_drive_step drive_medium_step=desk_drive_medium_step
    drive_medium_took=desk_drive_medium_took)
target_link_options(lagless_rig INTERFACE -Wl,-u,desk_drive_step) # so that the linker reads the rig before the app, which needs it
