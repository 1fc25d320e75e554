"""Builds a system in code; the result is the same data that a TOML file holds.

>>> build = Builder(stop_time=10.0, step=0.01)
>>> build.add("craft1", "FreeRigidBody", start={"angular_velocity": [0.1, 0.0, 0.0]})
>>> build.add("gyro1", "Gyro")
>>> build.connect("craft1.angular_velocity -> gyro1.angular_velocity")
>>> results = build.system().simulate()
>>> build.write("system.toml")
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .config import toml_text
from .system import System


class Builder:
    """Collects a system. Nothing is checked until :meth:`system` is called.

    ``simulation``: keys of the table of this name, such as ``stop_time`` and ``step``. ``folder``:
    where relative paths of FMUs and blocks start.
    """

    def __init__(self, *, folder: str | Path = ".", **simulation: Any) -> None:
        self.folder = Path(folder)
        self.data: dict[str, Any] = {
            "connections": [], "simulation": _plain(simulation), "instances": {},
        }  # fmt: skip

    def add(
        self,
        name: str,
        component: str | None = None,
        *,
        fmu: str | Path | None = None,
        parameters: Mapping[str, Any] | None = None,
        start: Mapping[str, Any] | None = None,
        **more: Any,
    ) -> str:
        """Add an instance of a block, or of an FMU; its name. ``more``: other keys of its table."""
        given = {
            "component": component, "fmu": None if fmu is None else str(fmu),
            "parameters": parameters, "start": start, **more,
        }  # fmt: skip
        self.data["instances"][name] = _plain({k: v for k, v in given.items() if v is not None})
        return name

    def connect(self, *connections: str) -> None:
        """Add connections ``a.output -> b.input``."""
        self.data["connections"] += connections

    def record(self, *signals: str, every: float | None = None) -> None:
        """Choose what is recorded, and how often, s."""
        table = {"signals": list(signals)} if signals else {}
        self.data["record"] = table | ({} if every is None else {"every": every})

    def plot(self, title: str, *signals: str, **more: Any) -> None:
        """Add a figure. ``more``: other keys of its table."""
        plots = self.data.setdefault("plots", [])
        plots.append(_plain({"title": title, "signals": list(signals), **more}))

    def system(self) -> System:
        """The system, checked and ready to run. Raises ConfigError with all problems."""
        return System.from_data(self.data, self.folder)

    def toml(self) -> str:
        """The system as TOML."""
        return toml_text.dump(self.data)

    def write(self, path: str | Path) -> None:
        """Write the system as TOML, to be run from ``folder``. Raises OSError."""
        Path(path).write_text(self.toml(), encoding="utf-8")


def _plain(value: Any) -> Any:
    """Arrays and numpy's numbers as TOML has them."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(v) for v in value]
    return value
