"""XML of an archive that may be hostile: refused before a full parser sees it."""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass, field
from xml.parsers import expat

MAX_DEPTH = 64
MAX_IDENTIFIER = 200  # bytes, of the 255 that a file name with its extension may have
INTERFACES = ("CoSimulation", "ModelExchange", "ScheduledExecution")
BOMS = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE, codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)
DECLARED = re.compile(rb"""^\s*<\?xml[^>]*?encoding\s*=\s*["']([^"']*)["']""")


@dataclass
class Head:
    """What the description says first: version, model and, by interface, its identifier."""

    version: str = ""
    model: str = ""
    identifiers: dict[str, str] = field(default_factory=dict)


class _RefusedError(Exception):
    pass


def xml_problem(content: bytes) -> str:
    """Why the XML is refused; empty if it is well-formed, in UTF-8 and without a document type.

    Identifiers of models become file names: those that would lead elsewhere are refused, too.
    """
    if content.startswith(BOMS) or b"\0" in content[:4]:
        return "is in UTF-16 or UTF-32; FMI asks for UTF-8"
    declared = DECLARED.match(content.removeprefix(codecs.BOM_UTF8))
    if declared and declared[1].lower() not in (b"utf-8", b"utf8", b"us-ascii"):
        return f"declares the encoding {declared[1].decode(errors='replace')}; FMI asks for UTF-8"
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        return f"is not UTF-8 at byte {error.start}"
    try:
        _parse(content, None)
    except _RefusedError as error:
        return str(error)
    except expat.ExpatError as error:
        return f"is not XML: {error}"
    return ""


def read_head(content: bytes) -> Head:
    """Version and identifiers of a model description in which xml_problem found nothing."""
    head = Head()
    _parse(content, head)
    return head


def _parse(content: bytes, head: Head | None) -> None:
    parser = expat.ParserCreate(namespace_separator=" ")
    depth = 0

    def doctype(*_: object) -> None:
        raise _RefusedError("has a document type (entities); FMI descriptions have none")

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > MAX_DEPTH:
            raise _RefusedError(f"is nested deeper than {MAX_DEPTH} elements")
        if depth <= 2 and (problem := _identifier_problem(name, attributes)):
            raise _RefusedError(problem)
        if head is not None and depth == 1:
            head.version = attributes.get("fmiVersion", "")
            head.model = attributes.get("modelName", "")
        if head is not None and depth == 2 and "modelIdentifier" in attributes:
            head.identifiers[name] = attributes["modelIdentifier"]

    def end(_: str) -> None:
        nonlocal depth
        depth -= 1

    parser.StartDoctypeDeclHandler = doctype
    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.Parse(content, True)


def _identifier_problem(element: str, attributes: dict[str, str]) -> str:
    """Why an element's identifier cannot be the name of a file, which the binary's is."""
    identifier = attributes.get("modelIdentifier")
    if identifier is None:
        return f"{element} has no modelIdentifier" if element in INTERFACES else ""
    if not identifier:
        return f"the modelIdentifier of {element} is empty"
    if len(identifier.encode()) > MAX_IDENTIFIER:
        return f"the modelIdentifier of {element} has more than {MAX_IDENTIFIER} bytes"
    if identifier in (".", "..") or any(c in "/\\:" or not c.isprintable() for c in identifier):
        asked = "FMI asks for letters, digits and underscores"
        return f"the modelIdentifier of {element} is a path, {identifier[:80]!r}; {asked}"
    return ""
