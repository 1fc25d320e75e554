"""Pulse modulator: from wanted thrust to on-times that valves can make."""

import numpy as np

from ..component import Component
from ..declarations import (
    Array,
    DiscreteState,
    Input,
    Output,
    Parameter,
    SamplePeriod,
    Scalar,
    Structure,
)


class PulseModulator(Component):
    """Turns a wanted mean thrust into one pulse per period: limited, quantised, not too short.

    t_on = round(T clip(F + c/T, 0, F_max) / (F_max q)) q
    t_on = 0   where F_max t_on < I_min;     thrust = F_max t_on / T

    ``thrust`` is the pulse's mean over the period T: pulses are not resolved in time. q is the
    on-time quantum, I_min the minimum impulse bit. The impulse c that a pulse could not give is
    carried to the next one if `carry` is set, so that small wishes are met on average.

    Source: M. Sidi, Spacecraft Dynamics and Control, ch. 9 (pulse-width modulation of thrusters).
    """

    thrusters = Structure(12, doc="number of thrusters")
    command = Input("thrusters", "N", doc="wanted mean thrust of each thruster")
    thrust = Output("thrusters", "N", doc="mean thrust over the period")
    on_time = Output("thrusters", "s", doc="length of each pulse")
    carried = DiscreteState("thrusters", "N.s", doc="impulse not given so far")
    max_thrust = Parameter("thrusters", "N", 1.0, min=1e-9, doc="thrust of an open valve")
    minimum_impulse = Parameter((), "N.s", min=0.0, doc="I_min, minimum impulse bit")
    on_time_quantum = Parameter((), "s", min=0.0, doc="q, step of the on-time; 0: any on-time")
    carry = Parameter((), "1", 1.0, type="boolean", doc="carry what a pulse could not give")
    sample_period = SamplePeriod(start=0.1)

    def outputs(self, command, carried, max_thrust, minimum_impulse, on_time_quantum,
                sample_period):
        on_time = pulse_length(command, carried, max_thrust, minimum_impulse, on_time_quantum,
                               sample_period)
        period = np.where(sample_period > 0.0, sample_period, 1.0)
        return {"thrust": max_thrust * on_time / period, "on_time": on_time}

    def update(self, command, carried, max_thrust, minimum_impulse, on_time_quantum, carry,
               sample_period):
        on_time = pulse_length(command, carried, max_thrust, minimum_impulse, on_time_quantum,
                               sample_period)
        wanted = np.clip(command, 0.0, max_thrust) * sample_period + carried
        bound = max_thrust * sample_period  # of what is carried: saturation must not wind up
        left = np.clip(wanted - max_thrust * on_time, -bound, bound)
        return {"carried": np.where(carry > 0.5, left, 0.0)}

    def requirements(self, sample_period):
        return {"sample_period must be positive": sample_period > 0.0}


def pulse_length(command: Array, carried: Array, max_thrust: Array, minimum_impulse: Scalar,
                 on_time_quantum: Scalar, sample_period: Scalar) -> Array:
    """t_on of each thruster."""
    impulse = np.clip(sample_period * command + carried, 0.0, sample_period * max_thrust)
    exact = impulse / max_thrust
    stepped = on_time_quantum > 0.0
    quantum = np.where(stepped, on_time_quantum, 1.0)
    rounded = np.minimum(np.round(exact / quantum) * quantum, sample_period)
    on_time = np.where(stepped, rounded, exact)
    return np.where(max_thrust * on_time >= minimum_impulse, on_time, 0.0)
