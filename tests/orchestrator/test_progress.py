"""The bar on a terminal."""

from __future__ import annotations

from io import StringIO

from rich.console import Console

from sightline.orchestrator.progress import bar


def test_bar_tells_time_and_rate_on_a_terminal() -> None:
    shown = StringIO()
    console = Console(file=shown, force_terminal=True, width=100)
    with bar(10.0, 20.0, console) as show:
        show(15.0)
    assert "t = 5.0 of 10.0 s" in shown.getvalue()
    assert "x real time" in shown.getvalue()


def test_nothing_is_shown_without_a_terminal() -> None:
    shown = StringIO()
    with bar(0.0, 1.0, Console(file=shown, force_terminal=False)) as show:
        show(0.5)
    assert shown.getvalue() == ""
