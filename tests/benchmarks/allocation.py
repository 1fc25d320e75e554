"""One allocation of a random wrench to twelve thrusters: native FMUs, and scipy's solvers.

Run from the project's folder: python -m tests.benchmarks.allocation
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from ctypes import c_double, c_uint32
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave
from rich.console import Console
from rich.table import Table
from scipy.optimize import linprog, nnls

from sightline.components.actuation.thruster_geometry import (
    control_sensitivity,
    default_directions,
    default_positions,
)
from sightline.fmus.build import build

ALLOCATORS = ("ThrusterAllocation", "ShiftedThrusterAllocation", "NonNegativeThrusterAllocation",
              "BoundedThrusterAllocation", "LeastPropellantThrusterAllocation")  # fmt: skip
WRENCHES = np.random.default_rng(1).standard_normal((50, 6))
ROUNDS = 20
SENSITIVITY = control_sensitivity(default_positions(12), default_directions(12), np.zeros(3))


def microseconds(action: Callable[[int], object]) -> float:
    """Per wrench, in the fastest of several rounds."""
    def once() -> float:
        start = time.perf_counter()
        for k in range(len(WRENCHES)):
            action(k)
        return (time.perf_counter() - start) / len(WRENCHES) * 1e6

    return min(once() for _ in range(ROUNDS))


def native(name: str, folder: Path) -> float:
    """Setting a wrench and getting the commands, less setting and getting it back."""
    path = build(name, target="native", out=folder)
    extracted = fmpy.extract(str(path), str(folder / name))
    description = fmpy.read_model_description(extracted)
    assert description.coSimulation is not None
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=extracted, instanceName=name,
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    fmu.instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    references = {v.name: v.valueReference for v in description.modelVariables}
    ports = [f"{port}[{i}]" for port in ("force", "torque") for i in (1, 2, 3)]
    into = (c_uint32 * 6)(*(references[p] for p in ports))
    out = (c_uint32 * 12)(*(references[f"command[{i}]"] for i in range(1, 13)))
    wrenches = [(c_double * 6)(*wrench) for wrench in WRENCHES]
    command, back = (c_double * 12)(), (c_double * 6)()

    def allocate(k: int) -> None:
        fmu.fmi2SetReal(fmu.component, into, 6, wrenches[k])
        fmu.fmi2GetReal(fmu.component, out, 12, command)

    def nothing(k: int) -> None:
        fmu.fmi2SetReal(fmu.component, into, 6, wrenches[k])
        fmu.fmi2GetReal(fmu.component, into, 6, back)

    taken = microseconds(allocate) - microseconds(nothing)
    fmu.terminate()
    fmu.freeInstance()
    return taken


def main() -> None:
    """Print the table."""
    rows = {"scipy nnls": microseconds(lambda k: nnls(SENSITIVITY, WRENCHES[k])),
            "scipy linprog": microseconds(
                lambda k: linprog(np.ones(12), A_eq=SENSITIVITY, b_eq=WRENCHES[k]))}  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        for name in ALLOCATORS:
            rows[name] = native(name, Path(folder))
    table = Table(title="one allocation to twelve thrusters")
    for heading in ("what", "us", "against scipy nnls"):
        table.add_column(heading, justify="right")
    for what, value in rows.items():
        table.add_row(what, f"{value:.1f}", f"{value / rows['scipy nnls']:.2f}")
    Console().print(table)


if __name__ == "__main__":
    main()
