# Scenarios of a report each, and their siblings: what watches the motor, and what follows from it.
grid_cases(relock bare_motor elastic_shaft false_alarms found)
scenario_cases(
        found_open_switch_told_as_encoder found_open_wire_told_as_direction found_open_wire_told_as_mismatch
        found_offset_step_before_a_start found_offset_step_and_noise_before_a_start
        found_wrong_lines_told_as_overspeed found_lost_estimate_told_as_overspeed)
