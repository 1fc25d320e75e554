"""The compiled system: where every value lives in one array, and which values go where.

Every FMU has one contiguous segment for the inputs that are set and one for its outputs, each
ordered by type; inputs that vary inside a step have two more for their values of earlier steps. A
stepper needs nothing else of the system.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

Indices = NDArray[np.intp]
Array = NDArray[np.float64]


class Act(IntEnum):
    """What a stepper does with one FMU, or with a cluster of them."""

    WRITE = 0  # copy the inputs, with their course during the step, and set them
    STEP = 1
    READ = 2  # get the outputs
    UPDATE = 3  # copy the inputs of the instant reached and set them
    SOLVE = 4  # a cluster's inputs such that they agree with its outputs


@dataclass(frozen=True)
class Block:
    """Values of one type: their value references, and where they are in the array.

    ``events``: inputs whose change is an event of the FMU.
    """

    type: str
    references: tuple[int, ...]
    first: int
    last: int
    events: bool = False


@dataclass(frozen=True)
class Segment:
    """The inputs or outputs of an FMU, by type."""

    first: int
    last: int
    blocks: tuple[Block, ...]


@dataclass(frozen=True)
class Course:
    """Inputs that vary inside a step, along a polynomial through the latest values.

    ``inputs`` are their positions; their values of the two steps before follow in the array from
    ``history`` on. ``newest`` tells at which instant a value is when it is copied: steps of the
    system before the end of the FMU's step. ``directions``: first and count of extrapolated inputs
    that may be a unit vector or quaternion.
    """

    order: int
    inputs: Indices
    references: tuple[int, ...]
    newest: tuple[int, ...]
    history: int
    directions: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Unit:
    """What is done with one FMU: input[k] = gain[k] · value[sources[k]] + shift[k], then a step.

    ``gain`` and ``shift`` are None where all values pass unchanged. The FMU steps at every
    ``every``-th communication point, in ``parts`` parts.
    """

    node: int
    inputs: Segment
    outputs: Segment
    sources: Indices
    gain: Array | None
    shift: Array | None
    every: int = 1
    parts: int = 1
    course: Course | None = None


@dataclass(frozen=True)
class Loop:
    """Inputs of a cluster that its own outputs drive; positions in the array, and units."""

    units: tuple[int, ...]
    inputs: Indices
    names: tuple[str, ...]


@dataclass(frozen=True)
class Plan:
    """Units in the order of stepping, and all acts of a communication step in order.

    An act is a pair of what is done, and the position of the unit (of the loop for SOLVE).
    ``recorded`` are the positions of one row of results, ``smooth`` those of outputs that are
    real and vary continuously.
    """

    size: int
    units: tuple[Unit, ...]
    acts: tuple[tuple[Act, int], ...]
    loops: tuple[Loop, ...]
    recorded: Indices
    smooth: Indices

    @property
    def order(self) -> int:
        """The greatest order of the inputs' courses."""
        return max((u.course.order for u in self.units if u.course), default=0)


@dataclass(frozen=True)
class Rates:
    """How an instance steps: at every n-th communication point, in so many parts."""

    every: int = 1
    parts: int = 1
