# Scenarios from reports about limits, sequence, refusals, catch and offsets of the firmware, each with related scenarios.
grid_cases(near_trip ride_through requests offsets speed_reasons)
