"""A progress bar on a terminal: simulated time, real-time factor and remaining time."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

Show = Callable[[float], None]


@contextmanager
def bar(start: float, stop: float, console: Console | None = None) -> Iterator[Show]:
    """Gives a function to call with the simulated time now and then; silent without terminal."""
    console = console or Console(stderr=True, emoji=False)
    if not console.is_terminal:
        yield lambda _: None
        return
    columns = (
        BarColumn(),
        TextColumn("t = {task.completed:.1f} of {task.total:.1f} s"),
        TextColumn("{task.fields[factor]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("", total=stop - start, factor="")
        began = time.perf_counter()

        def show(now: float) -> None:
            factor = (now - start) / max(time.perf_counter() - began, 1e-9)
            progress.update(task, completed=now - start, factor=f"{factor:.3g} x real time")

        yield show
