"""An FMU under test: its unpacked folder and its variables, the same for FMI 2.0 and FMI 3.0."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.model_description import read_model_description
from numpy.typing import NDArray

from ..safe_description import size_problems

Array = NDArray[np.float64]
FLOATS = ("Real", "Float64", "Float32")
INTEGERS = {
    "Integer": (-(2**31), 2**31 - 1), "Enumeration": (1, 2**31 - 1),
    **{f"Int{n}": (-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
    **{f"UInt{n}": (0, 2**n - 1) for n in (8, 16, 32, 64)},
}  # fmt: skip
BOOLEANS = ("Boolean",)
NUMERIC = (*FLOATS, *INTEGERS, *BOOLEANS)
INDEXED = re.compile(r"^(.+)\[(\d+(?:,\s*\d+)*)\](\)?)$")


@dataclass(frozen=True, eq=False)
class Variable:
    """One variable: a scalar of FMI 2.0 or an array of FMI 3.0."""

    name: str
    reference: int
    type: str
    causality: str
    variability: str
    initial: str
    shape: tuple[int, ...]
    start: Array | None
    min: float
    max: float
    nominal: float
    unit: str
    index: int  # position in the description, from 0
    clocked: bool  # FMI 3.0: may be set and read only while its clock is active

    @property
    def size(self) -> int:
        """Number of scalars."""
        return math.prod(self.shape)

    @property
    def elements(self) -> list[str]:
        """Names of the scalars, as FMI 2.0 writes them."""
        if not self.shape:
            return [self.name]
        stem, end = (self.name[:-1], ")") if self.name.endswith(")") else (self.name, "")
        indices = product(*(range(1, n + 1) for n in self.shape))
        return [f"{stem}[{','.join(map(str, i))}]{end}" for i in indices]

    @property
    def port(self) -> str:
        """Name of the array that a scalar of FMI 2.0 belongs to."""
        match = INDEXED.match(self.name)
        return match[1] + match[3] if match else self.name

    @property
    def continuous(self) -> bool:
        """Whether it may change between events."""
        return self.real and (self.variability or "continuous") == "continuous"

    @property
    def real(self) -> bool:
        """Whether it is a floating-point number."""
        return self.type in FLOATS


@dataclass(frozen=True)
class Unknown:
    """An entry of the model structure; ``dependencies`` is None where none are declared."""

    variable: Variable
    dependencies: tuple[Variable, ...] | None


class Subject:
    """An FMU under test. ``folder`` holds the unpacked archive.

    Raises ValueError for variables of more values than can be allocated.
    """

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder = path, folder
        if problems := size_problems(ET.parse(folder / "modelDescription.xml").getroot()):
            raise ValueError("; ".join(problems))
        self.description: Any = read_model_description(str(folder), validate=False)
        self.version = int(self.description.fmiVersion[0])
        own = [v for v in self.description.modelVariables if getattr(v, "alias", None) is None]
        self.variables = [_variable(v, i) for i, v in enumerate(own)]
        self._of = {id(v): w for v, w in zip(own, self.variables, strict=True)}
        self.by_name = {v.name: v for v in self.variables}

    @property
    def interfaces(self) -> dict[str, Any]:
        """``cs`` and ``me``, as far as offered, with what the description says of them."""
        both = {"cs": self.description.coSimulation, "me": self.description.modelExchange}
        return {n: i for n, i in both.items() if i is not None}

    def says(self, interface: str, *names: str) -> bool:
        """Whether the description sets one of these flags, FMPy's model not knowing them all."""
        element = {"cs": "CoSimulation", "me": "ModelExchange"}[interface]
        found = ET.parse(self.folder / "modelDescription.xml").find(element)
        return found is not None and any(found.get(n) in ("true", "1") for n in names)

    def of(self, *causalities: str) -> list[Variable]:
        """Numeric variables of these causalities, but clocked ones."""
        return [v for v in self.variables
                if v.causality in causalities and v.type in NUMERIC and not v.clocked]

    @cached_property
    def inputs(self) -> list[Variable]:
        """Numeric inputs."""
        return self.of("input")

    @cached_property
    def outputs(self) -> list[Variable]:
        """Numeric outputs."""
        return self.of("output")

    @cached_property
    def readable(self) -> list[Variable]:
        """Everything numeric but the time and clocked variables."""
        return [v for v in self.variables
                if v.type in NUMERIC and v.causality != "independent" and not v.clocked]

    @cached_property
    def derivatives(self) -> list[tuple[Variable, Variable]]:
        """Continuous states and their derivatives, in the order of the state vector."""
        pairs = []
        for unknown in self.description.derivatives:
            rate = unknown.variable
            if rate.derivative is not None:
                pairs.append((self._of[id(rate.derivative)], self._of[id(rate)]))
        return pairs

    @cached_property
    def states(self) -> list[Variable]:
        """Continuous states."""
        return [state for state, _ in self.derivatives]

    def structure(self, part: str) -> list[Unknown]:
        """Entries of the model structure: ``outputs``, ``derivatives``, ``initialUnknowns``."""
        result = []
        for unknown in getattr(self.description, part):
            known = unknown.dependencies
            named = None if known is None else tuple(self._of[id(v)] for v in known)
            result.append(Unknown(self._of[id(unknown.variable)], named))
        return result

    def settable_at_start(self) -> list[Variable]:
        """Parameters and start values that may be set before initialisation."""
        return [v for v in self.readable if v.variability != "constant" and
                (v.causality in ("parameter", "input") or v.initial == "exact")]

    @property
    def start_time(self) -> float:
        """Of the default experiment, or 0."""
        return _number(getattr(self.description.defaultExperiment, "startTime", None), 0.0)

    @property
    def step(self) -> float:
        """Communication step of the default experiment, or a hundredth of its length."""
        experiment = self.description.defaultExperiment
        fixed = getattr(self.description.coSimulation, "fixedInternalStepSize", None)
        if fixed:
            return float(fixed)
        step = _number(getattr(experiment, "stepSize", None), 0.0)
        stop = _number(getattr(experiment, "stopTime", None), self.start_time + 1.0)
        return step or max(stop - self.start_time, 1e-6) / 100.0

    @property
    def variable_step(self) -> bool:
        """Whether communication steps of any size are accepted."""
        cs = self.description.coSimulation
        return cs is None or bool(cs.canHandleVariableCommunicationStepSize)

    @property
    def tolerance(self) -> float | None:
        """Of the default experiment."""
        text = getattr(self.description.defaultExperiment, "tolerance", None)
        return float(text) if text else None

    def binary(self) -> Path:
        """The shared library for this machine."""
        folder = fmpy.platform if self.version == 2 else fmpy.platform_tuple
        infos = (*self.interfaces.values(), self.description.scheduledExecution)
        name = infos[0].modelIdentifier
        path: Path = self.folder / "binaries" / folder / f"{name}{fmpy.sharedLibraryExtension}"
        return path


