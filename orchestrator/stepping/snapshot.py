"""The whole state of a running system: every FMU's, and all values that pass between them.

In a file: ``/values``, ``/states/<instance>`` as bytes, and as attributes the number of the step,
the time, how many rows were recorded, what error control remembers, which system it is of, and
the SHA-256 of all that.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from ..errors import ConfigError, Problem
from ..results import space
from ..results.hdf5 import numbers, opened
from ..schedule.plan import Array
from ..wiring.graph import SystemGraph
from .adaptive import Control
from .stepper import Stepper


class Damaged(Exception):
    """A file does not hold what was written to it."""


@dataclass(frozen=True)
class Snapshot:
    """A moment of a run. ``number``: steps taken; ``control``: what error control remembers."""

    number: int
    time: float
    values: Array
    states: Mapping[str, bytes]
    rows: int = 0
    control: tuple[float, ...] = ()
    system: str = ""

    def write(self, path: Path) -> None:
        """Write the file, whole or not at all. Raises OSError."""
        part = path.with_name(f"{path.name}.part")
        part.touch()
        held = self.values.nbytes + sum(len(state) + space.NODE for state in self.states.values())
        space.take(part, 0, held + space.SLACK)
        with h5py.File(part, "w", libver="earliest") as file:
            file.create_dataset("values", data=self.values, track_times=False)
            for name, state in self.states.items():
                data = np.frombuffer(state, dtype=np.uint8)
                file.create_dataset(f"states/{name}", data=data, track_times=False)
            file.attrs["number"] = self.number
            file.attrs["time"] = self.time
            file.attrs["rows"] = self.rows
            file.attrs["control"] = np.array(self.control, dtype=float)
            file.attrs["system"] = self.system
            file.attrs["sha256"] = self.digest
        os.replace(part, path)

    @classmethod
    def read(cls, path: Path) -> Snapshot:
        """Read a file. Raises OSError if it is none, Damaged if not as it was written."""
        with opened(path) as file:
            written = str(file.attrs.get("sha256"))
            states = {str(name): numbers(data).tobytes() for name, data in file["states"].items()}
            snapshot = cls(
                int(file.attrs["number"]), float(file.attrs["time"]), numbers(file["values"]),
                states, int(file.attrs["rows"]), tuple(map(float, file.attrs["control"])),
                str(file.attrs["system"]),
            )  # fmt: skip
        if snapshot.digest != written:
            raise Damaged(path)
        return snapshot

    @property
    def digest(self) -> str:
        """SHA-256 of everything, in hexadecimal."""
        counts = (self.number, self.rows, self.values.size, len(self.states))
        exact = (float(x).hex() for x in (self.time, *self.control))
        head = " ".join([self.system, *map(str, counts), *exact])
        sha = hashlib.sha256(head.encode(errors="surrogateescape"))  # damaged text too
        sha.update(self.values.tobytes())
        for name, state in sorted(self.states.items()):
            sha.update(f"{name} {len(state)} ".encode(errors="surrogateescape") + state)
        return sha.hexdigest()


def take(
    stepper: Stepper, number: int, rows: int = 0, control: Control | None = None, system: str = ""
) -> Snapshot:
    """The state after a number of steps. Raises RunError if an FMU does not tell its own."""
    remembered: tuple[float, ...] = ()
    time = stepper.time(number)
    if control is not None:
        time = control.past[0]
        remembered = (control.width, control.accepted, control.rejected, *control.past)
    states = {slave.name: slave.serialize() for slave in stepper.slaves}
    return Snapshot(number, time, stepper.values.copy(), states, rows, remembered, system)


def put(stepper: Stepper, snapshot: Snapshot, control: Control | None = None) -> None:
    """Bring a system to a state. Raises RunError if an FMU does not take its own."""
    for slave in stepper.slaves:
        slave.deserialize(snapshot.states[slave.name])
    stepper.values[:] = snapshot.values
    if control is not None and snapshot.control:
        recall(control, snapshot)


def recall(control: Control, snapshot: Snapshot) -> None:
    """Let error control go on as it would have."""
    width, accepted, rejected, *past = snapshot.control
    control.width, control.accepted, control.rejected = width, int(accepted), int(rejected)
    control.past = past


def identity(graph: SystemGraph, text: str) -> str:
    """What a snapshot must agree in to be of a system: its config and its FMUs."""
    sha = hashlib.sha256(text.encode())
    for node in graph.nodes:
        sha.update(f"{node.name} {node.fmu.token}\n".encode())
    return sha.hexdigest()


def require_serializable(graph: SystemGraph, where: str) -> None:
    """Raises ConfigError if an FMU cannot write its state."""
    lacking = [n for n in graph.nodes if not n.fmu.can_serialize]
    if lacking:
        raise ConfigError([
            Problem(where, f"{n.name} ({n.fmu.model_name}) cannot write its state",
                    "its FMU would have to offer canSerializeFMUstate")
            for n in lacking
        ])  # fmt: skip
