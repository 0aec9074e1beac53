# The library that the Python package calls (docs/python.md). At run time it only needs libc and libm.
if(LAGLESS_SANITIZE) # an interpreter that is not sanitized cannot load it
    return()
endif()
set(LAGLESS_PYTHON_LIBRARY "" CACHE FILEPATH "liblagless.so of another build, to pack into a wheel; empty: build it here")
if(LAGLESS_PYTHON_LIBRARY)
    if(NOT EXISTS "${LAGLESS_PYTHON_LIBRARY}")
        message(FATAL_ERROR "LAGLESS_PYTHON_LIBRARY=${LAGLESS_PYTHON_LIBRARY}: there is no such file; accepted: another build's "
            "python/liblagless.so, or nothing")
    endif()
    add_custom_target(lagless_python)
    install(PROGRAMS "${LAGLESS_PYTHON_LIBRARY}" DESTINATION lagless COMPONENT python)
    get_filename_component(python_folder "${LAGLESS_PYTHON_LIBRARY}" DIRECTORY)
    set(python_boards ${LAGLESS_BOARD_NAMES})
    list(POP_FRONT python_boards)
    foreach(board IN LISTS python_boards) # the libraries of the other boards are in subfolders of its folder
        install(PROGRAMS "${python_folder}/boards/${board}/liblagless.so" DESTINATION lagless/boards/${board} COMPONENT python)
    endforeach()
else()
    add_library(lagless_python_objects OBJECT
        python/binding.c
        python/binding_campaign.c
        python/binding_commission.c
        python/binding_plant.c
    )
    desk_room(lagless_python_objects)
    target_compile_definitions(lagless_python_objects PRIVATE _GNU_SOURCE LAGLESS_ANY_BOARD "LAGLESS_VERSION=\"${PROJECT_VERSION}\"")
    target_link_libraries(lagless_python_objects PRIVATE lagless_lab lagless_plant)
    add_library(lagless_python SHARED $<TARGET_OBJECTS:lagless_python_objects>)
    target_link_libraries(lagless_python PRIVATE lagless_lab lagless_plant lagless_flags)
    # The library of the wheel has link-time optimisation. That of a build, for the package of the tree, has not, so that it links quickly.
    set(python_link "${LAGLESS_PLAIN_LINK}")
    if(SKBUILD)
        set(python_link "${LAGLESS_FAST_LINK}")
    endif()
    target_link_options(lagless_python PRIVATE ${python_link} -Wl,--as-needed -Wl,--no-undefined -Wl,--exclude-libs,ALL
        -static-libgcc -static-libstdc++)
    set_target_properties(lagless_python PROPERTIES OUTPUT_NAME lagless LINKER_LANGUAGE CXX LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/python)
endif()
if(SKBUILD) # pyproject.toml
    if(NOT LAGLESS_PYTHON_LIBRARY)
        install(TARGETS lagless_python LIBRARY DESTINATION lagless COMPONENT python)
    endif()
    install(DIRECTORY ${CMAKE_CURRENT_LIST_DIR}/../scenarios ${CMAKE_CURRENT_LIST_DIR}/../motors DESTINATION lagless COMPONENT python
        FILES_MATCHING PATTERN "*.toml")
endif()
