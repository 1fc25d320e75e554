"""Reads .fmu files into descriptions; says what is wrong with a file that cannot be used."""

from __future__ import annotations

import itertools
import math
import os
import re
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import fmpy
import fmpy.model_description as fmd
from lxml import etree

from ...fmus.safe_archive import inspect
from ...fmus.safe_description import description_problems
from ..alike import few
from ..errors import FmuError
from .description import FmuDescription, Kind, Port
from .units import BASE, Unit

KINDS: dict[str, Kind] = {
    "Real": "real",
    "Integer": "integer",
    "Boolean": "boolean",
    "String": "string",
    "Enumeration": "enumeration",
    "Float64": "real",
    "Float32": "real",
    **{f"{sign}Int{bits}": "integer" for sign in ("", "U") for bits in (8, 16, 32, 64)},
}
INDEXED = re.compile(r"^(?P<base>.+)\[(?P<index>\d+(?:,\s*\d+)*)\]$")
SUPPORTED = ("2.0", "3.0")
ENUMERATED = {"2.0": "Integer", "3.0": "Int64"}
PLATFORMS = {"2.0": fmpy.platform, "3.0": fmpy.platform_tuple}


def read(path: Path) -> FmuDescription:
    """The description of an FMU. Raises FmuError if the file cannot be run on this machine."""
    text, names = _open(path)
    version = text.get("fmiVersion", "")
    version = "3.0" if version.startswith("3.0.") else version
    if version not in SUPPORTED:
        raise FmuError(
            str(path),
            f"is of FMI {version or '(no version)'}",
            f"supported: FMI {', '.join(SUPPORTED)} for co-simulation",
        )
    if problems := description_problems(text):
        found = "; ".join(few(problems))
        raise FmuError(str(path), f"has a modelDescription.xml that cannot be used: {found}")
    try:
        model = fmd.read_model_description(str(path), validate=False)
    except Exception as error:
        raise FmuError(str(path), f"its modelDescription.xml is not valid: {error}") from None
    if model.coSimulation is None:
        raise FmuError(
            str(path),
            "offers no co-simulation, only model exchange",
            "export it for co-simulation",
        )
    offered = model.coSimulation
    _require_binary(path, offered.modelIdentifier, names, PLATFORMS[version])
    variables = [v for v in model.modelVariables if v.type in KINDS]
    flags = text.find("CoSimulation").attrib
    return FmuDescription(
        path=path,
        version=version,
        model_name=model.modelName,
        identifier=offered.modelIdentifier,
        token=model.guid if version == "2.0" else model.instantiationToken,
        description=model.description or "",
        generator=model.generationTool or "",
        ports=ports(variables, _units(model), _notes(text), ENUMERATED[version]),
        others={v.name: v.type for v in model.modelVariables if v.type not in KINDS},
        feedthrough=_feedthrough(model),
        variable_step=offered.canHandleVariableCommunicationStepSize,
        fixed_step=_number(flags.get("fixedInternalStepSize")),
        can_restore=_flag(flags, "canGetAndSetFMUstate", "canGetAndSetFMUState"),
        can_serialize=_flag(flags, "canSerializeFMUstate", "canSerializeFMUState"),
        can_interpolate=_flag(flags, "canInterpolateInputs"),
        has_derivatives=_flag(
            flags, "providesDirectionalDerivative", "providesDirectionalDerivatives"
        ),
        event_mode=_flag(flags, "hasEventMode"),
        only_once=_flag(flags, "canBeInstantiatedOnlyOncePerProcess"),
    )


def _flag(attributes: Mapping[str, str], *names: str) -> bool:
    return any(attributes.get(name) in ("true", "1") for name in names)


def _number(text: str | None) -> float | None:
    return None if text is None else float(text)


def _open(path: Path) -> tuple[Any, list[str]]:
    if not os.path.exists(path):
        siblings = sorted(p.name for p in path.parent.glob("*.fmu"))[:8]
        remedy = f"in that folder: {', '.join(siblings)}" if siblings else ""
        raise FmuError(str(path), "does not exist", remedy)
    if not os.path.isfile(path):
        raise FmuError(str(path), "is not a file", "name the .fmu file")
    if problems := inspect(path):
        found = "; ".join(f"cannot be used: {p}" if p.member else p.detail for p in problems)
        raise FmuError(str(path), found, "build or fetch it again")
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read("modelDescription.xml")), archive.namelist()


def _require_binary(path: Path, identifier: str, names: Iterable[str], platform: str) -> None:
    present = sorted({n.split("/")[1] for n in names if re.match(r"binaries/[^/]+/.", n)})
    binary = f"binaries/{platform}/{identifier}{fmpy.sharedLibraryExtension}"
    if binary not in set(names):
        has = f"it has binaries for {', '.join(present)}" if present else "it has no binaries"
        raise FmuError(
            str(path),
            f"cannot run on this platform: no {binary}",
            f"{has}; export it for {platform}",
        )


