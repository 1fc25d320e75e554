"""The command line. Commands import what they need when they run, so that help is quick."""

from __future__ import annotations

import io
import os
import sys
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from .errors import NO_ROOM
from .exit_codes import FAILED, STOPPED

app = typer.Typer(
    name="sightline",
    epilog="Example:  sightline demo --out first-run",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; created.")]
Set = Annotated[
    list[str] | None,
    typer.Option(
        "--set", help="instance.name=value, simulation.step=value or repeat.i=count; repeatable."
    ),
]
Csv = Annotated[bool, typer.Option("--csv", help="Write results.csv and results_units.csv too.")]
Isolate = Annotated[
    bool, typer.Option("--isolate", help="Run every FMU in a process of its own.")
]


class Kind(StrEnum):
    """Kinds of figures."""

    time = "time"
    angle = "angle"
    trajectory = "trajectory"
    activity = "activity"


class Form(StrEnum):
    """Forms of pictures."""

    png = "png"
    svg = "svg"


class Scale(StrEnum):
    """Scales of an axis."""

    linear = "linear"
    log = "log"


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        typer.echo(f"sightline {version('sightline')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_version, is_eager=True, help="Show it and exit."),
    ] = False,
) -> None:
    """Spacecraft formation-flying blocks as FMUs, and their co-simulation."""


@app.command("list", epilog="Example:  sightline list")
def list_blocks() -> None:
    """List the blocks by family."""
    from .commands import catalogue as command_catalogue

    command_catalogue.list_blocks()


@app.command(epilog="Example:  sightline info FreeRigidBody")
def info(
    name: Annotated[str, typer.Argument(help="A block of the catalogue, or file.py:Class.")],
) -> None:
    """Show a block's ports, parameters, units, frames, equations and source."""
    from .commands import catalogue as command_catalogue

    raise typer.Exit(command_catalogue.info(name))


@app.command(epilog="Example:  sightline build FreeRigidBody my_blocks.py:MyController --out built")
def build(
    names: Annotated[list[str], typer.Argument(help="Blocks of the catalogue, or file.py:Class.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the FMUs.")] = Path("."),
    target: Annotated[
        str | None,
        typer.Option(help="python or native; native where a C compiler is found if not given."),
    ] = None,
    fmi: Annotated[int, typer.Option(min=2, max=3, help="Version of FMI.")] = 2,
    platform: Annotated[
        str | None, typer.Option(help="Platforms of a native FMU: linux-x86_64,windows-x86_64,...")
    ] = None,
    structure: Annotated[
        list[str] | None, typer.Option(help="name=number for the block's structure; repeatable.")
    ] = None,
) -> None:
    """Build FMUs of blocks."""
    from .commands import catalogue as command_catalogue

    raise typer.Exit(
        command_catalogue.build(names, out, target, fmi, platform, structure or [])
    )


@app.command(epilog="Example:  sightline run system.toml --out results --set craft1.mass=12.5")
def run(
    config: Annotated[Path, typer.Argument(help="The system's TOML file.")],
    out: Out,
    settings: Set = None,
    csv: Csv = False,
    checkpoint_every: Annotated[
        float, typer.Option(min=0.0, help="Simulated seconds between writing checkpoint.h5.")
    ] = 0.0,
    resume: Annotated[
        Path | None, typer.Option(help="Go on from this checkpoint.h5, beside its results.")
    ] = None,
    isolate: Isolate = False,
) -> None:
    """Build, check and co-simulate a system; leave results.h5 and figures in a folder."""
    from .commands import run as command_run

    checkpoints = command_run.Checkpoints(checkpoint_every, resume)
    raise typer.Exit(command_run.run(config, out, settings or [], csv, checkpoints, isolate))


@app.command(epilog="Example:  sightline explain system.toml --graph system.svg")
def explain(
    config: Annotated[Path, typer.Argument(help="The system's TOML file.")],
    graph: Annotated[
        Path | None, typer.Option("--graph", "-g", help="Draw it: a .svg, .png or .pdf file.")
    ] = None,
    settings: Set = None,
) -> None:
    """Say what a run will do: order, rates, timing of connections, loops, units, frames."""
    from .commands import explain as command_explain

    raise typer.Exit(command_explain.run(config, settings or [], graph))


@app.command(epilog="Example:  sightline verify built/*.fmu --junit report.xml")
def verify(
    files: Annotated[list[Path], typer.Argument(help="FMU files, of any origin.")],
    junit: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the report as JUnit XML too.")
    ] = None,
    only: Annotated[
        list[str] | None, typer.Option(help="A check or a family of checks; repeatable.")
    ] = None,
    reference: Annotated[
        Path | None, typer.Option(help="Reference solution as CSV; NAME_in.csv gives inputs.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of random inputs and calls.")] = 0,
    thorough: Annotated[
        bool, typer.Option("--thorough", help="Try everything: minutes instead of seconds.")
    ] = False,
) -> None:
    """Test FMUs in isolation: description, calls, states, steps, inputs, resources."""
    from .commands import verify as command_verify

    raise typer.Exit(
        command_verify.verify(files, junit, only or [], reference, seed, thorough)
    )


@app.command(epilog="Example:  sightline demo --out first-run")
def demo(out: Out = Path("los_formation"), settings: Set = None, csv: Csv = False) -> None:
    """Co-simulate the packaged example: two spacecraft that hold a line of sight."""
    from .commands import run as command_run

    raise typer.Exit(command_run.demo(out, settings or [], csv))


@app.command(epilog="Example:  sightline plot results/results.h5 --signals 'craft*.position'")
def plot(
    results: Annotated[Path, typer.Argument(help="A results.h5 file.")],
    signals: Annotated[
        list[str] | None,
        typer.Option("--signals", "-s", help="instance.port, with * and ?; repeatable."),
    ] = None,
    kind: Annotated[
        Kind, typer.Option(help="angle, trajectory: from the last signal.")
    ] = Kind.time,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="A .png, .svg or .pdf file, or a folder.")
    ] = None,
    form: Annotated[Form, typer.Option("--format", help="Of figures in a folder.")] = Form.png,
    scale: Annotated[
        Scale | None, typer.Option(help="Of the value axis; log only where values span a decade.")
    ] = None,
    until: Annotated[float | None, typer.Option(help="End of the time axis, s.")] = None,
    title: Annotated[str | None, typer.Option(help="Headline.")] = None,
) -> None:
    """Draw signals of a results file; without --signals, the figures of its configuration."""
    from .commands import plot as command_plot

    settings = {"scale": scale and scale.value, "until": until, "title": title}
    raise typer.Exit(
        command_plot.plot(results, signals or [], kind.value, out, form.value, settings)
    )


def main() -> None:
    """Entry point. Exit codes: 0 done, 1 failed, 2 bad usage or config, 130 interrupted."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # of whatever letters a terminal knows
            stream.reconfigure(errors="backslashreplace")
    try:
        app()
    except KeyboardInterrupt:
        typer.echo("interrupted", err=True)
        sys.exit(STOPPED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(FAILED)
    except OSError as error:
        if error.errno not in NO_ROOM:
            raise
        typer.echo(f"cannot write: {error.strerror}", err=True)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())  # or Python tries again, and complains, at its end
        sys.exit(FAILED)


if __name__ == "__main__":
    main()
