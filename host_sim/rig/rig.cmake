add_library(lagless_rig STATIC
    rig/rig.c
    rig/rig_tables.c
)
desk_room(lagless_rig)
target_compile_definitions(lagless_rig PRIVATE _POSIX_C_SOURCE=200809L)
target_link_libraries(lagless_rig PUBLIC lagless_app lagless_hal lagless_chip lagless_plant)
