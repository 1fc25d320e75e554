"""Values that a config gives in the unit of a datasheet: { value = 0.15, unit = "deg/sqrt(h)" }.

They are converted to the unit that the FMU declares. A spectral density has fractional exponents
of base units, which FMI cannot define: what it means is then taken from its name.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import nearest
from ..fmi.description import Port
from ..fmi.units import Conversion, UnitError, conversion, defined, unit_of
from . import toml_text
from .spread import Refused

KEYS = ("value", "unit")
FORM = 'a value in its own unit is { value = 0.15, unit = "deg/sqrt(h)" }'
USUAL = (  # in datasheets: what to offer where another unit does not fit
    "deg", "arcsec", "arcsec/sqrt(Hz)", "deg/s", "deg/h", "deg/sqrt(h)", "deg/h/sqrt(h)",
    "km", "mm", "mm/sqrt(Hz)", "mm/s", "mm/s/sqrt(Hz)", "g", "mN", "mN.m", "mN.s", "ms", "h",
    "ppm", "percent",
)  # fmt: skip


def in_declared_unit(port: Port, table: Mapping[str, Any]) -> tuple[Any, str]:
    """The value in the port's unit, and what was given as text if it is another one.

    Raises Refused if the table is not a value and a unit, or the unit does not fit.
    """
    if absent := [k for k in KEYS if k not in table]:
        raise Refused(f"is a table that lacks {absent[0]}", FORM)
    if unknown := [k for k in table if k not in KEYS]:
        raise Refused(f"has the unknown key {unknown[0]}", FORM)
    value, name = table["value"], table["unit"]
    if not isinstance(name, str):
        raise Refused(f"has the unit {name!r}, not a text", FORM)
    passes = _conversion(port, name)
    if passes.trivial:
        return value, ""
    return _converted(value, passes), f"{toml_text.value(value)} {name}"


def _conversion(port: Port, name: str) -> Conversion:
    if port.kind != "real" or port.unit is None:
        what = f"is given in {name}, but {port.name} is declared without a unit"
        raise Refused(what, "give the plain value")
    try:
        given = unit_of(name)
    except UnitError as error:
        remedy = "" if error.meant else nearest(name, USUAL, "for example")
        raise Refused(str(error), remedy) from None
    try:
        declared = defined(port.unit)
    except UnitError:
        what = f"is given in {name}, but what {port.unit} means is not known"
        raise Refused(what, f"give the plain value in {port.unit}") from None
    passes = conversion(given, declared)
    if passes is None:
        fits = dict.fromkeys([str(port.unit), *(u for u in USUAL if _fits(u, declared.exponents))])
        what = f"is given in {name} ({given.dimension}), {port.name} is in {port.unit}"
        if declared.dimension != port.unit.name:
            what += f" ({declared.dimension})"
        plain = not any(declared.exponents or ())
        raise Refused(what, "give the plain value" if plain else f"give it in {' or '.join(fits)}")
    return passes


def _fits(name: str, exponents: tuple[float, ...] | None) -> bool:
    return unit_of(name).exponents == exponents


def _converted(value: Any, passes: Conversion) -> Any:
    """A number, or arrays of numbers, converted; what is no number is left as it is."""
    if isinstance(value, list):
        return [_converted(v, passes) for v in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return passes.gain * value + passes.shift
