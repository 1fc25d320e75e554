"""Units in FMI terms against their definitions."""

from __future__ import annotations

import math

import pytest

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


def test_an_unknown_unit_is_named() -> None:
    with pytest.raises(UnitError, match="'fnord' is not a unit"):
        unit("fnord")
