"""The rigid body's RK4 step: native FMU, hand-written C, pythonfmu; build times and sizes.

Run from the project's folder: python -m tests.benchmarks.native_rigid_body
"""

from __future__ import annotations

import subprocess
import tempfile
import time
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from rich.console import Console
from rich.table import Table

from sightline.components.catalogue import blocks
from sightline.fmus.build import build, describe
from sightline.fmus.native.platforms import own_platform
from sightline.fmus.native.target import build_native

HERE = Path(__file__).parent
HEADERS = Path(fmpy.__file__).parent / "c-code"
PYTHON_STEPS = 2000


def nanoseconds(folder: Path) -> tuple[float, float, float]:
    """Per step: doStep of the native FMU; set, step and get; hand-written C."""
    fmu, extracted, program = folder / "body.fmu", folder / "body", folder / "program"
    block = blocks()["FreeRigidBody"]()
    build_native(describe("FreeRigidBody", block, "native"), fmi=2, out=fmu)
    fmpy.extract(str(fmu), str(extracted))
    platform = own_platform()
    assert platform is not None
    subprocess.run(
        ["cc", "-O2", "-fno-math-errno", "-D_GNU_SOURCE", "-I", HEADERS,
         HERE / "native_rigid_body.c", "-o", program, "-lm", "-ldl"], check=True,
    )  # fmt: skip
    guid = fmpy.read_model_description(str(extracted)).guid
    done = subprocess.run([program, extracted / platform.binary(2, block.name), guid], check=True,
                          capture_output=True, text=True)  # fmt: skip
    step, all_three, hand = map(float, done.stdout.split())
    return step, all_three, hand


def python_nanoseconds(folder: Path) -> float:
    """Per doStep of the Python FMU."""
    path = build("FreeRigidBody", target="python", out=folder)
    extracted = fmpy.extract(str(path), str(folder / "python"))
    description = fmpy.read_model_description(extracted)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=extracted, instanceName="body",
                    modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
    fmu.instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    start = time.perf_counter()
    for k in range(PYTHON_STEPS):
        fmu.doStep(k * 0.01, 0.01)
    return (time.perf_counter() - start) / PYTHON_STEPS * 1e9


def builds(folder: Path) -> Table:
    """Seconds and kilobytes of every block's native FMU."""
    table = Table(title="native builds, FMI 2.0, this machine's compiler")
    for heading in ("block", "seconds", "binary kB"):
        table.add_column(heading, justify="right")
    platform = own_platform()
    assert platform is not None
    for name, cls in blocks().items():
        out = folder / f"{name}.fmu"
        start = time.perf_counter()
        build_native(describe(name, cls(), "native"), fmi=2, out=out)
        seconds = time.perf_counter() - start
        extracted = Path(fmpy.extract(str(out), str(folder / name)))
        size = (extracted / platform.binary(2, name)).stat().st_size
        table.add_row(name, f"{seconds:.2f}", f"{size / 1000:.0f}")
    return table


def main() -> None:
    """Print both tables."""
    table = Table(title="FreeRigidBody, one RK4 step")
    for heading in ("what", "ns", "ratio"):
        table.add_column(heading, justify="right")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        step, all_three, hand = nanoseconds(folder)
        rows = {"hand-written C": hand, "native FMU, doStep": step,
                "native FMU, set + doStep + get": all_three,
                "Python FMU, doStep": python_nanoseconds(folder)}  # fmt: skip
        for what, value in rows.items():
            table.add_row(what, f"{value:.0f}", f"{value / hand:.2f}")
        Console().print(table)
        Console().print(builds(folder))


if __name__ == "__main__":
    main()
