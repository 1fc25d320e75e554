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


def series(values: np.ndarray, unit: str, frame: str = "") -> Series:
    return Series(values, unit, frame, "")


@pytest.fixture
def results() -> Results:
    half = np.outer(TIME, [0.0, 0.0, 0.05])  # half the angle about z
    attitude = np.column_stack([np.sin(half), np.cos(half[:, 2])])
    still = np.tile([0.0, 0.0, 0.0, 1.0], (ROWS, 1))
    return Results(TIME, {
        "a.position": series(np.column_stack([TIME, TIME**2, -TIME]), "m", "inertial"),
        "b.position": series(np.zeros((ROWS, 3)), "m", "inertial"),
        "a.torque": series(np.zeros((ROWS, 3)), "N.m", "craft1"),
        "b.torque": series(np.zeros((ROWS, 3)), "N.m", "craft2"),
        "b.wheel_speed": series(np.zeros((ROWS, 3)), "rad/s"),
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
    assert lines(figure) == [["a.error"], ["b.thrust[1]", "b.thrust[2]"], ["a.position z"]]
    assert [a.get_ylabel() for a in figure.axes] == [
        "error", "thrust (N)", "position in inertial (m)",
    ]  # fmt: skip


def test_until_ends_the_time_axis(results: Results) -> None:
    (axes,) = figure_of(plot("a.error", until=4.0), results).axes
    assert axes.get_xlim() == pytest.approx((0.0, 4.0))


def test_logarithmic_scale_shows_magnitudes(results: Results) -> None:
    (axes,) = figure_of(plot("a.position[3]", scale="log"), results).axes
    assert (axes.get_yscale(), axes.get_ylabel()) == ("log", "|position| in inertial (m)")
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), TIME)


@pytest.mark.parametrize(("name", "values", "scale"), [
    ("over a few percent", 1.85 + 0.1 * np.exp(-TIME), "linear"),
    ("over a decade", 1.0 + TIME, "log"),
    ("with zeros in between", np.where(TIME > 5, 0.0, 1.0 + 0.1 * TIME), "linear"),
    ("of zeros only", 0.0 * TIME, "linear"),
])  # fmt: skip
def test_logarithmic_scale_is_for_values_that_span_a_decade(
    name: str, values: np.ndarray, scale: str
) -> None:
    results = Results(TIME, {"a.x": series(values, "m")}, True, "")
    (axes,) = figure_of(plot("a.x", scale="log"), results).axes
    assert axes.get_yscale() == scale, name


@pytest.mark.parametrize(("signals", "names", "label"), [
    (["a.attitude"], ["a.attitude x", "a.attitude y", "a.attitude z", "a.attitude w"], "attitude"),
    (["b.wheel_speed"], [f"b.wheel_speed[{i}]" for i in (1, 2, 3)], "wheel speed (rad/s)"),
    (["?.torque[1]"], ["a.torque x", "b.torque x"], "torque in craft1 and craft2 (N.m)"),
    (["a.position[2]"], ["a.position y"], "position in inertial (m)"),
])  # fmt: skip
def test_components_are_named_and_their_frame_told(
    results: Results, signals: list[str], names: list[str], label: str
) -> None:
    (axes,) = figure_of(plot(*signals), results).axes
    assert [line.get_label() for line in axes.lines] == names
    assert axes.get_ylabel() == label


@pytest.mark.parametrize(("ports", "unit", "label"), [
    (["radar.range", "approach.desired_range"], "m", "range (m)"),
    (["radar.elevation", "radar.azimuth"], "rad", "elevation, azimuth (rad)"),
    (["m.translation_lyapunov", "m.rotation_lyapunov"], "J", "lyapunov (J)"),
    (["a.p", "a.q", "a.r", "a.s"], "rad/s", "angular velocity (rad/s)"),
    (["a.p", "a.q", "a.r", "a.s"], "kg/s", "value (kg/s)"),
])  # fmt: skip
def test_axis_is_named_after_what_its_ports_share(
    ports: list[str], unit: str, label: str
) -> None:
    results = Results(TIME, {p: series(TIME, unit) for p in ports}, True, "")
    (axes,) = figure_of(plot("*"), results).axes
    assert axes.get_ylabel() == label


@pytest.mark.parametrize(("span", "label", "end"), [
    (7300.0, "time (s)", 7300.0), (129600.0, "time (h)", 36.0), (8.64e5, "time (d)", 10.0),
])  # fmt: skip
@pytest.mark.parametrize("kind", ["time", "activity"])
def test_time_is_in_a_unit_that_suits_its_span(
    span: float, label: str, end: float, kind: str
) -> None:
    results = Results(np.linspace(0.0, span, ROWS), {"a.x": series(TIME, "m")}, True, "")
    axes = figure_of(plot("a.x", kind=kind), results).axes[0]
    assert axes.get_xlabel() == label
    assert axes.get_xlim()[1] == pytest.approx(end, rel=1.01 / ROWS)  # a map ends a sample later


@pytest.mark.parametrize("kind", ["time", "activity"])
def test_a_title_of_any_length_lies_within_the_figure(results: Results, kind: str) -> None:
    signals = [f"gyro{i}.measured_angular_velocity" for i in range(12)]
    figure = figure_of(Plot(title=", ".join(signals), signals=["*"], kind=kind), results)
    figure.draw_without_rendering()
    (title,) = figure.texts
    assert title.get_text().startswith(signals[0])
    box = title.get_window_extent()
    assert box.x0 > 0
    assert box.x1 < figure.bbox.width
    assert box.y1 < figure.bbox.height


def test_twelve_elements_have_twelve_colours() -> None:
    results = Results(TIME, {"a.thrust": series(np.ones((ROWS, 12)), "N")}, True, "")
    (axes,) = figure_of(plot("a.thrust"), results).axes
    assert len({line.get_color() for line in axes.lines}) == 12


def test_of_two_vectors_the_second_lies_narrow_on_the_broad_first(results: Results) -> None:
    (axes,) = figure_of(plot("a.position", "b.position"), results).axes
    first, second = axes.lines[:3], axes.lines[3:]
    assert [x.get_color() for x in first] == [x.get_color() for x in second]
    assert all(a.get_linewidth() > 2 * b.get_linewidth() for a in first for b in second)


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
    assert figure.get_suptitle() == "t\nright: ∫|value| dt (N s)"
    assert figure.axes[-1].get_ylabel() == "thrust (N)"


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
