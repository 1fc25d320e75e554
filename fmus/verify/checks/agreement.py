"""FMUs of one model: FMI 2.0 and 3.0, Python and native give the same values."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..excitation import Excitation
from ..lab import Lab, deviation
from ..registry import NotApplicable, Notes, check
from ..subject import Subject, Variable

TOLERANCE = 1e-9  # of a value's size
FLOOR = 1e-3  # values below count as of this size: they are sums that cancel


@check("agreement", "FMUs of the same model lead to the same values")
def agreement(lab: Lab, notes: Notes) -> None:
    if not lab.others:
        raise NotApplicable("no other FMU of this model was checked before")
    for other in (o for o in lab.others if o.interfaces):
        notes.tried["FMUs"] += 1
        _ports(lab.subject, other, notes)
        _values(lab, replace(lab, subject=other, _made=[]), notes)


def _elements(subject: Subject, *causalities: str) -> dict[str, Variable]:
    return {e: v for v in subject.of(*causalities) for e in v.elements}


def _ports(subject: Subject, other: Subject, notes: Notes) -> None:
    for causality in ("input", "output", "parameter"):
        own, theirs = (_elements(s, causality) for s in (subject, other))
        for name in sorted(own.keys() ^ theirs.keys())[:5]:
            where = subject.path if name in own else other.path
            notes.wrong(name, f"{causality} of {where.name} only", "the same ports in both")
        for name in own.keys() & theirs.keys():
            if own[name].unit != theirs[name].unit:
                notes.wrong(name, f"unit {own[name].unit}", theirs[name].unit)


def _values(lab: Lab, other: Lab, notes: Notes) -> None:
    amplitude = min(lab.excitation.amplitude, other.excitation.amplitude)
    rows = []
    common = [n for n in _elements(lab.subject, "output") if n in
              _elements(other.subject, "output")]
    for bench in (lab, other):
        course = Excitation(bench.subject, amplitude, lab.seed)
        outputs = bench.subject.outputs
        table = bench.trajectory(bench.session(), course, h=lab.subject.step, watched=outputs)
        names = [e for v in outputs for e in v.elements]
        rows.append(table[:, [names.index(n) for n in common]])
    other.close()
    error, column = deviation(rows[0], rows[1], np.full(len(common), FLOOR))
    if not error <= TOLERANCE:
        row = int(np.argmax(np.abs(rows[0] - rows[1])[:, column]))
        notes.wrong(
            f"{common[column]} after step {row}", f"{rows[0][row, column]:.17g}",
            f"{rows[1][row, column]:.17g} as {other.subject.path.name}",
        )
