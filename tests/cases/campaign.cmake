# What campaigns have found and the firmware does not do right yet: each header says what is correct and what is present. Such a
# test is green while its scenario fails. Once the firmware is right it is red: then the name moves to the list of its subject.
foreach(name
        found_sound_drive_told_as_lost)
    add_test(NAME case_${name} COMMAND run_scenario ${CMAKE_CURRENT_SOURCE_DIR}/${name}.toml)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 300 WILL_FAIL TRUE)
endforeach()
