# Faults that campaigns have found and that the firmware still has. The header of each file states the correct result and the present one.
# Such a test passes while its scenario fails. Once the firmware is correct, the test fails; the scenario must then move to the list of its
# subject.
grid_cases(found_sound_drive_told_as_lost)
set_tests_properties(case_found_sound_drive_told_as_lost PROPERTIES WILL_FAIL TRUE)
