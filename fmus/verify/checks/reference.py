"""A reference solution: NAME_ref.csv, with inputs in NAME_in.csv, beside the FMU or given."""

from __future__ import annotations

import csv
import itertools
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
    time, columns = read_csv(path)
    found_inputs = Path(str(path).replace("_ref.csv", "_in.csv"))
    inputs = read_csv(found_inputs) if found_inputs.is_file() and found_inputs != path else None
    owners = {e: v for v in lab.subject.readable for e in v.elements}
    for name in [n for n in columns if n not in owners]:
        notes.wrong(path.name, f"the column {name} is no variable of the FMU", "names of variables")
        del columns[name]
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


def read_csv(path: Path) -> tuple[Array, dict[str, Array]]:
    """Times and columns by name. Raises ValueError if it is not a table of numbers."""
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = [[c.strip().strip('"') for c in r] for r in csv.reader(file) if r]
    table = np.array([[float(c) for c in row] for row in rows[1:]])
    return table[:, 0], {n: table[:, i] for i, n in enumerate(rows[0]) if i}


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
