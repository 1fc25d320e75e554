"""``sightline plot``: figures from a results file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..config.model import Plot
from ..config.parsing import parse
from ..exit_codes import DONE, FAILED, MISUSED
from ..results.curves import chosen, missing
from ..results.file import Results, read
from ..results.plots import draw, figure_of, save
from .terminal import console

SUFFIXES = (".png", ".svg", ".pdf")


def plot(
    file: Path, signals: Sequence[str], kind: str, out: Path | None, form: str,
    settings: dict[str, Any],
) -> int:  # fmt: skip
    """Draw signals of a results file, or without signals the figures of its config.

    ``settings``: other keys of a plot, None where not given. Returns the exit code.
    """
    errors = console(stderr=True)

    def fail(text: str, code: int) -> int:
        errors.print(text, markup=False)
        return code

    try:
        results = read(file)
    except OSError as error:
        return fail(f"{file} is not a results file: {error}", FAILED)
    if not len(results.time):
        return fail(f"{file} holds no samples", FAILED)
    if not results.complete:
        errors.print(f"{file} is incomplete: its run ended at t = {results.time[-1]:.6g} s, "
                     "before its stop time", markup=False)  # fmt: skip
    problems = [missing(p, results) for p in signals if not chosen([p], results)]
    if problems:
        return fail("\n".join(map(str, problems)), MISUSED)
    try:
        paths = _draw(file, results, signals, kind, out, form, settings)
    except ValidationError as error:
        return fail("\n".join(e["msg"] for e in error.errors(include_url=False)), MISUSED)
    except ValueError as error:
        return fail(str(error), MISUSED)
    except OSError as error:
        return fail(f"cannot write the figure: {error}", FAILED)
    console().print("\n".join(str(p) for p in paths), markup=False)
    return DONE


def _draw(
    file: Path, results: Results, signals: Sequence[str], kind: str, out: Path | None,
    form: str, settings: dict[str, Any],
) -> list[Path]:  # fmt: skip
    given = {k: v for k, v in settings.items() if v is not None}
    suffix = f".{form}"
    one = out is not None and out.suffix in SUFFIXES
    folder = out if out is not None and not one else file.parent
    if one and not signals:
        raise ValueError(f"--out {out} is one figure: say what is in it with --signals")
    folder.mkdir(parents=True, exist_ok=True)
    if not signals:
        plots = [p.model_copy(update=_renamed(p, suffix)) for p in _of_config(results)]
        return draw(folder, plots, results, suffix)
    title = given.pop("title", None) or ", ".join(signals)
    plot = Plot(title=title, signals=list(signals), kind=kind, **given)  # type: ignore[arg-type]
    if not one or out is None:
        return draw(folder, [plot], results, suffix)
    out.parent.mkdir(parents=True, exist_ok=True)
    save(figure_of(plot, results), out)
    return [out]


def _of_config(results: Results) -> list[Plot]:
    """The plots of the config that made the results; without any, one of everything."""
    tables = parse(results.config).get("plots", [])
    plots = [Plot.model_validate(t) for t in tables]
    return plots or [Plot(title="All signals", signals=["*"])]


def _renamed(plot: Plot, suffix: str) -> dict[str, str]:
    return {"file": str(Path(plot.file).with_suffix(suffix))} if plot.file else {}
