"""Chooses from results what a figure shows: the signals that globs name, and their elements."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import Problem, nearest
from ..schedule.plan import Array
from ..wiring.signals import compile_glob
from .file import Results, Series

UNIT_NORM = 1e-6  # what an attitude may be off from a unit quaternion


@dataclass(frozen=True)
class Curve:
    """One element of a signal over time; ``port`` is ``instance.port``.

    ``frame``: that of the vector whose component it is; empty if it is none.
    """

    port: str
    label: str
    unit: str
    values: Array
    frame: str = ""


def chosen(patterns: Iterable[str], results: Results) -> list[str]:
    """The ports that globs name, those of a glob in the results' order; elements as ``a.x[1]``."""
    found: dict[str, None] = {}
    for pattern in patterns:
        found |= dict.fromkeys(_match(pattern, results))
    return list(found)


def curves(names: Iterable[str], results: Results) -> list[Curve]:
    """The elements of ports, or single elements, as curves."""
    found = []
    for name in names:
        port = name if name in results.series else name.rpartition("[")[0]
        series = results.series[port]
        flat = series.values.reshape(len(results.time), -1)
        labels = element_labels(port, series.values.shape[1:])
        axes = component_names(series)
        unit = "" if series.unit == "1" else series.unit
        frame = series.frame if axes == "xyz" else ""
        found += [
            Curve(port, f"{port} {axes[i]}" if axes else label, unit, flat[:, i], frame)
            for i, label in enumerate(labels)
            if name in (port, label)
        ]
    return found


def component_names(series: Series) -> str:
    """``xyz`` of a vector in a frame, ``xyzw`` of a unit quaternion; else empty."""
    shape = series.values.shape[1:]
    if shape == (3,) and series.frame:
        return "xyz"
    if shape == (4,) and series.unit == "1":
        norms = np.linalg.norm(series.values, axis=1)
        return "xyzw" if np.all(np.abs(norms - 1.0) < UNIT_NORM) else ""
    return ""


def element_labels(port: str, shape: Sequence[int]) -> list[str]:
    """The names of a port's elements, ``a.x[1]``, ``a.x[2]``, ...; the port's if scalar."""
    if not shape:
        return [port]
    return [f"{port}[{','.join(str(i + 1) for i in place)}]" for place in np.ndindex(*shape)]


def plain(text: str) -> str:
    """A text to draw as it is: its dollars begin no mathematics."""
    return text.replace("$", r"\$")


def missing(pattern: str, results: Results) -> Problem:
    """What is wrong with a glob that names nothing."""
    remedy = nearest(pattern, results.series, "signals")
    return Problem("--signals", f'"{pattern}" names no recorded signal', remedy)


def _match(pattern: str, results: Results) -> list[str]:
    whole = compile_glob(pattern)
    ports = [name for name in results.series if whole.fullmatch(name)]
    if ports or "[" not in pattern:
        return ports
    return [
        label
        for name, series in results.series.items()
        for label in element_labels(name, series.values.shape[1:])
        if whole.fullmatch(label)
    ]
