# Scenarios of a report each, and their siblings: what watches the motor, and what follows from it.
foreach(name
        relock_hands_over_too_early relock_sensor_a relock_sensor_a_much relock_backwards)
    add_test(NAME case_${name} COMMAND run_scenario ${CMAKE_CURRENT_SOURCE_DIR}/${name}.toml)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 300)
endforeach()
