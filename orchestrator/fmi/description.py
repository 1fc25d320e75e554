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

    All elements of an array of FMI 3.0 have the same reference. Elements are in row-major order.
    ``settable`` says whether a start value may be given.
    """

    name: str
    shape: tuple[int, ...]
    kind: Kind
    causality: str
    references: tuple[int, ...]
    type: str = "Real"  # the word of the functions that get and set it
    variability: str = "continuous"
    unit: Unit | None = None
    frame: str = ""
    optional: bool = False  # an input that may well be driven by nothing
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
    """An FMU's interface. ``feedthrough``: for each output's reference, inputs that act at once.

    ``others``: variables that no value here can be given to, with their types, as ``Clock``.
    """

    path: Path
    version: str
    model_name: str
    identifier: str
    token: str
    description: str = ""
    generator: str = ""
    ports: Mapping[str, Port] = field(default_factory=dict)
    others: Mapping[str, str] = field(default_factory=dict)
    feedthrough: Mapping[int, frozenset[int]] = field(default_factory=dict)
    variable_step: bool = True
    fixed_step: float | None = None  # s, of the FMU's own solver
    can_restore: bool = False
    can_serialize: bool = False
    can_interpolate: bool = False  # takes derivatives of its inputs
    has_derivatives: bool = False  # gives derivatives of its outputs by its inputs
    event_mode: bool = False
    only_once: bool = False  # in a process

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

    @property
    def version_3(self) -> bool:
        """Whether this is FMI 3: array variables, many types, event mode."""
        return self.version.startswith("3.")

    def depends(self, output: Port, port: Port) -> bool:
        """Whether any element of an output depends at once on any element of an input."""
        acting = frozenset(port.references)
        return any(self.feedthrough.get(r, frozenset()) & acting for r in output.references)
