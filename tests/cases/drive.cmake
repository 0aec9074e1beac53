# Scenarios of a report each, and their siblings: limits, sequence, refusals, catch and offsets of the firmware.
grid_cases(near_trip ride_through requests offsets speed_reasons)

foreach(name on_after_quick_stop_console on_after_silence_console)
    add_test(NAME case_${name} COMMAND sh ${CMAKE_CURRENT_SOURCE_DIR}/${name}.sh $<TARGET_FILE:lagless>)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 120)
endforeach()
