add_library(lagless_plant STATIC
    plant/averaged.c
    plant/flux_map.c
    plant/flux_map_file.c
    plant/interval.c
    plant/noise.c
    plant/phasor.c
    plant/plant.c
    plant/plant_params.c
)
desk_room(lagless_plant)
target_link_libraries(lagless_plant PUBLIC lagless_board m) # the scales of its sensors are those of the board
