# Reports of a loop that coasted without end: the memory of an uncertain voltage was longer than the gap between two crossings.
scenario_cases(coasting_without_end coasting_backwards coasting_quarter_load coasting_other_motor coasting_linix)
scenario_cases(never_hands_over forced_frame_statement)
