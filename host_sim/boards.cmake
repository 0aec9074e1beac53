# The boards between which `lagless`, the Python package and `lagless fmu` choose: for each but that of the build a program and two
# libraries, boards/NAME/ in the folder of the build's own. Only what depends on the board is compiled again; the rest is the same
# objects. Linked plainly: a sixth slower, and in no time.
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
# Whoever builds `lagless` gets them. The debugger and the sanitizers build those that they need.
if(NOT LAGLESS_SANITIZE AND NOT CMAKE_BUILD_TYPE STREQUAL "Debug")
    add_dependencies(lagless lagless_boards)
endif()
