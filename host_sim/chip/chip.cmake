add_library(lagless_chip STATIC
)
desk_room(lagless_chip)
