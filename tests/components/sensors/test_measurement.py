"""Bias and white noise of the sensors."""

import numpy as np
import pytest

from sightline.components import catalogue
from sightline.components.sensors.measurement import measurement_error, noise_sigma

SENSORS = [pytest.param(block(), id=name)
           for name, block in catalogue.families()["sensors"].items()]
OUTPUT = {"Gyro": "measured_angular_velocity", "LineOfSightSensor": "line_of_sight",
          "RangeSensor": "range", "RelativeVelocitySensor": "relative_velocity"}


def refused(sensor, **values):
    conditions = sensor.evaluate("requirements", sensor.start_values() | values)
    return [message for message, holds in conditions.items() if not holds]


def test_a_sample_has_the_density_divided_by_the_root_of_the_period():
    assert noise_sigma(np.array(0.02), np.array(0.25)) == 0.04


def test_a_continuous_sensor_has_no_noise():
    assert noise_sigma(np.array(0.02), np.array(0.0)) == 0.0


def test_an_average_over_a_second_has_the_density_as_deviation_at_any_period():
    deviations = [noise_sigma(np.array(0.02), np.array(T)) * np.sqrt(T) for T in (0.001, 0.1, 1.0)]
    np.testing.assert_allclose(deviations, 0.02, rtol=1e-15)


def test_the_deviation_of_many_samples_is_sigma():
    draws = np.random.default_rng(0).standard_normal(100_000)
    samples = measurement_error(np.array(1.0), np.array(0.02), draws, np.array(0.25))
    assert np.std(samples) == pytest.approx(0.04, rel=0.01)  # 1/sqrt(2 n) is 0.2 %


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sensor_at_default_ignores_noise_draws(sensor):
    quiet, drawn = sensor.start_values(), sensor.start_values()
    drawn["noise"] = np.ones_like(drawn["noise"])
    np.testing.assert_equal(sensor.evaluate("outputs", drawn), sensor.evaluate("outputs", quiet))


@pytest.mark.parametrize("sensor", SENSORS)
def test_noise_scales_with_the_density(sensor):
    values = sensor.start_values()
    values |= {"sample_period": np.array(0.25), "noise": np.ones_like(values["noise"])}
    output = OUTPUT[sensor.name]
    noisy = sensor.evaluate("outputs", values | {"noise_density": np.array(1e-6)})[output]
    biased = sensor.evaluate("outputs", values | {"bias": np.full_like(values["bias"], 2e-6)})
    np.testing.assert_allclose(noisy, biased[output], rtol=0.0, atol=1e-20)


@pytest.mark.parametrize("sensor", SENSORS)
def test_noise_without_a_sample_period_is_refused(sensor):
    assert refused(sensor, noise_density=np.array(1e-3)) == [
        "noise_density must be 0 unless sample_period is positive"
    ]


@pytest.mark.parametrize("sensor", SENSORS)
def test_noise_with_a_sample_period_is_accepted(sensor):
    assert refused(sensor, noise_density=np.array(1e-3), sample_period=np.array(0.1)) == []
