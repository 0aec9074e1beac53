"""The drive and its simulation, from Python: the same rig, scenarios and campaigns that the program `lagless` runs, bit by bit.

    import lagless

    result = lagless.run("cold_start")            # a scenario by name, file, text or dict
    result.passed, result.fault, result["i_q"]    # verdicts, faults, numpy arrays
    result.plot()
    lagless.run("my.toml", board="mosfet_48v_60a")   # on another power stage: lagless.boards() lists them

    with lagless.Rig(seed=1) as rig:              # the simulation in closed loop, one period at a time
        rig.set(load_torque="2 N m", speed_request="500 r/min", enable="on")
        trace = rig.run("1 s", record=["true_omega_m", "i_q"])

    plant = lagless.Plant(n_p=4, R_s=0.95)        # only inverter, motor, shaft and sensors, for a user's controller
    now = plant.step([0.6, 0.5, 0.4])

    print(lagless.bench(MyEstimator))             # an estimator in Python or C, compared with that of the drive

    lagless.commission("cold_start").motor()      # R, L_d, L_q, psi_f, J as measured by the drive

    lagless.campaign(1000).summary["violated"]    # random runs, also on a dask cluster

All values are in SI units, peak values, per phase. Functions that set a value also accept text with a unit ("500 r/min", "3 us"). pandas,
matplotlib and dask are imported only by the functions that use them.
"""
from ._bench import Bench, bench
from ._boards import Board, boards
from ._campaign import Campaign, campaign
from ._commission import Commissioning, Measured, commission
from ._errors import Error
from ._library import library as _library
from ._motulator import from_motulator
from ._plant import Plant, PlantState
from ._result import Fault, Result, Trace, Verdict
from ._rig import Rig
from ._rows import Row, period, row, rows
from ._scenario import run, scenarios, sweep, to_toml

__version__ = _library.version().decode()

__all__ = ["Bench", "Board", "Campaign", "Commissioning", "Error", "Fault", "Measured", "Plant", "PlantState", "Result", "Rig", "Row", "Trace", "Verdict",
           "bench", "boards", "campaign", "commission", "from_motulator", "period", "row", "rows", "run", "scenarios", "sweep", "to_toml"]
