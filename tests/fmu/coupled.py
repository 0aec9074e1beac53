"""The master of docs/fmu.md: drive and plant as two FMUs, which exchange their values once in a period."""
import pathlib
import tempfile

import fmpy
from fmpy.fmi2 import FMU2Slave


class Part:
    """An instance of an FMU, with get and set by names."""

    def __init__(self, archive, folder):
        self.model = fmpy.read_model_description(str(archive))
        self.variables = {variable.name: variable for variable in self.model.modelVariables}
        self.period = float(self.model.defaultExperiment.stepSize)
        own = tempfile.mkdtemp(prefix=pathlib.Path(archive).stem + "_", dir=folder)  # a library that is loaded must not change
        self.slave = FMU2Slave(guid=self.model.guid, unzipDirectory=fmpy.extract(str(archive), unzipdir=own),
                               modelIdentifier=self.model.coSimulation.modelIdentifier, instanceName=pathlib.Path(archive).stem)
        self.slave.instantiate()
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()

    def names(self, causality):
        return [name for name, variable in self.variables.items() if variable.causality == causality]

    def split(self, names):
        """Value references of the Real variables and of the others, with their names in this order."""
        kinds = [[name for name in names if (self.variables[name].type == "Real") == real] for real in (True, False)]
        return [[self.variables[name].valueReference for name in kind] for kind in kinds], kinds[0] + kinds[1]

    def step(self, period):
        self.slave.doStep(period * self.period, self.period)

    def free(self):
        self.slave.terminate()
        self.slave.freeInstance()


class Wires:
    """The outputs of one part that are inputs of another one by the same name."""

    def __init__(self, source, target):
        shared = [name for name in source.names("output") if name in target.names("input")]
        self.source, self.target = source, target
        (self.reals, self.whole), self.names = source.split(shared)

    def carry(self):
        values = self.source.slave.getReal(self.reals), self.source.slave.getInteger(self.whole)
        self.target.slave.setReal(self.reals, values[0])
        self.target.slave.setInteger(self.whole, values[1])


class Coupled:
    """Both parts. `exact`: a period in which the power module trips is repeated by the drive, with the instant of the trip."""

    def __init__(self, drive, plant, exact=False):
        self.drive, self.plant, self.exact = drive, plant, exact
        self.samples, self.commands = Wires(plant, drive), Wires(drive, plant)
        drive.slave.exitInitializationMode()
        plant.slave.exitInitializationMode()
        self.period = 0
        self.repeated = 0

    def step(self):
        self.samples.carry()
        if self.exact:
            self.drive.slave.setReal([self.drive.variables["trip_time"].valueReference], [-1.0])
            before = self.drive.slave.getFMUState()
        self.drive.step(self.period)
        self.commands.carry()
        self.plant.step(self.period)
        if self.exact:  # the drive has not known the instant of a trip in this period
            trip = self.plant.slave.getReal([self.plant.variables["trip_time"].valueReference])
            if trip[0] >= 0.0:
                self.drive.slave.setFMUState(before)
                self.drive.slave.setReal([self.drive.variables["trip_time"].valueReference], trip)
                self.drive.step(self.period)
                self.repeated += 1
            self.drive.slave.freeFMUState(before)
        self.period += 1
