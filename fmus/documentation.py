"""What every FMU carries beside its code: a page that explains it, the licence and an icon."""

from __future__ import annotations

import html
import inspect
import zlib
from importlib.metadata import distribution, version
from struct import pack

from .model import Model, Variable

PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{name}</title><style>
body {{ font-family: sans-serif; max-width: 60em; margin: 2em auto; }}
table {{ border-collapse: collapse; }}
td, th {{ border: 1px solid #999; padding: .2em .6em; text-align: left; }}
</style></head><body><h1>{name}</h1>
<pre>{doc}</pre>
{structure}{tables}
<h2>Equations</h2><pre>{source}</pre>
<p>Made by Sightline {version}. MIT licence.</p></body></html>
"""
TABLES = (
    ("Inputs", ("input",)), ("Outputs", ("output", "state", "discrete")),
    ("Parameters", ("parameter",)), ("Settings", ("setting",)),
)  # fmt: skip


def documentation(model: Model) -> dict[str, bytes]:
    """Archive members: documentation, licence and icon."""
    block = type(model.block)
    tables = "".join(
        _table(title, [v for v in model.variables
                       if v.kind in kinds and (title != "Outputs" or v.is_output)])
        for title, kinds in TABLES
    )
    sizes = ", ".join(f"{n} = {s}" for n, s in model.block.structure.items())
    page = PAGE.format(
        name=block.__name__, doc=html.escape(inspect.getdoc(block) or ""), tables=tables,
        source=html.escape(inspect.getsource(block)), version=version("sightline"),
        structure=f"<p>Built for {html.escape(sizes)}.</p>\n" if sizes else "",
    )
    return {
        "documentation/index.html": page.encode(),
        "documentation/licenses/license.txt": _licence(),
        "model.png": icon(),
    }


def _table(title: str, variables: list[Variable]) -> str:
    if not variables:
        return ""
    rows = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in (
            v.name, "x".join(map(str, v.shape)) or "scalar", v.unit, v.frame or "", v.doc,
        )) + "</tr>\n"
        for v in variables
    )
    head = "<tr><th>name</th><th>size</th><th>unit</th><th>frame</th><th>meaning</th></tr>"
    return f"<h2>{title}</h2>\n<table>{head}\n{rows}</table>\n"


def _licence() -> bytes:
    for file in distribution("sightline").files or ():
        if file.name == "LICENSE":
            return file.read_binary()
    return b"MIT License\n"


def icon(size: int = 32) -> bytes:
    """A PNG: a line of sight between two spacecraft, drawn pixel by pixel."""
    rows = []
    for y in range(size):
        row = bytearray([0])
        for x in range(size):
            ends = min((x - 7) ** 2 + (y - 24) ** 2, (x - 24) ** 2 + (y - 7) ** 2) <= 16
            line = abs(x + y - 31) <= 0 and 7 <= x <= 24
            row += bytes((20, 60, 120)) if ends or line else bytes((255, 255, 255))
        rows.append(bytes(row))

    def chunk(kind: bytes, data: bytes) -> bytes:
        return pack(">I", len(data)) + kind + data + pack(">I", zlib.crc32(kind + data))

    header = pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    image = zlib.compress(b"".join(rows), 9)
    parts = ((b"IHDR", header), (b"IDAT", image), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(kind, data) for kind, data in parts)
