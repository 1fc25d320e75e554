"""Units in FMI terms: exponents of the base units, factor, and the name of the quantity.

Spelling: factors joined by ``.``, divisors by ``/``, integer exponents appended (``kg.m2``,
``m/s2``), square roots as ``sqrt(Hz)`` or ``√Hz``. The radian counts as a base unit, as in FMI.
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Mapping
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


LETTERS = "A-Za-zµμ°_"
SPELLED = re.compile(rf"[{LETTERS}0-9./*^() -]+")  # pint's parser drops other characters


class UnitError(ValueError):
    """A unit is not understood."""


@dataclass(frozen=True)
class Unit:
    """A unit by its base units: ``value_in_base = factor * value + offset``."""

    name: str
    powers: Mapping[str, float]
    factor: float
    offset: float = 0.0

    @property
    def exponents(self) -> dict[str, int] | None:
        """What FMI defines a unit by; None for fractional exponents, declared by name only."""
        if any(p != int(p) for p in self.powers.values()):
            return None
        return {n: int(p) for n, p in self.powers.items()}


@cache
def unit(name: str) -> Unit:
    """What a unit means. Raises UnitError if it is not a unit."""
    if name == "1":
        return Unit(name, {}, 1.0)
    text = re.sub(rf"(?:sqrt|√)\((.*?)\)|√([{LETTERS}]+)", r"((\1\2)**0.5)", name)
    text = re.sub(rf"([{LETTERS}]+)(-?[1-9]\d*)", r"\1**\2", text)
    text = re.sub(r"\.(?!\d)", "*", text).replace("%", "percent")
    text = re.sub(r"(?<![\w.])(\d+)(?![\w.])", r"\1.0", text)  # 10^10^10 overflows at once
    if not SPELLED.fullmatch(text):
        raise UnitError(f"{name!r} is not a unit")
    try:
        factor, base = _registry().get_base_units(text)
        found = {BASE_UNITS[n]: float(p) for n, p in base._units.items()}
        temperature = found == {"K": 1.0}
        zero = _registry().Quantity(0.0, text).to_base_units().magnitude if temperature else 0.0
    except Exception as error:  # pint raises many kinds, and Python's parser shows through it
        unknown = f": {error}" if type(error).__name__ == "UndefinedUnitError" else ""
        raise UnitError(f"{name!r} is not a unit{unknown}") from None
    if not 0.0 < float(factor) < math.inf:
        raise UnitError(f"{name!r} is not a unit")
    powers = {n: found[n] for n in BASE_UNITS.values() if n in found}
    return Unit(name, powers, float(factor), float(zero))


@cache
def _registry() -> Any:
    """Pint's registry with the radian as a base unit."""
    import pint

    logging.getLogger("pint").setLevel(logging.ERROR)
    registry: Any = pint.UnitRegistry()
    registry.define("radian = [angle] = rad")
    return registry
