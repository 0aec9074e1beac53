# Scenarios of a report each, and their siblings: limits, sequence, refusals, catch and offsets of the firmware.
foreach(name
        supply_near_trip_runs_away near_trip_encoder_bare_rotor near_trip_current_mode near_trip_supply_rises
        near_trip_motor_hot near_trip_forced_frame
        ride_through_low_supply ride_through_supply_at_the_edge ride_through_supply_sags ride_through_supply_sags_encoder)
    add_test(NAME case_${name} COMMAND run_scenario ${CMAKE_CURRENT_SOURCE_DIR}/${name}.toml)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 300)
endforeach()
