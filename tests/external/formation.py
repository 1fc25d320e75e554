"""Example 5.1 as any tool needs it: files, start values and links, read from its system.toml."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sightline.orchestrator import System
from sightline.orchestrator.wiring.graph import End

EXAMPLE = Path(__file__).parents[2] / "examples" / "los_formation" / "system.toml"
Series = NDArray[np.float64]


@dataclass(frozen=True)
class Variable:
    """A real scalar of one instance."""

    instance: str
    name: str
    reference: int

    def __str__(self) -> str:
        return f"{self.instance}::{self.name}"


@dataclass(frozen=True)
class Formation:
    """The wired system. ``feedthrough``: outputs that the instance's inputs change at once."""

    system: System
    fmus: Mapping[str, Path]
    start: Mapping[Variable, float]
    links: tuple[tuple[Variable, Variable], ...]
    outputs: tuple[Variable, ...]
    feedthrough: frozenset[Variable]

    def run(self, folder: Path) -> Series:
        """Our run: one row of all outputs for each communication point, the start included."""
        results = self.system.simulate(folder)
        ports = [results[n] for n, (_, port) in self.system.graph.signals.items()
                 if port.kind == "real"]
        return np.column_stack([p.reshape(len(results.time), -1) for p in ports])


def formation(
    folder: Path, step: float, stop: float, algorithm: str = "jacobi", record: float | None = None
) -> Formation:
    """The example from native FMUs with this algorithm, step and stop time.

    All outputs are recorded, every ``record`` seconds or every step.
    """
    config = folder / "system.toml"
    instances = tomllib.loads(EXAMPLE.read_text(encoding="utf-8"))["instances"]
    config.write_text(
        f'extends = "{EXAMPLE.as_posix()}"\nplots = []\n'
        f'[simulation]\nalgorithm = "{algorithm}"\nstep = {step}\nstop_time = {stop}\n'
        f'[record]\nsignals = ["*"]\nevery = {record or step}\n'
        + "".join(f'[instances.{name}]\ntarget = "native"\n' for name in instances),
        encoding="utf-8",
    )
    system = System.from_toml(config)
    nodes, graph = system.graph.nodes, system.graph
    outputs = [
        (Variable(node.name, port.label(i), port.references[i]), node)
        for node, port in graph.signals.values()
        if port.kind == "real"
        for i in range(port.size)
    ]
    return Formation(
        system=system,
        fmus={node.name: node.fmu.path for node in nodes},
        start={
            Variable(node.name, s.port.label(i), s.port.references[i]): float(value)
            for node in nodes
            for s in node.settings
            for i, value in enumerate(s.values)
        },
        links=tuple(
            (_element(c.source, i), _element(c.destination, i))
            for c in graph.connections
            for i in range(len(c.source.elements))
        ),
        outputs=tuple(variable for variable, _ in outputs),
        feedthrough=frozenset(
            variable for variable, node in outputs if node.fmu.feedthrough[variable.reference]
        ),
    )


def _element(end: End, number: int) -> Variable:
    element = end.elements[number]
    return Variable(end.instance, end.port.label(element), end.port.references[element])


def relative_difference(computed: Series, expected: Series) -> float:
    """The greatest difference of any column, relative to the column's greatest magnitude."""
    size = np.maximum(np.max(np.abs(expected), axis=0), np.finfo(float).tiny)
    return float(np.max(np.abs(computed - expected) / size))
