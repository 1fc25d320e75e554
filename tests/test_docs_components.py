"""components/README.md tells of every block what the block says of itself, and cites its paper."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest

from sightline.components import Component
from sightline.components.catalogue import families, summary

ROOT = Path(__file__).parent.parent
README = (ROOT / "components" / "README.md").read_text(encoding="utf-8")


def rows(heading: str) -> list[list[str]]:
    """The cells of the table that begins with this row."""
    lines = README.partition(f"{heading}\n")[2].partition("\n\n")[0].splitlines()[1:]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]


PAPERS = {key: wording for key, wording, _, _ in rows(
    "| key | wording in the code | paper | examples |"
)}  # fmt: skip


def keys(block: type[Component]) -> str:
    """The keys of the papers that a block's docstring names."""
    text = " ".join((inspect.getdoc(block) or "").split())
    return ", ".join(key for key, wording in PAPERS.items() if wording in text)


@pytest.mark.parametrize("family", families())
def test_table_of_a_folder_is_what_its_blocks_say(family: str) -> None:
    table = rows(f"| `{family}` | | paper |")
    assert table == [
        [f"`{name}`", summary(block), keys(block)] for name, block in families()[family].items()
    ]


def test_every_folder_of_blocks_has_its_table() -> None:
    assert re.findall(r"^\| `(\w+)` \| \| paper \|$", README, re.MULTILINE) == list(families())


def test_every_paper_is_named_by_a_block_and_has_a_wording_of_its_own() -> None:
    named = {key for blocks in families().values() for b in blocks.values()
             for key in keys(b).split(", ")}  # fmt: skip
    assert named - {""} == set(PAPERS)


def test_wording_of_papers_in_docstrings_is_one_of_the_table() -> None:
    sources = (ROOT / "components").rglob("*.py")
    text = " ".join(" ".join(p.read_text(encoding="utf-8") for p in sources).split())
    found = set(re.findall(r"(?:Source: |in the |; )((?:[\w()-]+ ){2,7}?paper), ", text))
    assert found <= set(PAPERS.values())


def test_examples_of_papers_are_the_folders_that_there_are() -> None:
    cells = " ".join(cell for *_, cell in rows("| key | wording in the code | paper | examples |"))
    linked = re.findall(r"\(\.\./examples/(\w+)\)", cells)
    assert sorted(linked) == sorted(p.parent.name for p in ROOT.glob("examples/*/system.toml"))
