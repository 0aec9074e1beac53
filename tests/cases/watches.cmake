# Scenarios from reports about the watches of the motor and the reactions to them, each with related scenarios.
grid_cases(relock slow_catch bare_motor elastic_shaft false_alarms found stuck_near_zero open_switch encoder)
scenario_cases(offset_is_not_stuck)
# A scenario for another board needs the program, which has all boards.
add_test(NAME case_light_rotor_swings_in COMMAND lagless run ${CMAKE_CURRENT_SOURCE_DIR}/light_rotor_swings_in.toml --force
    --out ${CMAKE_CURRENT_BINARY_DIR}/light_rotor_swings_in)
set_tests_properties(case_light_rotor_swings_in PROPERTIES LABELS scenario TIMEOUT 300)
# The fixed-point estimator has a limit of 0.63 rad in a period.
if(NOT LAGLESS_ESTIMATOR STREQUAL "fixed")
    add_test(NAME case_fast_rotor COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_CURRENT_SOURCE_DIR}/test_fast_rotor.py $<TARGET_FILE:lagless>
        ${CMAKE_CURRENT_BINARY_DIR}/fast_rotor ${CMAKE_CURRENT_SOURCE_DIR})
    set_tests_properties(case_fast_rotor PROPERTIES LABELS scenario TIMEOUT 300)
endif()
