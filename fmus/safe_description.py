"""A model description that may be hostile: its sizes, names and numbers, before they are used.

Looked at as elements of the XML, of FMI 2.0 and FMI 3.0 alike, before anything is allocated by the
numbers in it. Problems are told as ``variable: what is wrong``, all of them.

A leaf: the standard library only, so that verification and the orchestrator can share it.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator
from typing import Any

MAX_VALUES = 1_000_000  # of one variable
MAX_TOTAL = 10_000_000  # values of one FMU
MAX_AXES = 32  # of one variable
MAX_REFERENCE = 2**32 - 1
INDEX = re.compile(r"\[(\d+(?:,\s*\d+)*)\]\)?$")
INTEGER = re.compile(r"\s*[+-]?\d{1,40}\s*")


def description_problems(root: Any) -> list[str]:
    """Everything in a modelDescription.xml that cannot be used; ``root`` is its first element."""
    return [*_head(root), *_units(root), *_types(root), *_variables(root), *size_problems(root)]


def size_problems(root: Any) -> list[str]:
    """Variables of more values or dimensions than an FMU can be expected to have."""
    starts = {v.get("valueReference"): v.get("start") for v in _declared(root)}
    found, total = [], 0
    for variable in _declared(root):
        name = _name(variable)
        extents: list[int] = []
        for dimension in variable.findall("Dimension"):
            text = dimension.get("start") or starts.get(dimension.get("valueReference"))
            size = _whole(text)
            if size is None:
                found.append(f"{name}: size of a Dimension is {_said(text)}, not a whole number")
            else:
                extents.append(size)
        index = INDEX.search(variable.get("name") or "")
        indices = [_whole(i) or 0 for i in index[1].split(",")] if index else []
        axes = max(len(extents), len(indices))
        if axes > MAX_AXES:
            found.append(f"{name}: has {axes} dimensions, at most {MAX_AXES}")
            continue
        values = math.prod(extents)
        total += values * (1 + len(variable.findall("Alias")))
        if values > MAX_VALUES:
            found.append(f"{name}: has {_amount(values)} values, at most {MAX_VALUES:,}")
        if max(indices, default=0) > MAX_VALUES:
            found.append(f"{name}: its name has an index above {MAX_VALUES:,}")
    if total > MAX_TOTAL and not found:
        found.append(f"its variables have {_amount(total)} values, at most {MAX_TOTAL:,}")
    return found


def _head(root: Any) -> Iterator[str]:
    if not root.get("modelName"):
        yield "modelName is missing"
    for interface in root.findall("CoSimulation"):
        step = interface.get("fixedInternalStepSize")
        if step is not None and not (_finite(step) and float(step) > 0.0):
            yield f"CoSimulation: fixedInternalStepSize is {_said(step)}, not a number above 0"


def _units(root: Any) -> Iterator[str]:
    for unit in root.findall("UnitDefinitions/Unit"):
        for base in unit.findall("BaseUnit"):
            factor, offset = base.get("factor", "1"), base.get("offset", "0")
            if not _finite(factor) or float(factor) == 0.0:
                yield f"unit {_name(unit)}: factor is {_said(factor)}, not a finite number but 0"
            if not _finite(offset):
                yield f"unit {_name(unit)}: offset is {_said(offset)}, not a finite number"


def _types(root: Any) -> Iterator[str]:
    for declared in root.findall("TypeDefinitions/*"):
        for element in (declared, *declared):
            yield from _limits(element, f"type {_name(declared)}")
        for item in declared.iter("Item"):
            if not INTEGER.fullmatch(item.get("value") or ""):
                what = f"value of the item {_name(item)} is {_said(item.get('value'))}"
                yield f"type {_name(declared)}: {what}, not a whole number"


def _variables(root: Any) -> Iterator[str]:
    names: Counter[str] = Counter()
    for number, variable in enumerate(_declared(root), 1):
        name = _name(variable)
        names.update(e.get("name") or "" for e in (variable, *variable.findall("Alias")))
        if not variable.get("name"):
            yield f"variable {number} has no name"
        reference = variable.get("valueReference")
        value = _whole(reference)
        if value is None or value > MAX_REFERENCE:
            yield f"{name}: valueReference is {_said(reference)}, not from 0 to {MAX_REFERENCE}"
        for element in (variable, *variable):
            yield from _limits(element, name)
    for text, count in names.items():
        if text and count > 1:
            yield f"{_short(text)}: {count} variables have this name"


def _limits(element: Any, where: str) -> Iterator[str]:
    for name in ("min", "max"):
        text = element.get(name)
        if text is not None and _number(text) is None:
            yield f"{where}: {name} is {_said(text)}, not a number"


def _declared(root: Any) -> list[Any]:
    return list(root.findall("ModelVariables/*"))


def _number(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _finite(text: str) -> bool:
    number = _number(text)
    return number is not None and math.isfinite(number)


def _whole(text: str | None) -> int | None:
    """A number of digits only; whatever has more than 40 counts as 1e40."""
    digits = (text or "").strip()
    if not digits.isdecimal():
        return None
    return int(digits) if len(digits) <= 40 else 10**40


def _amount(count: int) -> str:
    return f"{count:,}" if count < 10**15 else "more than 1e+15"


def _said(text: str | None) -> str:
    return "missing" if text is None else repr(_short(text))


def _name(element: Any) -> str:
    return _short(element.get("name") or "(no name)")


def _short(text: str) -> str:
    return text if len(text) <= 80 else f"{text[:77]}..."
