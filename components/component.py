"""The base class of all blocks: declarations in, checked equations out.

A block declares its quantities in the class body and writes its equations as methods that receive
by name what they use and return a dict of declared quantities:

==============  =====================================  ==========================================
method          may receive                            returns
==============  =====================================  ==========================================
``derivatives`` inputs, parameters, states, time       the rate of every state
``outputs``     the same and noise                     every output that is not a state
``update``      the same and noise                     discrete states after the tick
``project``     states, parameters                     states moved back to their manifold
``requirements`` inputs, parameters, states            message -> condition that must hold
==============  =====================================  ==========================================

At a tick, ``outputs`` and ``update`` both see the discrete states from before the tick
(y_k = g(x_k, u_k), x_k+1 = f(x_k, u_k)); outputs are held until the next tick.
Blocks hold no values: one instance serves any number of simulations.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar

import numpy as np

from .declarations import (
    Array,
    DiscreteState,
    Input,
    Noise,
    Output,
    Parameter,
    Quantity,
    SamplePeriod,
    State,
    Structure,
)
from .errors import DeclarationError, nearest

EQUATIONS: dict[str, tuple[type, ...]] = {
    "derivatives": (Input, Parameter, State, DiscreteState),
    "outputs": (Input, Parameter, State, DiscreteState, Noise),
    "update": (Input, Parameter, State, DiscreteState, Noise),
    "project": (Parameter, State),
    "requirements": (Input, Parameter, State, DiscreteState),
}
TIME = "time"
MOST = 10_000  # of a structure: what can be traced and compiled in the end
RESERVED = ("time", "seed", "solver", "solver_step", "relative_tolerance", "absolute_tolerance")


class _Body(dict[str, Any]):
    """Class body that refuses a second declaration of the same name."""

    def __init__(self, component: str) -> None:
        super().__init__()
        self._component = component

    def __setitem__(self, name: str, value: Any) -> None:
        if isinstance(self.get(name), Quantity | Structure):
            raise DeclarationError(
                self._component, name, "declared twice", "give each quantity a name of its own"
            )
        super().__setitem__(name, value)


class _ComponentType(type):
    @classmethod
    def __prepare__(cls, name: str, bases: tuple[type, ...], /, **_: Any) -> _Body:
        return _Body(name)

    def __new__(
        cls, name: str, bases: tuple[type, ...], body: dict[str, Any], **options: Any
    ) -> _ComponentType:
        return super().__new__(cls, name, bases, dict(body), **options)


class Component(metaclass=_ComponentType):
    """A block. Subclass it, declare quantities, write equations; see the module's docstring.

    ``Component(**structure)`` binds the structure's integers and resolves all shapes; it raises
    DeclarationError if a structure name or value is wrong.
    """

    declarations: ClassVar[dict[str, Quantity]] = {}
    structures: ClassVar[dict[str, Structure]] = {}
    default_solver_step: ClassVar[float] = 0.01  # s

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        body = {n: v for n, v in vars(cls).items() if isinstance(v, Quantity | Structure)}
        named = {n: replace(v, name=n) for n, v in body.items()}
        cls.structures = cls.structures | {
            n: v for n, v in named.items() if isinstance(v, Structure)
        }
        cls.declarations = cls.declarations | {
            n: v for n, v in named.items() if isinstance(v, Quantity)
        }
        _check_declarations(cls)
        _check_signatures(cls)

    def __init__(self, **structure: int) -> None:
        cls = type(self)
        for name, value in structure.items():
            if name not in cls.structures:
                raise DeclarationError(
                    cls.__name__, name, "no such structure", nearest(name, cls.structures)
                )
            least = cls.structures[name].min
            if not isinstance(value, int) or value < least:
                raise DeclarationError(
                    cls.__name__, name, f"{value!r} is not an integer >= {least}"
                )
            if value > MOST:
                raise DeclarationError(cls.__name__, name, f"{value} is more than {MOST}")
        self.structure: dict[str, int] = {
            n: structure.get(n, s.default) for n, s in cls.structures.items()
        }
        self.quantities: dict[str, Quantity] = {}
        for name, quantity in cls.declarations.items():
            try:
                self.quantities[name] = quantity.resolve(self.structure)
            except ValueError as error:
                raise DeclarationError(cls.__name__, name, str(error)) from None

    @property
    def name(self) -> str:
        """The block's name: that of its class."""
        return type(self).__name__

    def of_type(self, *kinds: type) -> dict[str, Quantity]:
        """The resolved quantities declared as any of ``kinds``, in order of declaration."""
        return {n: q for n, q in self.quantities.items() if isinstance(q, kinds)}

    @property
    def inputs_(self) -> dict[str, Quantity]:
        """Input ports by name."""
        return self.of_type(Input)

    @property
    def outputs_(self) -> dict[str, Quantity]:
        """Output ports by name: states declared with ``output=True``, then outputs."""
        states = {n: q for n, q in self.of_type(State, DiscreteState).items()
                  if getattr(q, "output", False)}
        return states | self.of_type(Output)

    @property
    def sampled(self) -> bool:
        """Whether the block has a sample period."""
        return bool(self.of_type(SamplePeriod))

    def has(self, equation: str) -> bool:
        """Whether the block defines this equation method."""
        return callable(getattr(self, equation, None))

    def arguments(self, equation: str) -> tuple[str, ...]:
        """Names that an equation method receives."""
        return _names(getattr(type(self), equation))

    def expected(self, equation: str) -> dict[str, Quantity]:
        """The quantities that an equation method must return (``update``, ``project``: may)."""
        kind = {"outputs": Output, "update": DiscreteState}.get(equation, State)
        return self.of_type(kind)

    def evaluate(self, equation: str, values: Mapping[str, Any]) -> dict[str, Any]:
        """Call one equation method with what it uses of ``values``; numbers or symbols alike."""
        method: Callable[..., dict[str, Any]] = getattr(self, equation)
        known = {**self.structure, **values}
        return method(**{n: known[n] for n in self.arguments(equation)})

    def start_values(self) -> dict[str, Array]:
        """Start value of every quantity, and time 0."""
        values: dict[str, Array] = {n: q.value for n, q in self.quantities.items()}
        return values | {TIME: np.array(0.0)}

    def check(self) -> None:
        """Evaluate every equation at the start values.

        Raises DeclarationError naming the component and the port if an equation returns an
        unknown name, leaves one out, or returns a value of the wrong shape.
        """
        values = self.start_values()
        for equation in EQUATIONS:
            if self.has(equation):
                with np.errstate(all="ignore"):
                    result = self.evaluate(equation, values)
                self._check_result(equation, result)

    def _check_result(self, equation: str, result: Any) -> None:
        if not isinstance(result, dict):
            raise DeclarationError(
                self.name, equation, f"returns {type(result).__name__}", "return a dict by name"
            )
        if equation == "requirements":
            for message, condition in result.items():
                if np.shape(condition) != ():
                    raise DeclarationError(
                        self.name, equation, f"{message!r} is not a single condition",
                        "reduce it, for example by np.min or np.max",
                    )
            return
        expected = self.expected(equation)
        for name, value in result.items():
            if name not in expected:
                raise DeclarationError(
                    self.name, name, f"returned by {equation} but not declared as such",
                    nearest(name, expected),
                )
            shape = np.shape(value)
            if shape != expected[name].dimensions:
                raise DeclarationError(
                    self.name, name,
                    f"{equation} returns shape {shape}, declared is {expected[name].dimensions}",
                )
        if equation in ("derivatives", "outputs"):
            for name in expected:
                if name not in result:
                    raise DeclarationError(
                        self.name, name, f"not returned by {equation}",
                        f"add it to the dict that {equation} returns",
                    )


