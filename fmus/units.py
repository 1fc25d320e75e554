"""Units in FMI terms: exponents of the base units, factor, and the name of the quantity.

Spelling: factors joined by ``.``, divisors by ``/``, integer exponents appended (``kg.m2``,
``m/s2``), square roots as ``sqrt(Hz)``. The radian counts as a base unit, as in FMI.
"""

from __future__ import annotations

import logging
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

BASE_UNITS = {
    "kilogram": "kg", "meter": "m", "second": "s", "ampere": "A",
    "kelvin": "K", "mole": "mol", "candela": "cd", "radian": "rad",
}  # fmt: skip

QUANTITIES = {
    "m": "Length", "m/s": "Velocity", "m/s2": "Acceleration", "kg": "Mass",
    "kg.m2": "MomentOfInertia", "N": "Force", "N.m": "Torque", "s": "Time",
    "rad": "Angle", "rad/s": "AngularVelocity", "rad/s2": "AngularAcceleration", "J": "Energy",
    "N.s": "Impulse", "N/m2": "Pressure", "m2": "Area", "m3/s2": "GravitationalParameter",
}  # fmt: skip


class UnitError(ValueError):
    """A unit is not understood."""


@dataclass(frozen=True)
class Unit:
    """A unit as FMI defines it: ``value_in_base = factor * value``.

    ``exponents`` is None where FMI has no form for it (fractional exponents): such a unit is
    declared by name only.
    """

    name: str
    exponents: dict[str, int] | None
    factor: float


@cache
def unit(name: str) -> Unit:
    """The FMI form of a unit. Raises UnitError if it is not a unit."""
    if name == "1":
        return Unit(name, {}, 1.0)
    text = re.sub(r"sqrt\((.*?)\)", r"(\1)**0.5", name)
    text = re.sub(r"([A-Za-zµ°]+)(-?\d+)", r"\1**\2", text)
    text = re.sub(r"\.(?!\d)", "*", text)
    try:
        factor, base = _registry().get_base_units(text)
        powers = {BASE_UNITS[n]: p for n, p in base._units.items()}
    except Exception as error:  # pint raises many kinds, and Python's parser shows through it
        raise UnitError(f"{name!r} is not a unit ({error})") from None
    if any(p != int(p) for p in powers.values()):
        return Unit(name, None, float(factor))
    return Unit(name, {n: int(powers[n]) for n in BASE_UNITS.values() if n in powers},
                float(factor))


@cache
def _registry() -> Any:
    """Pint's registry with the radian as a base unit."""
    import pint

    logging.getLogger("pint").setLevel(logging.ERROR)
    registry: Any = pint.UnitRegistry()
    registry.define("radian = [angle] = rad")
    return registry
