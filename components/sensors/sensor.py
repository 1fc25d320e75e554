"""The base of all sensors: a sensor says what is true, the measurement chain does the rest.

A sensor declares its ports and writes ``truth``, which returns the true value of each output, and
``valid`` where the geometry decides on it. Its class line names its channels: for each an output
and the prefix of the parameters that describe its errors. Parameters, states and noise of the
chain (see :mod:`.measurement`) are then declared for each channel, with the units of its output.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..component import Component
from ..declarations import (
    Array,
    Condition,
    DiscreteState,
    Noise,
    Output,
    Parameter,
    Quantity,
    SamplePeriod,
    Structure,
)
from ..maths import multiply, scalar_last, small_rotation, unit
from . import measurement as chain


@dataclass(frozen=True)
class Channel:
    """One measured output and how errors act on it.

    ``errors``: "additive"; "direction" or "attitude": small rotations of a unit vector or a
    quaternion, about the body axes. ``frame`` is that of the errors.
    """

    output: str
    prefix: str = ""
    errors: str = "additive"
    frame: str | None = None


class Sensor(Component):
    """Base of the sensors; see the module's docstring."""

    channels: ClassVar[tuple[Channel, ...]] = ()
    truth_inputs: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls, *, channels: Sequence[Channel]) -> None:
        cls.channels = tuple(channels)
        inputs = list(inspect.signature(cls.__dict__["truth"]).parameters)[1:]
        cls.truth_inputs = tuple(inputs)
        declared = _common()
        for channel in channels:
            declared |= _errors(channel, cls.__dict__[channel.output])
        for name, quantity in declared.items():
            setattr(cls, name, quantity)
        names = [n for n, q in declared.items() if not isinstance(q, Structure | Output)]
        own = cls.__dict__.get("requirements")
        methods: dict[str, Callable[..., Any]] = {
            "outputs": _receiving([*inputs, *names, "history"], _outputs),
            "update": _receiving([*inputs, *names, "history"], _update),
            "requirements": _requirements(own, names),
        }
        for name, method in methods.items():
            setattr(cls, name, method)
        super().__init_subclass__()


def _common() -> dict[str, Quantity | Structure]:
    return {
        "history": Structure(1, doc="samples kept: the largest latency"),
        "valid": Output((), "1", type="boolean", doc="whether the outputs are a measurement"),
        "latency": Parameter((), "1", type="integer", min=0.0, doc="samples of delay"),
        "dropout": Parameter((), "1", min=0.0, max=1.0, doc="probability that a sample is lost"),
        "sample_period": SamplePeriod(),
        "dropout_noise": Noise(2, doc="decides on dropouts"),
        "started": DiscreteState((), "1", doc="0 before the first tick"),
        "past_valid": DiscreteState("history", "1", doc="validity of past samples, latest first"),
    }


def _errors(channel: Channel, output: Output) -> dict[str, Quantity | Structure]:
    """The chain's quantities for one output."""
    additive = channel.errors == "additive"
    shape = output.shape if additive else (3,)
    measured, frame = output.unit, channel.frame
    u = measured if additive else "rad"
    start: Any = output.start
    if shape_of(output) != () and np.ndim(start) == 0:
        start = np.full(shape_of(output), start)
    named: dict[str, Quantity | Structure] = {
        "bias": Parameter(shape, u, frame=frame, doc="constant error"),
        "turn_on_deviation": Parameter((), u, min=0.0,
                                       doc="standard deviation of a bias drawn at the start"),
        "noise_density": Parameter((), f"{u}/sqrt(Hz)", min=0.0,
                                   doc="amplitude spectral density of the white noise"),
        "drift_deviation": Parameter((), u, min=0.0,
                                     doc="standard deviation of the Gauss-Markov bias"),
        "drift_time": Parameter((), "s", 1000.0, min=1e-9,
                                doc="time constant of the Gauss-Markov bias"),
        "walk_density": Parameter((), f"{u}/s/sqrt(Hz)", min=0.0,
                                  doc="amplitude spectral density of the bias's random walk"),
        "resolution": Parameter((), u, min=0.0, doc="step of quantisation; 0: none"),
        "noise": Noise(shape, doc="white noise"),
        "turn_on_noise": Noise(shape, doc="draws the turn-on bias"),
        "drift_noise": Noise(shape, doc="drives the Gauss-Markov bias"),
        "walk_noise": Noise(shape, doc="drives the random walk"),
        "turn_on": DiscreteState(shape, u, frame=frame, doc="bias drawn at the first tick"),
        "drift": DiscreteState(shape, u, frame=frame, doc="Gauss-Markov bias"),
        "walk": DiscreteState(shape, u, frame=frame, doc="random walk of the bias"),
        "past": DiscreteState(("history", *shape_of(output)), measured,
                              lambda history: np.stack([start] * history),
                              doc="past samples, latest first"),
        "held": DiscreteState(output.shape, measured, start, frame=output.frame,
                              doc="the last output"),
    }
    if additive:
        named["scale_factor"] = Parameter(shape, "1", frame=frame, doc="relative error of scale")
        named["limit"] = Parameter((), u, min=0.0, doc="largest value of either sign; 0: none")
    if additive and shape == (3,):
        named["misalignment"] = Parameter(3, "rad", frame=frame,
                                          doc="small rotation of the sensor's axes")
    return {channel.prefix + name: quantity for name, quantity in named.items()}