@cache
def _names(method: Callable[..., Any]) -> tuple[str, ...]:
    return tuple(inspect.signature(method).parameters)[1:]  # without self


def _check_declarations(cls: type[Component]) -> None:
    for name, quantity in cls.declarations.items():
        if name in RESERVED or hasattr(Component, name) or name.startswith("_"):
            raise DeclarationError(cls.__name__, name, "this name is reserved", "choose another")
        if not isinstance(quantity.unit, str) or not quantity.unit:
            raise DeclarationError(
                cls.__name__, name, "unit is missing", "give an SI unit, or \"1\" for none"
            )
        for size in quantity.shape if isinstance(quantity.shape, tuple) else ():
            if not isinstance(size, str) and (not isinstance(size, int) or size < 1):
                raise DeclarationError(
                    cls.__name__, name, f"size {size!r} is not a positive integer",
                    "the first argument is the shape; give the start value as start=...",
                )
            if isinstance(size, str) and size not in cls.structures:
                raise DeclarationError(
                    cls.__name__, name, f"size {size!r} is not a declared structure",
                    nearest(size, cls.structures),
                )
    periods = [n for n, q in cls.declarations.items() if isinstance(q, SamplePeriod)]
    ticking = [n for n, q in cls.declarations.items() if isinstance(q, DiscreteState | Noise)]
    if ticking and not periods:
        raise DeclarationError(
            cls.__name__, ticking[0], "changes at ticks, but the block has no sample period",
            "declare sample_period = SamplePeriod()",
        )
    if periods and periods != ["sample_period"]:
        raise DeclarationError(
            cls.__name__, periods[0], "a SamplePeriod must be named sample_period"
        )


def _check_signatures(cls: type[Component]) -> None:
    for equation, kinds in EQUATIONS.items():
        method = getattr(cls, equation, None)
        if method is None:
            continue
        if not inspect.isfunction(method):
            raise DeclarationError(
                cls.__name__, equation, "is the name of an equation method", "rename the quantity"
            )
        allowed = [n for n, q in cls.declarations.items() if isinstance(q, kinds)]
        allowed += [*cls.structures, TIME]
        for name in _names(method):
            if name not in allowed:
                raise DeclarationError(
                    cls.__name__, equation, f"asks for {name!r}, which it cannot receive",
                    nearest(name, allowed),
                )
    for equation, kind in (("derivatives", State), ("outputs", Output), ("update", DiscreteState)):
        declared = [n for n, q in cls.declarations.items() if isinstance(q, kind)]
        if declared and not hasattr(cls, equation):
            raise DeclarationError(
                cls.__name__, declared[0], f"the block has no method {equation}",
                f"write {equation}(self, ...)",
            )

