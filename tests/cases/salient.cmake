# Salient rotors: held on the estimator, refused beyond what it takes, and up to which ratio L is learnt. The fixed-point twin takes
# none beyond L_q = 1.2 L_d.
if(LAGLESS_ESTIMATOR STREQUAL "fixed")
    return()
endif()
scenario_cases(ipm_learns_itself_astray salient_pll salient_start salient_119_starts salient_119_full_load salient_with_encoder
        salient_115_learns_no_inductance salient_105_learns_inductance)
# Family F of L_q/L_d 1 to 4: half and full load, driving and braking, put on after a catch; cold starts. A random share of
# the grid in every check, all of it with --long.
add_test(NAME salient_grid COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/salient_grid.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/salient_grid)
set_tests_properties(salient_grid PROPERTIES LABELS scenario TIMEOUT 300)
add_test(NAME salient_grid_long COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/salient_grid.py --long $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/salient_grid_long)
set_tests_properties(salient_grid_long PROPERTIES LABELS grid TIMEOUT 1200)
# Up to three times the base speed and down, wrong data, a link that sinks or stores: a share, and all of it.
add_test(NAME field_weakening COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/field_weakening.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/field_weakening)
set_tests_properties(field_weakening PROPERTIES LABELS scenario TIMEOUT 300)
add_test(NAME field_weakening_long COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/field_weakening.py --long $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/field_weakening_long)
set_tests_properties(field_weakening_long PROPERTIES LABELS grid TIMEOUT 1200)
add_test(NAME cli_salient COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_salient.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/salient ${CMAKE_CURRENT_SOURCE_DIR})
set_tests_properties(cli_salient PROPERTIES LABELS cli TIMEOUT 300)
