"""The system as a graph: instances of FMUs, and connections between elements of their ports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from ..fmi.description import FmuDescription, Port
from ..fmi.units import UNCHANGED, Conversion

Scalar = float | int | bool | str
Frames = str | tuple[str, ...]
TIME_LIMIT = 60.0  # s


@dataclass(frozen=True)
class Setting:
    """A parameter or start value, flat in row-major order.

    ``given`` is what the config says, if in another unit than the port's.
    """

    port: Port
    values: tuple[Scalar, ...]
    given: str = ""

    def __str__(self) -> str:
        numbers = [f"{v:.7g}" if isinstance(v, float) else str(v) for v in self.values]
        value = f"[{', '.join(numbers)}]" if self.port.shape else numbers[0]
        unit = "" if self.port.unit is None or self.port.unit.name == "1" else self.port.unit
        return f"{value} {unit}".rstrip()


@dataclass(frozen=True)
class Node:
    """One instance. ``frames`` binds the roles of its ports' frames to names of the system: to one,
    or to one for each row of the ports.

    ``time_limit``: s, that any one call may take if it is ``isolated``.
    """

    name: str
    fmu: FmuDescription
    settings: tuple[Setting, ...] = ()
    frames: Mapping[str, Frames] = field(default_factory=dict)
    isolated: bool = False
    time_limit: float = TIME_LIMIT

    def frame(self, port: Port, element: int | None = None) -> str:
        """The frame of a port, or of an element, by its name in the system; empty if unknown."""
        if port.frame == "inertial":
            return "inertial"
        bound = self.frames.get(port.frame, "")
        if isinstance(bound, str):
            return bound
        return ", ".join(bound) if element is None else bound[element * len(bound) // port.size]


@dataclass(frozen=True)
class End:
    """Elements of a port of an instance, counted from 0 in row-major order.

    ``index`` is what stands in brackets, ``""`` for the whole port: ``1,2``, row ``1``, column
    ``:,1``. ``shape`` is that of the elements.
    """

    instance: str
    port: Port
    elements: tuple[int, ...]
    shape: tuple[int, ...] = ()
    index: str = ""

    @property
    def whole(self) -> bool:
        """Whether these are all elements of the port."""
        return len(self.elements) == self.port.size

    def __str__(self) -> str:
        return f"{self.instance}.{self.port.name}" + (f"[{self.index}]" if self.index else "")


@dataclass(frozen=True)
class Connection:
    """Values that flow from an output to an input, element by element."""

    source: End
    destination: End
    conversion: Conversion = UNCHANGED

    def __str__(self) -> str:
        return f"{self.source} -> {self.destination}"

    @property
    def converted(self) -> str:
        """What is converted to what; empty if nothing is."""
        if self.conversion.trivial:
            return ""
        shift = f" {self.conversion.shift:+.10g}" if self.conversion.shift else ""
        units = f"{self.source.port.unit} to {self.destination.port.unit}"
        return f"{self}: {units}, times {self.conversion.gain:.10g}{shift}"


@dataclass(frozen=True)
class SystemGraph:
    """Everything that is run, checked. ``notes`` says what is allowed but worth knowing,
    ``warnings`` what is more likely a mistake."""

    nodes: tuple[Node, ...]
    connections: tuple[Connection, ...] = ()
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    @property
    def conversions(self) -> tuple[str, ...]:
        """Parameters and start values that the config gives in another unit than the port's."""
        return tuple(
            f"{node.name}.{setting.port.name}: {setting.given} to {setting}"
            for node in self.nodes for setting in node.settings if setting.given
        )

    @cached_property
    def index(self) -> dict[str, int]:
        """Position of each instance."""
        return {node.name: i for i, node in enumerate(self.nodes)}

    @cached_property
    def connected(self) -> dict[str, frozenset[int]]:
        """For each instance the value references of outputs that drive something."""
        found: dict[str, set[int]] = {node.name: set() for node in self.nodes}
        for c in self.connections:
            found[c.source.instance].update(c.source.port.references[e] for e in c.source.elements)
        return {name: frozenset(references) for name, references in found.items()}

    @cached_property
    def signals(self) -> dict[str, tuple[Node, Port]]:
        """All outputs by ``instance.port``, in the system's order."""
        return {
            f"{node.name}.{port.name}": (node, port)
            for node in self.nodes
            for port in node.fmu.outputs.values()
            if port.kind != "string"
        }
