"""The model description of FMI 3.0, with array variables, and the build description."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from importlib.metadata import version

import numpy as np

from ..components.catalogue import summary
from .fmi2 import LOG_CATEGORIES, VENDOR, Attributes, annotate, fmi_role, number, value_attributes
from .fmi2 import _units as add_units
from .model import SOLVERS, Model, Variable

TYPES = {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "enumeration": "Enumeration"}


def render(model: Model, token: str, interfaces: Mapping[str, Attributes]) -> bytes:
    """modelDescription.xml of FMI 3.0.

    ``interfaces``: ``CoSimulation`` and ``ModelExchange`` with their capability flags.
    """
    block = model.block
    root = ET.Element("fmiModelDescription", {
        "fmiVersion": "3.0", "modelName": block.name, "instantiationToken": token,
        "description": summary(type(block)), "version": version(VENDOR), "license": "MIT",
        "generationTool": f"Sightline {version(VENDOR)}", "variableNamingConvention": "structured",
    })  # fmt: skip
    for name in ("ModelExchange", "CoSimulation"):
        if name in interfaces:
            ET.SubElement(root, name, {"modelIdentifier": block.name, **interfaces[name]})
    add_units(root, model)
    _time_unit(root)
    if "solver" in model.by_name:
        types = ET.SubElement(root, "TypeDefinitions")
        solver = ET.SubElement(types, "EnumerationType", name="Solver")
        for value, name in enumerate(SOLVERS, start=1):
            ET.SubElement(solver, "Item", name=name, value=str(value))
    categories = ET.SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=text)
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize="0.01")
    variables = ET.SubElement(root, "ModelVariables")
    ET.SubElement(variables, "Float64", name="time", valueReference="0", causality="independent",
                  variability="continuous", unit="s", description="simulation time")
    for variable in model.variables:
        variables.append(_variable(model, variable))
    _structure(root, model)
    if block.structure:
        note = _annotation(root)
        for name, size in block.structure.items():
            ET.SubElement(note, "Structure", name=name, value=str(size))
    return _document(root)


def render_build_description(identifier: str, sources: Sequence[str]) -> bytes:
    """sources/buildDescription.xml: how to compile the FMU again."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=identifier)
    files = ET.SubElement(configuration, "SourceFileSet", language="C11")
    for source in sources:
        ET.SubElement(files, "SourceFile", name=source)
    return _document(root)


def _document(root: ET.Element) -> bytes:
    ET.indent(root)
    document: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return document + b"\n"


def _variable(model: Model, variable: Variable) -> ET.Element:
    causality, variability, initial = fmi_role(variable)
    attributes = {
        "name": variable.name, "valueReference": str(variable.reference),
        "description": variable.doc, "causality": causality, "variability": variability,
    }  # fmt: skip
    if initial:
        attributes["initial"] = initial
    if variable.type == "enumeration":
        attributes["declaredType"] = "Solver"
    if variable.kind == "derivative":
        attributes["derivative"] = str(model.by_name[variable.of].reference)
    if variable.start is not None:
        attributes["start"] = " ".join(number(variable, x) for x in np.ravel(variable.start))
    limits = value_attributes(variable)
    if variable.type == "boolean":
        limits = {}
    node = ET.Element(TYPES[variable.type], attributes | limits)
    if variable.frame or variable.optional:
        annotate(_annotation(node), variable)
    for size in variable.shape:
        ET.SubElement(node, "Dimension", start=str(size))
    return node


def _time_unit(root: ET.Element) -> None:
    definitions = root.find("UnitDefinitions")
    assert definitions is not None
    if definitions.find("Unit[@name='s']") is None:
        ET.SubElement(ET.SubElement(definitions, "Unit", name="s"), "BaseUnit", s="1")


def _annotation(node: ET.Element) -> ET.Element:
    return ET.SubElement(ET.SubElement(node, "Annotations"), "Annotation", type=VENDOR)


def _structure(root: ET.Element, model: Model) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    rates = model.of_kind("derivative")
    initial = sorted([*model.of_kind("output"), *rates], key=lambda v: v.reference)
    owner = {r: v.reference for v in model.variables for r in v.references}
    for name, unknowns, dependencies in (
        ("Output", model.outputs, model.dependencies),
        ("ContinuousStateDerivative", rates, model.dependencies),
        ("InitialUnknown", initial, model.initial_dependencies),
    ):
        for unknown in unknowns:
            knowns = sorted({owner[k] for r in unknown.references for k in dependencies[r]})
            ET.SubElement(structure, name, valueReference=str(unknown.reference),
                          dependencies=" ".join(map(str, _with_time(model, unknown) + knowns)))


def _with_time(model: Model, unknown: Variable) -> list[int]:
    """The reference of time, if an element of the variable depends on it directly."""
    if model.trace is None or unknown.kind not in ("output", "derivative"):
        return []
    equation = "outputs" if unknown.kind == "output" else "derivatives"
    first = model.of_kind(unknown.kind)[0].reference
    rows = model.trace.depends(equation, "t")[unknown.reference - first :][: unknown.size]
    return [0] if rows.any() else []
