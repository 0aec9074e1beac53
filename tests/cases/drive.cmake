# Scenarios of a report each, and their siblings: limits, sequence, refusals, catch and offsets of the firmware.
grid_cases(near_trip ride_through requests offsets speed_reasons)
