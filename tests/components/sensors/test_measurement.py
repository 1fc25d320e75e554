"""The measurement chain, error by error, and that every sensor has it."""

import numpy as np
import pytest

from sightline.components import catalogue
from sightline.components.declarations import Noise, Parameter
from sightline.components.sensors import measurement
from sightline.components.sensors.measurement import noise_sigma

SENSORS = [pytest.param(block(), id=name)
           for name, block in catalogue.families()["sensors"].items()]
RANDOM = ("noise_density", "turn_on_deviation", "drift_deviation", "walk_density")
CHANNELS = [pytest.param(block(), channel, id=f"{name}.{channel.output}")
            for name, block in catalogue.families()["sensors"].items()
            for channel in block.channels]
TURNED = [p for p in CHANNELS if p.values[1].errors != "additive"]
ADDITIVE = [p for p in CHANNELS if p.values[1].errors == "additive"]
RNG = np.random.default_rng(11)


def drawn(sensor, rng):
    return {name: rng.standard_normal(noise.dimensions)
            for name, noise in sensor.of_type(Noise).items()}


def ticks(sensor, count, each=None, seed=0, **values):
    """Outputs of successive ticks; ``each(k)`` gives inputs of tick k."""
    rng = np.random.default_rng(seed)
    values = sensor.start_values() | {n: np.asarray(v, float) for n, v in values.items()}
    rows = []
    for k in range(count):
        values |= drawn(sensor, rng) | (each(k) if each else {})
        rows.append(sensor.evaluate("outputs", values))
        values |= sensor.evaluate("update", values)
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def refused(sensor, **values):
    conditions = sensor.evaluate("requirements", sensor.start_values() | values)
    return [message for message, holds in conditions.items() if not holds]


def output(sensor, channel, **values):
    return sensor.evaluate("outputs", sensor.start_values() | values)[channel.output]


def test_a_sample_has_the_density_divided_by_the_root_of_the_period():
    assert noise_sigma(np.array(0.02), np.array(0.25)) == 0.04


def test_a_continuous_sensor_has_no_noise():
    assert noise_sigma(np.array(0.02), np.array(0.0)) == 0.0


def test_an_average_over_a_second_has_the_density_as_deviation_at_any_period():
    deviations = [noise_sigma(np.array(0.02), np.array(T)) * np.sqrt(T) for T in (0.001, 0.1, 1.0)]
    np.testing.assert_allclose(deviations, 0.02, rtol=1e-15)


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sensor_at_default_ignores_noise_draws(sensor):
    quiet = sensor.start_values()
    np.testing.assert_equal(sensor.evaluate("outputs", quiet | drawn(sensor, RNG)),
                            sensor.evaluate("outputs", quiet))


@pytest.mark.parametrize("sensor", SENSORS)
def test_a_sensor_at_default_is_valid(sensor):
    assert sensor.evaluate("outputs", sensor.start_values())["valid"] == 1.0