def shape_of(output: Output) -> tuple[int | str, ...]:
    """The declared shape as a tuple."""
    return output.shape if isinstance(output.shape, tuple) else (output.shape,)


def _receiving(names: Sequence[str], equation: Callable[..., Any]) -> Callable[..., Any]:
    """An equation method that asks for these names."""

    def method(self: Sensor, **values: Any) -> dict[str, Any]:
        result: dict[str, Any] = equation(self, values)
        return result

    asked = dict.fromkeys(["self", *names])
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    method.__dict__["__signature__"] = inspect.Signature(
        [inspect.Parameter(name, kind) for name in asked])
    return method


def _sample(sensor: Sensor, values: Mapping[str, Any]) -> tuple[dict[str, Array], Condition]:
    """What the sensor would say of this instant without delay, and whether it is valid."""
    truth: Callable[..., dict[str, Any]] = sensor.truth  # type: ignore[attr-defined]
    true = truth(**{n: values[n] for n in sensor.truth_inputs})
    seen = np.logical_not(chain.drops_out(values["dropout"], values["dropout_noise"]))
    said = {c.output: _distorted(c, true[c.output], values) for c in sensor.channels}
    return said, np.logical_and(seen, true["valid"]) if "valid" in true else seen


def _distorted(channel: Channel, value: Array, values: Mapping[str, Any]) -> Array:
    def named(name: str) -> Any:
        return values[channel.prefix + name]

    error = (named("bias") + _turn_on(channel, values) + named("drift") + named("walk")
             + chain.noise_sigma(named("noise_density"), values["sample_period"]) * named("noise"))
    if channel.errors == "direction":
        return unit(chain.quantised(small_rotation(error, value), named("resolution")))
    if channel.errors == "attitude":
        turned = multiply(value, unit(scalar_last(0.5 * error, np.ones(()))))
        return unit(chain.quantised(turned, 0.5 * named("resolution")))
    if channel.prefix + "misalignment" in values:
        value = chain.scaled(value, named("scale_factor"), named("misalignment"))
    else:
        value = (1.0 + named("scale_factor")) * value
    return chain.quantised(chain.limited(value + error, named("limit")), named("resolution"))


def _turn_on(channel: Channel, values: Mapping[str, Any]) -> Array:
    """The bias that the first tick draws."""
    drawn = values[f"{channel.prefix}turn_on_deviation"] * values[f"{channel.prefix}turn_on_noise"]
    first = np.logical_and(values["started"] < 0.5, values["sample_period"] > 0.0)
    return np.where(first, drawn, values[f"{channel.prefix}turn_on"])


def _delayed(sample: Array, past: Array, values: Mapping[str, Any]) -> Array:
    """The sample of ``latency`` ticks ago."""
    chosen = sample
    for k in range(values["history"]):
        chosen = np.where(values["latency"] > k + 0.5, past[k], chosen)
    return chosen


def _outputs(sensor: Sensor, values: Mapping[str, Any]) -> dict[str, Any]:
    said, seen = _sample(sensor, values)
    valid = _delayed(np.where(seen, 1.0, 0.0), values["past_valid"], values)
    shown = np.logical_or(valid > 0.5, values["sample_period"] <= 0.0)
    outputs = {
        c.output: np.where(shown, _delayed(said[c.output], values[f"{c.prefix}past"], values),
                           values[f"{c.prefix}held"])
        for c in sensor.channels
    }
    return outputs | {"valid": np.where(valid > 0.5, 1.0, 0.0)}


def _update(sensor: Sensor, values: Mapping[str, Any]) -> dict[str, Any]:
    said, seen = _sample(sensor, values)
    shown, T = _outputs(sensor, values), values["sample_period"]
    states = {"started": np.ones(()),
              "past_valid": _pushed(np.where(seen, 1.0, 0.0), values["past_valid"])}
    for c in sensor.channels:
        def named(name: str, prefix: str = c.prefix) -> Any:
            return values[prefix + name]

        states |= {
            f"{c.prefix}turn_on": _turn_on(c, values),
            f"{c.prefix}drift": chain.next_drift(
                named("drift"), named("drift_deviation"), named("drift_time"), T,
                named("drift_noise")),
            f"{c.prefix}walk": chain.next_walk(
                named("walk"), named("walk_density"), T, named("walk_noise")),
            f"{c.prefix}past": _pushed(said[c.output], named("past")),
            f"{c.prefix}held": shown[c.output],
        }
    return states


def _pushed(latest: Array, past: Array) -> Array:
    return np.stack([latest, *(past[k] for k in range(past.shape[0] - 1))])


def _requirements(own: Callable[..., Any] | None, names: Sequence[str]) -> Callable[..., Any]:
    """The sensor's own requirements and those of the chain."""
    wanted = list(inspect.signature(own).parameters)[1:] if own else []
    random = [n for n in names if n.endswith(
        ("noise_density", "turn_on_deviation", "drift_deviation", "walk_density"))]
    random += ["dropout", "latency"]

    def requirements(sensor: Sensor, values: Mapping[str, Any]) -> dict[str, Any]:
        conditions = own(sensor, **{n: values[n] for n in wanted}) if own else {}
        sampled = values["sample_period"] > 0.0
        ticking = {f"{n} must be 0 unless sample_period is positive":
                   np.where(sampled, 0.0, values[n]) <= 0.0 for n in random}
        kept = {"latency must not exceed history": values["latency"] <= values["history"] + 0.5}
        return {**conditions, **ticking, **kept}

    return _receiving([*wanted, *random, "sample_period", "history"], requirements)
