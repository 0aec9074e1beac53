# The boards that the user of `lagless`, of the Python package and of `lagless fmu` can select. Each board except that of the build
# has a program and two libraries in boards/NAME/, below the folder of the program of the build. Only the sources that depend on
# the board are compiled again. These programs have no link-time optimisation: they are a sixth slower, but link quickly.
set(boards_programs "")
set(boards_libraries "")
foreach(board file IN ZIP_LISTS LAGLESS_BOARD_NAMES LAGLESS_BOARD_FILES)
    lagless_add_board(${board} "${file}")
    list(GET LAGLESS_BOARD_NAMES 0 default)
    if(board STREQUAL default)
        continue()
    endif()
    lagless_add_lab(lagless_lab_${board} lagless_rig_${board})
    set_target_properties(lagless_lab_${board} PROPERTIES EXCLUDE_FROM_ALL TRUE)

    add_executable(lagless_${board} EXCLUDE_FROM_ALL $<TARGET_OBJECTS:lagless_cli> $<TARGET_OBJECTS:lagless_scope>
        $<TARGET_OBJECTS:lagless_line>)
    target_link_libraries(lagless_${board} PRIVATE lagless_lab_${board} $<$<BOOL:${EDIT_LIBRARY}>:${EDIT_LIBRARY}>)
    target_link_options(lagless_${board} PRIVATE ${LAGLESS_PLAIN_LINK})
    set_target_properties(lagless_${board} PROPERTIES OUTPUT_NAME lagless LINKER_LANGUAGE CXX
        RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/boards/${board})
    list(APPEND boards_programs lagless_${board})

    foreach(library python fmu)
        if(TARGET lagless_${library} AND NOT LAGLESS_PYTHON_LIBRARY)
            add_library(lagless_${library}_${board} SHARED EXCLUDE_FROM_ALL $<TARGET_OBJECTS:lagless_${library}_objects>)
            target_link_libraries(lagless_${library}_${board} PRIVATE lagless_lab_${board} lagless_plant_${board})
            get_target_property(options lagless_${library} LINK_OPTIONS)
            target_link_options(lagless_${library}_${board} PRIVATE ${options} ${LAGLESS_PLAIN_LINK})
            set_target_properties(lagless_${library}_${board} PROPERTIES OUTPUT_NAME lagless LINKER_LANGUAGE CXX
                LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/${library}/boards/${board})
            if(library STREQUAL "fmu")
                set_target_properties(lagless_${library}_${board} PROPERTIES PREFIX "")
            endif()
            add_dependencies(lagless_${library} lagless_${library}_${board})
            list(APPEND boards_libraries lagless_${library}_${board})
        endif()
    endforeach()
    if(SKBUILD AND NOT LAGLESS_PYTHON_LIBRARY)
        install(TARGETS lagless_python_${board} LIBRARY DESTINATION lagless/boards/${board} COMPONENT python)
    endif()
endforeach()
add_custom_target(lagless_boards DEPENDS ${boards_programs})
# The target `lagless` builds all of them. The builds for the debugger and for the sanitizers build only those that they need.
if(NOT LAGLESS_SANITIZE AND NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
    add_dependencies(lagless lagless_boards)
endif()
