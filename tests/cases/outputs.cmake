# Brake chopper and holding brake: docs/chopper_and_brake.md.
grid_cases(chopper)
