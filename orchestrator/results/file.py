"""The results file: ``/time`` and ``/<instance>/<port>``, with units, frames and the config.

``/conversions`` lists, a line each, what the config gives in other units than the FMUs', and
``/fmus`` the FMUs by the SHA-256 of their files.

Rows are kept in memory and written now and then; what has been flushed stays readable when the
process dies. The same config gives a bit-identical file: it holds no time of day.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from types import TracebackType
from typing import Any
from urllib.parse import unquote

import h5py
import numpy as np

from ..errors import nearest
from ..schedule.plan import Array
from ..wiring.graph import SystemGraph
from ..wiring.signals import Signal
from . import space
from .claim import claimed
from .hdf5 import numbers, opened
from .provenance import fmus

FILE = "results.h5"
CHUNK = 1024  # rows
TYPES = {"real": "f8", "integer": "i4", "enumeration": "i4", "boolean": "u1"}
LONG = ("Int64", "UInt64", "UInt32")  # integers that need eight bytes


@dataclass(frozen=True)
class Column:
    """Where a signal's elements are in a row."""

    signal: Signal
    first: int
    last: int


class ResultsWriter:
    """Appends rows; ``expected`` is how many, if known.

    Raises OSError if the folder cannot be written, or another run is writing there.
    """

    def __init__(
        self,
        folder: Path,
        graph: SystemGraph,
        signals: Sequence[Signal],
        config: str,
        expected: int | None = None,
    ) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        with ExitStack() as stack:
            stack.enter_context(claimed(folder))
            self._begin(folder, graph, signals, config, expected)
            self._claim = stack.pop_all()

    def _begin(
        self,
        folder: Path,
        graph: SystemGraph,
        signals: Sequence[Signal],
        config: str,
        expected: int | None,
    ) -> None:
        """Begin an empty file in place of any before. Raises OSError."""
        self.path = folder / FILE
        self.path.unlink(missing_ok=True)
        self.samples = 0
        self.columns = columns_of(signals)
        self._chunk = min(CHUNK, expected or CHUNK)
        self._make_room(len(config.encode()) + space.NODE * 2 * (len(signals) + len(graph.nodes)))
        self._file = h5py.File(self.path, "w", libver="earliest", track_order=True)
        self._file["config"] = config  # an attribute holds 64 kB at most
        self._file["conversions"] = "\n".join(graph.conversions)
        self._file["fmus"] = "\n".join(fmus(graph))
        self._file.attrs["sightline_version"] = _version()
        self._file.attrs["complete"] = False
        self._file.attrs["steps"] = self._file.attrs["rejected_steps"] = 0
        self._time = self._dataset("time", (), "f8", {"unit": "s", "description": "time"})
        for instance in dict.fromkeys(c.signal.instance for c in self.columns):
            self._file.create_group(instance, track_order=True)
        self._datasets = [self._of(graph, c.signal) for c in self.columns]
        self._file.flush()

    def append(self, times: Array, rows: Array) -> None:
        """Write rows of values and flush them."""
        count = len(times)
        if not count:
            return
        self._take_room(count)
        first, self.samples = self.samples, self.samples + count
        for dataset in (self._time, *self._datasets):
            dataset.resize(self.samples, axis=0)
        self._time[first:] = times
        for column, dataset in zip(self.columns, self._datasets, strict=True):
            shape = (count, *column.signal.port.shape)
            dataset[first:] = rows[:, column.first:column.last].reshape(shape)
        self._file.flush()
        os.truncate(self.path, self._file.id.get_filesize())

    def complete(self, steps: int, rejected: int) -> None:
        """Mark that the run reached its stop time, by so many steps."""
        self._file.attrs["complete"] = True
        self._file.attrs["steps"] = steps
        self._file.attrs["rejected_steps"] = rejected

    def close(self) -> None:
        """Close the file."""
        try:
            self._file.close()
        finally:
            self._claim.close()

    def _make_room(self, count: int) -> None:
        """Begin an empty file if there will be room for so many bytes. Raises OSError."""
        self.path.touch()
        try:
            space.take(self.path, 0, count + space.SLACK)
        except OSError:
            self.path.unlink()
            raise

    def _take_room(self, count: int) -> None:
        """Have room for so many more rows. Raises OSError."""
        chunks = -(-(self.samples + count) // self._chunk) - -(-self.samples // self._chunk)
        values = 1 + sum(c.last - c.first for c in self.columns)
        each = 8 * self._chunk * values + space.NODE * (1 + len(self.columns))
        space.take(self.path, self._file.id.get_filesize(), chunks * each + space.SLACK)

    def __enter__(self) -> ResultsWriter:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _of(self, graph: SystemGraph, signal: Signal) -> Any:
        node = graph.nodes[graph.index[signal.instance]]
        port = signal.port
        attributes = {
            "unit": str(port.unit) if port.unit else "",
            "frame": node.frame(port) or port.frame,
            "description": port.description,
        }
        kind = "i8" if port.type in LONG else TYPES[port.kind]
        return self._dataset(signal.dataset, port.shape, kind, attributes)

    def _dataset(
        self, name: str, shape: tuple[int, ...], kind: str, attributes: Mapping[str, str]
    ) -> Any:
        dataset = self._file.create_dataset(
            name,
            shape=(0, *shape),
            maxshape=(None, *shape),
            chunks=(self._chunk, *shape),
            dtype=kind,
            track_times=False,
        )
        dataset.attrs.update(attributes)
        return dataset


class UnknownSignal(KeyError):
    """Results hold no signal of this ``name``; ``signals``: those that they hold."""

    def __init__(self, name: str, signals: Iterable[str]) -> None:
        super().__init__(name)
        self.name, self.signals = name, tuple(signals)

    def __str__(self) -> str:
        remedy = nearest(self.name, self.signals, "signals")
        return f'the results hold no signal "{self.name}"; {remedy}'


@dataclass(frozen=True)
class Series:
    """One recorded signal: values have the shape (samples, *port shape)."""

    values: Array
    unit: str
    frame: str
    description: str


@dataclass(frozen=True)
class Results:
    """A results file in memory: ``results["craft1.position"]`` is an array over ``time``.

    ``steps``: how many were taken, if complete; ``rejected``: those that error control took again.
    """

    time: Array
    series: Mapping[str, Series]
    complete: bool
    config: str
    conversions: tuple[str, ...] = ()
    fmus: tuple[str, ...] = ()
    steps: int = 0
    rejected: int = 0

    def __getitem__(self, name: str) -> Array:
        """The values of a signal. Raises UnknownSignal, a KeyError."""
        return self._of(name).values

    def unit(self, name: str) -> str:
        """The unit of a signal. Raises UnknownSignal, a KeyError."""
        return self._of(name).unit

    def _of(self, name: str) -> Series:
        if name not in self.series:
            raise UnknownSignal(name, self.series)
        return self.series[name]

    def until(self, time: float) -> Results:
        """The results up to a time."""
        rows = int(np.searchsorted(self.time, time, side="right"))
        series = {n: replace(s, values=s.values[:rows]) for n, s in self.series.items()}
        return replace(self, time=self.time[:rows], series=series)


def read(path: Path) -> Results:
    """Read a results file, complete or not. Raises OSError if it is none."""
    with opened(path) as file:
        found: dict[str, Series] = {}
        for instance in (n for n in file if isinstance(file[n], h5py.Group)):
            for name, data in file[instance].items():
                attributes = (str(data.attrs[a]) for a in ("unit", "frame", "description"))
                found[f"{instance}.{unquote(name)}"] = Series(numbers(data), *attributes)
        texts = (file[n].asstr()[()] for n in ("config", "conversions", "fmus"))
        config, conversions, fmus = texts
        time = numbers(file["time"])
        rows = min([len(time), *(len(s.values) for s in found.values())])  # whole ones, if killed
        found = {n: replace(s, values=s.values[:rows]) for n, s in found.items()}
        return Results(
            np.ravel(time)[:rows], found, bool(file.attrs["complete"]), config,
            tuple(conversions.splitlines()), tuple(fmus.splitlines()), int(file.attrs["steps"]),
            int(file.attrs["rejected_steps"]),
        )  # fmt: skip


def holding(paths: Iterable[Path], rows: int) -> Path | None:
    """The first of some files that holds so many rows; None if none does."""
    for path in paths:
        if path.is_file():
            with opened(path) as file:
                if len(file["time"]) >= rows:
                    return path
    return None


def copy_rows(path: Path, rows: int, writer: ResultsWriter) -> None:
    """Write the first rows of another file with the same signals. Raises OSError."""
    with opened(path) as file:
        if len(file["time"]) < rows:
            raise OSError(f"{path} has {len(file['time'])} rows, not {rows}")
        for first in range(0, rows, CHUNK):
            part = slice(first, min(first + CHUNK, rows))
            times = file["time"][part]
            values = np.empty((len(times), writer.columns[-1].last if writer.columns else 0))
            for column in writer.columns:
                data = file[column.signal.dataset][part]
                values[:, column.first:column.last] = data.reshape(len(times), -1)
            writer.append(times, values)


def columns_of(signals: Sequence[Signal]) -> list[Column]:
    ends = np.cumsum([0, *(len(s.elements) for s in signals)])
    return [
        Column(s, int(a), int(b)) for s, a, b in zip(signals, ends[:-1], ends[1:], strict=True)
    ]


def _version() -> str:
    from importlib.metadata import version

    return version("sightline")
