"""Checks parameters and start values against what an FMU declares."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from ..config.quantities import in_declared_unit
from ..config.spread import Refused
from ..errors import Problem, nearest
from ..fmi.description import FmuDescription, Port
from .graph import Scalar, Setting

Report = Callable[[Problem, tuple[str, ...]], None]
TABLES = ("parameters", "start")
LARGEST = (sys.float_info.max, 3.4028234663852886e38)  # of Float64 and of Float32


def settings(
    instance: str, fmu: FmuDescription, tables: Mapping[str, Mapping[str, Any]], report: Report
) -> tuple[Setting, ...]:
    """The values to set before initialisation; what is wrong goes to ``report``."""
    result = []
    for table in TABLES:
        for name, value in tables[table].items():
            path = ("instances", instance, table, name)
            found = _setting(fmu, table, name, value)
            if isinstance(found, Setting):
                result.append(found)
            else:
                what, remedy = found
                report(Problem(".".join(path), what, remedy), path)
    return tuple(result)


def table_of(fmu: FmuDescription, name: str) -> str | None:
    """Whether a name is a parameter or takes a start value; None if it is neither."""
    port = fmu.ports.get(name)
    if port is None or not port.settable:
        return None
    return "parameters" if port.causality == "parameter" else "start"


def names_of(fmu: FmuDescription, table: str) -> list[str]:
    """The names that a table may give."""
    return [n for n in fmu.ports if table_of(fmu, n) == table]


def _setting(
    fmu: FmuDescription, table: str, name: str, value: Any
) -> Setting | tuple[str, str]:
    right = table_of(fmu, name)
    if right is None:
        kind = "parameter" if table == "parameters" else "start value"
        what = f"{fmu.model_name} has no {kind} of this name"
        if name in fmu.ports:
            what = f"{name} is computed by {fmu.model_name} and cannot be set"
        return what, nearest(name, names_of(fmu, table), f"{kind}s")
    if right != table:
        kind = "a parameter" if right == "parameters" else "not a parameter but a start value"
        return f"{name} is {kind}", f"give it in {right}"
    port, given = fmu.ports[name], ""
    if isinstance(value, Mapping):
        try:
            value, given = in_declared_unit(port, value)
        except Refused as refused:
            return refused.what, refused.remedy
    shape = _shape(value)
    if shape != port.shape:
        return f"has {_words(shape)}, {name} needs {_words(port.shape)}", ""
    flat = tuple(_flatten(value))
    for element, scalar in enumerate(flat):
        if wrong := _wrong(port, scalar):
            if given and isinstance(scalar, int | float):
                wrong += f" {port.unit}, given as {given}"
            return f"{port.label(element)} {wrong}", _remedy(port)
    return Setting(port, tuple(_convert(port, s) for s in flat), given)


def _shape(value: Any) -> tuple[int, ...] | None:
    if not isinstance(value, list):
        return ()
    shapes = {_shape(v) for v in value}
    if len(shapes) != 1 or None in shapes:
        return None
    return (len(value), *(shapes.pop() or ()))


def _flatten(value: Any) -> Iterator[Any]:
    if isinstance(value, list):
        for inner in value:
            yield from _flatten(inner)
    else:
        yield value


def _words(shape: tuple[int, ...] | None) -> str:
    if shape is None:
        return "rows of different length"
    return f"the shape {' x '.join(str(n) for n in shape)}" if shape else "a single value"


def _wrong(port: Port, scalar: Any) -> str:
    number = isinstance(scalar, int | float) and not isinstance(scalar, bool)
    integer = number and not isinstance(scalar, float)
    choices = {choice for item in port.items for choice in item}
    fits = {
        "real": number,
        "integer": integer,
        "enumeration": scalar in choices if choices else integer,
        "boolean": isinstance(scalar, bool),
        "string": isinstance(scalar, str),
    }[port.kind]
    if not fits and choices:
        return f"is {scalar!r}, not one of its choices"
    if not fits:
        return f"is {scalar!r}, not {'an' if port.kind[0] in 'ei' else 'a'} {port.kind}"
    if not number:
        return ""
    if port.kind == "real" and not abs(scalar) <= LARGEST[port.type == "Float32"]:
        return f"is {scalar}, not a finite number"
    if port.kind != "real" and scalar not in (whole := _range(port.type)):
        return f"is {scalar}, not from {whole[0]} to {whole[-1]}"
    if port.minimum is not None and scalar < port.minimum:
        return f"is {scalar:g}, below the minimum {port.minimum:g}"
    if port.maximum is not None and scalar > port.maximum:
        return f"is {scalar:g}, above the maximum {port.maximum:g}"
    return ""


def _range(kind: str) -> range:
    """The integers of a type of FMI; an Integer of FMI 2.0 has 32 bits."""
    found = re.fullmatch(r"(U?)Int(\d+)", kind)
    unsigned, bits = (bool(found[1]), int(found[2])) if found else (False, 32)
    return range(2**bits) if unsigned else range(-(2 ** (bits - 1)), 2 ** (bits - 1))


def _remedy(port: Port) -> str:
    return f"valid: {', '.join(n for n, _ in port.items)}" if port.items else ""


def _convert(port: Port, scalar: Any) -> Scalar:
    if port.kind == "real":
        return float(scalar)
    if port.kind == "enumeration" and isinstance(scalar, str):
        return dict(port.items)[scalar]
    return scalar  # type: ignore[no-any-return]
