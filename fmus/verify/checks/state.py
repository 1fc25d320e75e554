"""Complete states: saved, restored, as bytes; and steps that are taken back."""

from __future__ import annotations

import numpy as np

from ..driver import Handle, good
from ..excitation import Excitation
from ..lab import STEPS, Lab, first_difference, same
from ..registry import NotApplicable, Notes, check
from ..session import Session
from ..subject import Array, names_of

HALF = STEPS // 2


def _require(lab: Lab, ability: str) -> None:
    if not getattr(lab.subject.interfaces[lab.interface], ability, False):
        raise NotApplicable(f"not declared ({ability})")
    if lab.interface == "me":
        raise NotApplicable("checked for co-simulation only")


def _compare(lab: Lab, notes: Notes, where: str, found: list[Array], expected: list[Array]) -> None:
    notes.tried["continuations"] += 1
    a, b = np.array(found), np.array(expected)
    if not same(a, b):
        part = first_difference(names_of(lab.watched), a, b)
        notes.wrong(where, f"differs: {part}", "the same bits as without")


def _saved(session: Session) -> Handle:
    status, state = session.driver.save()
    session.must(status, "saving the state")
    return state


@check("state.restore", "a restored state continues bit for bit")
def restore(lab: Lab, notes: Notes) -> None:
    _require(lab, "canGetAndSetFMUstate")
    course = lab.excitation
    other = Excitation(lab.subject, course.amplitude, 5)
    session = lab.begun()
    lab.continue_(session, course, 0, HALF)
    driver = session.driver
    _, middle = driver.save()
    at_middle = session.read(lab.watched)
    expected = lab.continue_(session, course, HALF, STEPS)
    session.must(driver.save()[0], "saving a second state")
    lab.continue_(session, other, STEPS, STEPS + 3)
    for attempt in ("once", "again"):
        session.must(driver.restore(middle), "restoring the state")
        _compare(lab, notes, f"values, restored {attempt}",
                 [session.read(lab.watched)], [at_middle])
        found = lab.continue_(session, course, HALF, STEPS)
        _compare(lab, notes, f"continued, restored {attempt}", found, expected)
    session.must(driver.save(middle)[0], "saving into an existing state")
    session.must(driver.drop(middle), "freeing the state")


@check("state.modes", "a state saved before or in initialisation brings that back")
def modes(lab: Lab, notes: Notes) -> None:
    _require(lab, "canGetAndSetFMUstate")
    expected = list(lab.trajectory(lab.session()))
    session = lab.session()
    driver = session.driver
    status, fresh = driver.save()
    session.must(status, "saving the state before initialisation")
    lab.trajectory(session, Excitation(lab.subject, lab.excitation.amplitude, 3))
    session.must(driver.restore(fresh), "restoring the state of before initialisation")
    _compare(lab, notes, "simulated again from before initialisation",
             list(lab.trajectory(session)), expected)


@check("state.rollback", "steps taken back leave no trace")
def rollback(lab: Lab, notes: Notes) -> None:
    _require(lab, "canGetAndSetFMUstate")
    if not lab.subject.variable_step:
        raise NotApplicable("communication steps have a fixed size")
    course = lab.excitation
    expected = lab.continue_(lab.begun(), course, 0, STEPS)
    other = Excitation(lab.subject, course.amplitude, 8)
    session = lab.begun()
    h = lab.subject.step

    def there_and_back(k: int) -> None:
        state = _saved(session)
        time = lab.subject.start_time + k * h
        for i, part in enumerate((0.37, 1.9, 0.01)[: 1 + k % 3]):
            session.put(other.at(k + i))
            session.step(part * h, time)
            time += part * h
        session.must(session.driver.restore(state), "restoring the state")
        session.must(session.driver.drop(state), "freeing the state")

    found = lab.continue_(session, course, 0, STEPS, before=there_and_back)
    _compare(lab, notes, "with a rollback of one to three steps before each", found, expected)


@check("state.serialize", "a state as bytes continues bit for bit, in another instance too")
def serialize(lab: Lab, notes: Notes) -> None:
    _require(lab, "canSerializeFMUstate")
    course = lab.excitation
    session = lab.begun()
    lab.continue_(session, course, 0, HALF)
    driver = session.driver
    _, state = driver.save()
    status, data = driver.serialize(state)
    session.must(status, "serialising the state")
    again = driver.serialize(state)[1]
    if again != data:
        notes.wrong("serialised twice", "the bytes differ", "the same bytes")
    expected = lab.continue_(session, course, HALF, STEPS)
    fresh = lab.begun()
    for where, target in (("the same instance", session), ("another instance", fresh)):
        status, back = target.driver.deserialize(data)
        target.must(status, "deserialising the state")
        target.must(target.driver.restore(back), "restoring the deserialised state")
        found = lab.continue_(target, course, HALF, STEPS)
        _compare(lab, notes, f"continued in {where}", found, expected)
    notes.tried["bytes"] = len(data)


@check("state.damaged", "bytes that are no state are refused")
def damaged(lab: Lab, notes: Notes) -> None:
    _require(lab, "canSerializeFMUstate")
    driver = lab.begun().driver
    _, state = driver.save()
    data = driver.serialize(state)[1]
    rng = np.random.default_rng(lab.seed)
    spoilt = {"no bytes": b"", "half of the bytes": data[: len(data) // 2],
              "one byte": data[:1], "random bytes": rng.bytes(len(data)),
              "zeros": bytes(len(data)), "text": b"a state of nothing " * 40}
    for what, content in spoilt.items():
        if content == data or not lab.trial(f"deserialising {what}"):
            continue
        victim = lab.begun().driver
        status, made = victim.deserialize(content)
        if good(status) and made:
            status = victim.restore(made)
        notes.tried["damaged states"] += 1
        if good(status):
            notes.wrong(f"deserialising {what}", "accepted", "an error status")
    lab.trial("")
    expected = list(lab.trajectory(lab.session()))
    _compare(lab, notes, "a new instance after that", list(lab.trajectory(lab.session())), expected)
