"""A running system that its user steps: read, set, save, restore.

>>> with system.start() as running:
...     for time in running:
...         position = running["craft1.position"]
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from .config.model import Simulation
from .errors import Problem, nearest
from .fmi.log import RunLog
from .results.file import columns_of
from .schedule.plan import Array, Plan
from .stepping.adaptive import Control
from .stepping.snapshot import Snapshot, put, require_serializable, take
from .stepping.starting import start
from .wiring.graph import SystemGraph
from .wiring.signals import Selection
from .wiring.values import settings


@dataclass(frozen=True)
class Parts:
    """What a session needs of a system."""

    graph: SystemGraph
    plan: Plan
    selection: Selection
    simulation: Simulation


class Session:
    """Begins at the start time, initialised; to be used in a ``with`` statement.

    Raises RunError if an FMU fails, FmuError if an archive is damaged.
    """

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._columns = {c.signal.name: c for c in columns_of(parts.selection.recorded)}
        self.number = 0  # communication steps taken
        self.log = RunLog(None)

    def __enter__(self) -> Session:
        with ExitStack() as stack:
            parts = self._parts
            self._stepper, self.rested = start(
                parts.graph, parts.plan, parts.simulation, self.log, stack
            )
            self._slaves = {slave.name: slave for slave in self._stepper.slaves}
            self._control: Control | None = None
            if parts.simulation.adaptive:
                tolerance = parts.simulation.tolerance
                self._control = Control(self._stepper, tolerance, parts.plan.smooth)
            self._stack = stack.pop_all()
        return self

    def __exit__(self, *error: object) -> None:
        self._stack.close()

    @property
    def time(self) -> float:
        """The time reached, s."""
        return self._instant(self.number)

    def _instant(self, number: int) -> float:
        simulation = self._parts.simulation
        last = number == simulation.steps and simulation.adaptive
        return simulation.stop_time if last else self._stepper.time(number)

    def __iter__(self) -> Iterator[float]:
        """Step to the stop time; gives the time after each communication step."""
        while self.number < self._parts.simulation.steps:
            self.step()
            yield self.time

    def step(self, count: int = 1) -> None:
        """Take communication steps, beyond the stop time too. Raises RunError."""
        if self._control is None:
            last = self.number + count
            never = last + 1  # a stride that records none of these steps
            self._stepper.advance(self.number, last, never, np.empty((0, 0)))
            self.number = last
            return
        for _ in range(count):
            for _time in self._control.reach(self._instant(self.number + 1)):
                pass
            self.number += 1

    def __getitem__(self, name: str) -> Array:
        """The present value of a recorded signal, in the port's shape. Raises KeyError."""
        column = self._columns.get(name)
        if column is None:
            raise KeyError(f"{name} is not recorded; {nearest(name, self._columns, 'recorded')}")
        where = self._parts.plan.recorded[column.first:column.last]
        values: Array = self._stepper.values[where].reshape(column.signal.port.shape)
        return values

    def values(self) -> dict[str, Array]:
        """The present values of all recorded signals."""
        return {name: self[name] for name in self._columns}

    def set(self, name: str, value: Any) -> None:
        """Set an input that nothing drives, or a tunable parameter, from the next step on.

        Raises ValueError if there is none of this name or the value does not suit it.
        """
        instance, _, port = name.partition(".")
        graph = self._parts.graph
        if instance not in graph.index:
            raise ValueError(f"there is no instance {instance}")
        fmu = graph.nodes[graph.index[instance]].fmu
        found = fmu.ports.get(port)
        fixed = found is not None and found.variability == "fixed"
        if found is None or found.causality not in ("input", "parameter") or fixed:
            names = [n for n, p in fmu.of("input", "parameter").items() if p.variability != "fixed"]
            raise ValueError(f"{name} cannot be set while running; {nearest(port, names)}")
        if any(instance == c.destination.instance and port == c.destination.port.name
               for c in graph.connections):
            raise ValueError(f"{name} is driven by a connection")
        plain = value.tolist() if isinstance(value, np.ndarray | np.generic) else value
        tables: dict[str, dict[str, Any]] = {"parameters": {}, "start": {}}
        tables["parameters" if found.causality == "parameter" else "start"][port] = plain
        problems: list[Problem] = []
        for setting in settings(instance, fmu, tables, lambda p, _: problems.append(p)):
            self._slaves[instance].set(setting)
        if problems:
            raise ValueError(f"{name}: {problems[0].what}")

    def save(self) -> Snapshot:
        """The state of the whole system. Raises ConfigError if an FMU cannot write its own."""
        require_serializable(self._parts.graph, "save")
        return take(self._stepper, self.number, control=self._control)

    def restore(self, snapshot: Snapshot) -> None:
        """Go to a state saved by this session or another one of the same system."""
        put(self._stepper, snapshot, self._control)
        self.number = snapshot.number
