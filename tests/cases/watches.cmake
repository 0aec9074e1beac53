# Scenarios of a report each, and their siblings: what watches the motor, and what follows from it.
grid_cases(relock bare_motor elastic_shaft false_alarms found)
