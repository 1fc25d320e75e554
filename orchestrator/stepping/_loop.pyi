from typing import Any

from numpy.typing import NDArray

from ..schedule.plan import Array, Indices

TYPES: dict[str, int]

class Loop:
    rows: int
    act: int
    number: int
    status: int
    part: int

    def __init__(self, count: int, moves: int, links: int, widest: int) -> None: ...
    def prepare(
        self, values: Array, recorded: Indices, acts: NDArray[Any], start: float, step: float
    ) -> None: ...
    def add(
        self,
        component: int,
        functions: tuple[int, ...],
        three: bool,
        final: bool,
        every: int,
        parts: int,
        first: int,
        sources: Indices,
        gain: Array | None,
        shift: Array | None,
        sets: list[tuple[int, object, int, int, int]],
        gets: list[tuple[int, object, int, int, int]],
    ) -> None: ...
    def follow(
        self,
        derive: int,
        which: Indices,
        references: NDArray[Any],
        orders: NDArray[Any],
        directions: NDArray[Any],
        weights: Array,
        polynomial: Array,
        derivatives: Array,
        history: int,
    ) -> None: ...
    def advance(
        self,
        first: int,
        last: int,
        stride: int,
        buffer: Array,
        act: int = 0,
        free: tuple[float, float] | None = None,
    ) -> bool: ...
