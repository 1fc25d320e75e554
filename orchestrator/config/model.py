"""The config of a system as typed data. Loading, merging and locating: see :mod:`.loading`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PlainValidator, field_validator
from pydantic_core import PydanticCustomError

INSTANCE_NAME = r"^[A-Za-z_][A-Za-z0-9_-]*$"
INDEX_NAME = r"^[A-Za-z_][A-Za-z0-9_]*$"
RESERVED = ("time", "config", "conversions", "fmus")  # what results hold besides instances
CONNECTION = re.compile(
    r"^\s*(?P<source>[^\s.]+)\.(?P<output>.+?)\s*->\s*(?P<destination>[^\s.]+)\.(?P<input>.+?)\s*$"
)
NEAR = 1e-6  # of a step: instants this close are one
ROUNDING = 1e-15  # relative: what is left of time in a float
LARGEST = 1e15  # s
COPIES = 100_000  # of a template
PARTS = 1_000_000_000  # of a step
FIGURE = re.compile(r"[^/\\]{1,200}\.(png|svg|pdf)")
Instant = Annotated[float, Field(ge=-LARGEST, le=LARGEST, allow_inf_nan=False)]
Width = Annotated[float, Field(ge=1 / LARGEST, le=LARGEST, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Frames = str | tuple[str, ...]
Relative = Annotated[float, Field(ge=ROUNDING, le=1.0, allow_inf_nan=False)]


class _Table(BaseModel):
    """A table of the config: unknown keys are errors, types are not guessed."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Simulation(_Table):
    """When and how the system is stepped. Times in seconds.

    ``delay``: connections that may be one step late, to break algebraic loops. ``tolerance``: of
    the adaptive algorithm, whose first step is ``step``.
    """

    start_time: Instant = 0.0
    stop_time: Instant
    step: Width
    algorithm: Literal["gauss-seidel", "jacobi", "adaptive"] = "gauss-seidel"
    coupling: Literal["hold", "linear", "quadratic"] = "hold"
    tolerance: Relative = 1e-6
    loop_tolerance: Relative = 1e-9
    loop_iterations: Annotated[int, Field(ge=1, le=PARTS)] = 50
    delay: list[str] = []

    @property
    def adaptive(self) -> bool:
        """Whether error control chooses the steps, of which ``step`` is the first."""
        return self.algorithm == "adaptive"

    @property
    def steps(self) -> int:
        """Number of communication steps; the last of the adaptive algorithm's may be shorter."""
        count = (self.stop_time - self.start_time) / self.step
        return math.ceil(count - NEAR) if self.adaptive else round(count)


def _frames(value: object) -> object:
    """A role's frame by its name, or by a list of names where each row of a port has another."""
    names = value if isinstance(value, list) and value else [value]
    if not all(isinstance(name, str) for name in names):
        raise PydanticCustomError("frames", "input should be a name or a list of names")
    return tuple(names) if isinstance(value, list) else value


class Instance(_Table):
    """One FMU of the system: a file, or a component to build."""

    component: str | None = None
    fmu: str | None = None
    target: Literal["python", "native"] | None = None
    structure: dict[str, int] = {}
    parameters: dict[str, Any] = {}
    start: dict[str, Any] = {}
    frames: dict[str, Annotated[Frames, PlainValidator(_frames)]] = {}
    every: Annotated[int, Field(ge=1, le=PARTS)] = 1  # communication steps that one of its spans
    max_step: Width | None = None  # s, that the FMU takes at once
    isolate: bool = False  # run it in a process of its own
    time_limit: Positive | None = None  # s of real time, that one call takes there

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
    every: Width | None = None


class Plot(_Table):
    """One figure. ``until``: the end of the time axis, s.

    The last signal of a trajectory or an angle is what the others are seen from. ``file``: a name
    without a folder, so that it lies beside the results; else the title gives it.
    """

    title: str
    signals: Annotated[list[str], Field(min_length=1)]
    kind: Literal["time", "angle", "trajectory", "activity"] = "time"
    y: str = ""
    scale: Literal["linear", "log"] = "linear"
    until: Instant | None = None
    file: str = ""

    @field_validator("file")
    @classmethod
    def _plain(cls, file: str) -> str:
        if file and not (FIGURE.fullmatch(file) and file.isprintable()):
            what = "input should be a name without a folder that ends in .png, .svg or .pdf"
            raise PydanticCustomError("figure", what)
        return file

    def file_name(self, suffix: str) -> str:
        """The name of its file; ``suffix``: of one that is named after the title."""
        return self.file or f"{slug(self.title)}{suffix}"


class Repeat(_Table):
    """A template of instances and connections, written for the copy ``{i}`` of 1 to ``count``."""

    count: Annotated[int, Field(ge=1, le=COPIES)]
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
        """Communication steps of equal size from one recorded row to the next."""
        every, simulation = self.record.every, self.simulation
        return 1 if every is None else min(round(every / simulation.step), simulation.steps + 1)

    @property
    def rows(self) -> int | None:
        """How many rows a run records; None if error control decides."""
        simulation, every = self.simulation, self.record.every
        if not simulation.adaptive:
            return simulation.steps // self.record_stride + 1
        if every is None:
            return None
        return math.ceil((simulation.stop_time - simulation.start_time) / every - NEAR) + 1


def inconsistencies(
    config: Config, isolate: bool = False
) -> Iterator[tuple[tuple[str | int, ...], str, str]]:
    """What does not fit together: the place, what is wrong, and the remedy.

    ``isolate``: every instance will be isolated, whatever the config says.
    """
    simulation, every = config.simulation, config.record.every
    start, stop, step = simulation.start_time, simulation.stop_time, simulation.step
    count = max(1, round((stop - start) / step))
    furthest = max(abs(start), abs(stop))
    for path, width in ((("simulation", "step"), step), (("record", "every"), every)):
        if width is not None and width < ROUNDING * furthest:
            yield path, f"{width:g} is lost in the rounding of the time {furthest:g}", ""
    if stop <= start:
        yield ("simulation", "stop_time"), f"{stop:g} is not after start_time = {start:g}", ""
    elif not simulation.adaptive and not _whole((stop - start) / step):
        what = f"{stop:.12g} is not a whole number of steps of {step:g} from the start"
        yield ("simulation", "stop_time"), what, f"nearest: {start + count * step:.12g}"
    if every is not None and not simulation.adaptive and not _whole(every / step):
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
        if instance.max_step is not None and instance.every * step / instance.max_step > PARTS:
            what = f"{instance.max_step:g} splits a step of {instance.every * step:g} into too many"
            yield ("instances", name, "max_step"), what, ""
        if instance.time_limit is not None and not (isolate or instance.isolate):
            what = "can be kept by an isolated FMU only"
            yield ("instances", name, "time_limit"), what, "add isolate = true"
    named = [plot.file_name(".png") for plot in config.plots]
    for number, plot in enumerate(config.plots):
        if (first := named.index(named[number])) < number:
            key = "file" if plot.file else "title"
            what = f"{named[number]} is the file of plots.{first} already"
            yield ("plots", number, key), what, "give it another title or file"
        if plot.until is not None and plot.until <= start:
            what = f"{plot.until:g} is not after start_time = {start:g}"
            yield ("plots", number, "until"), what, ""
        if plot.scale == "log" and plot.kind in ("trajectory", "activity"):
            yield ("plots", number, "scale"), f"{plot.kind} has no logarithmic scale", ""


def slug(title: str) -> str:
    """A file name from a title."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower())[:80].strip("-") or "plot"


def _whole(count: float) -> bool:
    return round(count) >= 1 and abs(count - round(count)) < NEAR
