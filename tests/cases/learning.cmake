# Harmonics of the rotor's EMF that were learnt as dead time, an unequal leg, and a start.
grid_cases(emf_harmonics)
