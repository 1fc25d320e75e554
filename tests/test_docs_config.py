"""orchestrator/README.md tells of every key of a config and its default; its example runs."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

import numpy as np
import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from sightline.orchestrator import System
from sightline.orchestrator.config import quantities, spread
from sightline.orchestrator.config.loading import TABLES
from sightline.orchestrator.config.model import Config, Instance, Plot, Record, Repeat, Simulation

ROOT = Path(__file__).parent.parent
README = (ROOT / "orchestrator" / "README.md").read_text(encoding="utf-8")
EXAMPLE = re.findall(r"```toml\n(.*?)```", README, re.DOTALL)[0]
REQUIRED = "required"
MODELS: dict[str, type[BaseModel]] = {
    "top level": Config,
    "`[simulation]`": Simulation,
    "`[instances.NAME]`": Instance,
    "`[repeat.INDEX]`": Repeat,
    "`[record]`": Record,
    "`[[plots]]`": Plot,
}


def rows(heading: str) -> list[list[str]]:
    """The cells of the table whose first cell is this."""
    lines = README.partition(f"\n| {heading} |")[2].partition("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]


def told(cell: str) -> Any:
    """A default as the document tells it; None for a key that is not set."""
    if cell in (REQUIRED, "—"):
        return cell if cell == REQUIRED else None
    return tomllib.loads(f"value = {cell.strip('`')}")["value"]


def true(field: FieldInfo) -> Any:
    """A default as the model has it; a table as the keys that differ from its own defaults."""
    default = REQUIRED if field.is_required() else field.get_default(call_default_factory=True)
    return default.model_dump(exclude_defaults=True) if isinstance(default, BaseModel) else default


def choices(annotation: Any) -> list[str]:
    """The texts that a key takes; none if it takes any."""
    if get_origin(annotation) is Literal:
        return list(get_args(annotation))
    if get_origin(annotation) in (Union, UnionType):
        return [choice for part in get_args(annotation) for choice in choices(part)]
    return []


@pytest.mark.parametrize("heading", MODELS)
def test_table_has_all_keys_and_their_defaults(heading: str) -> None:
    keys = [(cells[0].strip("`"), told(cells[1])) for cells in rows(heading)]
    fields = MODELS[heading].model_fields
    assert dict(keys) == {name: true(field) for name, field in fields.items()}
    assert len(keys) == len(fields)


def test_every_model_of_a_config_has_its_table() -> None:
    assert set(MODELS.values()) == {Config, *TABLES.values()}


def test_choices_of_a_key_are_all_told() -> None:
    for heading, model in MODELS.items():
        text = {cells[0].strip("`"): " ".join(cells) for cells in rows(heading)}
        for name, field in model.model_fields.items():
            untold = [c for c in choices(field.annotation) if f'"{c}"' not in text[name]]
            assert untold == [], f"{heading} {name}"


def test_rules_for_values_are_all_told() -> None:
    rules = [tomllib.loads(f"rule = {cells[0].strip('`')}")["rule"] for cells in rows("table")]
    keys = {key for rule in rules for key in rule}
    known = {k for kind, (more, others) in spread.KEYS.items() for k in (kind, *more, *others)}
    assert keys == known | set(quantities.KEYS)
    assert {rule["random"] for rule in rules if "random" in rule} == set(spread.RANDOM)


def test_rules_for_values_are_followed(tmp_path: Path) -> None:
    (tmp_path / "starts.csv").write_text("x,y,z\n1,2,3\n4,5,6\n", encoding="utf-8")
    for cells in rows("table"):
        rule = tomllib.loads(f"rule = {cells[0].strip('`')}")["rule"]
        assert len(spread.spread(rule, 2, tmp_path, "craft{i}.value")) == 2


def test_example_runs_and_the_two_craft_come_to_one_attitude(tmp_path: Path) -> None:
    (tmp_path / "system.toml").write_text(EXAMPLE, encoding="utf-8")
    results = System.from_toml(tmp_path / "system.toml").simulate(tmp_path / "out")
    cosine = np.sum(results["craft1.attitude"] * results["craft2.attitude"], axis=1)
    angle = 2.0 * np.arccos(np.minimum(np.abs(cosine), 1.0))  # rad, between the two attitudes
    assert angle[0] > 2.0
    assert angle[-1] < 0.02
    assert np.ptp(results["control1.torque"]) > 0.0


def test_example_uses_every_table() -> None:
    assert set(tomllib.loads(EXAMPLE)) == set(Config.model_fields) - {"extends"}


def test_links_within_the_document_lead_somewhere() -> None:
    headings = re.findall(r"^## (.+)$", README, re.MULTILINE)
    assert set(re.findall(r"\]\(#([\w-]+)\)", README)) <= {h.lower() for h in headings}
