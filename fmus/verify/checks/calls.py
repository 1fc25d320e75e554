"""Orders of calls: every legal one accepted, every illegal one refused without damage."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ..driver import Driver, good, status_name
from ..lab import Lab, first_difference, same
from ..registry import NotApplicable, Notes, check
from ..session import Ended, Refused, Session
from ..subject import Array, names_of
from ..walk import INITIALIZATION, INSTANTIATED, STEP, TERMINATED, Walk

SEQUENCES, LENGTH = 60, 30
BUDGET = 1.5  # s


def _last(driver: Driver) -> str:
    return f" ({driver.log[-1].text})" if driver.log else " (no message)"


@check("calls.lifecycle", "an instance can be freed, terminated and reset wherever that is legal")
def lifecycle(lab: Lab, notes: Notes) -> None:
    for interface in lab.subject.interfaces:
        for depth in range(4):
            for ending in ("free", "reset", "terminate"):
                if ending == "terminate" and depth < 3:
                    continue
                notes.tried["sequences"] += 1
                driver = lab.instance(interface=interface)
                for name, call in _life(lab, driver, depth, ending):
                    if not good(status := call()):
                        where = f"{interface}, {name}: {ending} after {depth} calls"
                        notes.wrong(where, status_name(status) + _last(driver), "OK")
                        break
                driver.free()


def _life(
    lab: Lab, driver: Driver, depth: int, ending: str
) -> list[tuple[str, Callable[[], int]]]:
    """The calls of a life, by name."""
    start = lab.subject.start_time
    opening: list[tuple[str, Callable[[], int]]] = [
        ("setup", lambda: driver.setup(start, None, 1e-6)),
        ("entering initialisation", driver.enter_initialization),
        ("leaving initialisation", driver.exit_initialization),
    ]
    again = [("setup", lambda: driver.setup(start)), *opening[1:]]
    endings = {"free": [], "terminate": [("terminating", driver.terminate)],
               "reset": [("reset", driver.reset), *again]}
    return [*opening[:depth], *endings[ending]]


@check("calls.legal", "random legal orders of calls are accepted")
def legal(lab: Lab, notes: Notes) -> None:
    lab.must_run()
    began = time.monotonic()
    for number in range(round(SEQUENCES * lab.effort)):
        if time.monotonic() - began > BUDGET * lab.effort and not lab.thorough:
            break
        for interface in lab.subject.interfaces:
            rng = np.random.default_rng((lab.seed, number))
            notes.tried["sequences"] += 1
            if not lab.trial(f"{interface}, sequence {number}"):
                continue
            walk = Walk(lab, lab.instance(interface=interface), rng)
            path: list[str] = []
            for _ in range(LENGTH):
                moves = walk.moves()
                move = moves[int(rng.integers(len(moves)))]
                path.append(move.name)
                status = walk.go(move)
                notes.tried["calls"] += 1
                if not good(status) or walk.unsound:
                    found = walk.unsound or status_name(status) + _last(walk.driver)
                    trail = ", ".join(path[-6:])
                    where = f"{interface}, {walk.mode}: {trail} (sequence {number})"
                    notes.wrong(where, found, "OK")
                    break
            walk.driver.free()


@dataclass(frozen=True)
class Illegal:
    """A call that must be refused in a mode of co-simulation."""

    mode: str
    name: str
    do: Callable[[Driver], int]
    sets: bool = False  # a setter: an FMU may also answer the next step


def illegal_calls(lab: Lab) -> Iterator[Illegal]:
    """Calls that the standard forbids, as far as this FMU can be asked for them."""
    h, start = lab.subject.step, lab.subject.start_time
    for mode in (INSTANTIATED, INITIALIZATION, TERMINATED):
        yield Illegal(mode, "a step", lambda d: d.do_step(start, h))
    for mode in (INSTANTIATED, STEP, TERMINATED):
        yield Illegal(mode, "leaving initialisation", lambda d: d.exit_initialization())
    for mode in (INITIALIZATION, STEP, TERMINATED):
        yield Illegal(mode, "entering initialisation", lambda d: d.enter_initialization())
    for mode in (INSTANTIATED, TERMINATED):
        yield Illegal(mode, "terminating", lambda d: d.terminate())
    if lab.subject.version == 2:
        yield Illegal(STEP, "setup of the experiment", lambda d: d.setup(start))
    yield Illegal(STEP, "a step back in time", lambda d: d.do_step(start, -h))
    yield Illegal(STEP, "a step of NaN", lambda d: d.do_step(start, math.nan))
    yield Illegal(STEP, "an infinite step", lambda d: d.do_step(start, math.inf))
    yield Illegal(STEP, "a step from NaN", lambda d: d.do_step(math.nan, h))
    yield Illegal(STEP, "a step from another time", lambda d: d.do_step(start + 1000.0 * h, h))
    yield from _illegal_values(lab)


def _illegal_values(lab: Lab) -> Iterator[Illegal]:
    subject = lab.subject
    unknown = max((v.reference for v in subject.variables), default=0) + 1000
    real = "Real" if subject.version == 2 else "Float64"
    for verb in ("Get", "Set"):
        def access(d: Driver, verb: str = verb) -> int:
            return d.transfer(verb + real, [unknown], (ctypes.c_double * 1)())

        yield Illegal(STEP, f"{verb.lower()}ting an unknown value reference", access)
    for v in subject.readable:
        if v.causality == "parameter" and v.variability == "fixed" and v.start is not None:
            yield Illegal(STEP, f"setting the fixed parameter {v.name}",
                          lambda d, v=v: d.set([v], v.start), True)  # type: ignore[misc]
            break
    for v in subject.outputs:
        if v.initial == "calculated":
            yield Illegal(STEP, f"setting the calculated output {v.name}",
                          lambda d, v=v: d.set([v], np.zeros(v.size)), True)  # type: ignore[misc]
            break


def _brought(lab: Lab, mode: str) -> Driver:
    """A new instance in a mode."""
    driver = lab.instance()
    statuses = []
    if mode != INSTANTIATED:
        statuses += [driver.setup(lab.subject.start_time), driver.enter_initialization()]
    if mode in (STEP, TERMINATED):
        statuses.append(driver.exit_initialization())
    if mode == TERMINATED:
        statuses.append(driver.terminate())
    assert all(map(good, statuses))
    return driver


@check("calls.illegal", "calls that the standard forbids are refused, and do no damage")
def illegal(lab: Lab, notes: Notes) -> None:
    if lab.interface == "me":
        raise NotApplicable("checked for co-simulation only")
    expected = lab.trajectory(lab.session(), steps=3)
    for call in illegal_calls(lab):
        notes.tried["calls"] += 1
        where = f"{call.name} in mode {call.mode}"
        if not lab.trial(where):
            continue
        driver = _brought(lab, call.mode)
        status = call.do(driver)
        if good(status) and call.sets:
            status = driver.do_step(lab.subject.start_time, lab.subject.step)
        if good(status):
            notes.wrong(where, "accepted", "an error status")
        _undamaged(lab, notes, driver, where, expected)
        driver.free()


def _undamaged(lab: Lab, notes: Notes, driver: Driver, where: str, expected: Array) -> None:
    """After a reset (a new instance after a fatal error) everything must be as ever."""
    session = lab.session() if driver.fatal else Session(driver)
    try:
        if not driver.fatal:
            session.must(driver.reset(), "reset")
        found = lab.trajectory(session, steps=3)
    except (Refused, Ended) as error:
        notes.wrong(where, f"afterwards {error}", "a usable FMU after a reset")
        return
    if not same(found, expected):
        part = first_difference(names_of(lab.watched), found, expected)
        notes.wrong(where, f"afterwards, reset, {part}", "the same as without the call")


@check("calls.storm", "calls in any order, legal or not, neither crash nor damage")
def storm(lab: Lab, notes: Notes) -> None:
    if lab.interface == "me":
        raise NotApplicable("checked for co-simulation only")
    expected = lab.trajectory(lab.session(), steps=3)
    forbidden = list(illegal_calls(lab))
    began = time.monotonic()
    for number in range(round(SEQUENCES * lab.effort)):
        if time.monotonic() - began > BUDGET * lab.effort and not lab.thorough:
            break
        notes.tried["sequences"] += 1
        if not lab.trial(where := f"random calls (sequence {number})"):
            continue
        rng = np.random.default_rng((lab.seed, number, 1))
        walk = Walk(lab, lab.instance(), rng)
        for _ in range(LENGTH):
            if walk.driver.fatal:
                break
            notes.tried["calls"] += 1
            if rng.random() < 0.4:
                forbidden[int(rng.integers(len(forbidden)))].do(walk.driver)
            else:
                moves = walk.moves()
                walk.go(moves[int(rng.integers(len(moves)))])
        _undamaged(lab, notes, walk.driver, where, expected)
        walk.driver.free()
