# Scenarios of learning: harmonics of the rotor's EMF must not be learnt as dead time; an unequal leg and a start; an L too small for the
# dither.
grid_cases(emf_harmonics small_inductance)
