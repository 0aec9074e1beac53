# Scenarios of a report each, and their siblings: limits, sequence, refusals, catch and offsets of the firmware.
scenario_cases(
        supply_near_trip_runs_away near_trip_encoder_bare_rotor near_trip_current_mode near_trip_supply_rises
        near_trip_motor_hot near_trip_forced_frame
        ride_through_low_supply ride_through_supply_at_the_edge ride_through_supply_sags ride_through_supply_sags_encoder
        on_after_quick_stop on_during_quick_stop on_before_quick_stop_ends_standing
        reset_starts_the_motor reset_then_off_then_on reset_of_a_hot_motor retry_of_the_module_starts_by_itself
        offset_drifts_while_off offset_drifts_between_two_runs offset_beyond_its_limit_while_off
        offset_beside_a_rotor_that_feeds_the_link
        relock_twice
        noise_told_as_overspeed noise_told_as_too_fast slow_sensor_told_as_overspeed large_inductance_told_as_overspeed
        true_overspeed true_overspeed_wrong_flux true_overspeed_encoder)

foreach(name on_after_quick_stop_console on_after_silence_console)
    add_test(NAME case_${name} COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/${name}.sh $<TARGET_FILE:lagless>)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 120)
endforeach()
