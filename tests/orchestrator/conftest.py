"""Systems written as TOML; FMUs by description only where nothing runs, real ones where it does."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import fmpy
import pytest

from sightline.orchestrator.errors import ConfigError
from sightline.orchestrator.system import System

UNITS = """
<UnitDefinitions>
  <Unit name="m"><BaseUnit m="1"/></Unit>
  <Unit name="km"><BaseUnit m="1" factor="1000"/></Unit>
  <Unit name="K"><BaseUnit K="1"/></Unit>
  <Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
  <Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>
</UnitDefinitions>
<TypeDefinitions><SimpleType name="Method"><Enumeration>
  <Item name="rk4" value="1"/><Item name="euler" value="2"/>
</Enumeration></SimpleType></TypeDefinitions>
"""

MACHINE = b"\xb7\0" if "aarch64" in fmpy.platform_tuple else b"\x3e\0"
NAMES = b"\0fmi2DoStep\0fmi2GetDerivatives\0fmi3InstantiateCoSimulation\0"
# a binary by its header and names only: nothing in it can run
LIBRARY = b"\x7fELF\2\1\1" + bytes(9) + b"\3\0" + MACHINE + NAMES


def variable(
    name: str, causality: str = "input", kind: str = "Real", frame: str = "",
    optional: bool = False, **attributes: str,
) -> str:  # fmt: skip
    """One ScalarVariable without its value reference."""
    inner = " ".join(f'{k}="{v}"' for k, v in attributes.items())
    port = f'<Port frame="{frame}" optional="{str(optional).lower()}"/>'
    tool = f'<Annotations><Tool name="sightline">{port}</Tool></Annotations>'
    note = tool if frame or optional else ""
    variability = {"parameter": "fixed"}.get(causality, "")
    if kind != "Real" and not variability:
        variability = "discrete"
    extra = f' variability="{variability}"' if variability else ""
    return (
        f'<ScalarVariable name="{name}" valueReference="#" causality="{causality}"{extra}>'
        f"<{kind} {inner}/>{note}</ScalarVariable>"
    )


def vector(name: str, size: int, *args: str, **attributes: Any) -> list[str]:
    """The ScalarVariables of an array."""
    return [variable(f"{name}[{i}]", *args, **attributes) for i in range(1, size + 1)]


MakeFmu = Callable[..., Path]


@pytest.fixture
def make_fmu(tmp_path: Path) -> MakeFmu:
    """Writes an FMU that can be read, not run. ``feeds``: output -> inputs that act at once."""

    def make(
        name: str, variables: Iterable[str], feeds: dict[str, list[str]] | None = None,
        head: str = f'<CoSimulation modelIdentifier="{"{name}"}"/>', version: str = "2.0",
        platform: str = fmpy.platform,
    ) -> Path:  # fmt: skip
        texts = list(variables)
        names = [t.split('"')[1] for t in texts]
        body = "".join(t.replace("#", str(i), 1) for i, t in enumerate(texts))
        unknowns = ""
        for number, text in enumerate(texts):
            if 'causality="output"' not in text:
                continue
            acting = (feeds or {}).get(names[number], []) if feeds is not None else None
            indices = " ".join(str(names.index(a) + 1) for a in acting or [])
            declared = f' dependencies="{indices}"' if acting is not None else ""
            unknowns += f'<Unknown index="{number + 1}"{declared}/>'
        xml = (
            f'<fmiModelDescription fmiVersion="{version}" modelName="{name}" guid="x">'
            f"{head.format(name=name)}{UNITS}<ModelVariables>{body}</ModelVariables>"
            f"<ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure></fmiModelDescription>"
        )
        path = tmp_path / f"{name}.fmu"
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("modelDescription.xml", xml)
            binary = f"binaries/{platform}/{name}{fmpy.sharedLibraryExtension}"
            archive.writestr(binary, LIBRARY)
        return path

    return make


SIMULATION = "[simulation]\nstop_time = 1.0\nstep = 0.1\n"


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """Writes a config of connections and instances, ``name = "table body"``."""

    def toml(
        connections: Iterable[str] = (), rest: str = "", simulation: str = SIMULATION,
        name: str = "system.toml", **instances: str,
    ) -> Path:  # fmt: skip
        lines = ["connections = [", *(f'  "{c}",' for c in connections), "]", simulation]
        for instance, body in instances.items():
            lines.append(f"[instances.{instance}]\n{body}\n")
        path = tmp_path / name
        path.write_text("\n".join([*lines, rest]), encoding="utf-8")
        return path

    return toml


@pytest.fixture
def problems() -> Callable[..., list[str]]:
    """The problems of a config, one line each, without the folder."""

    def found(path: Path, overrides: dict[str, object] | None = None) -> list[str]:
        with pytest.raises(ConfigError) as caught:
            System.from_toml(path, overrides)
        return [str(p).replace(f"{path.parent}/", "") for p in caught.value.problems]

    return found
