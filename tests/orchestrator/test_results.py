"""The results file: the order of signals, any length of config, the same bytes however written."""

from __future__ import annotations

import csv
import hashlib
from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import ResultsWriter, holding, read
from sightline.orchestrator.results.table import write_csv
from sightline.orchestrator.system import System

from .conftest import variable


@pytest.fixture
def system(write, make_fmu) -> System:
    make_fmu("plant", [
        variable("z", "output", unit="m"), *[variable(f"a[{i}]", "output") for i in (1, 2)],
        variable("on", "output", "Boolean"),
    ])  # fmt: skip
    plant = 'fmu = "plant.fmu"'
    return System.from_toml(write(q=plant, p=plant))


def rows(count: int) -> np.ndarray:
    return np.arange(8.0 * count).reshape(count, 8) % 2.0


def test_signals_come_in_the_order_of_the_system(system, tmp_path: Path) -> None:
    with ResultsWriter(tmp_path, system.graph, system.selection.recorded, "") as writer:
        writer.append(np.array([0.0]), rows(1))
    assert list(read(writer.path).series) == ["q.z", "q.a", "q.on", "p.z", "p.a", "p.on"]


def test_config_of_any_length_is_kept(system, tmp_path: Path) -> None:
    config = "# ä\n" * 100_000
    with ResultsWriter(tmp_path, system.graph, system.selection.recorded, config) as writer:
        pass
    assert read(writer.path).config == config


def test_bytes_do_not_depend_on_when_rows_are_written(system, tmp_path: Path) -> None:
    contents = []
    for name, part in (("a", 1), ("b", 337), ("c", 1000)):
        with ResultsWriter(
            tmp_path / name, system.graph, system.selection.recorded, "", 5000
        ) as writer:
            for first in range(0, 5000, part):
                count = min(part, 5000 - first)
                writer.append(np.arange(first, first + count) * 0.1, rows(count))
            writer.complete(5000, 0)
        contents.append(writer.path.read_bytes())
    assert contents[0] == contents[1] == contents[2]


def test_first_file_with_enough_rows_is_found(system, tmp_path: Path) -> None:
    for name, count in (("a", 2), ("b", 5)):
        with ResultsWriter(
            tmp_path / name, system.graph, system.selection.recorded, ""
        ) as writer:
            writer.append(np.arange(float(count)), rows(count))
    paths = [tmp_path / n / "results.h5" for n in ("gone", "a", "b")]
    assert holding(paths, 2) == paths[1]
    assert holding(paths, 3) == paths[2]
    assert holding(paths, 6) is None


def test_results_until_a_time_are_cut(system, tmp_path: Path) -> None:
    with ResultsWriter(tmp_path, system.graph, system.selection.recorded, "") as writer:
        writer.append(np.arange(5.0), rows(5))
    cut = read(writer.path).until(2.0)
    assert (list(cut.time), cut["q.a"].shape) == ([0.0, 1.0, 2.0], (3, 2))
    assert cut.unit("q.z") == "m"


def test_an_unknown_signal_names_the_nearest(system, tmp_path: Path) -> None:
    with ResultsWriter(tmp_path, system.graph, system.selection.recorded, "") as writer:
        pass
    results = read(writer.path)
    told = r'^the results hold no signal "q.zz"; did you mean .*q.z.*\?$'
    for asked in (results.__getitem__, results.unit):
        with pytest.raises(KeyError, match=told):
            asked("q.zz")


def test_table_has_numbers_below_its_header_and_units_beside_it(system, tmp_path: Path) -> None:
    signals = system.selection.recorded
    with ResultsWriter(tmp_path, system.graph, signals, "") as writer:
        writer.append(np.array([0.0, 0.5]), rows(2))
    table, units = write_csv(writer.path, signals)
    found = np.genfromtxt(table, delimiter=",", names=True, deletechars="")
    np.testing.assert_array_equal(found["time"], [0.0, 0.5])
    with units.open(encoding="utf-8") as file:
        told = {row["column"]: row["unit"] for row in csv.DictReader(file)}
    assert tuple(told) == found.dtype.names
    assert (told["time"], told["q.z"], told["q.a[2]"]) == ("s", "m", "")


def test_fmus_are_kept_by_the_content_of_their_files(system, tmp_path: Path) -> None:
    with ResultsWriter(tmp_path / "out", system.graph, system.selection.recorded, "") as writer:
        pass
    content = hashlib.sha256((tmp_path / "plant.fmu").read_bytes()).hexdigest()
    assert read(writer.path).fmus == (f"{content} plant: q, p",)