@pytest.mark.parametrize(("sensor", "channel"), CHANNELS)
def test_noise_scales_with_the_density(sensor, channel):
    values, p = sensor.start_values(), channel.prefix
    values |= {"sample_period": np.array(0.25),
               f"{p}noise": np.ones_like(values[f"{p}noise"])}
    noisy = output(sensor, channel, **values | {f"{p}noise_density": np.array(1e-6)})
    biased = output(sensor, channel, **values | {f"{p}bias": np.full_like(values[f"{p}bias"],
                                                                          2e-6)})
    np.testing.assert_allclose(noisy, biased, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("sensor", SENSORS)
def test_random_errors_without_a_sample_period_are_refused(sensor):
    names = [n for n in sensor.of_type(Parameter) if n.endswith(RANDOM)]
    expected = [f"{n} must be 0 unless sample_period is positive" for n in names]
    assert sorted(refused(sensor, **dict.fromkeys(names, np.array(1e-3)))) == sorted(expected)


@pytest.mark.parametrize("sensor", SENSORS)
def test_random_errors_with_a_sample_period_are_accepted(sensor):
    names = [n for n in sensor.of_type(Parameter) if n.endswith(RANDOM)]
    assert refused(sensor, sample_period=np.array(0.1),
                   **dict.fromkeys(names, np.array(1e-3))) == []


@pytest.mark.parametrize("sensor", SENSORS)
def test_more_latency_than_samples_kept_is_refused(sensor):
    assert refused(sensor, sample_period=np.array(0.1), latency=np.array(2.0)) == [
        "latency must not exceed history"]


@pytest.mark.parametrize(("sensor", "channel"), ADDITIVE)
def test_the_scale_factor_is_relative(sensor, channel):
    scale = {f"{channel.prefix}scale_factor": np.full(np.shape(output(sensor, channel)), 0.01)}
    np.testing.assert_allclose(output(sensor, channel, **scale), 1.01 * output(sensor, channel))


def test_misalignment_turns_a_vector():
    gyro = catalogue.find("Gyro")()
    turned = output(gyro, gyro.channels[0], angular_velocity=np.array([1.0, 0.0, 0.0]),
                    misalignment=np.array([0.0, 0.0, 1e-3]))
    np.testing.assert_allclose(turned, [1.0, 1e-3, 0.0], atol=1e-6)  # angle²/2


@pytest.mark.parametrize(("sensor", "channel"), ADDITIVE)
def test_a_measurement_is_a_multiple_of_the_resolution(sensor, channel):
    p = channel.prefix
    bias = np.full(np.shape(output(sensor, channel)), 0.37)
    rounded = output(sensor, channel, **{f"{p}bias": bias, f"{p}resolution": np.array(0.25)})
    np.testing.assert_allclose(rounded, output(sensor, channel) + 0.25)  # 1.37 -> 1.25


@pytest.mark.parametrize(("sensor", "channel"), ADDITIVE)
def test_a_measurement_saturates_on_both_sides(sensor, channel):
    p, shape = channel.prefix, np.shape(output(sensor, channel))
    for sign in (1.0, -1.0):
        said = output(sensor, channel, **{f"{p}bias": np.full(shape, 9.0 * sign),
                                          f"{p}limit": np.array(2.0)})
        np.testing.assert_array_equal(said, np.full(shape, 2.0 * sign))


@pytest.mark.parametrize(("sensor", "channel"), TURNED)
def test_a_turned_measurement_stays_a_unit_vector(sensor, channel):
    said = output(sensor, channel, bias=np.array([0.1, -0.2, 0.3]), resolution=np.array(1e-2))
    assert np.linalg.norm(said) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("latency", [0, 1, 2, 3])
def test_latency_delays_by_whole_samples(latency):
    gyro = catalogue.find("Gyro")(history=3)
    said = ticks(gyro, 6, lambda k: {"angular_velocity": np.full(3, k + 1.0)}, sample_period=0.1,
                 latency=latency)
    expected = np.maximum(np.arange(1.0, 7.0) - latency, 0.0)
    np.testing.assert_array_equal(said["measured_angular_velocity"][:, 0], expected)


def test_before_the_first_delayed_sample_a_sensor_is_not_valid():
    gyro = catalogue.find("Gyro")(history=3)
    said = ticks(gyro, 5, sample_period=0.1, latency=2)
    np.testing.assert_array_equal(said["valid"], [0.0, 0.0, 1.0, 1.0, 1.0])


def test_dropouts_come_with_their_probability():
    valid = ticks(catalogue.find("RangeSensor")(), 4000, sample_period=0.1, dropout=0.2)["valid"]
    assert valid.mean() == pytest.approx(0.8, abs=0.02)  # three deviations


def test_a_lost_sample_leaves_the_last_value():
    said = ticks(catalogue.find("Gyro")(), 200,
                 lambda k: {"angular_velocity": np.full(3, k + 1.0)}, sample_period=0.1,
                 dropout=0.5)
    value, valid = said["measured_angular_velocity"][:, 0], said["valid"]
    lost = np.flatnonzero(valid[1:] < 0.5) + 1
    np.testing.assert_array_equal(value[lost], value[lost - 1])
    np.testing.assert_array_equal(value[valid > 0.5], np.flatnonzero(valid > 0.5) + 1.0)


def test_the_turn_on_bias_is_drawn_once():
    said = ticks(catalogue.find("RangeSensor")(), 20, sample_period=0.1, turn_on_deviation=0.5)
    assert np.ptp(said["range"]) == 0.0
    assert said["range"][0] != 1.0


def test_the_turn_on_bias_has_its_deviation():
    sensor = catalogue.find("RangeSensor")()
    said = [ticks(sensor, 1, seed=k, sample_period=0.1, turn_on_deviation=0.5)["range"][0]
            for k in range(2000)]
    assert np.std(said) == pytest.approx(0.5, rel=0.05)  # 1/sqrt(2 n) is 1.6 %


def allan_deviation(rate, samples):
    """Of non-overlapping averages of so many samples; sequences along the first axis."""
    count = len(rate) // samples
    means = rate[: count * samples].reshape(count, samples, -1).mean(axis=1)
    return np.sqrt(0.5 * np.mean(np.diff(means, axis=0) ** 2))


@pytest.mark.parametrize("averaging", [0.1, 1.0, 10.0])
def test_the_allan_deviation_of_white_noise_falls_with_the_root_of_time(averaging):
    T, density = 0.1, 0.02
    noise = noise_sigma(np.array(density), np.array(T)) * RNG.standard_normal((20_000, 20))
    expected = density / np.sqrt(averaging)
    assert allan_deviation(noise, round(averaging / T)) == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("averaging", [1.0, 10.0, 50.0])
def test_the_allan_deviation_of_a_random_walk_rises_with_the_root_of_time(averaging):
    T, density, walks, walk = 0.1, 0.003, [], np.zeros(100)
    for noise in RNG.standard_normal((10_000, 100)):
        walk = measurement.next_walk(walk, np.array(density), np.array(T), noise)
        walks.append(walk)
    expected = density * np.sqrt(averaging / 3.0)
    assert allan_deviation(np.array(walks), round(averaging / T)) == pytest.approx(expected,
                                                                                   rel=0.05)


@pytest.mark.parametrize("lag", [0, 10, 40])
def test_the_drift_has_its_deviation_and_correlation_time(lag):
    T, τ, deviation, drifts, drift = 0.1, 2.0, 0.5, [], np.zeros(200)
    for noise in RNG.standard_normal((3000, 200)):
        drift = measurement.next_drift(drift, np.array(deviation), np.array(τ), np.array(T), noise)
        drifts.append(drift)
    settled = np.array(drifts[500:])
    correlation = np.mean(settled[: len(settled) - lag] * settled[lag:])
    assert correlation == pytest.approx(deviation**2 * np.exp(-lag * T / τ), abs=0.01)


@pytest.mark.parametrize("band", [slice(1, 50), slice(200, 400)])
def test_the_spectral_density_of_a_sensor_is_its_parameter(band):
    T, density, count = 0.1, 0.02, 4096
    said = ticks(catalogue.find("Gyro")(), count, sample_period=T, noise_density=density)
    spectrum = np.fft.rfft(said["measured_angular_velocity"], axis=0)
    power = np.mean(np.abs(spectrum[band]) ** 2) * T / count  # two-sided
    assert np.sqrt(power) == pytest.approx(density, rel=0.12)  # 147 values: 3 deviations


def test_drift_and_walk_of_a_sensor_follow_their_equations():
    sensor, values = catalogue.find("Gyro")(), {}
    values = sensor.start_values() | drawn(sensor, RNG) | {
        "sample_period": np.array(0.1), "drift_deviation": np.array(0.5),
        "drift_time": np.array(2.0), "walk_density": np.array(0.3)}
    after = sensor.evaluate("update", values)
    shown = sensor.evaluate("outputs", values | after)["measured_angular_velocity"]
    np.testing.assert_allclose(shown, after["drift"] + after["walk"])
