"""FMUs that act at instants of their own: what this project's FMUs say about it."""

from __future__ import annotations

from ..wiring.graph import Node

NAME = "sample_period"  # a fixed parameter, s; 0 where the FMU acts continuously


def sample_period(node: Node) -> float:
    """The period in effect, s; 0 where there is none."""
    port = node.fmu.ports.get(NAME)
    if port is None or port.causality != "parameter" or port.kind != "real" or port.shape:
        return 0.0
    for setting in node.settings:
        if setting.port.name == NAME:
            return float(setting.values[0])
    return float(port.start[0]) if port.start else 0.0
