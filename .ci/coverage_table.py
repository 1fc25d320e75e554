"""Tables of coverage: coverage_table.py COVERAGE_JSON FOLDER_OF_GCDA_FILES."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

RUNTIME = {p.name for p in (Path(__file__).parents[1] / "fmus" / "native").glob("*.c")}


def packages(report: Path) -> None:
    """Lines and branches of each package, from the report of coverage.py."""
    totals: dict[str, Counter[str]] = {}
    for name, file in json.loads(report.read_text())["files"].items():
        package = Path(name).parts[Path(name).parts.index("sightline") + 1]
        totals.setdefault(package, Counter()).update(
            {k: v for k, v in file["summary"].items() if isinstance(v, int)}
        )
    for package, n in sorted(totals.items()):
        row(package, n["covered_lines"], n["num_statements"],
            n["covered_branches"], n["num_branches"])  # fmt: skip


def runtime(folder: Path) -> None:
    """Lines and branches of the C runtime, over all libraries that counted."""
    lines: Counter[tuple[object, ...]] = Counter()
    branches: Counter[tuple[object, ...]] = Counter()
    with tempfile.TemporaryDirectory() as scratch:
        for data in sorted(folder.glob("*.gcda")):
            done = subprocess.run(
                ["gcov", "--json-format", "--branch-probabilities", "--stdout", data.resolve()],
                cwd=scratch, check=True, capture_output=True, text=True,
            )  # fmt: skip
            for report in map(json.loads, done.stdout.splitlines()):
                for file in report["files"]:
                    if (name := Path(file["file"]).name) in RUNTIME:
                        _add(name, file["lines"], lines, branches)
    for name in sorted({str(k[0]) for k in lines}):
        mine = [[n > 0 for k, n in c.items() if k[0] == name] for c in (lines, branches)]
        row(name, *(n for kind in mine for n in (sum(kind), len(kind))))
    all_ = [[n > 0 for n in c.values()] for c in (lines, branches)]
    row("C runtime", *(n for kind in all_ for n in (sum(kind), len(kind))))


def _add(
    name: str, found: list[dict[str, object]], lines: Counter[tuple[object, ...]],
    branches: Counter[tuple[object, ...]],
) -> None:  # fmt: skip
    for line in found:
        lines[name, line["line_number"]] += line["count"]  # type: ignore[operator]
        several: list[dict[str, int]] = line["branches"]  # type: ignore[assignment]
        for number, branch in enumerate(several):
            branches[name, line["line_number"], len(several), number] += branch["count"]


def row(name: str, *counts: int) -> None:
    """Shares of lines and of branches."""
    shares = [
        f"{100 * hit / all_:5.1f} % of {all_:6,}" if all_ else "-"
        for hit, all_ in zip(counts[::2], counts[1::2], strict=True)
    ]
    print(f"{name:<16} lines {shares[0]:<20} branches {shares[1]}")


if __name__ == "__main__":
    packages(Path(sys.argv[1]))
    runtime(Path(sys.argv[2]))
