"""The config of a system as typed data. Loading, merging and locating: see :mod:`.loading`."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

INSTANCE_NAME = r"^[A-Za-z_][A-Za-z0-9_-]*$"
INDEX_NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
RESERVED = ("time", "config")  # what results hold besides instances
CONNECTION = re.compile(
    r"^\s*(?P<source>[^\s.]+)\.(?P<output>.+?)\s*->\s*(?P<destination>[^\s.]+)\.(?P<input>.+?)\s*$"
)
Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]


class _Table(BaseModel):
    """A table of the config: unknown keys are errors, types are not guessed."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Simulation(_Table):
    """When and how the system is stepped. Times in seconds.

    ``delay``: connections that may be one step late, to break algebraic loops. ``tolerance``: of
    the adaptive algorithm, whose first step is ``step``.
    """

    start_time: Finite = 0.0
    stop_time: Finite
    step: Positive
    algorithm: Literal["gauss-seidel", "jacobi", "adaptive"] = "gauss-seidel"
    coupling: Literal["hold", "linear", "quadratic"] = "hold"
    tolerance: Positive = 1e-6
    loop_tolerance: Positive = 1e-9
    loop_iterations: Annotated[int, Field(ge=1)] = 50
    delay: list[str] = []

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round((self.stop_time - self.start_time) / self.step)


class Instance(_Table):
    """One FMU of the system: a file, or a component to build."""

    component: str | None = None
    fmu: str | None = None
    target: Literal["python", "native"] | None = None
    structure: dict[str, int] = {}
    parameters: dict[str, Any] = {}
    start: dict[str, Any] = {}
    frames: dict[str, str] = {}
    every: Annotated[int, Field(ge=1)] = 1  # communication steps that one of its steps spans
    max_step: Positive | None = None  # s, that the FMU takes at once

    @property
    def builds(self) -> str | None:
        """The component to build; None if a file is named, or both are."""
        return self.component if self.fmu is None else None

    @property
    def file(self) -> str | None:
        """The FMU's file; None if a component is named, or both are."""
        return self.fmu if self.component is None else None


class Record(_Table):
    """What goes into the results."""

    signals: list[str] = ["*"]
    every: Positive | None = None


class Plot(_Table):
    """One figure. ``until``: the end of the time axis, s.

    The last signal of a trajectory or an angle is what the others are seen from.
    """

    title: str
    signals: Annotated[list[str], Field(min_length=1)]
    kind: Literal["time", "angle", "trajectory", "activity"] = "time"
    y: str = ""
    scale: Literal["linear", "log"] = "linear"
    until: Finite | None = None
    file: str = ""


class Repeat(_Table):
    """A template of instances and connections, written for the copy ``{i}`` of 1 to ``count``."""

    count: Annotated[int, Field(ge=1)]
    neighbours: Literal["ring", "open"] = "ring"
    instances: dict[str, dict[str, Any]] = {}
    connections: list[str] = []


class Repeats(_Table):
    """The templates of a system by the name of their index."""

    repeat: dict[Annotated[str, Field(pattern=INDEX_NAME)], Repeat] = {}


class Config(Repeats):
    """A whole system. ``instances`` and ``connections`` hold those of the templates too."""

    extends: str | None = None
    simulation: Simulation
    instances: Annotated[
        dict[Annotated[str, Field(pattern=INSTANCE_NAME)], Instance], Field(min_length=1)
    ]
    connections: list[str] = []
    record: Record = Record()
    plots: list[Plot] = []

    @property
    def record_stride(self) -> int:
        """Communication steps from one recorded row to the next."""
        every = self.record.every
        return 1 if every is None else round(every / self.simulation.step)


def inconsistencies(config: Config) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
    """What does not fit together: the place, what is wrong, and the remedy."""
    simulation, every = config.simulation, config.record.every
    start, stop, step = simulation.start_time, simulation.stop_time, simulation.step
    count = max(1, round((stop - start) / step))
    if stop <= start:
        yield ("simulation", "stop_time"), f"{stop:g} is not after start_time = {start:g}", ""
    elif not _whole((stop - start) / step):
        what = f"{stop:.12g} is not a whole number of steps of {step:g} from the start"
        yield ("simulation", "stop_time"), what, f"nearest: {start + count * step:.12g}"
    if every is not None and not _whole(every / step):
        what = f"{every:g} is not a multiple of the step {step:g}"
        yield ("record", "every"), what, f"nearest: {max(1, round(every / step)) * step:.12g}"
    for name, instance in config.instances.items():
        if name in RESERVED:
            yield ("instances", name), "is the name of something else in the results", "rename it"
        if (instance.component is None) == (instance.fmu is None):
            found = "neither" if instance.fmu is None else "both"
            yield ("instances", name), f"has {found} of component and fmu", "give one of them"
        elif instance.fmu is not None and (instance.structure or instance.target):
            key = "structure" if instance.structure else "target"
            yield ("instances", name, key), "is a choice of building, but an fmu is built", ""
    for number, plot in enumerate(config.plots):
        if plot.until is not None and plot.until <= start:
            what = f"{plot.until:g} is not after start_time = {start:g}"
            yield ("plots", number, "until"), what, ""
        if plot.scale == "log" and plot.kind in ("trajectory", "activity"):
            yield ("plots", number, "scale"), f"{plot.kind} has no logarithmic scale", ""


def _whole(count: float) -> bool:
    return round(count) >= 1 and abs(count - round(count)) < 1e-6
