# The command line: how a run can end that no expectation names, existing and truncated files, and `lagless tune` compared with the drive.
set(cli_folder ${CMAKE_SOURCE_DIR}/tests/cli)
foreach(name unexpected_end overwrite cut_files texts own_motor)
    add_test(NAME cli_${name} COMMAND ${Python3_EXECUTABLE} -B ${cli_folder}/test_${name}.py $<TARGET_FILE:lagless>
        ${CMAKE_CURRENT_BINARY_DIR}/${name} ${CMAKE_CURRENT_SOURCE_DIR})
    set_tests_properties(cli_${name} PROPERTIES LABELS cli TIMEOUT 300)
endforeach()

set_tests_properties(cli_own_motor PROPERTIES COST 20)

# `lagless tune` on every board: the boards of hal/f28335/boards, two boards of the tests, and the default board at other carriers
# (tests/board makes their libraries).
if(NOT LAGLESS_SANITIZE AND LAGLESS_BOARD STREQUAL "pm50rl1a060")
    find_package(Threads REQUIRED)
    lagless_add_board(esc48 tests/cases/esc48.h -O1)
    foreach(board desk48 esc48 20000)
        if(NOT TARGET lagless_lab_${board})
            lagless_add_lab(lagless_lab_${board} lagless_rig_${board})
            set_target_properties(lagless_lab_${board} PROPERTIES EXCLUDE_FROM_ALL TRUE)
        endif()
    endforeach()
    foreach(board "" _hvmtrpfckit _mosfet_48v_60a _igbt_540v_30a _desk48 _esc48 _20000)
        lagless_test(lab_tune_boards${board} LABEL board SOURCES ${CMAKE_SOURCE_DIR}/tests/lab/test_tune_boards.c LIBS lagless_lab${board} m)
        target_compile_definitions(test_lab_tune_boards${board} PRIVATE _GNU_SOURCE)
    endforeach()
endif()
