"""Units in FMI terms against their definitions."""

from __future__ import annotations

import math
import re

import pytest

from sightline.components import Component, Input, Output
from sightline.fmus.fmi2 import render
from sightline.fmus.model import model_of
from sightline.fmus.units import UnitError, unit


@pytest.mark.parametrize(
    ("name", "exponents", "factor"),
    [
        ("1", {}, 1.0),
        ("m", {"m": 1}, 1.0),
        ("m/s2", {"m": 1, "s": -2}, 1.0),
        ("N.m", {"kg": 1, "m": 2, "s": -2}, 1.0),
        ("kg.m2", {"kg": 1, "m": 2}, 1.0),
        ("N.m.s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}, 1.0),
        ("rad/s", {"s": -1, "rad": 1}, 1.0),
        ("deg", {"rad": 1}, math.pi / 180),
        ("km", {"m": 1}, 1000.0),
        ("g", {"kg": 1}, 1e-3),
        ("m3/s2", {"m": 3, "s": -2}, 1.0),
        ("rpm", {"s": -1, "rad": 1}, 2 * math.pi / 60),
        ("g0", {"m": 1, "s": -2}, 9.80665),
        ("%", {}, 0.01),
    ],
)
def test_unit_has_the_exponents_and_factor_of_its_definition(
    name: str, exponents: dict[str, int], factor: float
) -> None:
    found = unit(name)
    assert found.exponents == exponents
    assert found.factor == pytest.approx(factor, rel=1e-15)


def test_a_spectral_density_has_no_integer_exponents() -> None:
    assert unit("rad/s/sqrt(Hz)").exponents is None


@pytest.mark.parametrize("name", ["deg/sqrt(h)", "deg/√h", "deg/√(h)"])
def test_an_angle_random_walk_has_half_exponents(name: str) -> None:
    found = unit(name)
    assert found.exponents is None
    assert found.powers == {"s": -0.5, "rad": 1.0}
    assert found.factor == pytest.approx(math.pi / 180 / 60, rel=1e-15)


class Heater(Component):
    """A block with a unit that does not start at 0."""

    temperature = Input((), "degC")
    measured = Output((), "degC")

    def outputs(self, temperature):
        return {"measured": temperature}


def test_celsius_starts_at_its_own_zero() -> None:
    assert (unit("degC").factor, unit("degC").offset) == (1.0, 273.15)
    text = render(model_of(Heater(), None, derivatives=False), "token", {"CoSimulation": {}})
    assert b'<BaseUnit K="1" offset="273.15" />' in text


@pytest.mark.parametrize("name", ["fnord", "", "deg ∕ h", "sqrt(", "5 m", "m + s"])
def test_what_is_no_unit_is_named(name: str) -> None:
    with pytest.raises(UnitError, match=re.escape(f"{name!r} is not a unit")):
        unit(name)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("Nm", "N.m"), ("Nms", "N.m.s"), ("mNm", "mN.m"), ("Nmm", "N.mm"), ("Ns", "N.s"),
        ("kgm2", "kg.m2"), ("kgm2/s", "kg.m2/s"), ("Am2", "A.m2"), ("rads", "rad/s"),
        ("degs", "deg/s"), ("ms2", "m/s2"), ("ms-2", "m/s2"), ("ms-1", "m/s"), ("ms^2", "m/s2"),
    ],
)  # fmt: skip
def test_symbols_run_together_are_refused_with_what_was_meant(name: str, meant: str) -> None:
    with pytest.raises(UnitError, match=rf"is not a unit: .*; did you mean {meant}\?$"):
        unit(name)


@pytest.mark.parametrize("name", ["c", "e", "parsec", "dB", "mph", "radps"])
def test_what_this_field_does_not_measure_in_is_no_unit(name: str) -> None:
    with pytest.raises(UnitError, match=rf"^'{name}' is not a unit: {name} is not known$"):
        unit(name)


@pytest.mark.parametrize(
    ("name", "factor", "base"),
    [
        ("m/s/s", 1.0, "m/s2"), ("deg/sec", math.pi / 180, "rad/s"), ("mrad", 1e-3, "rad"),
        ("rpm", 2 * math.pi / 60, "rad/s"), ("arcsec", math.pi / 648000, "rad"),
        ("km", 1000.0, "m"), ("um", 1e-6, "m"), ("µm", 1e-6, "m"), ("ms", 1e-3, "s"),
        ("degrees", math.pi / 180, "rad"), ("m/ms2", 1e6, "m/s2"), ("N*m", 1.0, "N.m"),
    ],
)  # fmt: skip
def test_usual_spellings_mean_what_they_say(name: str, factor: float, base: str) -> None:
    assert unit(name).powers == unit(base).powers
    assert unit(name).factor == pytest.approx(factor, rel=1e-15)
