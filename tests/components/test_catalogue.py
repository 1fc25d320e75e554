"""What holds for every block of the catalogue."""

import numpy as np
import pytest

from sightline.components import Component, catalogue
from sightline.components.component import EQUATIONS
from sightline.components.declarations import Noise
from sightline.components.errors import UnknownBlockError

BLOCKS = [pytest.param(block, id=name) for name, block in catalogue.blocks().items()]
PORTS = [
    pytest.param(quantity, id=f"{name}.{port}")
    for name, block in catalogue.blocks().items()
    for port, quantity in block().quantities.items()
]


@pytest.mark.parametrize(("family", "block"), [
    ("actuation", "ThrusterCluster"), ("controllers", "LineOfSightFormationController"),
    ("dynamics", "FreeRigidBody"), ("estimators", "RelativeAttitudeDetermination"),
    ("monitors", "LineOfSightFormationMonitor"), ("sensors", "Gyro"),
])
def test_a_block_is_found_in_its_family(family, block):
    assert block in catalogue.families()[family]


def test_a_base_of_blocks_is_not_a_block():
    assert "Allocator" not in catalogue.blocks()


def test_a_block_is_found_by_name():
    assert catalogue.find("Gyro").__name__ == "Gyro"


def test_an_unknown_block_is_an_error_with_the_nearest_names():
    with pytest.raises(UnknownBlockError) as caught:
        catalogue.find("RangeSensr")
    assert str(caught.value) == "no block is named 'RangeSensr'; did you mean 'RangeSensor'?"


def test_a_name_near_to_none_is_an_error_with_all_names():
    with pytest.raises(UnknownBlockError, match=r"valid are .*FreeRigidBody, .*Gyro, "):
        catalogue.find("zzz")


@pytest.mark.parametrize("block", BLOCKS)
def test_every_block_passes_its_check(block: type[Component]):
    block().check()


@pytest.mark.parametrize("block", BLOCKS)
def test_every_block_meets_its_requirements_at_its_start_values(block: type[Component]):
    conditions = block().evaluate("requirements", block().start_values())
    assert [message for message, holds in conditions.items() if not holds] == []


@pytest.mark.parametrize("block", BLOCKS)
def test_every_block_has_a_summary_of_one_sentence(block: type[Component]):
    assert catalogue.summary(block).endswith(".")


@pytest.mark.parametrize("block", BLOCKS)
def test_every_block_cites_its_source(block: type[Component]):
    assert "\n    Source: " in block.__doc__


@pytest.mark.parametrize("quantity", PORTS)
def test_every_quantity_has_a_unit(quantity):
    assert quantity.unit


@pytest.mark.parametrize("quantity", PORTS)
def test_every_quantity_has_documentation(quantity):
    assert quantity.doc


@pytest.mark.parametrize("block", BLOCKS)
def test_every_vector_port_has_a_frame(block: type[Component]):
    vectors = {n: q for n, q in block.declarations.items()
               if q.shape == (3,) and not isinstance(q, Noise)}
    assert [name for name, quantity in vectors.items() if quantity.frame is None] == []


@pytest.mark.parametrize("block", BLOCKS)
def test_every_attitude_and_every_row_of_vectors_says_whose_it_is(block: type[Component]):
    ports = {n: block.declarations[n] for n in (*block().inputs_, *block().outputs_)}
    framed = {n: q for n, q in ports.items() if q.shape[-1:] == (3,) or (
        q.shape[-1:] == (4,) and "attitude" in n and "relative" not in n
    )}  # fmt: skip
    assert [name for name, quantity in framed.items() if quantity.frame is None] == []


@pytest.mark.parametrize("block", BLOCKS)
def test_no_equation_changes_what_it_receives(block: type[Component]):
    values = block().start_values()
    before = {name: value.copy() for name, value in values.items()}
    for equation in filter(block().has, EQUATIONS):
        block().evaluate(equation, values)
    np.testing.assert_equal(values, before)
