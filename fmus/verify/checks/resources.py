"""What the FMU leaves behind: memory, open files, threads, its folder and the working one."""

from __future__ import annotations

import gc
import locale
import os
import time
from collections.abc import Callable
from pathlib import Path

from ..lab import Lab
from ..registry import NotApplicable, Notes, check
from ..session import Ended

BUDGET = 0.6  # s
SLACK = 768 << 10  # bytes that allocators may keep
PROC = Path("/proc/self")


def _memory() -> int:
    """Resident bytes of this process."""
    gc.collect()
    pages = int((PROC / "statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")


def _growth(action: Callable[[int], object], warm: int, lab: Lab) -> tuple[int, int]:
    """Bytes by which memory grows, and the number of actions."""
    for k in range(warm):
        action(k)
    before = _memory()
    began, count = time.monotonic(), 0
    while time.monotonic() - began < BUDGET * lab.effort:
        action(warm + count)
        count += 1
    return _memory() - before, count


def _require_proc() -> None:
    if not (PROC / "statm").is_file():
        raise NotApplicable("the platform has no /proc to measure by")


@check("resources.steps", "memory does not grow with the number of steps")
def steps(lab: Lab, notes: Notes) -> None:
    _require_proc()
    session, first = lab.begun(), 0
    h, start = lab.subject.step, lab.subject.start_time
    inputs = lab.excitation.at(0)

    def step(k: int) -> None:
        nonlocal session, first
        session.put(inputs)
        try:
            session.step(h, start + (k - first) * h)
        except Ended:
            lab.close()
            session, first = lab.begun(), k + 1
        session.read(lab.subject.outputs)

    grown, count = _growth(step, 200, lab)
    notes.tried["steps"] = count
    if grown > SLACK and grown > 16 * count:
        notes.wrong("memory", f"grows by {grown / count:.0f} bytes a step", "no growth")


@check("resources.instances", "instances that are freed leave no memory, files or threads")
def instances(lab: Lab, notes: Notes) -> None:
    _require_proc()

    def cycle(k: int) -> None:
        session = lab.session("cycle").begin(inputs=lab.excitation.at(0))
        session.step(lab.subject.step)
        session.read(lab.subject.outputs)
        lab.close()

    lab.must_run()
    for k in range(3):
        cycle(k)
    files, threads = _open_files(), len(list((PROC / "task").iterdir()))
    grown, count = _growth(cycle, 20, lab)
    notes.tried["instances"] = count
    if grown > SLACK and grown > 1024 * count:
        notes.wrong("memory", f"grows by {grown / count:.0f} bytes an instance", "no growth")
    if left := _open_files() - files:
        notes.wrong("open files", f"{', '.join(sorted(left)[:3])} left open", "none")
    if (more := len(list((PROC / "task").iterdir())) - threads) > 0:
        notes.wrong("threads", f"{more} left running", "none")


def _open_files() -> set[str]:
    names = set()
    for link in (PROC / "fd").iterdir():
        try:
            names.add(f"{link.name} -> {link.readlink()}")
        except OSError:
            continue  # the handle of this very listing
    return {n for n in names if "/proc/" not in n}


@check("resources.surroundings", "working directory, locale and folders stay as they were")
def surroundings(lab: Lab, notes: Notes) -> None:
    place, words = Path.cwd(), locale.setlocale(locale.LC_ALL)
    before = _files(lab.subject.folder)
    session = lab.session()
    lab.trajectory(session)
    session.driver.free()
    if Path.cwd() != place:
        notes.wrong("working directory", f"changed to {Path.cwd().name}", "unchanged")
        os.chdir(place)
    if left := sorted(p.name for p in place.iterdir()):
        notes.wrong("working directory", f"{', '.join(left[:3])} written", "nothing written")
    if locale.setlocale(locale.LC_ALL) != words:
        notes.wrong("locale", f"changed to {locale.setlocale(locale.LC_ALL)}", words)
    changed = {n for n, s in _files(lab.subject.folder).items() if before.get(n) != s}
    if changed:
        notes.wrong("the FMU's folder", f"{', '.join(sorted(changed)[:3])} written", "unchanged")


def _files(folder: Path) -> dict[str, int]:
    return {str(p.relative_to(folder)): p.stat().st_size for p in folder.rglob("*")
            if p.is_file() and "__pycache__" not in p.parts}
