"""Sanitizers, valgrind, a million steps, many instances and threads."""

from __future__ import annotations

import resource
import shutil
import subprocess
import threading
from ctypes import byref, c_bool, c_double
from pathlib import Path

import numpy as np
import pytest

from .conftest import ALL, OWN, Builder
from .driver import Fmi, Instance, Native

HERE = Path(__file__).parent
SANITIZERS = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def sequence(native: Native, out: Path, flags: list[str]) -> Path:
    """The full call sequence on this block as a program."""
    subprocess.run(
        ["cc", "-std=c11", "-g1", *flags, "-I", native.folder / "sources",
         HERE / f"sequence{native.fmi}.c", "-o", out, "-lm"], check=True,
    )  # fmt: skip
    return out


# every block in one version under each tool; the test blocks, which use everything, in both
SANITIZED = [(name, 2) for name in sorted(ALL)] + [(name, 3) for name in OWN]
CHECKED = [(name, 3) for name in sorted(ALL)] + [(name, 2) for name in OWN]


@pytest.mark.external
@pytest.mark.parametrize(("name", "version"), SANITIZED)
def test_sanitizers_report_nothing(
    name: str, version: Fmi, native: Builder, tmp_path: Path
) -> None:
    program = sequence(native(name, version), tmp_path / "program", ["-O0", *SANITIZERS])
    done = subprocess.run([program], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.external
@pytest.mark.parametrize(("name", "version"), CHECKED)
def test_valgrind_reports_nothing(
    name: str, version: Fmi, native: Builder, tmp_path: Path
) -> None:
    valgrind = shutil.which("valgrind")
    assert valgrind, "the tests need valgrind"
    program = sequence(native(name, version), tmp_path / "program", ["-O1"])
    done = subprocess.run(
        [valgrind, "-q", "--leak-check=full", "--show-leak-kinds=all", "--error-exitcode=9",
         program], capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


def resident() -> int:
    """Resident size of this process, kB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() // 1024


def test_a_million_steps_do_not_grow_the_process(everything: Native) -> None:
    fmu = everything.instance()
    fmu.set(sample_period=0.01, solver_step=0.01)
    fmu.initialise()
    step, component = getattr(fmu.fmu, f"fmi{everything.fmi}DoStep"), fmu.fmu.component
    receivers = [byref(c_bool()), byref(c_bool()), byref(c_bool()), byref(c_double())]
    more = [1] if everything.fmi == 2 else [True, *receivers]
    before = 0
    for k in range(1_000_000):
        step(component, k * 0.01, 0.01, *more)
        if k == 1000:
            before = resident()
    assert resident() - before < 300  # kB; the interpreter's own ups and downs


def run(fmu: Instance, steps: int) -> np.ndarray:
    for k in range(steps):
        fmu.set(force=[np.sin(k), np.cos(k), 1.0])
        fmu.step(k * 0.03, 0.03)
    return fmu.all("state", "discrete", "output")


def test_instances_do_not_disturb_each_other(everything: Native) -> None:
    alone = everything.instance("b")
    alone.initialise()
    expected = run(alone, 50)
    fmus = [everything.instance(n) for n in "abc"]
    for fmu in fmus:
        fmu.initialise()
    for k in range(50):
        for fmu in fmus:
            fmu.set(force=[np.sin(k), np.cos(k), 1.0])
            fmu.step(k * 0.03, 0.03)
    np.testing.assert_array_equal(fmus[1].all("state", "discrete", "output"), expected)


def test_threads_do_not_disturb_each_other(native: Builder, fmi: Fmi) -> None:
    everything = native("Everything", fmi)
    names = [f"thread {i}" for i in range(4)]
    expected = {}
    for name in names:
        fmu = everything.instance(name)
        fmu.initialise()
        expected[name] = run(fmu, 300)
    found: dict[str, np.ndarray] = {}

    def work(name: str) -> None:
        fmu = everything.instance(name)
        fmu.initialise()
        found[name] = run(fmu, 300)

    threads = [threading.Thread(target=work, args=(n,)) for n in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for name in names:
        np.testing.assert_array_equal(found[name], expected[name])


def test_two_fmus_of_one_block_live_in_one_process(native: Builder, tmp_path: Path) -> None:
    one = native("Everything", 2)
    folder = tmp_path / "copy"
    shutil.copytree(one.folder, folder)
    other = Native(one.model, 2, one.path, folder)
    a, b, c = one.instance(), other.instance(), native("Everything", 3).instance()
    for fmu in (a, b, c):
        fmu.initialise()
    first, second, third = (run(fmu, 20) for fmu in (a, b, c))
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(first, third)


@pytest.mark.parametrize("count", [200])
def test_instances_come_and_go(everything: Native, count: int) -> None:
    for k in range(count):
        fmu = everything.instance(f"number {k}")
        fmu.initialise()
        fmu.step(0.0, 0.1)
        fmu.fmu.freeInstance()
