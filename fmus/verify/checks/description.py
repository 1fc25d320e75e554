"""The description by itself, and against the binaries that it describes."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterator

import fmpy
import numpy as np
from fmpy import fmi2, fmi3
from fmpy.model_description import ValidationError, read_model_description
from fmpy.validation import validate_fmu

from ...safe_binary import EXTENSIONS, FOLDERS, offered
from ...units import UnitError, unit
from ..driver import NoInstance, good
from ..lab import Lab
from ..registry import NotApplicable, Notes, check
from ..subject import BOOLEANS, FLOATS, NUMERIC, Variable

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@check("description.schema", "the description follows the standard's XML schema")
def schema(lab: Lab, notes: Notes) -> None:
    try:
        read_model_description(str(lab.subject.folder), validate=True)
    except ValidationError as error:
        for problem in error.problems:
            if "Schema" in problem or "Element" in problem or "line" in problem:
                notes.wrong("modelDescription.xml", problem)
    except Exception as error:
        notes.wrong("modelDescription.xml", str(error))


@check("description.validation", "FMPy's validation has nothing to say")
def validation(lab: Lab, notes: Notes) -> None:
    for problem in validate_fmu(str(lab.subject.path)):
        notes.wrong("modelDescription.xml", problem)


@check("description.units", "units are defined, and by the dimension that their names say")
def units(lab: Lab, notes: Notes) -> None:
    defined = {u.name: u.baseUnit for u in lab.subject.description.unitDefinitions}
    used: dict[str, str] = {}
    for variable in lab.subject.variables:
        if variable.unit:
            used.setdefault(variable.unit, variable.name)
    if not used:
        raise NotApplicable("no variable has a unit")
    notes.tried["units"] = len(used)
    for name, where in used.items():
        if name not in defined:
            notes.wrong(where, f"the unit {name} is not defined", "a Unit in UnitDefinitions")
            continue
        try:
            known = unit(name)
        except UnitError:
            known = None
        base = defined[name]
        if base is None:
            if known is None or known.exponents is not None:
                notes.wrong(name, "has no BaseUnit", "exponents of the base units")
        elif known is not None and known.exponents is not None:
            _compare_unit(name, base, known.exponents, known.factor, notes)


def _compare_unit(
    name: str, base: object, exponents: dict[str, int], factor: float, notes: Notes
) -> None:
    found = {b: int(getattr(base, b) or 0) for b in BASE if int(getattr(base, b) or 0)}

    def without_angle(powers: dict[str, int]) -> dict[str, int]:
        return {b: p for b, p in powers.items() if b != "rad"}

    if without_angle(found) != without_angle(exponents):
        notes.wrong(name, f"is defined as {_power(found)}", _power(exponents))
    elif not math.isclose(float(getattr(base, "factor") or 1.0), factor, rel_tol=1e-9):  # noqa: B009
        notes.wrong(name, f"has the factor {getattr(base, 'factor')}", f"{factor:g}")  # noqa: B009


def _power(exponents: dict[str, int]) -> str:
    return ".".join(f"{b}{p if p != 1 else ''}" for b, p in exponents.items()) or "1"


@check("description.structure", "the model structure is complete and consistent")
def structure(lab: Lab, notes: Notes) -> None:
    subject = lab.subject
    outputs = [u.variable.name for u in subject.structure("outputs")]
    for variable in (v for v in subject.variables if v.causality == "output"):
        if outputs.count(variable.name) != 1:
            found = f"stands {outputs.count(variable.name)} times in the outputs of the structure"
            notes.wrong(variable.name, found, "once")
    states = {id(v) for v in subject.states}
    if "me" not in subject.interfaces:  # states need not be told by derivatives then
        states |= {id(v) for v in subject.variables if v.initial == "exact"
                   and v.causality in ("local", "output") and v.variability == "continuous"}
    listed = {id(u.variable) for u in subject.structure("initialUnknowns")}
    rates = {id(v) for _, v in subject.derivatives}
    for variable in subject.variables:
        calculated = variable.initial in ("calculated", "approx")
        free = not variable.clocked and variable.type != "Clock"
        needed = calculated and free and (
            variable.causality in ("output", "calculatedParameter")
            or id(variable) in rates or id(variable) in states)
        if needed and id(variable) not in listed:
            notes.wrong(variable.name, "is not an initial unknown", "an entry in InitialUnknowns")
        if id(variable) in listed and not calculated:
            found = f"is an initial unknown, with initial={variable.initial or 'none'}"
            notes.wrong(variable.name, found)
    for part in ("outputs", "derivatives", "initialUnknowns"):
        for unknown in subject.structure(part):
            for known in unknown.dependencies or ():
                notes.tried["dependencies"] += 1
                own_value = known is unknown.variable and part != "initialUnknowns"
                if not (_may_be_known(known, part, states) or own_value):
                    found = f"depends on {known.name}, a {known.causality}, in {part}"
                    notes.wrong(unknown.variable.name, found, "an input, a state or a parameter")


def _may_be_known(known: Variable, part: str, states: set[int]) -> bool:
    """Parameters may be listed everywhere.

    FMI 3.0 counts them among the knowns; FMI 2.0 does so for initial unknowns only, but a fixed
    one that is listed for a derivative says nothing false: it never changes there.
    """
    if known.causality in ("input", "independent", "parameter", "structuralParameter"):
        return True
    if id(known) in states or known.type == "Clock":
        return True
    return known.initial == "exact" if part == "initialUnknowns" else (
        known.variability in ("discrete", "tunable"))


@check("description.start", "start values are there where needed, legal and within their limits")
def start(lab: Lab, notes: Notes) -> None:
    for v in lab.subject.variables:
        needed = v.initial in ("exact", "approx") or v.causality in ("input", "parameter")
        if v.type in (*FLOATS, *BOOLEANS) and needed and v.start is None:
            notes.wrong(v.name, "has no start value", "one: the tool does not calculate it")
        if v.min > v.max:
            notes.wrong(v.name, f"min {v.min:g} is above max {v.max:g}")
        if not v.nominal > 0.0:
            notes.wrong(v.name, f"nominal {v.nominal:g}", "a value above 0")
        if v.start is None:
            continue
        notes.tried["start values"] += v.size
        if len(v.start) != v.size:
            notes.wrong(v.name, f"{len(v.start)} start values for {v.size} elements")
        for name, value in zip(v.elements, v.start, strict=False):
            if not v.min <= value <= v.max:
                limits = f"{v.min:g} to {v.max:g}"
                notes.wrong(name, f"starts at {value:g}", limits)
            elif not np.isfinite(value):
                notes.wrong(name, f"starts at {value:g}", "a finite value")


@check("description.values", "variables have at the start the values that are declared")
def values(lab: Lab, notes: Notes) -> None:
    lab.require_interface()
    declared = [
        v for v in lab.subject.variables
        if v.start is not None and len(v.start) == v.size and v.type in NUMERIC and not v.clocked
        and (v.causality in ("input", "parameter") or v.initial == "exact")
    ]  # fmt: skip
    for interface in lab.subject.interfaces:
        driver = lab.instance(interface=interface)
        status = max(driver.setup(lab.subject.start_time), driver.enter_initialization())
        for v in declared if good(status) else ():  # else the checks of calls tell
            assert v.start is not None
            status, found = driver.get([v])
            if not good(status):
                continue
            notes.tried["values"] += v.size
            near = 1e-6 if v.type == "Float32" else 1e-12
            for name, value, said in zip(v.elements, found, v.start, strict=True):
                if not abs(value - said) <= near * max(1.0, abs(said)) and np.isfinite(said):
                    notes.wrong(name, f"is {value:.12g} at the start", f"{said:.12g} as declared")
        driver.free()


def functions(version: int, interface: str) -> set[str]:
    """Names of all functions that the standard asks of an interface."""
    module = fmi2 if version == 2 else fmi3
    kind = getattr(module, f"FMU{version}{'Slave' if interface == 'cs' else 'Model'}")
    prefix = f"fmi{version}"
    return {n for n, _ in inspect.getmembers(kind) if n.startswith(prefix)}


@check("description.binaries", "binaries are there and export every function of the interfaces")
def binaries(lab: Lab, notes: Notes) -> None:
    subject = lab.subject
    if not subject.binary().is_file():
        here = subject.binary().relative_to(subject.folder)
        present = sorted(p.name for p in (subject.folder / "binaries").glob("*"))
        has = f"it has {', '.join(present)}" if present else "it has none"
        notes.wrong("binaries", f"no {here}; {has}", f"a binary for {fmpy.platform_tuple}")
    scheduled = getattr(subject.description, "scheduledExecution", None)
    offers = subject.interfaces | ({"scheduled execution": scheduled} if scheduled else {})
    for interface, info in offers.items():
        for path in _libraries(lab, info.modelIdentifier):
            notes.tried["binaries"] += 1
            missing = functions(subject.version, interface) - offered(
                path.read_bytes(), str(subject.version)
            )
            if missing:
                listed = ", ".join(sorted(missing)[:6]) + (", …" if len(missing) > 6 else "")
                where = str(path.relative_to(subject.folder))
                notes.wrong(where, f"lacks {listed}", f"every function of {interface}")


def _libraries(lab: Lab, identifier: str) -> Iterator:  # type: ignore[type-arg]
    for folder in sorted((lab.subject.folder / "binaries").glob("*")):
        if folder.name in FOLDERS:
            path = folder / f"{identifier}{EXTENSIONS[FOLDERS[folder.name][0]]}"
            if path.is_file():
                yield path


@check("description.token", "the token of the description is the binary's, and another is refused")
def token(lab: Lab, notes: Notes) -> None:
    if not lab.subject.description.guid:
        notes.wrong("modelDescription.xml", "has no token (guid, instantiationToken)")
        return
    lab.require_interface()
    for interface in lab.subject.interfaces:
        try:
            lab.instance(interface=interface).free()
        except NoInstance as error:
            notes.wrong(f"{interface} with the token of the description", str(error),
                        "an instance", "description and binary must come from one build")
            return
    if getattr(lab.subject.interfaces[lab.interface], "needsExecutionTool", False):
        return  # a wrapper's binary is the same for all of its FMUs and cannot know the token
    try:
        lab.driver().instantiate("{a token of another FMU}").free()
    except NoInstance:
        return
    notes.wrong("instantiation with another token", "gives an instance", "none")
