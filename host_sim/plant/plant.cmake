add_library(lagless_plant STATIC
    plant/interval.c
    plant/noise.c
    plant/phasor.c
    plant/plant.c
    plant/plant_params.c
)
desk_room(lagless_plant)
# GCC's straight-line vectoriser makes fused multiply-adds from neighbouring sums and differences even with contraction
# off, where the machine has them: other bits there. Without it the plant is a little faster, too.
target_compile_options(lagless_plant PRIVATE -fno-tree-slp-vectorize)
target_link_libraries(lagless_plant PUBLIC m)