def names_of(variables: Iterable[Variable]) -> list[str]:
    """Names of all scalars."""
    return [name for v in variables for name in v.elements]


def _variable(v: Any, index: int) -> Variable:
    shape = tuple(v.shape or ())
    low, high = INTEGERS.get(v.type, (-math.inf, math.inf))
    declared = v.declaredType
    return Variable(
        v.name, int(v.valueReference), v.type, v.causality, v.variability, v.initial or "",
        shape, _start(v, shape), _limit(v, declared, "min", low), _limit(v, declared, "max", high),
        _limit(v, declared, "nominal", 1.0), v.unit or getattr(declared, "unit", None) or "", index,
        bool(v.clocks),
    )  # fmt: skip


def _limit(v: Any, declared: Any, name: str, otherwise: float) -> float:
    text = getattr(v, name) or getattr(declared, name, None)
    items = getattr(declared, "items", None)
    if text is None and items and name in ("min", "max"):
        values = [int(i.value) if i.value else n + 1 for n, i in enumerate(items)]
        return float(min(values) if name == "min" else max(values))
    return _number(text, otherwise)


def _start(v: Any, shape: tuple[int, ...]) -> Array | None:
    if v.start is None or v.type not in NUMERIC:
        return None
    words = {"true": "1", "false": "0"}
    values = [float(words.get(t, t)) for t in str(v.start).split()]
    size = math.prod(shape)
    return np.array(values * size if len(values) == 1 else values)


def _number(text: Any, otherwise: float) -> float:
    return otherwise if text is None else float(text)
