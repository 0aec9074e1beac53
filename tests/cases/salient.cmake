# Salient rotors: held on the estimator, refused beyond what it takes, and up to which ratio L is learnt. The fixed-point twin takes
# none beyond L_q = 1.2 L_d.
if(LAGLESS_ESTIMATOR STREQUAL "fixed")
    return()
endif()
scenario_cases(ipm_learns_itself_astray salient_pll salient_start salient_with_encoder)
grid_cases(salient_learning)
# Family F of L_q/L_d 1 to 4: half and full load, driving and braking, put on after a catch; cold starts. A random share of
# the grid in every check, all of it with --long.
# A share of each grid, and all of it. field_weakening: up to three times the base speed and down, wrong data, a link that sinks or stores.
foreach(name salient_grid field_weakening)
    add_test(NAME ${name} COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/${name}.py $<TARGET_FILE:lagless>
        ${CMAKE_CURRENT_BINARY_DIR}/${name})
    set_tests_properties(${name} PROPERTIES LABELS scenario TIMEOUT 300)
    add_test(NAME ${name}_long COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/${name}.py --long $<TARGET_FILE:lagless>
        ${CMAKE_CURRENT_BINARY_DIR}/${name}_long)
    set_tests_properties(${name}_long PROPERTIES LABELS grid TIMEOUT 1200)
endforeach()
add_test(NAME cli_salient COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_salient.py $<TARGET_FILE:lagless>
    ${CMAKE_CURRENT_BINARY_DIR}/salient ${CMAKE_CURRENT_SOURCE_DIR})
set_tests_properties(cli_salient PROPERTIES LABELS cli TIMEOUT 300)
