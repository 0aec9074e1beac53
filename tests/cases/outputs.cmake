# Scenarios of docs/chopper_and_brake.md: the brake chopper, the current of the supply, and the holding brake.
grid_cases(chopper supply_current)
