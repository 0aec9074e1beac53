# Harmonics of the rotor's EMF that were learnt as dead time, an unequal leg, and a start.
grid_cases(emf_harmonics)
# Elastic shafts that swing with the alternating i_d: the run that the campaign found, and its siblings.
scenario_cases(found_inductance_learnt_astray_on_an_elastic_shaft)
grid_cases(elastic_dither)
