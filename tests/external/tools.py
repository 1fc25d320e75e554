"""The same system, from the same files, in other tools.

What the tools do with the same files differs in one visible way:

- Sightline (Jacobi) and libcosim set all inputs, step all FMUs, read all outputs, and pass them on.
  A row holds what was read: outputs with feedthrough belong to the inputs held during the step.
- Ecos does the same, then sets the passed inputs and reads all outputs again. The inputs of the
  next step come from the first reading, so that the system moves in the same way; but its row holds
  the second: outputs with feedthrough are those that the others show one row later.

All of them carry outputs to inputs at least as many times as there are FMUs before they leave
initialisation mode, more than the longest chain of feedthrough: they start from the same values.
Time is n·h in Sightline, a whole number of nanoseconds in libcosim, and a sum of h in Ecos.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import extract
from fmpy.fmi2 import FMU2Slave

from sightline.orchestrator.fmi.archive import read

from .formation import Formation, Series

NANOSECOND = 1e-9  # s


@contextmanager
def libcosim_execution(system: Formation, step: float) -> Iterator[tuple[Any, dict[str, int]]]:
    """A libcosim execution of the system, and the index of each instance."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimSlave import CosimLocalSlave

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_step_size(round(step / NANOSECOND))
    slaves = [CosimLocalSlave(str(path), name) for name, path in system.fmus.items()]
    index = {
        name: execution.add_local_slave(slave)
        for name, slave in zip(system.fmus, slaves, strict=True)
    }
    for variable, value in system.start.items():
        done(execution.real_initial_value(index[variable.instance], variable.reference, value))
    for source, sink in system.links:
        status = execution.connect_real_variables(
            index[source.instance], source.reference, index[sink.instance], sink.reference
        )
        done(status == 0)
    yield execution, index
    del execution, slaves  # in this order


def libcosim(system: Formation, step: float, count: int) -> Series:
    """All outputs after each of ``count`` steps."""
    from libcosimpy.CosimEnums import CosimVariableType
    from libcosimpy.CosimObserver import CosimObserver

    with libcosim_execution(system, step) as (execution, index):
        observer = CosimObserver.create_time_series(count + 1)
        done(execution.add_observer(observer))
        places = [(index[v.instance], v.reference) for v in system.outputs]
        for slave, reference in places:
            done(observer.start_time_series(slave, reference, CosimVariableType.REAL))
        done(execution.step(count))
        columns = [
            observer.time_series_real_samples(slave, reference, 1, count)[2]
            for slave, reference in places
        ]
    return np.array(columns).T


@contextmanager
def ecos_simulation(system: Formation, step: float) -> Iterator[Any]:
    """An initialised Ecos simulation of the system."""
    from ecospy import EcosSimulation, EcosSimulationStructure
    from ecospy.lib import EcosLib

    EcosLib.set_log_level("err")
    with EcosSimulationStructure() as structure:
        for name, path in system.fmus.items():
            structure.add_model(name, path)
        for source, sink in system.links:
            structure.make_real_connection(str(source), str(sink))
        structure.add_parameter_set("start", {str(v): x for v, x in system.start.items()})
        with EcosSimulation(step, structure=structure) as simulation:
            done(simulation.init(0.0, "start"))
            yield simulation


def ecos(system: Formation, step: float, count: int) -> Series:
    """All outputs at the start and after each of ``count`` steps."""
    names = [str(v) for v in system.outputs]
    with ecos_simulation(system, step) as simulation:
        rows = [[simulation.get_real(name) for name in names]]
        for _ in range(count):
            simulation.step()
            rows.append([simulation.get_real(name) for name in names])
    return np.array(rows)


class FmpyLoop:
    """A Jacobi loop as one writes it with FMPy."""

    def __init__(self, system: Formation, step: float, stack: ExitStack) -> None:
        self.step, self.number = step, 0
        self.inputs: dict[str, list[int]] = {name: [] for name in system.fmus}
        self.sources: dict[str, list[tuple[str, int]]] = {name: [] for name in system.fmus}
        self.outputs: dict[str, list[int]] = {name: [] for name in system.fmus}
        place = {}
        for v in system.outputs:
            place[v] = (v.instance, len(self.outputs[v.instance]))
            self.outputs[v.instance].append(v.reference)
        for source, sink in system.links:
            self.inputs[sink.instance].append(sink.reference)
            self.sources[sink.instance].append(place[source])
        self.slaves = {name: _slave(name, path, stack) for name, path in system.fmus.items()}
        for variable, value in system.start.items():
            self.slaves[variable.instance].setReal([variable.reference], [value])
        for slave in self.slaves.values():
            slave.setupExperiment(startTime=0.0)
            slave.enterInitializationMode()
        for _ in self.slaves:
            self._read()
            self._write()
        for slave in self.slaves.values():
            slave.exitInitializationMode()
        self._read()

    def advance(self, count: int) -> None:
        """Take steps."""
        for _ in range(count):
            self._write()
            for slave in self.slaves.values():
                slave.doStep(self.number * self.step, self.step)
            self._read()
            self.number += 1

    def row(self) -> list[float]:
        """All outputs."""
        return [value for values in self.values.values() for value in values]

    def _write(self) -> None:
        for name, slave in self.slaves.items():
            values = [self.values[instance][i] for instance, i in self.sources[name]]
            slave.setReal(self.inputs[name], values)

    def _read(self) -> None:
        self.values = {n: s.getReal(self.outputs[n]) for n, s in self.slaves.items()}


def _slave(name: str, path: Path, stack: ExitStack) -> FMU2Slave:
    fmu = read(path)
    folder = stack.enter_context(tempfile.TemporaryDirectory())
    extract(str(path), folder)
    slave = FMU2Slave(guid=fmu.token, unzipDirectory=folder, modelIdentifier=fmu.identifier,
                      instanceName=name)  # fmt: skip
    slave.instantiate()
    stack.callback(slave.freeInstance)
    stack.callback(slave.terminate)
    return slave


def fmpy_loop(system: Formation, step: float, count: int) -> Series:
    """All outputs at the start and after each of ``count`` steps."""
    with ExitStack() as stack:
        loop = FmpyLoop(system, step, stack)
        rows = [loop.row()]
        for _ in range(count):
            loop.advance(1)
            rows.append(loop.row())
    return np.array(rows)


def done(success: bool) -> None:
    """Raise RuntimeError if a tool refused a call."""
    if not success:
        raise RuntimeError("the tool refused a call")
