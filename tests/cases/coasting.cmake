# Reports of a loop that coasted without end: the memory of an uncertain voltage was longer than the gap between two crossings.
foreach(name coasting_without_end coasting_backwards coasting_quarter_load coasting_other_motor coasting_linix)
    add_test(NAME case_${name} COMMAND run_scenario ${CMAKE_CURRENT_SOURCE_DIR}/${name}.toml)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 300)
endforeach()
foreach(name never_hands_over forced_frame_statement)
    add_test(NAME case_${name} COMMAND run_scenario ${CMAKE_CURRENT_SOURCE_DIR}/${name}.toml)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 300)
endforeach()
