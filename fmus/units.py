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


KNOWN = frozenset((  # of pint's units, by its names for them; other readings are slips: Nm, degs
    "meter", "second", "gram", "ampere", "kelvin", "mole", "candela", "radian", "steradian",
    "hertz", "newton", "pascal", "joule", "watt", "coulomb", "volt", "farad", "ohm", "siemens",
    "weber", "tesla", "gauss", "henry", "lumen", "lux", "electron_volt", "bar", "liter",
    "minute", "hour", "day", "week", "year", "degree", "arcminute", "arcsecond",
    "milliarcsecond", "turn", "revolutions_per_minute", "degree_Celsius",
    "delta_degree_Celsius", "degree_Fahrenheit", "metric_ton", "standard_gravity",
    "astronomical_unit", "standard_atmosphere", "foot", "inch", "mile", "nautical_mile", "knot",
    "pound", "force_pound", "force_kilogram", "pound_force_per_square_inch", "watt_hour",
    "percent", "ppm",
))  # fmt: skip
ANGLES = frozenset(("radian", "degree", "arcminute", "arcsecond", "turn"))
LETTERS = "A-Za-zµμ°_Ω"
SYMBOL = re.compile(rf"[{LETTERS}]+0?")
MILLISECONDS = re.compile(r"(?<![\w/])ms(?:\^|\*\*)?(-?[1-9])")
SPELLED = re.compile(rf"[{LETTERS}0-9./*^() -]+")  # pint's parser drops other characters


class UnitError(ValueError):
    """A unit is not understood. ``meant``: what may have been meant; empty if not known."""

    def __init__(self, name: str, why: str = "", meant: str = "") -> None:
        self.name, self.why, self.meant = name, why, meant
        remedy = f"; did you mean {meant}?" if meant else ""
        super().__init__(f"{name!r} is not a unit{why and f': {why}'}{remedy}")


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
    _refuse_slips(name)
    text = re.sub(rf"(?:sqrt|√)\((.*?)\)|√([{LETTERS}]+)", r"((\1\2)**0.5)", name)
    text = re.sub(rf"([{LETTERS}]+)(-?[1-9]\d*)", r"\1**\2", text)
    text = re.sub(r"\.(?!\d)", "*", text).replace("%", "percent")
    text = re.sub(r"(?<![\w.])(\d+)(?![\w.])", r"\1.0", text)  # 10^10^10 overflows at once
    if not SPELLED.fullmatch(text):
        raise UnitError(name)
    try:
        factor, base = _registry().get_base_units(text)
        found = {BASE_UNITS[n]: float(p) for n, p in base._units.items()}
        temperature = found == {"K": 1.0}
        zero = _registry().Quantity(0.0, text).to_base_units().magnitude if temperature else 0.0
    except Exception:  # pint raises many kinds, and Python's parser shows through it
        raise UnitError(name) from None
    if not 0.0 < float(factor) < math.inf:
        raise UnitError(name)
    powers = {n: found[n] for n in BASE_UNITS.values() if n in found}
    return Unit(name, powers, float(factor), float(zero))


def _refuse_slips(name: str) -> None:
    """Refuse what pint reads otherwise than it is meant, or not at all. Raises UnitError."""
    if slip := MILLISECONDS.search(name):
        meant = f"m/s{slip[1].lstrip('-')}".removesuffix("1")
        meant = MILLISECONDS.sub(meant, name)
        raise UnitError(name, f"{slip[0]} is a power of milliseconds", meant)
    for symbol in SYMBOL.findall(name):
        if symbol != "sqrt" and _reading(symbol) is None:
            parts = _parts(symbol)
            meant = name.replace(symbol, parts, 1) if parts else ""
            raise UnitError(name, f"{symbol} is not known", meant)


@cache
def _reading(symbol: str) -> tuple[str, str] | None:
    """The prefix and pint's name of a unit; None if it is none, or a symbol with a plural s."""
    for prefix, name, _ in _registry().parse_unit_name(symbol)[:1]:
        short = symbol.removesuffix("s")
        plural = short not in ("", symbol) and symbol != f"{prefix}{name}s" and (
            any(found[1] == name for found in _registry().parse_unit_name(short))
        )
        return (prefix, name) if name in KNOWN and not plural else None
    return None


def _parts(symbol: str) -> str:
    """Symbols that a text runs together, ``N.m`` of ``Nm``; empty if there are none.

    Few ones, and prefixes at the first or at a length or mass, are likeliest.
    """
    best: dict[int, tuple[float, tuple[str, ...]]] = {0: (0.0, ())}
    for end in range(1, len(symbol) + 1):
        for first in [n for n in best if n < end]:
            part, (cost, parts) = symbol[first:end], best[first]
            prefix, name = _reading(part) or ("", "")
            if not name or (first and prefix and name not in ("meter", "gram")):
                continue
            cost += 1.0 + 1.5 * bool(first and prefix) + 2.0 * (part in parts)
            if end not in best or cost < best[end][0]:
                best[end] = cost, (*parts, part)
    parts = best.get(len(symbol), (0.0, ()))[1]
    rate = parts[1:] == ("s",) and (_reading(parts[0]) or ("", ""))[1] in ANGLES
    return ("/" if rate else ".").join(parts)


@cache
def _registry() -> Any:
    """Pint's registry with the radian as a base unit."""
    import pint

    logging.getLogger("pint").setLevel(logging.ERROR)
    registry: Any = pint.UnitRegistry()
    registry.define("radian = [angle] = rad")
    return registry
