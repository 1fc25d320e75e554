"""The interface of a block's FMU: its variables, their value references and dependencies.

Written once here and rendered for FMI 2.0 and FMI 3.0. All values of an FMU stand in one array of
doubles, in the order of VARIABLE_KINDS; a value reference is the index into it, an array
variable's that of its first element (row-major).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Literal, TypeAlias

import numpy as np

from ..components.component import Component
from ..components.declarations import (
    Array,
    DiscreteState,
    Input,
    Noise,
    Output,
    Parameter,
    Quantity,
    State,
    ValueType,
)
from .tracing import Trace

Kind: TypeAlias = Literal[
    "time", "input", "parameter", "state", "discrete", "output", "derivative", "setting"
]
KIND_OF: dict[type, Kind] = {
    Input: "input", Parameter: "parameter", State: "state", DiscreteState: "discrete",
    Output: "output",
}  # fmt: skip
GROUP_OF: dict[Kind, str] = {"input": "u", "parameter": "p", "state": "x", "discrete": "d"}

SOLVERS = ("rk4", "dormand-prince")  # items 1, 2 of the enumeration


@dataclass(frozen=True)
class Variable:
    """One variable of the FMU. ``reference`` is that of its first scalar, ``start`` is None where
    the FMU calculates the value."""

    name: str
    kind: Kind
    shape: tuple[int, ...]
    unit: str
    doc: str
    reference: int
    start: Array | None = None
    type: ValueType | Literal["enumeration"] = "real"
    frame: str | None = None
    min: float | None = None
    max: float | None = None
    nominal: float | None = None
    tunable: bool = False
    is_output: bool = False
    optional: bool = False  # an input that may well be driven by nothing
    of: str = ""  # the state that a derivative belongs to

    @property
    def size(self) -> int:
        """Number of scalars."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def references(self) -> range:
        """Value references of the scalars."""
        return range(self.reference, self.reference + self.size)

    @property
    def scalar_names(self) -> list[str]:
        """FMI 2.0 names, 1-based, row-major: ``position[1]``, ``inertia[1,2]``."""
        if not self.shape:
            return [self.name]
        stem, end = (self.name[:-1], ")") if self.kind == "derivative" else (self.name, "")
        indices = product(*(range(1, n + 1) for n in self.shape))
        return [f"{stem}[{','.join(map(str, i))}]{end}" for i in indices]


@dataclass(frozen=True)
class Model:
    """A block's FMU: its variables in order and, per scalar unknown, the scalars it depends on.

    ``trace`` is None for a block that cannot be traced; its dependencies are then those that the
    signatures of its equations show.
    """

    block: Component
    trace: Trace | None
    variables: tuple[Variable, ...]

    def of_kind(self, *kinds: Kind) -> list[Variable]:
        """Variables of these kinds, in order."""
        return [v for v in self.variables if v.kind in kinds]

    def references(self, *kinds: Kind) -> list[int]:
        """Value references of all scalars of these kinds."""
        return [r for v in self.of_kind(*kinds) for r in v.references]

    @property
    def outputs(self) -> list[Variable]:
        """Output ports: states declared as outputs, then computed outputs."""
        return [v for v in self.variables if v.is_output]

    @property
    def size(self) -> int:
        """Number of doubles."""
        return sum(v.size for v in self.variables)

    @cached_property
    def by_name(self) -> dict[str, Variable]:
        """Variables by name."""
        return {v.name: v for v in self.variables}

    @cached_property
    def dependencies(self) -> dict[int, tuple[int, ...]]:
        """Value reference of each output and derivative -> those it depends on, ascending.

        Knowns are inputs, states and discrete states; parameters are in
        ``initial_dependencies``. An output that is a state depends on itself.
        """
        return self._dependencies(("input", "state", "discrete"))

    @cached_property
    def initial_dependencies(self) -> dict[int, tuple[int, ...]]:
        """The same at initialisation, where parameters count as knowns."""
        return self._dependencies(("input", "parameter", "state", "discrete"))

    def _dependencies(self, knowns: tuple[Kind, ...]) -> dict[int, tuple[int, ...]]:
        result: dict[int, tuple[int, ...]] = {
            r: (r,) for v in self.outputs if v.kind in ("state", "discrete") for r in v.references
        }
        for kind, equation in (("output", "outputs"), ("derivative", "derivatives")):
            unknowns = self.references(kind)  # type: ignore[arg-type]
            if unknowns:
                found = self._rows(equation, knowns)
                result |= {r: tuple(found[i]) for i, r in enumerate(unknowns)}
        return result

    def _rows(self, equation: str, knowns: Iterable[Kind]) -> list[list[int]]:
        if self.trace is None:
            used = set(self.block.arguments(equation))
            some = [r for k in knowns for v in self.of_kind(k) if v.name in used
                    for r in v.references]
            return [some] * sum(q.size for q in self.block.expected(equation).values())
        patterns = [
            (self.references(k), self.trace.depends(equation, GROUP_OF[k])) for k in knowns
        ]
        rows = patterns[0][1].shape[0]
        return [
            [refs[j] for refs, pattern in patterns for j in np.flatnonzero(pattern[i])]
            for i in range(rows)
        ]


