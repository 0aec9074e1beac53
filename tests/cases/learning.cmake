# Harmonics of the rotor's EMF that were learnt as dead time, an unequal leg, and a start.
foreach(name emf_harmonics_learnt_as_dead_time emf_harmonics_100_rpm emf_harmonics_200_rpm emf_harmonics_of_other_sign
             emf_harmonics_backwards unequal_leg_100_rpm start_teaches_nothing_wrong)
    add_test(NAME case_${name} COMMAND run_scenario ${CMAKE_CURRENT_SOURCE_DIR}/${name}.toml)
    set_tests_properties(case_${name} PROPERTIES LABELS scenario TIMEOUT 300)
endforeach()
