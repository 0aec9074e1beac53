# Reports of a loop that coasted without end: the memory of an uncertain voltage was longer than the gap between two crossings.
grid_cases(coasting)
scenario_cases(never_hands_over forced_frame_statement)
