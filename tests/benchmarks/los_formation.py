"""Microseconds per FMU step of example los_formation, Python and native FMUs side by side.

Run from the project's folder: python -m tests.benchmarks.los_formation
"""

from __future__ import annotations

import statistics
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "los_formation" / "system.toml"
STEPS = {"native": 5000, "python": 200}
ROUNDS = 3
CONFIG = """
extends = '{example}'
[simulation]
stop_time = {stop}
step = 0.01
[record]
every = {stop}
"""


def system(target: str, folder: Path) -> System:
    """The example with all blocks built for one target."""
    plain = System.from_toml(EXAMPLE)
    text = CONFIG.format(example=EXAMPLE, stop=STEPS[target] * 0.01)
    text += "".join(f'[instances.{n}]\ntarget = "{target}"\n' for n in plain.graph.index)
    config = folder / f"{target}.toml"
    config.write_text(text, encoding="utf-8")
    return System.from_toml(config)


def main() -> None:
    """Print the table."""
    table = Table(title="los_formation, 12 FMUs, step 10 ms")
    for heading in ("target", "us per communication step", "us per FMU step", "ratio"):
        table.add_column(heading, justify="right")
    medians = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        systems = {target: system(target, folder) for target in STEPS}
        seconds: dict[str, list[float]] = {target: [] for target in STEPS}
        for _ in range(ROUNDS):
            for target, runs in seconds.items():
                runs.append(systems[target].execute(folder / target).seconds)
        for target, runs in seconds.items():
            medians[target] = statistics.median(runs) / STEPS[target] * 1e6
    fmus = len(systems["native"].graph.nodes)
    for target, median in medians.items():
        ratio = median / medians["native"]
        table.add_row(target, f"{median:.1f}", f"{median / fmus:.2f}", f"{ratio:.1f}")
    Console().print(table)


if __name__ == "__main__":
    main()
