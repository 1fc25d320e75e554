"""The command line. Commands import what they need when they run, so that help is quick."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

DONE, FAILED, MISUSED, STOPPED = 0, 1, 2, 130  # exit codes

app = typer.Typer(
    name="sightline",
    help="Spacecraft formation-flying blocks as FMUs, and their co-simulation.",
    epilog="Example:  sightline demo --out first-run",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; created.")]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", help="instance.name=value for a parameter or start value; repeatable."),
]
Csv = Annotated[bool, typer.Option("--csv", help="Write results.csv too.")]


@app.command("list", epilog="Example:  sightline list")
def list_blocks() -> None:
    """List the blocks by family."""
    from . import command_catalogue

    command_catalogue.list_blocks()


@app.command(epilog="Example:  sightline info FreeRigidBody")
def info(
    name: Annotated[str, typer.Argument(help="A block of the catalogue, or file.py:Class.")],
) -> None:
    """Show a block's ports, parameters, units, frames, equations and source."""
    from . import command_catalogue

    raise typer.Exit(command_catalogue.info(name))


@app.command(epilog="Example:  sightline build FreeRigidBody my_blocks.py:MyController --out fmus")
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
    from . import command_catalogue

    raise typer.Exit(
        command_catalogue.build(names, out, target, fmi, platform, structure or [])
    )


@app.command(epilog="Example:  sightline run system.toml --out results --set craft1.mass=12.5")
def run(
    config: Annotated[Path, typer.Argument(help="The system's TOML file.")],
    out: Out,
    settings: Set = None,
    csv: Csv = False,
) -> None:
    """Build, check and co-simulate a system; leave results.h5 and figures in a folder."""
    from . import command_run

    raise typer.Exit(command_run.run(config, out, settings or [], csv))


@app.command(epilog="Example:  sightline demo --out first-run")
def demo(out: Out = Path("los_formation"), settings: Set = None, csv: Csv = False) -> None:
    """Co-simulate the packaged example: two spacecraft that hold a line of sight."""
    from . import command_run

    raise typer.Exit(command_run.demo(out, settings or [], csv))


def main() -> None:
    """Entry point. Exit codes: 0 done, 1 failed, 2 bad usage or config, 130 interrupted."""
    try:
        app()
    except KeyboardInterrupt:
        typer.echo("interrupted", err=True)
        sys.exit(STOPPED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(FAILED)


if __name__ == "__main__":
    main()
