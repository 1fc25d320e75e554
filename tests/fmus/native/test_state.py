"""Saved states are complete: what follows a restored state is the same to the last bit."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from .conftest import Builder
from .driver import Fmi, Instance, Native
from .samples import random_values

SETTINGS = {"sample_period": 0.07, "seed": 5, "solver": 2}


def run(fmu: Instance, first: int, count: int) -> np.ndarray:
    """Values after each of ``count`` steps with inputs that depend on the step's number only."""
    rows = []
    for k in range(first, first + count):
        fmu.set(**random_values(np.random.default_rng(k), fmu.model, "input"))
        fmu.step(k * 0.05, 0.05)
        rows.append(fmu.all("state", "discrete", "output"))
    return np.array(rows)


def started(native: Native) -> Instance:
    fmu = native.instance()
    fmu.set(**{n: v for n, v in SETTINGS.items() if n in fmu.model.by_name})
    fmu.initialise()
    return fmu


def test_what_follows_a_restored_state_is_bit_identical(block_fmu: Native) -> None:
    fmu = started(block_fmu)
    run(fmu, 0, 5)
    state = fmu.save()
    first = run(fmu, 5, 10)
    fmu.restore(state)
    np.testing.assert_array_equal(run(fmu, 5, 10), first)
    fmu.free(state)


def test_a_serialised_state_goes_on_in_another_instance(block_fmu: Native) -> None:
    fmu = started(block_fmu)
    run(fmu, 0, 5)
    state = fmu.save()
    data = fmu.serialise(state)
    first = run(fmu, 5, 10)
    other = started(block_fmu)
    other.restore(other.deserialise(data))
    np.testing.assert_array_equal(run(other, 5, 10), first)


SCRIPT = """
import sys
from pathlib import Path
import numpy as np
sys.path.insert(0, {root!r})
from tests.fmus.native.driver import Native, native_model
from tests.fmus.native.blocks import Everything
from tests.fmus.native.test_state import run
native = Native(native_model(Everything()), {fmi}, Path({path!r}), Path({folder!r}))
fmu = native.instance("another name")
fmu.restore(fmu.deserialise(Path({data!r}).read_bytes()))
np.save({out!r}, run(fmu, 5, 10))
"""


def test_a_serialised_state_goes_on_in_another_process(
    everything: Native, tmp_path: Path
) -> None:
    fmu = started(everything)
    run(fmu, 0, 5)
    data, out = tmp_path / "state.bin", tmp_path / "rows.npy"
    data.write_bytes(fmu.serialise(fmu.save()))
    first = run(fmu, 5, 10)
    script = SCRIPT.format(root=str(Path(__file__).parents[3]), fmi=everything.fmi,
                           path=str(everything.path), folder=str(everything.folder),
                           data=str(data), out=str(out))  # fmt: skip
    subprocess.run([sys.executable, "-c", script], check=True)
    np.testing.assert_array_equal(np.load(out), first)


def test_a_state_holds_a_tick_that_was_read_and_a_tick_that_was_not(everything: Native) -> None:
    for read in (False, True):
        fmu = started(everything)
        run(fmu, 0, 7)  # 7 * 0.05 = 5 * 0.07: a tick is pending
        fmu.set(force=[1.0, 2.0, 3.0])
        if read:
            fmu.get("pull")
        fmu.set(force=[7.0, 8.0, 9.0])
        state = fmu.save()
        fmu.step(0.35, 0.01)
        first = fmu.all("state", "discrete", "output")
        fmu.restore(state)
        fmu.step(0.35, 0.01)
        np.testing.assert_array_equal(fmu.all("state", "discrete", "output"), first)


def test_a_state_holds_input_derivatives(native: Builder) -> None:
    fmu = native("Oscillator", 2).instance()
    fmu.initialise()
    fmu.fmu.setRealInputDerivatives([fmu.model.by_name["push"].reference], [1], [2.0])
    state = fmu.save()
    fmu.step(0.0, 0.5)
    first = fmu.all("state")
    fmu.restore(state)
    fmu.step(0.0, 0.5)
    np.testing.assert_array_equal(fmu.all("state"), first)


def test_a_failed_step_can_be_undone(everything: Native) -> None:
    fmu = started(everything)
    fmu.set(level=6.5)
    state = fmu.save()
    fmu.set(level=7.0)
    with pytest.raises(FMICallException):
        fmu.step(0.0, 0.1)
    fmu.restore(state)
    fmu.step(0.0, 0.1)
    assert np.all(np.isfinite(fmu.all("state", "output")))


def test_foreign_and_damaged_bytes_are_refused(native: Builder, fmi: Fmi) -> None:
    other = started(native("Oscillator", fmi))
    foreign = other.serialise(other.save())
    fmu = started(native("Everything", fmi))
    own = fmu.serialise(fmu.save())
    for data in (foreign, own[:-1], own + b"\0", bytes(len(own)), b""):
        with pytest.raises(FMICallException):
            fmu.deserialise(data)
    assert "belongs to another FMU" in fmu.messages
    assert "bytes given for a serialized state" in fmu.messages
    run(fmu, 0, 2)


def test_a_reset_instance_starts_anew(everything: Native) -> None:
    fmu = started(everything)
    first = run(fmu, 0, 5)
    fmu.fmu.reset()
    fmu.set(**SETTINGS)
    fmu.initialise()
    np.testing.assert_array_equal(run(fmu, 0, 5), first)


def test_two_runs_are_bit_identical(block_fmu: Native) -> None:
    np.testing.assert_array_equal(run(started(block_fmu), 0, 20), run(started(block_fmu), 0, 20))
