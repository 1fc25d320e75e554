"""Figures and the plot command: which lines, which axes, the same bytes each time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from sightline.orchestrator.config.model import Plot
from sightline.orchestrator.results.curves import chosen, curves
from sightline.orchestrator.results.file import Results, Series
from sightline.orchestrator.results.plots import draw, figure_of, rotation_angle

TIME = np.linspace(0.0, 10.0, 101)
ROWS = len(TIME)


def series(values: np.ndarray, unit: str) -> Series:
    return Series(values, unit, "", "")


@pytest.fixture
def results() -> Results:
    half = np.outer(TIME, [0.0, 0.0, 0.05])  # half the angle about z
    attitude = np.column_stack([np.sin(half), np.cos(half[:, 2])])
    still = np.tile([0.0, 0.0, 0.0, 1.0], (ROWS, 1))
    return Results(TIME, {
        "a.position": series(np.column_stack([TIME, TIME**2, -TIME]), "m"),
        "b.position": series(np.zeros((ROWS, 3)), "m"),
        "a.attitude": series(attitude, "1"),
        "b.attitude": series(still, "1"),
        "a.error": series(np.exp(-TIME), "1"),
        "b.thrust": series(np.tile([1.0, 0.5], (ROWS, 1)), "N"),
        "b.gain": series(np.zeros((ROWS, 2, 2)), "1"),
    }, True, "")  # fmt: skip


def plot(*signals: str, **more: object) -> Plot:
    return Plot(title="t", signals=list(signals), **more)  # type: ignore[arg-type]


def lines(figure: Figure) -> list[list[str]]:
    return [[str(line.get_label()) for line in axes.lines] for axes in figure.axes]


def test_globs_choose_ports_and_elements_in_the_order_asked_for(results: Results) -> None:
    assert chosen(["b.pos*", "a.position[2]"], results) == ["b.position", "a.position[2]"]
    assert [c.label for c in curves(["b.gain"], results)] == [
        "b.gain[1,1]", "b.gain[1,2]", "b.gain[2,1]", "b.gain[2,2]",
    ]  # fmt: skip


def test_histories_have_one_pair_of_axes_per_unit(results: Results) -> None:
    figure = figure_of(plot("a.error", "b.thrust", "a.position[3]"), results)
    assert lines(figure) == [["a.error"], ["b.thrust[1]", "b.thrust[2]"], ["a.position[3]"]]
    assert [a.get_ylabel() for a in figure.axes] == ["error", "thrust (N)", "position (m)"]


def test_until_ends_the_time_axis(results: Results) -> None:
    (axes,) = figure_of(plot("a.error", until=4.0), results).axes
    assert axes.get_xlim() == pytest.approx((0.0, 4.0))


def test_logarithmic_scale_shows_magnitudes(results: Results) -> None:
    (axes,) = figure_of(plot("a.position[3]", scale="log"), results).axes
    assert (axes.get_yscale(), axes.get_ylabel()) == ("log", "|position| (m)")
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), TIME)


def test_angle_is_that_of_the_rotation_between_attitudes(results: Results) -> None:
    (axes,) = figure_of(plot("a.attitude", "b.attitude", kind="angle"), results).axes
    expected = np.degrees(0.1 * TIME)
    # 1e-13: rounding of some ten operations, in degrees
    np.testing.assert_allclose(axes.lines[0].get_ydata(), expected, atol=1e-13)


def test_angle_does_not_see_the_sign_of_a_quaternion() -> None:
    one = np.array([[0.0, 0.6, 0.0, 0.8]])
    assert rotation_angle(one, -one) == 0.0


def test_trajectories_are_seen_from_the_last_signal(results: Results) -> None:
    figure = figure_of(plot("a.position", "b.position", kind="trajectory"), results)
    (axes,) = figure.axes
    assert axes.get_legend_handles_labels()[1] == [
        "a", "b", "start", "end", "shadow in the x-y plane",
    ]  # fmt: skip


def test_activity_has_a_row_per_thruster_with_its_sum(results: Results) -> None:
    figure = figure_of(plot("b.thrust", kind="activity"), results)
    sums = [t.get_text() for t in figure.axes[1].get_yticklabels()]
    assert sums == ["10", "5"]  # 1 N and 0.5 N over 10 s
    assert figure.axes[0].get_title().endswith("right: ∫|value| dt (N s)")


@pytest.mark.parametrize(("kind", "signals"), [
    ("trajectory", ["a.position"]),
    ("trajectory", ["a.position", "b.attitude"]),
    ("angle", ["a.position", "b.position"]),
])  # fmt: skip
def test_signals_that_do_not_suit_the_kind_are_refused(
    results: Results, kind: str, signals: list[str]
) -> None:
    found = ", ".join(signals)
    with pytest.raises(ValueError, match=rf"^{kind} needs two or more .* found {found}$"):
        figure_of(plot(*signals, kind=kind), results)


def test_many_lines_are_told_apart_by_their_order(results: Results) -> None:
    many = {f"c{i}.error": series(np.full(ROWS, float(i)), "1") for i in range(1, 31)}
    (axes,) = figure_of(plot("*"), Results(TIME, many, True, "")).axes
    assert axes.get_legend() is None
    assert axes.texts[0].get_text() == "30 lines,\nc1.error\n(dark) to\nc30.error\n(light)"


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_same_results_give_the_same_bytes(
    results: Results, tmp_path: Path, suffix: str
) -> None:
    contents = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        plots = [plot("a.*"), plot("b.thrust", kind="activity", file=f"b{suffix}")]
        paths = draw(tmp_path / name, plots, results, suffix)
        contents.append([p.read_bytes() for p in paths])
    assert contents[0] == contents[1]
