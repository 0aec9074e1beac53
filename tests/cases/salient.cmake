# Salient rotors: the estimator holds them up to a ratio of the inductances, the drive refuses larger ratios, and L is learnt up to a
# smaller one. The fixed-point twin accepts no ratio beyond L_q = 1.2 L_d.
if(LAGLESS_ESTIMATOR STREQUAL "fixed")
    return()
endif()
scenario_cases(salient_with_encoder)
grid_cases(salient_rotors)
# A family of motors with L_q/L_d from 1 to 4, and its field weakening up to three times the base speed and back. Every check runs a random
# share of each grid; --long runs all of it.
set(salient_grid ${CMAKE_SOURCE_DIR}/tools/run-grids $<TARGET_FILE:run_scenario>)
foreach(part "" _long)
    add_test(NAME salient_grid${part} COMMAND ${Python3_EXECUTABLE} -B ${salient_grid} ${CMAKE_CURRENT_BINARY_DIR}/salient_grid${part}
        ${CMAKE_CURRENT_SOURCE_DIR}/salient.grid)
    string(REPLACE "_" "--" long "${part}")
    add_test(NAME field_weakening${part} COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/field_weakening.py ${long}
        $<TARGET_FILE:lagless> ${CMAKE_CURRENT_BINARY_DIR}/field_weakening${part})
    add_test(NAME saturation${part} COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/saturation.py ${long}
        $<TARGET_FILE:lagless> ${CMAKE_CURRENT_BINARY_DIR}/saturation${part})
endforeach()
set_tests_properties(salient_grid field_weakening saturation PROPERTIES LABELS scenario TIMEOUT 300 COST 8)
set_tests_properties(salient_grid_long field_weakening_long saturation_long PROPERTIES LABELS grid TIMEOUT 1200)
set_tests_properties(salient_grid_long PROPERTIES ENVIRONMENT LAGLESS_GRID_SHARE=1)
add_test(NAME cli_salient COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_salient.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/salient ${CMAKE_CURRENT_SOURCE_DIR})
set_tests_properties(cli_salient PROPERTIES LABELS cli TIMEOUT 300)
