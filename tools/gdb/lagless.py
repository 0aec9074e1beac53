"""gdb commands for the closed loop: go to a period and back, print why the drive stopped, read registers by name.

    gdb -x tools/gdb/lagless.py --args build/host/lagless run SCENARIO.toml        (or simply tools/debug SCENARIO.toml)

This file only loads lagless_commands.py as a module, so that its names are not added to gdb's global Python names. A second load has
no effect."""


def load_lagless():
    import os
    import sys

    sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
    write_bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # writes no files into the source tree
    try:
        import lagless_commands  # noqa: F401
    finally:
        sys.dont_write_bytecode = write_bytecode
        sys.path.pop(0)


load_lagless()
