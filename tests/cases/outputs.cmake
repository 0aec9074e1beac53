# Brake chopper, current of the supply, holding brake: docs/chopper_and_brake.md.
grid_cases(chopper supply_current)
