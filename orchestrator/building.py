"""The one place where the orchestrator reaches the FMU builder: config in, .fmu files out.

Only the command line and :mod:`.system` come here, and only when a config names components.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from .config.loading import Loaded
from .config.model import Instance
from .errors import Problem

Say = Callable[[str], None]


def component_name(component: str, folder: Path) -> str:
    """A block's name as it is; ``file.py:Class`` with its path seen from the config's folder."""
    return str(folder / component) if ".py" in component else component


def build_all(loaded: Loaded, say: Say) -> tuple[dict[str, Path], list[Problem]]:
    """Build what the instances name, each distinct component once; files, and what failed."""
    files: dict[str, Path] = {}
    problems: list[Problem] = []
    known: dict[tuple[object, ...], Path | tuple[str, ...]] = {}
    notes: set[str] = set()

    def note(text: str) -> None:
        if text not in notes:
            notes.add(text)
            say(f"note: {text}")

    for name, instance in loaded.config.instances.items():
        if instance.builds is None:
            continue
        component = component_name(instance.builds, loaded.folder)
        key = (component, tuple(sorted(instance.structure.items())), instance.target)
        if key not in known:
            known[key] = _build(component, instance, say, note)
        built = known[key]
        if isinstance(built, Path):
            files[name] = built
            continue
        path = ("instances", name, "component")
        for reason in built:
            problem = Problem(".".join(path), f"cannot be built: {reason}")
            problems.append(loaded.place(problem, path))
    return files, problems


def _build(component: str, instance: Instance, say: Say, note: Say) -> Path | tuple[str, ...]:
    from ..fmus.build import build
    from ..fmus.errors import BuildError

    def begun() -> None:
        say(f"building {component}")

    try:
        return build(
            component, structure=instance.structure, target=instance.target, begun=begun,
            note=note,
        )
    except BuildError as error:
        return tuple(error.problems)


def compiler_missing() -> bool:
    """Whether FMUs are built for Python because there is no C compiler."""
    from ..fmus.native.target import compiler_available

    return not compiler_available()
