"""What the orchestrator knows of an FMU: plain data, whatever the file it came from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from .units import Unit

Kind = Literal["real", "integer", "boolean", "string", "enumeration"]


@dataclass(frozen=True)
class Port:
    """A variable of an FMU: a scalar or an array, with one value reference per element.

    Elements are in row-major order. ``settable`` says whether a start value may be given.
    """

    name: str
    shape: tuple[int, ...]
    kind: Kind
    causality: str
    references: tuple[int, ...]
    unit: Unit | None = None
    frame: str = ""
    description: str = ""
    settable: bool = False
    start: tuple[str, ...] = ()
    minimum: float | None = None
    maximum: float | None = None
    items: tuple[tuple[str, int], ...] = ()  # names of an enumeration

    @property
    def size(self) -> int:
        """Number of scalars."""
        return math.prod(self.shape)

    def label(self, element: int) -> str:
        """The name of one element, ``position[2]`` or ``inertia[1,3]``; the port's if scalar."""
        if not self.shape:
            return self.name
        index = []
        for extent in reversed(self.shape):
            element, remainder = divmod(element, extent)
            index.append(remainder + 1)
        return f"{self.name}[{','.join(str(i) for i in reversed(index))}]"

    def labels(self) -> Iterator[str]:
        """The names of all elements."""
        return (self.label(i) for i in range(self.size))


@dataclass(frozen=True)
class FmuDescription:
    """An FMU's interface. ``feedthrough``: for each output's reference, inputs that act at once."""

    path: Path
    version: str
    model_name: str
    identifier: str
    token: str
    description: str = ""
    generator: str = ""
    ports: Mapping[str, Port] = field(default_factory=dict)
    feedthrough: Mapping[int, frozenset[int]] = field(default_factory=dict)
    variable_step: bool = True
    can_restore: bool = False

    def of(self, *causalities: str) -> dict[str, Port]:
        """The ports of some causalities, by name."""
        return {n: p for n, p in self.ports.items() if p.causality in causalities}

    @property
    def inputs(self) -> dict[str, Port]:
        """Input ports by name."""
        return self.of("input")

    @property
    def outputs(self) -> dict[str, Port]:
        """Output ports by name."""
        return self.of("output")

    def depends(self, output: Port, port: Port) -> bool:
        """Whether any element of an output depends at once on any element of an input."""
        acting = frozenset(port.references)
        return any(self.feedthrough.get(r, frozenset()) & acting for r in output.references)
