"""The same calls give the same bits: across instances, processes and resets."""

from __future__ import annotations

import contextlib
import os

import numpy as np

from ..excitation import Excitation
from ..lab import STEPS, Lab, first_difference, same
from ..registry import NotApplicable, Notes, check
from ..subject import Array, names_of


def _compare(lab: Lab, notes: Notes, where: str, found: Array, expected: Array) -> None:
    notes.tried["trajectories"] += 1
    if not same(found, expected):
        part = first_difference(names_of(lab.watched), found, expected)
        notes.wrong(where, f"differs: {part}", "the same bits")


@check("determinism.instances", "instances of one name agree bit for bit, one after the other")
def instances(lab: Lab, notes: Notes) -> None:
    expected = lab.trajectory(lab.session())
    for _ in range(2):
        session = lab.session()
        _compare(lab, notes, "a second instance", lab.trajectory(session), expected)
        session.driver.free()


@check("determinism.independence", "an instance does not notice others beside it")
def independence(lab: Lab, notes: Notes) -> None:
    if lab.subject.interfaces[lab.interface].canBeInstantiatedOnlyOncePerProcess:
        raise NotApplicable("only one instance per process is allowed")
    expected = lab.trajectory(lab.session())
    course, other = lab.excitation, Excitation(lab.subject, lab.excitation.amplitude, 99)
    session, beside = lab.begun(), lab.session("two").begin(inputs=other.at(0))
    rows = [session.read(lab.watched)]
    for k in range(STEPS):
        lab.continue_(beside, other, k, k + 1)
        rows += lab.continue_(session, course, k, k + 1)
        if k == STEPS // 2:
            beside.driver.free()
            beside = lab.session("three").begin(inputs=other.at(0))
            lab.continue_(beside, other, 0, k + 1)
    _compare(lab, notes, "an instance with others beside it", np.array(rows), expected)


@check("determinism.reset", "a reset instance is as a fresh one")
def reset(lab: Lab, notes: Notes) -> None:
    expected = lab.trajectory(lab.session())
    session = lab.session()
    lab.trajectory(session, Excitation(lab.subject, lab.excitation.amplitude, 7))
    for _ in range(2):
        session.must(session.driver.reset(), "reset")
        _compare(lab, notes, "after reset", lab.trajectory(session), expected)


@check("determinism.processes", "two processes agree bit for bit")
def processes(lab: Lab, notes: Notes) -> None:
    if not hasattr(os, "fork"):
        raise NotApplicable("there is no fork on this platform")
    expected = lab.trajectory(lab.session())
    data = _elsewhere(lab, expected.nbytes)
    if len(data) != expected.nbytes:
        notes.wrong("another process", "did not finish", "the same trajectory")
    else:
        found = np.frombuffer(data).reshape(expected.shape)
        _compare(lab, notes, "another process", found, expected)


def _elsewhere(lab: Lab, size: int) -> bytes:
    """The trajectory in a fork whose heap has been stirred, so that memory is not fresh zeros."""
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(reader)
        try:
            waste = [bytes([170]) * (64 << (i % 9)) for i in range(2000)]
            del waste
            data = lab.trajectory(lab.session()).tobytes()
            with os.fdopen(writer, "wb") as out:
                out.write(data)
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader, "rb") as stream:
        data = stream.read(size)  # not to its end: what the FMU forks holds the pipe open
    with contextlib.suppress(ChildProcessError):  # an FMU may have told the system to wait for it
        os.waitpid(pid, 0)
    return data
