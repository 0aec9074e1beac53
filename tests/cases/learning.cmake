# Harmonics of the rotor's EMF that were learnt as dead time, an unequal leg, and a start.
scenario_cases(
        emf_harmonics_learnt_as_dead_time emf_harmonics_100_rpm emf_harmonics_200_rpm emf_harmonics_of_other_sign
        emf_harmonics_backwards unequal_leg_100_rpm start_teaches_nothing_wrong)
