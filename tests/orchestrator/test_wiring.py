"""Connections, frames, parameters and start values: each message by its text."""

from __future__ import annotations

import pytest

from sightline.orchestrator.system import System

from .conftest import variable, vector


@pytest.fixture(autouse=True)
def blocks(make_fmu) -> None:
    make_fmu("plant", [
        *vector("position", 3, "output", unit="m", frame="inertial"),
        *vector("velocity", 3, "output", frame="body"),
        *vector("attitude", 4, "output"),
        *vector("pair", 2, "output"),
        variable("height", "output", unit="km"),
        variable("temperature", "output", unit="degC"),
        variable("count", "output", "Integer"),
        variable("on", "output", "Boolean"),
        *vector("force", 3, unit="N", frame="body", start="0"),
        variable("mass", "parameter", unit="N", start="1", min="0", max="10"),
        *vector("inertia", 2, "parameter", start="1"),
        variable("method", "parameter", "Enumeration", declaredType="Method", start="1"),
        variable("steps", "parameter", "Integer", start="1"),
    ], {})  # fmt: skip
    make_fmu("sensor", [
        *vector("position", 3, unit="m", frame="inertial", start="0"),
        *vector("body_rate", 3, frame="body", start="0"),
        variable("height", unit="m", start="0"),
        variable("temperature", unit="K", start="0"),
        variable("count", kind="Integer", start="0"),
        *[variable(f"grid[{i},{j}]", start="0") for i in (1, 2) for j in (1, 2)],
        *vector("angle", 3, "output", unit="m", frame="body"),
    ], {"angle[1]": ["position[1]"]})  # fmt: skip


PLANT, SENSOR = 'fmu = "plant.fmu"', 'fmu = "sensor.fmu"'


@pytest.mark.parametrize(
    ("connection", "message"),
    [
        ("p.positon -> s.position", "p (plant) has no port positon; did you mean position?"),
        ("q.position -> s.position", "there is no instance q; instances: p, s"),
        ("p.position -> s.positions", "s (sensor) has no port positions; did you mean position?"),
        ("p.attitude -> s.position[1]",
         "p.attitude has 4 elements, s.position[1] needs 1 element; "
         "connect elements or rows: a.x[1] -> b.y[2]"),
        ("p.attitude -> s.grid[1]",
         "p.attitude has 4 elements, s.grid[1] needs 2 elements; "
         "connect elements or rows: a.x[1] -> b.y[2]"),
        ("p.attitude -> s.grid[:,3]",
         "s.grid[:,3] does not exist; grid is grid[1,1] to grid[2,2]"),
        ("p.height -> s.grid[1,1,1]",
         "s.grid[1,1,1] does not exist; grid is grid[1,1] to grid[2,2]"),
        ("p.attitude -> s.grid",
         "p.attitude has 4 elements, s.grid needs 2 x 2 elements; "
         "connect elements or rows: a.x[1] -> b.y[2]"),
        ("p.position[4] -> s.height",
         "p.position[4] does not exist; position is position[1] to position[3]"),
        ("p.height[1] -> s.height", "p.height[1] does not exist; height is a scalar"),
        ("p.mass -> s.height",
         "p.mass is a parameter, not an output; its outputs: attitude, count, height, on, "
         "pair, position, temperature, velocity"),
        ("p.position -> s.angle",
         "s.angle is an output, not an input; its inputs: body_rate, count, grid, height, "
         "position, temperature"),
        ("p.position -> p.force", "p.position is in m, p.force needs N (kg.m.s-2)"),
        ("p.temperature -> s.height", "p.temperature is in degC (K), s.height needs m"),
        ("p.height -> s.count", "p.height is real, s.count needs integer"),
        ("p.on -> s.height", "p.on is boolean, s.height needs real"),
        ("p.position", "is not of the form a.x -> b.y; elements: a.x[1] -> b.y[2]"),
    ],
)  # fmt: skip
def test_connection_is_refused(write, problems, connection: str, message: str) -> None:
    path = write([connection], p=PLANT, s=SENSOR)
    assert problems(path)[0] == f'system.toml:2: connection "{connection}": {message}'


