"""What `build` answers to a wrong request: a BuildError that says what would be right."""

from __future__ import annotations

from pathlib import Path

import pytest

from sightline.fmus.build import build
from sightline.fmus.errors import BuildError

HEAD = "from sightline.components import Component, Input, Output, Parameter\n\n\n"


def block(folder: Path, body: str) -> str:
    path = folder / "mine.py"
    path.write_text(HEAD + body, encoding="utf-8")
    return f"{path}:Mine"


def problems(component: str, **choices: object) -> str:
    with pytest.raises(BuildError) as caught:
        build(component, **choices)  # type: ignore[arg-type]
    return str(caught.value)


def test_unknown_block_names_the_nearest() -> None:
    assert "'FreeRigidBody'" in problems("FreeRigidBodi")


def test_missing_file_is_named(tmp_path: Path) -> None:
    assert f"there is no file {tmp_path / 'no.py'}" in problems(f"{tmp_path / 'no.py'}:Mine")


def test_syntax_error_names_file_and_line(tmp_path: Path) -> None:
    assert "mine.py, line 4" in problems(block(tmp_path, "class Mine(Component:\n"))


def test_wrong_class_name_offers_the_nearest(tmp_path: Path) -> None:
    reference = block(tmp_path, 'class Mine(Component):\n    """Mine."""\n')
    assert "did you mean Mine?" in problems(reference.replace(":Mine", ":Mina"))


def test_class_may_be_left_out_if_there_is_one(tmp_path: Path, fmu_cache: None) -> None:
    source = '''class Mine(Component):
    """Doubles."""

    x = Input((), "m", doc="in")
    y = Output((), "m", doc="out")

    def outputs(self, x):
        return {"y": 2.0 * x}
'''
    assert build(block(tmp_path, source).removesuffix(":Mine"), target="python").is_file()


def test_declaration_mistake_names_component_and_port(tmp_path: Path) -> None:
    source = 'class Mine(Component):\n    """Mine."""\n\n    x = Input(3)\n'
    assert "Mine.x: unit is missing" in problems(block(tmp_path, source))


def test_every_unknown_unit_is_reported_at_once(tmp_path: Path) -> None:
    source = ('class Mine(Component):\n    """Mine."""\n\n    x = Input(3, "mtr")\n'
              '    p = Parameter((), "pnds")\n')
    text = problems(block(tmp_path, source), target="python")
    assert "Mine.x: 'mtr' is not a unit" in text
    assert "Mine.p: 'pnds' is not a unit" in text


def test_equation_that_fails_is_described(tmp_path: Path) -> None:
    source = ('class Mine(Component):\n    """Mine."""\n\n    y = Output((), "m")\n\n'
              '    def outputs(self):\n        return {"y": 1 / 0}\n')
    assert "ZeroDivisionError: division by zero" in problems(block(tmp_path, source))


def test_wrong_structure_is_named() -> None:
    text = problems("ThrusterCluster", structure={"thruster": 4})
    assert "ThrusterCluster.thruster: no such structure; did you mean 'thrusters'?" in text


def test_python_fmu_of_version_3_is_refused() -> None:
    assert "a Python FMU is FMI 2.0; FMI 3.0 needs --target native" in problems(
        "Gyro", target="python", fmi=3
    )
