"""The table beside a results file, for spreadsheets: ``results.csv``, with ``results_units.csv``.

The first line of the table is its header and all others are numbers, as other tools read it, FMPy
and ``sightline verify --reference`` among them; so units and frames are in a table of their own,
with a row for each column.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py

from ..wiring.signals import Signal
from .file import CHUNK

TABLE = "results.csv"
UNITS = "results_units.csv"
ATTRIBUTES = ("unit", "frame", "description")


def write_csv(results: Path, signals: Sequence[Signal]) -> tuple[Path, Path]:
    """Write both tables: time, then every element of every signal. Raises OSError."""
    paths = results.with_name(TABLE), results.with_name(UNITS)
    names = [f"{s.instance}.{s.port.label(e)}" for s in signals for e in s.elements]
    with h5py.File(results, "r") as file:
        _write(paths[0], ["time", *names], (
            row for first in range(0, len(file["time"]), CHUNK)
            for row in _rows(file, signals, slice(first, first + CHUNK))
        ))  # fmt: skip
        told = [file["time"], *(file[s.dataset] for s in signals for _ in s.elements)]
        _write(paths[1], ["column", *ATTRIBUTES], (
            [name, *(data.attrs.get(a, "") for a in ATTRIBUTES)]
            for name, data in zip(["time", *names], told, strict=True)
        ))  # fmt: skip
    return paths


def _write(path: Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as out:
        writer = csv.writer(out)
        writer.writerow(header)
        writer.writerows(rows)


def _rows(file: Any, signals: Sequence[Signal], part: slice) -> Iterator[list[float]]:
    time = file["time"][part]
    columns = [time.tolist()]
    for signal in signals:
        values = file[signal.dataset][part].reshape(len(time), -1)
        columns += [values[:, i].tolist() for i in range(values.shape[1])]
    return (list(row) for row in zip(*columns, strict=True))