@pytest.mark.parametrize(
    ("index", "elements"), [("2", (2, 3)), ("2,:", (2, 3)), (":,1", (0, 2)), (" 2 , 1 ", (2,))]
)
def test_rows_and_columns_of_an_array_are_connected_whole(
    write, index: str, elements: tuple[int, ...]
) -> None:
    source = "p.height" if len(elements) == 1 else "p.pair"
    (connection,) = System.from_toml(
        write([f"{source} -> s.grid[{index}]"], p=PLANT, s=SENSOR)
    ).graph.connections
    assert connection.destination.elements == elements
    assert str(connection.destination) == f"s.grid[{index.replace(' ', '')}]"


def test_row_and_element_of_it_drive_an_input_twice(write, problems) -> None:
    path = write(["p.pair -> s.grid[2]", "p.height -> s.grid[2,2]"], p=PLANT, s=SENSOR)
    assert problems(path) == [
        'system.toml:3: connection "p.height -> s.grid[2,2]": s.grid[2,2] is already driven '
        'by "p.pair -> s.grid[2]"; an input has one source'
    ]


def test_input_is_driven_once(write, problems) -> None:
    path = write(["p.position -> s.position", "p.height -> s.position[2]"], p=PLANT, s=SENSOR)
    assert problems(path) == [
        'system.toml:3: connection "p.height -> s.position[2]": s.position[2] is already driven '
        'by "p.position -> s.position"; an input has one source'
    ]


def test_frames_of_different_craft_do_not_connect(write, problems) -> None:
    path = write(
        ["p.velocity -> s.body_rate"],
        p=PLANT + '\nframes = { body = "craft1" }',
        s=SENSOR + '\nframes = { body = "craft2" }',
    )
    assert problems(path) == [
        'system.toml:2: connection "p.velocity -> s.body_rate": p.velocity is of the frame '
        "craft1 (its body), s.body_rate needs craft2 (its body); connect ports of one frame, or "
        "correct frames = {...}"
    ]


def test_inertial_frame_is_the_same_everywhere_and_unbound_roles_pass(write) -> None:
    connections = ["p.position -> s.position", "p.velocity -> s.body_rate"]
    system = System.from_toml(write(connections, p=PLANT, s=SENSOR + '\nframes = {body = "c"}'))
    assert [str(c) for c in system.graph.connections] == connections


def test_inertial_and_body_do_not_connect(write, problems) -> None:
    path = write(["p.position -> s.body_rate"], p=PLANT, s=SENSOR + '\nframes = {body = "c"}')
    assert "the frame inertial, s.body_rate needs c (its body)" in problems(path)[0]


def test_unknown_frame_role_names_the_nearest(write, problems) -> None:
    path = write(p=PLANT + '\nframes = { bdy = "craft1" }')
    assert problems(path) == [
        "system.toml:9: instances.p.frames.bdy: plant has no frame of this role; did you mean body?"
    ]


