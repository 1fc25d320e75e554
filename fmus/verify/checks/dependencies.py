"""Declared dependencies: an output that is declared independent of an input stays as it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..driver import good
from ..excitation import ports
from ..lab import Lab
from ..registry import NotApplicable, Notes, check
from ..session import Session
from ..subject import Array, Variable


@check("dependencies", "outputs declared independent of an input do not change with it")
def dependencies(lab: Lab, notes: Notes) -> None:
    subject = lab.subject
    if not subject.inputs:
        raise NotApplicable("the FMU has no numeric inputs")
    declared = {u.variable: u.dependencies for u in subject.structure("outputs")
                if u.variable in subject.outputs and u.dependencies is not None}
    if not declared:
        raise NotApplicable("no dependencies are declared: all are assumed")
    session = lab.begun()
    course = lab.excitation
    for k in range(3):
        lab.continue_(session, course, k, k + 1)
        _perturb_all(session, course.at(k), declared, notes)
        session.put(course.at(k))


def _perturb_all(
    session: Session, inputs: Array, declared: Mapping[Variable, tuple[Variable, ...]],
    notes: Notes,
) -> None:  # fmt: skip
    outputs = list(declared)
    variables = session.subject.inputs
    owners = [v for v in variables for _ in range(v.size)]
    before = session.read(outputs)
    for port in ports(variables):
        for moved, members in _moves(inputs, port, owners):
            status = session.driver.set(variables, moved)
            status, after = session.driver.get(outputs) if good(status) else (status, before)
            if not good(status):
                notes.tried["perturbations refused"] += 1
                session.driver.set(variables, inputs)
                continue
            notes.tried["perturbations"] += 1
            if not np.all(np.isfinite(after)):
                names = ", ".join(dict.fromkeys(m.name for m in members))
                notes.wrong(names, "outputs that are not finite, with status OK",
                            "an error status, or finite values")
                continue
            at = 0
            for output in outputs:
                part = slice(at, at + output.size)
                at += output.size
                known = declared[output]
                unchanged = np.array_equal(before[part], after[part], equal_nan=True)
                if not unchanged and not any(m in known for m in members):
                    names = ", ".join(dict.fromkeys(m.name for m in members))
                    notes.wrong(output.name, f"changes with {names}",
                                "no change: no such dependency is declared", "declare it")
        session.driver.set(variables, inputs)


def _moves(
    inputs: Array, port: list[int], owners: Sequence[Variable]
) -> list[tuple[Array, list[Variable]]]:
    """The inputs with one scalar moved, for each scalar; or the whole port if it is a direction."""
    values = inputs[port]
    result = []
    norm = float(np.linalg.norm(values))
    if len(port) in (3, 4) and abs(norm - 1.0) < 1e-9:
        moved = inputs.copy()
        turned = values + 1e-3 * np.cos(np.arange(len(port)))
        moved[port] = turned / np.linalg.norm(turned)
        return [(moved, [owners[i] for i in port])]
    for i in port:
        moved = inputs.copy()
        owner = owners[i]
        if owner.real:
            moved[i] += 1e-3 * max(abs(moved[i]), 1.0)
            if moved[i] > owner.max:
                moved[i] = inputs[i] - 1e-3 * max(abs(inputs[i]), 1.0)
        elif owner.type == "Boolean":
            moved[i] = 1.0 - moved[i]
        else:
            moved[i] += 1.0 if moved[i] < owner.max else -1.0
        result.append((moved, [owner]))
    return result
