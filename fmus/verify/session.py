"""An instance that is initialised and stepped: by doStep, or by RK4 around model exchange.

Here a refusal is an error: Refused tells which call, and what the FMU said.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .driver import Driver, good, status_name
from .subject import Array, Variable, names_of

SUBSTEPS = 10  # of RK4 in one step of model exchange
ZERO = 1e-9  # of a step: nearer events are at the same instant


class Refused(Exception):
    """A legal call was not done: ``action`` says which, ``found`` the status and the message."""

    def __init__(self, action: str, found: str) -> None:
        super().__init__(f"{action}: {found}")
        self.action, self.found = action, found


class NotFinite(Refused):
    """Values that are not finite came with status OK: no smaller inputs excuse that."""

    def __init__(self, action: str, what: str = "values") -> None:
        super().__init__(action, f"{what} not finite, with status OK")


class Ended(Exception):
    """The FMU asked to end the simulation, as every FMU may."""

    def __init__(self, time: float) -> None:
        super().__init__(f"the FMU itself ends the simulation at {time:g} s")


class Session:
    """A driver with a time. ``crude``: model exchange by one step of forward Euler, not by RK4."""

    def __init__(self, driver: Driver, crude: bool = False) -> None:
        self.driver, self.crude = driver, crude
        self.subject = driver.subject
        self.time = 0.0
        self._next_event: float | None = None
        self._running = False  # initialised, for model exchange
        self.in_event = False  # events are handled when the next step departs, with its inputs

    def must(self, status: int, action: str) -> None:
        """Raise Refused unless the status is good."""
        if not good(status):
            log = self.driver.log
            said = f" ({log[-1].text})" if log else " (no message)"
            raise Refused(action, status_name(status) + said)

    def begin(
        self, start: float | None = None, values: Mapping[Variable, Array] | None = None,
        inputs: Array | None = None,
    ) -> Session:  # fmt: skip
        """Set up, set values and inputs, initialise."""
        self.time = self.subject.start_time if start is None else start
        self.must(self.driver.setup(self.time), "setup of the experiment")
        for variable, value in (values or {}).items():
            self.must(self.driver.set([variable], value), f"setting {variable.name}")
        if inputs is not None:
            self.put(inputs)
        self.must(self.driver.enter_initialization(), "entering initialisation")
        self.must(self.driver.exit_initialization(), "leaving initialisation")
        self.in_event = self._running = self.driver.interface == "me"
        return self

    def put(self, inputs: Array) -> None:
        """Set all inputs; those that are discrete, while a model is integrated, at an event."""
        if self._running and not self.in_event and any(
            not v.continuous for v in self.subject.inputs
        ):
            self.must(self.driver.call("EnterEventMode"), "entering event mode")
            self.in_event = True
        if self.subject.inputs:
            self.must(self.driver.set(self.subject.inputs, inputs), "setting the inputs")

    def read(self, variables: Sequence[Variable]) -> Array:
        """Values of variables. Raises Refused, NotFinite."""
        status, values = self.driver.get(variables)
        self.must(status, "reading the variables")
        if not np.all(finite := np.isfinite(values)):
            names = np.array(names_of(variables))[~finite]
            raise NotFinite(f"reading the variables at {self.time:g} s", ", ".join(names[:4]))
        return values

    def step(self, h: float, time: float | None = None) -> None:
        """One step from ``time``, or from where the last one ended. Raises Refused, Ended."""
        start = self.time if time is None else time
        if self.driver.interface == "cs":
            status = self.driver.do_step(start, h)
            if self.driver.ended(status):
                reached = self.driver.last_time()
                raise Ended(start + h if reached is None else reached)
            self.must(status, f"the step from {start:g} s by {h:g} s")
        else:
            self._integrate(start + h)
        self.time = start + h

    # model exchange ------------------------------------------------------------------------

    def _integrate(self, end: float) -> None:
        """Steps of the solver, with events at their times."""
        step = (end - self.time) / (1 if self.crude else SUBSTEPS)
        near = ZERO * abs(step)
        t = self.time
        self.leave_event_mode()
        while t < end - near:
            event = self._next_event
            goal = min(t + step, end)
            at_event = event is not None and event <= goal + near
            if event is not None and at_event:
                goal = max(event, t)
            if goal > t + near:
                self._advance(t, goal - t)
            self.time = t = goal
            self.must(self.driver.set_time(t), "setting the time")
            status, wanted, end_wanted = self.driver.completed_step()
            self.must(status, "completing a step")
            if end_wanted:
                raise Ended(t)
            if wanted or at_event:
                self.must(self.driver.call("EnterEventMode"), "entering event mode")
                self.in_event = True
                if t < end - near:
                    self.leave_event_mode()
        self.time = end

    def _advance(self, t: float, h: float) -> None:
        n = sum(v.size for v in self.subject.states)
        if not n:
            self.must(self.driver.set_time(t + h), "setting the time")
            return
        status, x = self.driver.get_states(n)
        self.must(status, "reading the states")
        k1 = self._rates(t, x, n)
        if self.crude:
            self._rates(t + h, x + h * k1, n)
            return
        k2 = self._rates(t + h / 2, x + h / 2 * k1, n)
        k3 = self._rates(t + h / 2, x + h / 2 * k2, n)
        k4 = self._rates(t + h, x + h * k3, n)
        self._rates(t + h, x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), n)

    def _rates(self, t: float, x: Array, n: int) -> Array:
        self.must(self.driver.set_time(t), "setting the time")
        self.must(self.driver.set_states(x), "setting the states")
        status, rates = self.driver.get_rates(n)
        self.must(status, "reading the derivatives")
        if not np.all(np.isfinite(rates)):
            raise NotFinite("reading the derivatives")
        return rates

    def leave_event_mode(self) -> None:
        """Iterate event mode to its end and go on to continuous time."""
        if not self.in_event:
            return
        self.in_event = False
        for _ in range(100):
            status, info = self.driver.update_discrete()
            self.must(status, "updating discrete states")
            if info.terminate:
                raise Ended(self.time)
            if not info.again:
                break
        else:
            raise Refused("updating discrete states", "asked for again a hundred times")
        if info.next_time is not None and np.isnan(info.next_time):
            raise NotFinite("updating discrete states", "the time of the next event is")
        self._next_event = info.next_time
        self.must(self.driver.call("EnterContinuousTimeMode"), "entering continuous time")
