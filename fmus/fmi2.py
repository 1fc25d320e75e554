"""The model description of FMI 2.0: one scalar variable per element, structured naming."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from importlib.metadata import version

import numpy as np

from ..components.catalogue import summary
from .model import SOLVERS, Model, Variable
from .units import QUANTITIES, unit

VENDOR = "sightline"
LOG_CATEGORIES = {
    "logStatusWarning": "Warnings.",
    "logStatusDiscard": "Steps that were not done.",
    "logStatusError": "Errors, with the variable that they concern.",
    "logStatusFatal": "Errors after which the instance is unusable.",
    "logAll": "All messages.",
}
Attributes = Mapping[str, str]


def render(
    model: Model, token: str, interfaces: Mapping[str, Attributes], sources: tuple[str, ...] = ()
) -> bytes:
    """modelDescription.xml of FMI 2.0.

    ``interfaces``: ``CoSimulation`` and ``ModelExchange`` with their capability flags;
    ``sources``: C files that the FMU carries.
    """
    block = model.block
    root = ET.Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": block.name, "guid": token,
        "description": summary(type(block)), "version": version(VENDOR), "license": "MIT",
        "generationTool": f"Sightline {version(VENDOR)}", "variableNamingConvention": "structured",
        "numberOfEventIndicators": "0",
    })  # fmt: skip
    for name in ("ModelExchange", "CoSimulation"):
        if name in interfaces:
            node = ET.SubElement(root, name, {"modelIdentifier": block.name, **interfaces[name]})
            if sources:
                files = ET.SubElement(node, "SourceFiles")
                for source in sources:
                    ET.SubElement(files, "File", name=source)
    _units(root, model)
    if "solver" in model.by_name:
        types = ET.SubElement(root, "TypeDefinitions")
        simple = ET.SubElement(types, "SimpleType", name="Solver")
        items = ET.SubElement(simple, "Enumeration")
        for number, name in enumerate(SOLVERS, start=1):
            ET.SubElement(items, "Item", name=name, value=str(number))
    categories = ET.SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        ET.SubElement(categories, "Category", name=name, description=text)
    ET.SubElement(root, "DefaultExperiment", startTime="0.0", stopTime="10.0", stepSize="0.01")
    if block.structure:
        annotations = ET.SubElement(root, "VendorAnnotations")
        tool = ET.SubElement(annotations, "Tool", name=VENDOR)
        ET.SubElement(tool, "Structure", {n: str(size) for n, size in block.structure.items()})
    variables = ET.SubElement(root, "ModelVariables")
    for variable in model.variables:
        for element in range(variable.size):
            variables.append(_scalar(model, variable, element))
    _structure(root, model)
    ET.indent(root)
    document: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return document + b"\n"


def _units(root: ET.Element, model: Model) -> None:
    definitions = ET.SubElement(root, "UnitDefinitions")
    for name in dict.fromkeys(v.unit for v in model.variables if v.type == "real"):
        node = ET.SubElement(definitions, "Unit", name=name)
        found = unit(name)
        if found.exponents is not None:
            attributes = {n: str(p) for n, p in found.exponents.items()}
            if found.factor != 1.0:
                attributes["factor"] = repr(found.factor)
            if found.offset != 0.0:
                attributes["offset"] = repr(found.offset)
            ET.SubElement(node, "BaseUnit", attributes)


def _scalar(model: Model, variable: Variable, element: int) -> ET.Element:
    causality, variability, initial = fmi_role(variable)
    attributes = {
        "name": variable.scalar_names[element],
        "valueReference": str(variable.references[element]),
        "description": variable.doc, "causality": causality, "variability": variability,
    }  # fmt: skip
    if initial:
        attributes["initial"] = initial
    node = ET.Element("ScalarVariable", attributes)
    typed = ET.SubElement(node, variable.type.capitalize(), value_attributes(variable))
    if variable.type == "enumeration":
        typed.set("declaredType", "Solver")
    if variable.kind == "derivative":
        typed.set("derivative", str(model.by_name[variable.of].references[element]))
    if variable.start is not None:
        typed.set("start", number(variable, np.ravel(variable.start)[element]))
    if variable.frame or variable.optional:
        annotations = ET.SubElement(node, "Annotations")
        annotate(ET.SubElement(annotations, "Tool", name=VENDOR), variable)
    return node


def annotate(note: ET.Element, variable: Variable) -> None:
    """Put what FMI has no attribute for into an annotation, the same in both versions."""
    port = ET.SubElement(note, "Port")
    if variable.frame:
        port.set("frame", variable.frame)
    if variable.optional:
        port.set("optional", "true")


def fmi_role(variable: Variable) -> tuple[str, str, str | None]:
    """Causality, variability and initial of a variable, the same in both versions."""
    changes = "continuous" if variable.type == "real" else "discrete"
    match variable.kind:
        case "input":
            return "input", changes, None
        case "parameter" | "setting":
            return "parameter", "tunable" if variable.tunable else "fixed", "exact"
        case "state":
            return "output" if variable.is_output else "local", "continuous", "exact"
        case "discrete":
            return "output" if variable.is_output else "local", "discrete", "exact"
        case "derivative":
            return "local", "continuous", "calculated"
        case _:
            return "output", changes, "calculated"


def value_attributes(variable: Variable) -> dict[str, str]:
    """Quantity, unit, min, max, nominal as attributes of the typed element."""
    attributes: dict[str, str] = {}
    if variable.type == "real":
        if quantity := QUANTITIES.get(variable.unit):
            attributes["quantity"] = quantity
        attributes["unit"] = variable.unit
    for name in ("min", "max", "nominal"):
        value = getattr(variable, name)
        if value is not None:
            attributes[name] = number(variable, value)
    return attributes


def number(variable: Variable, value: float) -> str:
    """A value in the notation of the variable's type; reals to the last bit."""
    if variable.type == "boolean":
        return "true" if value else "false"
    return repr(float(value)) if variable.type == "real" else str(int(value))


def _structure(root: ET.Element, model: Model) -> None:
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [r for v in model.outputs for r in v.references]
    rates = model.references("derivative")
    calculated = [r for v in model.outputs if v.start is None for r in v.references]
    parts = (
        ("Outputs", outputs, model.dependencies),
        ("Derivatives", rates, model.dependencies),
        ("InitialUnknowns", sorted([*calculated, *rates]), model.initial_dependencies),
    )
    for name, unknowns, dependencies in parts:
        if not unknowns:
            continue
        node = ET.SubElement(structure, name)
        for reference in unknowns:
            known = " ".join(map(str, dependencies[reference]))
            ET.SubElement(node, "Unknown", index=str(reference), dependencies=known)
