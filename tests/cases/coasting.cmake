# The tracking loop must not coast without end. It would do so if the drive treated the voltage around a zero crossing of the current as
# uncertain for longer than the time between two crossings.
grid_cases(coasting)
scenario_cases(never_hands_over forced_frame_statement)
