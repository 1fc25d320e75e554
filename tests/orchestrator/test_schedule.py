"""The order of FMUs, and which connections are a step late."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from sightline.orchestrator.schedule.order import Cluster
from sightline.orchestrator.system import System

from .conftest import SIMULATION, variable

JACOBI = SIMULATION + 'algorithm = "jacobi"\n'


@pytest.fixture(autouse=True)
def blocks(make_fmu) -> None:
    """x has no direct feedthrough, f has; d does not declare; c only crosses u1 -> y2."""
    ports = [variable("y", "output"), variable("u", start="0")]
    make_fmu("x", ports, {})
    make_fmu("f", ports, {"y": ["u"]})
    make_fmu("d", ports)
    crossed = [variable(f"{n}{i}", c) for n, c in (("y", "output"), ("u", "input")) for i in (1, 2)]
    make_fmu("c", crossed, {"y2": ["u1"]})


@pytest.fixture
def build(write) -> Callable[..., System]:
    def system(connections: list[str], simulation: str = SIMULATION, **kinds: str) -> System:
        tables = {n: f'fmu = "{k}.fmu"' for n, k in kinds.items()}
        path: Path = write(connections, simulation=simulation, **tables)
        return System.from_toml(path)

    return system


def names(system: System) -> list[str]:
    return [system.graph.nodes[i].name for i in system.schedule.order]


CHAIN = ["plant.y -> sensor.u", "sensor.y -> control.u", "control.y -> plant.u"]


def test_chain_steps_after_the_plant_that_feeds_it(build) -> None:
    system = build(CHAIN, control="f", sensor="f", plant="x")
    assert names(system) == ["plant", "sensor", "control"]


def test_only_the_input_of_the_plant_is_delayed(build) -> None:
    system = build(CHAIN, control="f", sensor="f", plant="x")
    assert [str(c) for c in system.schedule.delayed] == ["control.y -> plant.u"]


def test_order_of_the_config_decides_among_equals(build) -> None:
    assert names(build(["b.y -> a.u"], b="x", a="x")) == ["b", "a"]
    late = build(["b.y -> a.u"], a="x", b="x")
    assert names(late) == ["a", "b"]
    assert [str(c) for c in late.schedule.delayed] == ["b.y -> a.u"]


def test_undeclared_dependencies_count_as_feedthrough(build) -> None:
    assert names(build(["b.y -> a.u"], a="d", b="x")) == ["b", "a"]


def test_algebraic_loop_is_a_cluster_to_be_solved(build) -> None:
    system = build(["a.y -> b.u", "b.y -> a.u", "b.y -> c.u"], c="f", a="f", b="f")
    assert system.schedule.clusters == (Cluster((1, 2), cyclic=True), Cluster((0,)))
    assert system.schedule.delayed == ()
    assert system.plan.loops[0].names == ("a.u", "b.u")


def test_loop_is_broken_where_the_user_says(build) -> None:
    late = SIMULATION + 'delay = ["b.y -> a.u"]\n'
    system = build(["a.y -> b.u", "b.y -> a.u"], late, b="f", a="f")
    assert names(system) == ["a", "b"]
    assert [str(c) for c in system.schedule.delayed] == ["b.y -> a.u"]


def test_delay_of_no_connection_is_a_problem(write, problems) -> None:
    late = SIMULATION + 'delay = ["b.y -> a.v"]\n'
    path = write(["b.y -> a.u"], a='fmu = "f.fmu"', b='fmu = "x.fmu"', simulation=late)
    assert problems(path) == [
        'simulation.delay: "b.y -> a.v" is no connection; did you mean b.y -> a.u?'
    ]


def test_fmu_that_feeds_itself_is_a_loop(build) -> None:
    system = build(["a.y -> a.u"], a="f")
    assert system.schedule.clusters == (Cluster((0,), cyclic=True),)


def test_fmus_that_feed_each_other_without_a_loop_pass_values_by_variable(build) -> None:
    crossed = ["a.y2 -> b.u1", "b.y2 -> a.u2", "b.y1 -> a.u1", "a.y1 -> b.u2"]
    system = build(crossed, a="c", b="c")
    assert system.schedule.clusters == (Cluster((0, 1), updates=(0, 1, 0)),)
    assert system.plan.loops == ()


def test_jacobi_delays_everything_and_allows_loops(build) -> None:
    system = build(["a.y -> b.u", "b.y -> a.u"], JACOBI, a="f", b="f")
    assert [str(c) for c in system.schedule.delayed] == ["a.y -> b.u", "b.y -> a.u"]


def test_feedthrough_to_an_unconnected_output_bends_only_where_it_must(build) -> None:
    crossed = build(["p.y -> a.u1"], a="c", p="x")
    assert names(crossed) == ["p", "a"]
    loop = build(["b.y1 -> a.u1", "a.y1 -> b.u1"], a="c", b="c")
    assert names(loop) == ["a", "b"]


def test_inputs_and_outputs_of_an_fmu_are_contiguous(build) -> None:
    plan = build(CHAIN, control="f", sensor="f", plant="x").plan
    spans = [(u.inputs.first, u.inputs.last, u.outputs.first, u.outputs.last) for u in plan.units]
    assert spans == [(0, 1, 1, 2), (2, 3, 3, 4), (4, 5, 5, 6)]
    assert [u.sources.tolist() for u in plan.units] == [[5], [1], [3]]
