"""Sampled blocks: ticks at exact multiples of the period, held outputs, noise by tick."""

from __future__ import annotations

import numpy as np
import pytest

from sightline.fmus.python.noise import fnv1a, normal_draws

from .driver import Native


def start(native: Native, period: float = 0.1, name: str = "one", at: float = 0.0, **values):  # type: ignore[no-untyped-def]
    fmu = native.instance(name)
    fmu.set(sample_period=period, **values)
    fmu.initialise(at)
    return fmu


def pull_of_tick(native: Native, tick: int, name: str = "one", seed: int = 1) -> np.ndarray:
    return normal_draws(seed, fnv1a(name), tick, 0, 3)


def test_several_ticks_in_one_step_are_all_taken(everything: Native) -> None:
    fmu = start(everything, 0.1)
    fmu.step(0.0, 1.05)
    assert fmu.get("ticks") == 11  # at 0, 0.1, ..., 1.0


@pytest.mark.parametrize("h", [0.1, 0.01, 0.03, 1 / 3, 0.7])
def test_ticks_never_drift(everything: Native, h: float) -> None:
    fmu = start(everything, 0.1)
    count = round(200.0 / h)
    for k in range(count):
        fmu.step(k * h, h)
    end = count * h
    assert fmu.get("ticks") == np.ceil(end / 0.1 - 1e-6)  # the one at the end is pending


def test_ticks_count_from_the_start_time(everything: Native) -> None:
    fmu = start(everything, 0.1, at=5.03)
    fmu.step(5.03, 0.05)
    assert fmu.get("ticks") == 1
    fmu.step(5.08, 0.1)
    assert fmu.get("ticks") == 2


def test_outputs_hold_between_ticks(everything: Native) -> None:
    fmu = start(everything, 0.1)
    fmu.set(force=[1.0, 2.0, 3.0])
    held = fmu.get("pull")
    fmu.step(0.0, 0.05)
    fmu.set(force=[9.0, 9.0, 9.0])
    np.testing.assert_array_equal(fmu.get("pull"), held)


def test_a_pending_tick_follows_inputs_that_are_set_before_it_is_read_again(
    everything: Native,
) -> None:
    fmu = start(everything, 0.1)
    fmu.set(force=[1.0, 0.0, 0.0])
    first = fmu.get("pull")
    fmu.set(force=[2.0, 0.0, 0.0])
    np.testing.assert_allclose(fmu.get("pull") - first, [1.0, 0.0, 0.0], rtol=1e-12)


def test_an_evaluation_that_was_read_stands(everything: Native) -> None:
    fmu = start(everything, 0.1)
    fmu.set(force=[1.0, 0.0, 0.0])
    read = fmu.get("pull")
    fmu.set(force=[5.0, 0.0, 0.0])
    fmu.step(0.0, 0.05)
    np.testing.assert_array_equal(fmu.get("pull"), read)
    noise = pull_of_tick(everything, 0)
    np.testing.assert_allclose(fmu.get("memory"), noise + np.array([1.0, 0.0, 0.0]), rtol=1e-14)


def test_without_a_read_the_tick_takes_the_inputs_of_departure(everything: Native) -> None:
    fmu = start(everything, 0.1)
    fmu.set(force=[5.0, 0.0, 0.0])
    fmu.step(0.0, 0.05)
    noise = pull_of_tick(everything, 0)
    np.testing.assert_allclose(fmu.get("memory"), noise + np.array([5.0, 0.0, 0.0]), rtol=1e-14)


def test_without_a_period_outputs_act_continuously(everything: Native) -> None:
    fmu = start(everything, 0.0)
    fmu.step(0.0, 0.05)
    fmu.set(force=[1.0, 2.0, 3.0])
    speed = fmu.get("speed")
    np.testing.assert_allclose(fmu.get("pull"), speed + np.array([1.0, 2.0, 3.0]), rtol=1e-15)
    assert fmu.get("ticks") == 0


@pytest.mark.parametrize("seed", [0, 1, 2**31 - 1])
@pytest.mark.parametrize("name", ["one", "näme 2"])
def test_noise_equals_that_of_numpy(everything: Native, name: str, seed: int) -> None:
    fmu = start(everything, 0.1, name, seed=seed, level=0.0)
    for tick in range(5):
        memory = fmu.get("memory")
        expected = normal_draws(seed, fnv1a(name), tick, 0, 3) - memory
        np.testing.assert_allclose(fmu.get("pull"), expected, rtol=1e-12)
        jitter = normal_draws(seed, fnv1a(name), tick, 1, 6)
        mixed = everything.model.block.start_values()["matrix"] @ jitter[:3]
        mixed = 3 * (mixed + jitter[3] * jitter[4] - jitter[5])
        np.testing.assert_allclose(fmu.get("mixed"), mixed, rtol=1e-12)
        fmu.step(tick * 0.1, 0.1)


@pytest.mark.parametrize("h", [0.1, 0.02, 0.05, 0.3])
def test_the_communication_step_changes_neither_ticks_nor_noise(
    everything: Native, h: float
) -> None:
    fmu, fine = start(everything, 0.1), start(everything, 0.1)
    for k in range(round(3.0 / h)):
        fmu.step(k * h, h)
    for k in range(300):
        fine.step(k * 0.01, 0.01)
    for name in ("ticks", "memory", "pull"):
        np.testing.assert_allclose(fmu.get(name), fine.get(name), rtol=1e-12)


def test_instances_with_other_names_or_seeds_have_other_noise(everything: Native) -> None:
    draws = {tuple(start(everything, 0.1, name, seed=seed).get("pull"))
             for name in ("a", "b") for seed in (1, 2)}
    assert len(draws) == 4