def _units(model: Any) -> dict[str, Unit]:
    units = {}
    for unit in model.unitDefinitions:
        base = unit.baseUnit
        if base is None:
            units[unit.name] = Unit(unit.name)
        else:
            exponents = tuple(int(getattr(base, b, 0) or 0) for b in BASE)
            units[unit.name] = Unit(unit.name, exponents, base.factor, base.offset)
    return units


def _notes(text: Any) -> dict[str, Any]:
    """This project's annotation, by the variable's name."""
    notes = {}
    for variable in text.iterfind("ModelVariables/*"):
        note = variable.find("Annotations/Tool[@name='sightline']/Port")  # FMI 2.0
        if note is None:
            note = variable.find("Annotations/Annotation[@type='sightline']/Port")  # FMI 3.0
        if note is not None:
            notes[variable.get("name")] = note
    return notes


def _feedthrough(model: Any) -> dict[int, frozenset[int]]:
    """For each output's reference the inputs' references; without a declaration, all inputs."""
    inputs = frozenset(v.valueReference for v in model.modelVariables if v.causality == "input")
    result = {v.valueReference: inputs for v in model.modelVariables if v.causality == "output"}
    for unknown in model.outputs:
        if unknown.dependencies is not None:
            acting = frozenset(v.valueReference for v in unknown.dependencies)
            result[unknown.variable.valueReference] = acting & inputs
    return result


def ports(
    variables: Iterable[Any],
    units: Mapping[str, Unit],
    notes: Mapping[str, Any],
    enumerated: str = "Integer",
) -> dict[str, Port]:
    """Scalars named ``x[1]``, ``x[2]``, ... grouped into arrays; everything else as it is."""
    groups: dict[str, list[tuple[tuple[int, ...], Any]]] = {}
    variables = list(variables)
    for variable in variables:
        match = INDEXED.match(variable.name)
        if match and not variable.shape:
            index = tuple(int(i) for i in match["index"].split(","))
            groups.setdefault(match["base"], []).append((index, variable))
    taken = {v.name for v in variables}
    shapes = {b: s for b, m in groups.items() if b not in taken and (s := _shape(m)) is not None}
    result: dict[str, Port] = {}
    for variable in variables:
        match = INDEXED.match(variable.name)
        base = match["base"] if match else ""
        if base in result and base in shapes:
            continue
        if base in shapes:
            members = [v for _, v in sorted(groups[base], key=lambda m: m[0])]
            port = _port(base, shapes[base], members, units, notes)
        else:
            port = _port(variable.name, variable.shape or (), [variable], units, notes)
        if port.kind == "enumeration":
            port = replace(port, type=enumerated)
        result[port.name] = port
    return result


def _shape(members: list[tuple[tuple[int, ...], Any]]) -> tuple[int, ...] | None:
    """The array that indices fill completely, counted from 1; None if they do not."""
    if len({(v.causality, v.type, v.unit) for _, v in members}) != 1:
        return None
    if len({len(i) for i, _ in members}) != 1:
        return None
    shape = tuple(max(axis) for axis in zip(*(i for i, _ in members), strict=True))
    if math.prod(shape) != len(members):
        return None
    full = set(itertools.product(*(range(1, n + 1) for n in shape)))
    return shape if {i for i, _ in members} == full else None


def _port(
    name: str,
    shape: tuple[int, ...],
    members: list[Any],
    units: Mapping[str, Unit],
    notes: Mapping[str, Any],
) -> Port:
    first = members[0]
    note = notes.get(first.name, {})
    declared = first.declaredType
    unit = first.unit or getattr(declared, "unit", None)
    low = first.min or getattr(declared, "min", None)
    high = first.max or getattr(declared, "max", None)
    starts = tuple(v.start for v in members)
    references = tuple(v.valueReference for v in members)
    if first.shape:  # an array of FMI 3.0
        references *= math.prod(first.shape)
        starts = tuple((first.start or "").split()) or (None,)
        starts *= len(references) if len(starts) == 1 else 1
    settable = first.variability != "constant" and (
        first.causality in ("input", "parameter") or first.initial in ("exact", "approx")
    )
    return Port(
        name=name,
        shape=shape,
        kind=KINDS[first.type],
        causality=first.causality,
        references=references,
        type=first.type,
        variability=first.variability or "continuous",
        unit=units.get(unit, Unit(unit)) if unit else None,
        frame=note.get("frame", "").strip(),
        optional=note.get("optional") == "true",
        description=first.description or "",
        settable=settable,
        start=starts if all(s is not None for s in starts) else (),
        minimum=None if low is None else float(low),
        maximum=None if high is None else float(high),
        items=tuple((i.name, int(i.value)) for i in declared.items) if declared else (),
    )
