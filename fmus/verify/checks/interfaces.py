"""Co-simulation against model exchange of the same FMU.

Neither standard bounds the error of the solver inside co-simulation. Where the trajectories part,
that is forgiven as far as the crudest consistent solver errs: forward Euler with one step for each
communication step. The equations, asked at the same states, must agree all the same.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..lab import STEPS, Lab, deviation
from ..registry import NotApplicable, Notes, check
from ..session import Session
from ..subject import Array, Variable, names_of

TOLERANCE = 1e-4  # of a value's size: the bench's RK4 against the FMU's own solver
FLOOR = 1e-4
FORGIVEN = 2.0  # errors of forward Euler: other solvers of first order err as much the other way
EQUAL = 1e-9  # of a value's size: the same equations, compiled twice


@check("interfaces", "co-simulation and model exchange lead to the same values")
def interfaces(lab: Lab, notes: Notes) -> None:
    if set(lab.subject.interfaces) != {"cs", "me"}:
        raise NotApplicable("the FMU offers one interface only")
    if lab.subject.description.numberOfEventIndicators:
        raise NotApplicable("state events: the bench finds them too coarsely to compare")
    watched = [v for v in lab.watched if v.real]
    expected, found = (_course(lab, lab.begun(interface=i), watched) for i in ("cs", "me"))
    notes.tried["steps"] = len(expected) - 1
    error, column = deviation(found, expected, np.full(expected.shape[1], FLOOR))
    if error <= TOLERANCE:
        return
    crude = _course(lab, lab.begun(interface="me", crude=True), watched)
    apart, allowed = (np.max(np.abs(x - found), axis=0) for x in (expected, crude))
    size = np.maximum(np.max(np.abs(found), axis=0), FLOOR)
    excess = apart - FORGIVEN * allowed - TOLERANCE * size
    if np.all(excess <= 0.0):
        notes.tried["values that differ as the error of a solver"] = int(
            np.sum(apart > TOLERANCE * size))
        _equations(lab, notes, watched)
        return
    column = int(np.argmax(excess / size))
    row = int(np.argmax(np.abs(found - expected)[:, column]))
    notes.wrong(
        f"{names_of(watched)[column]} after step {row}",
        f"{found[row, column]:.9g} by model exchange",
        f"{expected[row, column]:.9g} as by co-simulation",
    )


def _course(lab: Lab, session: Session, watched: Sequence[Variable]) -> Array:
    """The values before and after each step, read whenever inputs have changed.

    A sampled FMU may take the values that were read at a sample instant for final.
    """
    rows = [session.read(watched)]
    for k in range(STEPS):
        session.put(lab.excitation.at(k))
        session.read(watched)
        session.step(lab.subject.step, lab.subject.start_time + k * lab.subject.step)
        rows.append(session.read(watched))
    return np.array(rows)


def _equations(lab: Lab, notes: Notes, watched: Sequence[Variable]) -> None:
    """Let model exchange take over the states of co-simulation after each step, and compare."""
    slave, model = lab.begun(interface="cs"), lab.begun(interface="me")
    names = names_of(watched)
    for k in range(STEPS):
        for session in (slave, model):
            session.put(lab.excitation.at(k))
            session.read(watched)
            session.step(lab.subject.step, lab.subject.start_time + k * lab.subject.step)
        at_event = model.in_event
        model.leave_event_mode()
        model.must(model.driver.set_states(slave.read(lab.subject.states)), "setting the states")
        if at_event:
            continue  # co-simulation handles it when the next step departs
        found, expected = model.read(watched), slave.read(watched)
        size = np.maximum(np.abs(expected), FLOOR)
        error = np.abs(found - expected) / size
        if error.size and not error.max() <= EQUAL:
            column = int(np.argmax(error))
            notes.wrong(
                f"{names[column]} after step {k + 1}, at the same states",
                f"{found[column]:.9g} by model exchange",
                f"{expected[column]:.9g} as by co-simulation",
            )
            return
