"""What a run was made of, besides its config: the files of the FMUs, by their content."""

from __future__ import annotations

from ..fmi.extraction import digest
from ..wiring.graph import SystemGraph


def fmus(graph: SystemGraph) -> tuple[str, ...]:
    """A line for each FMU: the file's SHA-256, the model's name, the instances. Raises OSError."""
    instances: dict[str, list[str]] = {}
    digests = {path: digest(path) for path in {node.fmu.path for node in graph.nodes}}
    for node in graph.nodes:
        key = f"{digests[node.fmu.path]} {node.fmu.model_name}"
        instances.setdefault(key, []).append(node.name)
    return tuple(f"{key}: {', '.join(names)}" for key, names in instances.items())