def test_same_dimension_converts_and_says_so(write) -> None:
    connections = ["p.height -> s.height", "p.temperature -> s.temperature"]
    system = System.from_toml(write(connections, p=PLANT, s=SENSOR))
    height, temperature = system.graph.connections
    assert (height.conversion.gain, height.conversion.shift) == (1000.0, 0.0)
    assert (temperature.conversion.gain, temperature.conversion.shift) == (1.0, 273.15)
    assert system.graph.notes[:2] == (
        "p.height -> s.height: km to m, times 1000",
        "p.temperature -> s.temperature: degC to K, times 1 +273.15",
    )


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("parameters = { mas = 1 }", "plant has no parameter of this name; did you mean mass?"),
        ("parameters = { force = [1, 2, 3] }",
         "force is not a parameter but a start value; give it in start"),
        ("start = { mass = 1 }", "mass is a parameter; give it in parameters"),
        ("start = { height = 1 }",
         "height is computed by plant and cannot be set; start values: force"),
        ("parameters = { mass = nan }", "mass is nan, not a finite number"),
        ("parameters = { mass = inf }", "mass is inf, not a finite number"),
        ("parameters = { mass = -1 }", "mass is -1, below the minimum 0"),
        ("parameters = { mass = 11.5 }", "mass is 11.5, above the maximum 10"),
        ("parameters = { mass = true }", "mass is True, not a real"),
        ("parameters = { steps = 1.0 }", "steps is 1.0, not an integer"),
        ("parameters = { mass = [1] }", "has the shape 1, mass needs a single value"),
        ("parameters = { inertia = 1 }", "has a single value, inertia needs the shape 2"),
        ("parameters = { inertia = [[1], [1, 2]] }",
         "has rows of different length, inertia needs the shape 2"),
        ("parameters = { inertia = [1, nan] }", "inertia[2] is nan, not a finite number"),
        ("parameters = { method = 'heun' }",
         "method is 'heun', not one of its choices; valid: rk4, euler"),
    ],
)  # fmt: skip
def test_value_is_refused(write, problems, table: str, message: str) -> None:
    where = f"instances.p.{table.split()[0]}.{table.split()[3]}"
    assert problems(write(p=f"{PLANT}\n{table}")) == [f"system.toml:9: {where}: {message}"]


def test_override_finds_parameters_and_start_values(write) -> None:
    path = write(p=PLANT + "\nparameters = { mass = 2.0 }")
    system = System.from_toml(path, {"p.mass": 3, "p.force": [1, 2, 3], "p.method": "euler"})
    values = {s.port.name: s.values for s in system.graph.nodes[0].settings}
    assert values == {"mass": (3.0,), "force": (1.0, 2.0, 3.0), "method": (2,)}
    assert "parameters = { mass = 3, method = \"euler\" }" in system.loaded.text


def test_override_of_an_unknown_name_is_refused(write, problems) -> None:
    assert problems(write(p=PLANT), {"p.masss": 1, "q.mass": 1}) == [
        "--set p.masss: p has no parameter or start value masss; did you mean mass?",
        "--set q.mass: there is no instance q; instances: p",
    ]


@pytest.mark.parametrize(
    ("rest", "message"),
    [
        ('[record]\nsignals = ["p.posit*n", "p.vel"]',
         'record.signals: "p.vel" names no output; did you mean p.velocity?'),
        ('[record]\nsignals = ["s.position"]',
         'record.signals: "s.position" names no output but an input; name its source p.position'),
        ('[[plots]]\ntitle = "x"\nsignals = ["p.position[4]"]',
         'plots.0.signals: "p.position[4]" names no output; did you mean p.position'),
        ('[[plots]]\ntitle = "x"\nkind = "trajectory"\nsignals = ["p.position"]',
         "plots.0.signals: trajectory needs two or more signals of 2 or 3 elements, found "
         "p.position [3]"),
        ('[[plots]]\ntitle = "x"\nkind = "angle"\nsignals = ["p.position", "p.attitude"]',
         "plots.0.signals: angle needs two or more signals of 4 elements, found p.position [3], "
         "p.attitude [4]"),
        ('[[plots]]\ntitle = "x"\nuntil = 0.0\nsignals = ["p.position"]',
         "plots.0.until: 0 is not after start_time = 0"),
        ('[[plots]]\ntitle = "x"\nscale = "log"\nkind = "activity"\nsignals = ["p.position"]',
         "plots.0.scale: activity has no logarithmic scale"),
    ],
)  # fmt: skip
def test_glob_is_refused(write, problems, rest: str, message: str) -> None:
    path = write(["p.position -> s.position"], rest, p=PLANT, s=SENSOR)
    assert message in problems(path)[0]


def test_plotted_signals_are_recorded_too(write) -> None:
    rest = '[record]\nsignals = ["p.height"]\n[[plots]]\ntitle = "x"\nsignals = ["s.angle[2]"]'
    system = System.from_toml(write(["p.position -> s.position"], rest, p=PLANT, s=SENSOR))
    assert [s.name for s in system.selection.recorded] == ["p.height", "s.angle"]
