"""Co-simulation against model exchange of the same FMU."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..lab import STEPS, Lab, deviation
from ..registry import NotApplicable, Notes, check
from ..subject import Array, Variable, names_of

TOLERANCE = 1e-4  # of a value's size: the bench's RK4 against the FMU's own solver
FLOOR = 1e-4


@check("interfaces", "co-simulation and model exchange lead to the same values")
def interfaces(lab: Lab, notes: Notes) -> None:
    if set(lab.subject.interfaces) != {"cs", "me"}:
        raise NotApplicable("the FMU offers one interface only")
    if lab.subject.description.numberOfEventIndicators:
        raise NotApplicable("state events: the bench finds them too coarsely to compare")
    watched = [v for v in lab.watched if v.real]
    expected, found = (_course(lab, interface, watched) for interface in ("cs", "me"))
    notes.tried["steps"] = len(expected) - 1
    error, column = deviation(found, expected, np.full(expected.shape[1], FLOOR))
    if error > TOLERANCE:
        row = int(np.argmax(np.abs(found - expected)[:, column]))
        notes.wrong(
            f"{names_of(watched)[column]} after step {row}",
            f"{found[row, column]:.9g} by model exchange",
            f"{expected[row, column]:.9g} as by co-simulation",
        )


def _course(lab: Lab, interface: str, watched: Sequence[Variable]) -> Array:
    """The values before and after each step, read whenever inputs have changed.

    A sampled FMU may take the values that were read at a sample instant for final.
    """
    session = lab.begun(interface=interface)
    rows = [session.read(watched)]
    for k in range(STEPS):
        session.put(lab.excitation.at(k))
        session.read(watched)
        session.step(lab.subject.step, lab.subject.start_time + k * lab.subject.step)
        rows.append(session.read(watched))
    return np.array(rows)
