"""A reference solution: NAME_ref.csv, with inputs in NAME_in.csv, beside the FMU or given."""

from __future__ import annotations

import csv
import itertools
import math
from pathlib import Path

import numpy as np

from ..excitation import flat_start
from ..lab import Lab
from ..registry import NotApplicable, Notes, check
from ..session import Ended
from ..subject import Array

TOLERANCE = 1e-3  # of a column's size: inputs are held over a step


@check("reference", "outputs follow the reference solution")
def reference(lab: Lab, notes: Notes) -> None:
    stem = lab.subject.path.with_suffix("")
    path = lab.reference or Path(f"{stem}_ref.csv")
    if not path.is_file():
        raise NotApplicable(f"there is no {path.name} beside the FMU, and none was given")
    beside = Path(str(path).replace("_ref.csv", "_in.csv"))
    inputs = None
    try:
        time, columns = read_csv(path)
        if beside.is_file() and beside != path:
            inputs = read_csv(beside)
    except Unreadable as unread:
        notes.wrong(str(unread), unread.found, unread.expected)
        return
    owners = {e: v for v in lab.subject.readable for e in v.elements}
    for name in [n for n in columns if n not in owners]:
        notes.wrong(path.name, f"the column {name} is no variable of the FMU", "names of variables")
        del columns[name]
    if not columns:
        return
    watched = list(dict.fromkeys(owners[n] for n in columns))
    names = [e for v in watched for e in v.elements]
    session = lab.session().begin(float(time[0]), inputs=_inputs(lab, inputs, float(time[0])))
    rows = [session.read(watched)]
    for a, b in itertools.pairwise(time):
        session.put(_inputs(lab, inputs, float(a)))
        if b > a:
            try:
                session.step(float(b - a), float(a))
            except Ended as end:
                rows.append(session.read(watched))
                if b < time[-1]:
                    notes.wrong(path.name, str(end), f"values until {time[-1]:g} s")
                break
        session.put(_inputs(lab, inputs, float(b)))
        rows.append(session.read(watched))
    table = np.array(rows)
    for name, expected in columns.items():
        notes.tried["values"] += len(expected)
        found = table[:, names.index(name)]
        expected = expected[: len(found)]
        size = max(float(np.max(np.abs(expected))), 1e-9)
        error = np.abs(found - expected)
        if not np.all(error <= TOLERANCE * size):
            row = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
            notes.wrong(f"{name} at {time[row]:g} s", f"{found[row]:.9g}", f"{expected[row]:.9g}")


class Unreadable(Exception):
    """A file is no table of numbers over time: the text says where, ``found`` what is wrong."""

    def __init__(self, where: str, found: str, expected: str) -> None:
        super().__init__(where)
        self.found, self.expected = found, expected


def read_csv(path: Path) -> tuple[Array, dict[str, Array]]:
    """Times and columns by name. Raises Unreadable."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            rows = [(n, [c.strip().strip('"') for c in r])
                    for n, r in enumerate(csv.reader(file), 1) if r]
    except (UnicodeDecodeError, csv.Error, OSError) as error:
        raise Unreadable(path.name, f"cannot be read: {error}", "text in UTF-8") from None
    if len(rows) < 2:
        raise Unreadable(path.name, "has no rows", "a row of names, then rows of numbers")
    names = rows[0][1]
    if len(names) < 2:
        found = "has one column only" + ("; ';' does not separate" if ";" in names[0] else "")
        raise Unreadable(path.name, found, "a column of times and others, separated by ','")
    if again := sorted({n for n in names if names.count(n) > 1}):
        raise Unreadable(path.name, f"has the column {again[0]} more than once", "columns once")
    table = np.array([_numbers(f"{path.name}, line {n}", names, row) for n, row in rows[1:]])
    back = np.flatnonzero(np.diff(table[:, 0]) < 0.0)
    if back.size:
        line = rows[int(back[0]) + 2][0]
        raise Unreadable(f"{path.name}, line {line}", "goes back in time", "times in order")
    return table[:, 0], {n: table[:, i] for i, n in enumerate(names) if i}


def _numbers(where: str, names: list[str], row: list[str]) -> list[float]:
    """A row as finite numbers. Raises Unreadable."""
    if len(row) != len(names):
        raise Unreadable(where, f"has {len(row)} values", f"{len(names)}, as there are names")
    values = []
    for name, text in zip(names, row, strict=True):
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise Unreadable(f"{where}, column {name}", repr(text), "a finite number")
        values.append(value)
    return values


def _inputs(lab: Lab, table: tuple[Array, dict[str, Array]] | None, time: float) -> Array:
    """All inputs at a time: continuous ones interpolated, others as set last."""
    values = flat_start(lab.subject.inputs)
    if table is None:
        return values
    at = 0
    for variable in lab.subject.inputs:
        for name in variable.elements:
            if name in table[1]:
                values[at] = _value(table[0], table[1][name], time, variable.real)
            at += 1
    return values


def _value(times: Array, column: Array, time: float, smooth: bool) -> float:
    last = int(np.searchsorted(times, time, side="right")) - 1
    if not smooth or last < 0 or times[last] == time:
        return float(column[max(last, 0)])
    return float(np.interp(time, times, column))
