"""What a block declares: ports, parameters, structure, states and noise.

A declaration is a plain value placed in the class body of a :class:`~.component.Component`.
Units follow the FMI spelling: ``kg.m2``, ``m/s2``, ``rad/s``, ``N.m``; ``1`` for no unit.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import nearest

Array: TypeAlias = NDArray[np.float64]
Scalar: TypeAlias = np.floating[Any] | Array
Condition: TypeAlias = np.bool | NDArray[np.bool]
Shape: TypeAlias = int | str | tuple[int | str, ...]
Start: TypeAlias = ArrayLike | Callable[..., ArrayLike]
ValueType: TypeAlias = Literal["real", "integer", "boolean"]
Q = TypeVar("Q", bound="Quantity")


@dataclass(frozen=True)
class Quantity:
    """A declared quantity. ``shape``: ``()``, ``3``, ``(3, 3)`` or with names of the structure.

    ``start`` is a number (fills the shape), an array, or a function of the structure's integers,
    received by name. ``frame`` names the role of the frame in which components are given, such as
    ``inertial`` or ``body``. Of an attitude it says whose attitude it is: the numbers are the
    rotation from that frame to inertial. Where each row is of another craft, so is its frame.
    """

    shape: Shape = ()
    unit: str | None = None
    start: Start = 0.0
    _: KW_ONLY
    frame: str | None = None
    doc: str = ""
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    type: ValueType = "real"
    name: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if not isinstance(self.shape, tuple):
            object.__setattr__(self, "shape", (self.shape,))

    @property
    def dimensions(self) -> tuple[int, ...]:
        """The shape as integers; the structure's names must have been resolved."""
        assert isinstance(self.shape, tuple)
        return tuple(int(n) for n in self.shape)

    @property
    def size(self) -> int:
        """Number of scalars."""
        return math.prod(self.dimensions)

    @property
    def value(self) -> Array:
        """The start value as an array of the resolved shape."""
        return np.array(self.start, dtype=float)

    def resolve(self: Q, structure: Mapping[str, int]) -> Q:
        """The same quantity with the structure's integers put into shape and start.

        Raises ValueError if the start value does not have the shape or is out of range.
        """
        assert isinstance(self.shape, tuple)
        shape = tuple(structure[n] if isinstance(n, str) else n for n in self.shape)
        start = call_by_name(self.start, structure) if callable(self.start) else self.start
        value = np.asarray(start, dtype=float)
        if value.ndim == 0:
            value = np.full(shape, value)
        if value.shape != shape:
            raise ValueError(f"start value has shape {value.shape}, declared is {shape}")
        if self.min is not None and np.any(value < self.min):
            raise ValueError(f"start value is below min = {self.min:g}")
        if self.max is not None and np.any(value > self.max):
            raise ValueError(f"start value is above max = {self.max:g}")
        return replace(self, shape=shape, start=value)


def call_by_name(function: Callable[..., Any], values: Mapping[str, Any]) -> Any:
    """Call a function with those of ``values`` that it names as arguments.

    Raises ValueError if it names one that there is not.
    """
    names = list(inspect.signature(function).parameters)
    unknown = [n for n in names if n not in values]
    if unknown:
        raise ValueError(f"start asks for {unknown[0]!r}; {nearest(unknown[0], values)}")
    return function(**{n: values[n] for n in names})


@dataclass(frozen=True)
class Input(Quantity):
    """An input port; unconnected, it keeps ``start``.

    ``optional``: that nothing drives it is nothing unusual, as of a disturbance or a feedforward.
    """

    _: KW_ONLY
    optional: bool = False


@dataclass(frozen=True)
class Output(Quantity):
    """An output port, computed by ``outputs``."""


@dataclass(frozen=True)
class Parameter(Quantity):
    """A value set before the run (``tunable``: also during it)."""

    _: KW_ONLY
    tunable: bool = False


@dataclass(frozen=True)
class SamplePeriod(Parameter):
    """The period of a block's ticks; 0 lets the block act continuously."""

    unit: str | None = "s"
    min: float | None = 0.0
    doc: str = "period of the ticks; 0: continuous"


@dataclass(frozen=True)
class State(Quantity):
    """A continuous state; ``derivatives`` gives its rate. ``output=True`` makes it a port too."""

    _: KW_ONLY
    output: bool = False


@dataclass(frozen=True)
class DiscreteState(Quantity):
    """A state that ``update`` changes at every tick of the sample period."""

    _: KW_ONLY
    output: bool = False


@dataclass(frozen=True)
class Noise(Quantity):
    """Independent draws from N(0, 1), new at every tick, handed to ``update`` and ``outputs``."""

    unit: str | None = "1"


@dataclass(frozen=True)
class Structure:
    """An integer that sets array sizes; fixed when the FMU is built."""

    default: int
    min: int = 1
    doc: str = ""
    name: str = field(default="", compare=False)
