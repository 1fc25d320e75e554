"""Example 5.1 from the same FMU files in Ecos (fixed-step algorithm)."""

import pytest

from .conftest import Reference
from .formation import Series, relative_difference
from .tools import ecos


@pytest.fixture(scope="module")
def rows(reference: Reference) -> Series:
    return ecos(reference.system, reference.step, reference.count)


def columns(reference: Reference, *, feedthrough: bool) -> list[int]:
    system = reference.system
    return [i for i, v in enumerate(system.outputs) if (v in system.feedthrough) == feedthrough]


def test_ecos_computes_the_states_of_example_51_as_our_jacobi_run(
    reference: Reference, rows: Series
):
    states = columns(reference, feedthrough=False)

    difference = relative_difference(rows[:, states], reference.rows[:, states])

    assert len(states) == 2 * 13
    assert difference <= reference.tolerance


def test_ecos_shows_outputs_with_feedthrough_one_row_before_our_jacobi_run(
    reference: Reference, rows: Series
):
    direct = columns(reference, feedthrough=True)

    difference = relative_difference(rows[:-1, direct], reference.rows[1:, direct])

    assert len(direct) == len(reference.system.outputs) - 2 * 13
    assert difference <= reference.tolerance