def model_of(block: Component, trace: Trace | None, *, derivatives: bool) -> Model:
    """Lay out the variables of a block's FMU; ``derivatives`` exposes the states' rates."""
    variables: list[Variable] = []
    reference = 1  # 0 is time

    def add(quantity: Quantity, kind: Kind, **more: object) -> None:
        nonlocal reference
        fields: dict[str, object] = {
            "name": quantity.name, "kind": kind, "shape": quantity.dimensions,
            "unit": quantity.unit, "doc": quantity.doc, "reference": reference,
            "start": quantity.value, "type": quantity.type, "frame": quantity.frame,
            "min": quantity.min, "max": quantity.max, "nominal": quantity.nominal,
        }  # fmt: skip
        variables.append(Variable(**(fields | more)))  # type: ignore[arg-type]
        reference += quantity.size

    for declared, kind in KIND_OF.items():
        for quantity in block.of_type(declared).values():
            more: dict[str, object] = {}
            if isinstance(quantity, Input):
                more["optional"] = quantity.optional
            if isinstance(quantity, Parameter):
                more["tunable"] = quantity.tunable
            if isinstance(quantity, State | DiscreteState):
                more["is_output"] = quantity.output
            if isinstance(quantity, Output):
                more |= {"is_output": True, "start": None}
            add(quantity, kind, **more)
    states = block.of_type(State)
    if derivatives:
        for name, state in states.items():
            rate = Quantity(state.shape, rate_unit(state.unit), frame=state.frame,
                            doc=f"rate of change of {name}", name=f"der({name})")
            add(rate.resolve({}), "derivative", start=None, of=name)
    for setting, type_ in _typed_settings(block):
        add(setting.resolve({}), "setting", type=type_)
    return Model(block, trace, tuple(variables))


def settings_of(block: Component) -> list[Quantity]:
    """What the FMU adds to the block's own parameters: solver, tolerances, seed."""
    return [setting.resolve({}) for setting, _ in _typed_settings(block)]


def rate_unit(unit: str | None) -> str:
    """The unit of a rate: ``m`` -> ``m/s``, ``m/s`` -> ``m/s2``."""
    if unit in (None, "1"):
        return "1/s"
    assert unit is not None
    if unit.endswith("/s"):
        return unit + "2"
    return unit + "/s"


def _typed_settings(block: Component) -> list[tuple[Quantity, str]]:
    settings: list[tuple[Quantity, str]] = []
    if block.of_type(State):
        settings += [
            (Parameter((), "1", 1.0, name="solver", min=1, max=len(SOLVERS),
                       doc="integration: 1 fixed-step RK4, 2 adaptive Dormand-Prince 5(4)"),
             "enumeration"),
            (Parameter((), "s", block.default_solver_step, name="solver_step", min=1e-6,
                       doc="largest step of RK4, first step of Dormand-Prince"), "real"),
            (Parameter((), "1", 1e-10, name="relative_tolerance", min=1e-15, max=1.0,
                       doc="relative tolerance of Dormand-Prince"), "real"),
            (Parameter((), "1", 1e-12, name="absolute_tolerance", min=1e-300,
                       doc="absolute tolerance of Dormand-Prince"), "real"),
        ]
    if block.of_type(Noise):
        settings.append((Parameter((), "1", 1.0, name="seed", min=0, max=2**31 - 1,
                                   doc="seed of the noise streams"), "integer"))
    return settings
