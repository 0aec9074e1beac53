"""Translates motulator's names to the parameters of the plant and of the drive."""
from ._errors import Error

# name: rows of the plant, rows of the drive's parameters.
_NAMES = {
    "n_p": (("pole_pairs",), ("motor_pole_pairs",)),
    "R_s": (("resistance",), ("motor_resistance",)),
    "L_d": (("inductance_d",), ("motor_inductance_d",)),
    "L_q": (("inductance_q",), ("motor_inductance_q",)),
    "L_s": (("inductance_d", "inductance_q"), ("motor_inductance_d", "motor_inductance_q")),
    "psi_f": (("flux_linkage",), ("motor_flux_linkage",)),
    "J": (("inertia",), ("motor_inertia",)),
    "B_L": (("friction_viscous",), ()),
    "B": (("friction_viscous",), ()),
    "u_dc": (("dc_voltage",), ()),
    "tau_L": (("load_torque",), ()),
}


def plant_rows(values):
    """Replaces motulator's names by those of the plant's rows; other names are unchanged. The load becomes active, because the
    load of motulator has a sign."""
    found = {}
    for name, value in values.items():
        for one in _NAMES.get(name, ((name,),))[0]:
            if one in found:
                raise Error(f"{name}: {one} is given twice; give one of the names", name)
            found[one] = value
    if "tau_L" in values:
        found.setdefault("load_kind", 1.0)
    return found


def from_motulator(pars=None, **names):
    """A motor in motulator's names (n_p, R_s, L_d, L_q or L_s, psi_f, J, B_L, u_dc, tau_L) as {"plant": ..., "params": ...}:
    the true values, and the same values as parameters of the drive. In a scenario: `{**lagless.from_motulator(n_p=3, R_s=3.6),
    "run": ...}`.

    `pars` may be an object of motulator, for example SynchronousMachinePars: its members with these names are used. SI units, peak
    values, as both have them; L_d and L_q are inductances (a saturated machine's maps are not handled); u_dc and tau_L are set
    only in the plant."""
    values = {name: getattr(pars, name) for name in _NAMES if isinstance(getattr(pars, name, None), (int, float))}
    unknown = [name for name in names if name not in _NAMES]
    if unknown:
        raise Error(f"{unknown[0]}: accepted: {', '.join(_NAMES)}", unknown[0])
    values.update(names)
    params = {one: value for name, value in values.items() for one in _NAMES[name][1]}
    return {"plant": plant_rows(values), "params": params}
