"""Common code of the tools that run many motors: the built program and its Python package, and the text of a motor file."""
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PROGRAM, LIBRARY = ROOT / "build/host/lagless", ROOT / "build/host/python/liblagless.so"

# Unit of each key of a motor's file that has one.
UNITS = {"rated_current_peak": "A", "rated_speed": "rad/s", "resistance": "ohm", "inductance_d": "H", "inductance_q": "H", "saturation_current": "A",
         "flux_linkage": "Wb", "inertia": "kg m^2", "friction_coulomb": "N m", "friction_viscous": "N m s/rad", "link_voltage": "V"}


def text_of(title, source, values):
    """A motor's file: key -> value in SI units."""
    lines = (f'{key} = "{value:.9g} {UNITS[key]}"' if key in UNITS else f"{key} = {value}" for key, value in values.items())
    return "\n".join([f'title = "{title}"', f'source = "{source}"', *lines]) + "\n"


def use_built(tool):
    """Makes `import lagless` find the package of this repository and the built library; ends the tool if nothing is built."""
    if not PROGRAM.exists() or not (LIBRARY.exists() or "LAGLESS_LIBRARY" in os.environ):
        print(f"tools/{tool}: build/host is not built: cmake --preset host && cmake --build --preset host", file=sys.stderr)
        sys.exit(3)
    os.environ.setdefault("LAGLESS_LIBRARY", str(LIBRARY))
    sys.path.insert(0, str(ROOT / "host_sim/python"))


def motors_of_library():
    return sorted(path.stem for path in (ROOT / "host_sim/motors").glob("*.toml"))
