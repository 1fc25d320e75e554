"""Spacecraft formation-flying blocks in plain numpy: declarations first, equations below."""

from .component import Component
from .declarations import (
    DiscreteState,
    Input,
    Noise,
    Output,
    Parameter,
    SamplePeriod,
    State,
    Structure,
)
from .errors import DeclarationError

__all__ = [
    "Component",
    "DeclarationError",
    "DiscreteState",
    "Input",
    "Noise",
    "Output",
    "Parameter",
    "SamplePeriod",
    "State",
    "Structure",
]
