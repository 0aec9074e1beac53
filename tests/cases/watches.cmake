# Scenarios of a report each, and their siblings: what watches the motor, and what follows from it.
grid_cases(relock bare_motor elastic_shaft)
scenario_cases(
        false_alarm_encoder_332 false_alarm_encoder_start false_alarm_encoder_standing
        false_alarm_encoder_large_inductance
        false_alarm_runaway false_alarm_runaway_fan false_alarm_runaway_reversal
        found_healthy_motor_told_as_stuck_sensor found_offset_drift_told_as_gain found_offset_drift_with_encoder
        found_broken_wire_told_as_encoder found_wrong_flux_told_as_overspeed found_catch_told_as_stuck_sensor
        found_large_flux_drives_a_light_rotor found_quick_stop_in_the_alignment found_small_offset_told_as_wrong_encoder
        found_elastic_shaft_told_as_runaway
        found_open_switch_told_as_encoder found_open_wire_told_as_direction found_open_wire_told_as_mismatch
        found_offset_step_before_a_start found_offset_step_and_noise_before_a_start
        found_wrong_lines_told_as_overspeed found_lost_estimate_told_as_overspeed)
