"""Co-simulation against model exchange of the same FMU."""

from __future__ import annotations

import numpy as np

from ..lab import Lab, deviation
from ..registry import NotApplicable, Notes, check
from ..subject import names_of

TOLERANCE = 1e-4  # of a value's size: the bench's RK4 against the FMU's own solver
FLOOR = 1e-4


@check("interfaces", "co-simulation and model exchange lead to the same values")
def interfaces(lab: Lab, notes: Notes) -> None:
    if set(lab.subject.interfaces) != {"cs", "me"}:
        raise NotApplicable("the FMU offers one interface only")
    if lab.subject.description.numberOfEventIndicators:
        raise NotApplicable("state events: the bench finds them too coarsely to compare")
    watched = [v for v in lab.watched if v.real]
    expected = lab.trajectory(lab.session(interface="cs"), watched=watched)
    found = lab.trajectory(lab.session(interface="me"), watched=watched)
    notes.tried["steps"] = len(expected) - 1
    error, column = deviation(found, expected, np.full(expected.shape[1], FLOOR))
    if error > TOLERANCE:
        row = int(np.argmax(np.abs(found - expected)[:, column]))
        notes.wrong(
            f"{names_of(watched)[column]} after step {row}",
            f"{found[row, column]:.9g} by model exchange",
            f"{expected[row, column]:.9g} as by co-simulation",
        )
