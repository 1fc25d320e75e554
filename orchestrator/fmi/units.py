"""Units as FMI describes them: value in base units = factor · value + offset."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ...fmus.units import UnitError as UnitError
from ...fmus.units import unit as unit_by_name

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Unit:
    """A unit's name and, where it is defined, its base-unit exponents, factor and offset.

    FMI defines units of integer exponents only; others are declared by name.
    """

    name: str
    exponents: tuple[float, ...] | None = None
    factor: float = 1.0
    offset: float = 0.0

    def __str__(self) -> str:
        return self.name

    @property
    def dimension(self) -> str:
        """The base units, such as ``kg.m.s-2``; ``1`` where there is none."""
        parts = [
            f"{base}{f'{power:g}' if power != 1 else ''}"
            for base, power in zip(BASE, self.exponents or (), strict=False)
            if power
        ]
        return ".".join(parts) or "1"


@dataclass(frozen=True)
class Conversion:
    """destination value = gain · source value + shift."""

    gain: float = 1.0
    shift: float = 0.0

    @property
    def trivial(self) -> bool:
        """Whether values pass unchanged."""
        return self.gain == 1.0 and self.shift == 0.0


UNCHANGED = Conversion()


def unit_of(name: str) -> Unit:
    """A unit by its name alone, such as ``deg/sqrt(h)``. Raises UnitError if it is not a unit."""
    found = unit_by_name(name)
    exponents = tuple(found.powers.get(base, 0.0) for base in BASE)
    return Unit(name, exponents, found.factor, found.offset)


def defined(unit: Unit) -> Unit:
    """A unit with the meaning of its name if it has no definition. Raises UnitError."""
    return unit if unit.exponents is not None else unit_of(unit.name)


def conversion(source: Unit | None, destination: Unit | None) -> Conversion | None:
    """How a value passes from one unit to another; None if it cannot, or only as 0 or infinity.

    A unit that is absent is not checked; without definitions the names must agree.
    """
    if source is None or destination is None:
        return UNCHANGED
    if source.exponents is None or destination.exponents is None:
        return UNCHANGED if source.name == destination.name else None
    if source.exponents != destination.exponents:
        return None
    if (source.factor, source.offset) == (destination.factor, destination.offset):
        return UNCHANGED
    if destination.factor == 0.0:
        return None
    gain = source.factor / destination.factor
    shift = (source.offset - destination.offset) / destination.factor
    usable = gain != 0.0 and math.isfinite(gain) and math.isfinite(shift)
    return Conversion(gain, shift) if usable else None
