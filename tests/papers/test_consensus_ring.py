"""A ring of spacecraft under the attitude consensus law, co-simulated from one template."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.components.maths import rotate
from sightline.orchestrator.results.file import Results
from sightline.orchestrator.results.plots import rotation_angle
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "consensus_ring"
INERTIA = np.array([5.0, 4.0, 1.0])  # kg m2
LARGEST = {  # largest angle between neighbours by DOP853 at 1e-12, rad
    0: 3.086556, 1: 3.104390, 5: 3.092024, 10: 2.105170, 20: 0.796031, 50: 5.40238e-2,
    100: 1.393995e-3, 200: 2.295378e-6,
}  # fmt: skip
TWISTED = {0: 3.086556, 5: 2.116800, 10: 1.447811, 20: 0.998579, 50: 0.651598, 200: 0.629608}
MOST_SPIN = np.sqrt(0.5 * (1.0 - np.cos(2.0 * np.pi / 10)) / (5.0 - 1.0))  # rad/s


@pytest.fixture(scope="module")
def ring(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The ring of ten with its monitor: 200 s at 10 ms."""
    return System.from_toml(EXAMPLE / "monitored.toml").simulate(tmp_path_factory.mktemp("ring"))


@pytest.fixture(scope="module")
def twisted(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The ring of ten whose spring acts the short way round."""
    return System.from_toml(EXAMPLE / "twisted.toml").simulate(tmp_path_factory.mktemp("twisted"))


def of_all(results: Results, port: str, craft: int = 10) -> np.ndarray:
    """A port of every craft: sample, craft, element."""
    return np.stack([results[f"craft{i}.{port}"] for i in range(1, craft + 1)], axis=1)


def to_the_next(results: Results) -> np.ndarray:
    """Angle from each craft to the next one of the ring: sample, craft."""
    attitudes = of_all(results, "attitude")
    pairs = zip(attitudes.swapaxes(0, 1), np.roll(attitudes, -1, axis=1).swapaxes(0, 1),
                strict=True)  # fmt: skip
    return np.stack([rotation_angle(one, other) for one, other in pairs], axis=1)


def momentum(results: Results, craft: int = 10) -> np.ndarray:
    """Σ C_i^T I_b ω_i: sample, element."""
    own = of_all(results, "angular_velocity", craft) * INERTIA
    turned = rotate(np.moveaxis(of_all(results, "attitude", craft), -1, 0), np.moveaxis(own, -1, 0))
    return np.sum(turned, axis=-1).T


def at(results: Results, time: float) -> int:
    return int(np.argmin(np.abs(results.time - time)))


@pytest.mark.parametrize("time", LARGEST)
def test_the_largest_angle_is_within_1_percent_of_the_table(ring: Results, time: float) -> None:
    angle = to_the_next(ring)[at(ring, time)].max()
    assert angle == pytest.approx(LARGEST[time], rel=0.01)


def test_the_monitor_sees_the_largest_angle(ring: Results) -> None:
    largest = to_the_next(ring).max(axis=1)
    np.testing.assert_allclose(ring["monitor.relative_angle"], largest, rtol=1e-6, atol=1e-9)


def test_all_attitudes_and_angular_velocities_agree_at_the_end(ring: Results) -> None:
    attitudes, rates = of_all(ring, "attitude")[-1], of_all(ring, "angular_velocity")[-1]
    # neighbours 2.3e-6 rad apart, five edges across: at most 1.2e-5
    np.testing.assert_allclose(attitudes, attitudes[[0] * 10], rtol=0, atol=1.2e-5)
    np.testing.assert_allclose(rates, rates[[0] * 10], rtol=0, atol=1e-6)


def test_the_common_body_keeps_the_momentum_and_goes_on_turning(ring: Results) -> None:
    own = of_all(ring, "angular_velocity")[-1, 0]
    common = rotate(of_all(ring, "attitude")[-1, 0], 10.0 * INERTIA * own)
    np.testing.assert_allclose(common, momentum(ring)[0], atol=1e-3)  # drift of held torques
    assert np.linalg.norm(own) > 0.04  # rad/s


def test_the_energy_never_rises(ring: Results) -> None:
    assert np.diff(ring["monitor.energy"]).max() < 1e-12  # J; rounding of 0.03 J


def test_the_energy_falls_at_the_rate_of_its_formula(ring: Results) -> None:
    settled = ring.time > 5.0  # s; before, 0.5 s between samples are too few for a difference
    slope = np.gradient(ring["monitor.energy"], ring.time, edge_order=2)[settled]
    rate = ring["monitor.energy_rate"][settled]
    np.testing.assert_allclose(slope, rate, rtol=0, atol=0.01 * np.max(np.abs(rate)))


def drift(folder: Path, step: float, count: int) -> float:
    """Change of the momentum in 10 s."""
    settings = {"repeat.i": count, "simulation.step": step, "simulation.stop_time": 10.0}
    results = System.from_toml(EXAMPLE / "system.toml", settings).simulate(folder)
    L = momentum(results, count)
    return float(np.linalg.norm(L[-1] - L[0]))


def test_the_momentum_drifts_with_the_step_of_the_held_torques_only(tmp_path: Path) -> None:
    drifts = [drift(tmp_path, step, 10) for step in (0.02, 0.01, 0.005)]
    ratios = np.array(drifts[:-1]) / drifts[1:]
    np.testing.assert_allclose(ratios, 2.0, rtol=0.05)  # first order, with its h^2 remainder


def test_a_ring_of_fifty_keeps_its_momentum_too(tmp_path: Path) -> None:
    assert drift(tmp_path, 0.01, 50) < 5e-3  # kg m2/s, of 50 craft with torques up to 1 N m


@pytest.mark.parametrize("time", TWISTED)
def test_the_twisted_ring_is_within_1_percent_of_its_table(twisted: Results, time: float) -> None:
    angle = to_the_next(twisted)[at(twisted, time)].max()
    assert angle == pytest.approx(TWISTED[time], rel=0.01)


def test_with_the_nearer_sign_this_start_stays_twisted_by_36_degrees(twisted: Results) -> None:
    angles = np.degrees(to_the_next(twisted)[-1])
    np.testing.assert_allclose(angles, 36.0, atol=0.2)  # the slow common turning bends it by 0.1


@pytest.mark.parametrize(("share", "grows"), [(0.85, False), (1.15, True)])
def test_agreement_in_a_spin_about_the_minor_axis_holds_up_to_its_bound(
    tmp_path: Path, share: float, grows: bool
) -> None:
    config = tmp_path / "spin.toml"
    config.write_text(f"""
extends = '{EXAMPLE / "system.toml"}'
plots = []
[simulation]
step = 0.05
stop_time = 300.0
[repeat.i.instances."craft{{i}}".start]
attitude = [0.0, 0.0, 0.0, 1.0]
angular_velocity = [0.0, 0.0, {share * MOST_SPIN}]
[instances.craft1.start]
attitude = [0.01, 0.0, 0.0, 0.99995]
""", encoding="utf-8")
    largest = to_the_next(System.from_toml(config).simulate(tmp_path)).max(axis=1)
    assert (largest[-1] > 2.0 * largest[len(largest) // 3]) == grows
