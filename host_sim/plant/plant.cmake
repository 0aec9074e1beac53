add_library(lagless_plant STATIC
)
desk_room(lagless_plant)
