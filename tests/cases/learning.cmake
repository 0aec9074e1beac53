# These scenarios test learning. Harmonics of the rotor's EMF must not be learnt as dead time, also with an unequal leg and during a start.
# An L that is too small for the dither must not be learnt wrong, and neither must an L beside a resonance of the shaft.
grid_cases(emf_harmonics small_inductance dither_resonance)
