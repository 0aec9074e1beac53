# Scenarios from reports about the watches of the motor and the reactions to them, each with related scenarios.
grid_cases(relock bare_motor elastic_shaft false_alarms found)
scenario_cases(light_rotor_swings_in)
