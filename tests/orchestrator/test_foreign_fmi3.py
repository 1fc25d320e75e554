"""FMI 3.0 FMUs of other makers: every status, early return, events, clocks and binary variables."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import fmpy
import numpy as np
import pytest

from sightline.orchestrator.errors import ConfigError, RunError
from sightline.orchestrator.explain.explanation import explain
from sightline.orchestrator.explain.text import text
from sightline.orchestrator.results.file import read
from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

from .foreign import archive, library

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="writes FMUs in C")
SOURCE = r"""
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
typedef void (*Logger)(void *, int, const char *, const char *);
typedef struct {
    double u, x, time;
    int mood, count; /* events */
    bool events, event, doubled, on;
    void *env;
    Logger log;
} Fmu;
typedef const unsigned *Refs;
void *fmi3InstantiateCoSimulation(const char *n, const char *t, const char *r, bool v, bool l,
    bool events, bool early, Refs i, size_t k, void *env, Logger log, void *update)
{
    Fmu *f = calloc(1, sizeof(Fmu));
    *f = (Fmu){.u = 1.0, .events = events, .env = env, .log = log};
    return f;
}
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterInitializationMode(void *c, bool d, double t, double a, bool e, double b)
{
    ((Fmu *)c)->event = true;
    return 0;
}
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3Terminate(void *c) { return 0; }
int fmi3EnterEventMode(void *c)
{
    ((Fmu *)c)->event = true;
    ((Fmu *)c)->count++;
    return 0;
}
int fmi3EnterStepMode(void *c) { ((Fmu *)c)->event = false; return 0; }
int fmi3UpdateDiscreteStates(void *c, bool *again, bool *end, bool *n, bool *s, bool *d, double *t)
{
    Fmu *f = c;
    *again = *end = *n = *s = *d = false;
    if (f->mood == 5 && f->time > 0.2 && !f->doubled) { f->doubled = true; *again = true; }
    return 0;
}
int fmi3SetFloat64(void *c, Refs r, size_t n, const double *v, size_t m)
{
    for (size_t i = 0; i < n; i++) ((double *)c)[r[i]] = v[i];
    return 0;
}
int fmi3GetFloat64(void *c, Refs r, size_t n, double *v, size_t m)
{
    for (size_t i = 0; i < n; i++) v[i] = ((double *)c)[r[i]];
    return 0;
}
int fmi3SetInt32(void *c, Refs r, size_t n, const int *v, size_t m)
{
    ((Fmu *)c)->mood = v[0];
    return 0;
}
int fmi3GetInt32(void *c, Refs r, size_t n, int *v, size_t m) { *v = ((Fmu *)c)->count; return 0; }
int fmi3SetBoolean(void *c, Refs r, size_t n, const bool *v, size_t m)
{
    Fmu *f = c;
    f->on = v[0];
    return f->event || !f->events ? 0 : 3;
}
int fmi3GetBoolean(void *c, Refs r, size_t n, bool *v, size_t m)
{
    v[0] = r[0] == 5 ? ((Fmu *)c)->on : ((Fmu *)c)->x > 0.25;
    return 0;
}
int fmi3DoStep(void *c, double t, double h, bool final, bool *event, bool *end, bool *early,
               double *last)
{
    Fmu *f = c;
    *event = *end = *early = false;
    *last = t;
    if (f->mood == 1 && t > 0.25) f->log(f->env, 1, "logStatusWarning", "late");
    if (f->mood == 2 && t > 0.25) { *end = true; return 0; }
    if (f->mood == 3 && t > 0.25) { f->log(f->env, 4, "logStatusFatal", "broken"); return 4; }
    if (f->mood == 4 && h > 0.03 * (1 + 1e-9)) { f->log(f->env, 2, "c", "too far"); return 2; }
    if (f->mood == 6 && t > 0.25) {
        f->log(f->env, 3, "c", "this");
        f->log(f->env, 3, "c", "and that");
        return 3;
    }
    if (f->mood == 5 && f->events && t < 0.25 && t + h >= 0.25) { /* an event inside the step */
        f->x += (0.25 - t) * f->u;
        f->time = *last = 0.25;
        *event = *early = true;
        return 0;
    }
    f->x += h * f->u * (f->doubled ? 2 : 1);
    f->time = *last = t + h;
    return f->mood == 1;
}
"""
DESCRIPTION = """<fmiModelDescription fmiVersion="3.0" modelName="moody" instantiationToken="m">
<CoSimulation modelIdentifier="moody" canHandleVariableCommunicationStepSize="true" {flags}/>
<ModelVariables>
<Float64 name="u" valueReference="0" causality="input" start="1"/>
<Float64 name="x" valueReference="1" causality="output"/>
<Int32 name="mood" valueReference="2" causality="parameter" variability="fixed" start="0"/>{more}
</ModelVariables>
<ModelStructure><Output valueReference="1" dependencies=""/>{outputs}</ModelStructure>
</fmiModelDescription>"""
EVENTS = 'hasEventMode="true" mightReturnEarlyFromDoStep="true"'
OTHERS = """
<Clock name="tick" valueReference="3" causality="input" intervalVariability="triggered"/>
<Binary name="data" valueReference="4" causality="input"><Start value="00"/></Binary>"""


def description(flags: str, more: str) -> str:
    """The FMU's description with more variables, whose outputs depend on no input."""
    found = re.findall(r'valueReference="(\d)" causality="output"', more)
    outputs = "".join(f'<Output valueReference="{r}" dependencies=""/>' for r in found)
    return DESCRIPTION.format(flags=flags, more=more, outputs=outputs)


@pytest.fixture(scope="module")
def binary(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The FMU's shared library."""
    return library(tmp_path_factory.mktemp("moody"), "moody", SOURCE)


@pytest.fixture(params=["python", "compiled"])
def moody(request, monkeypatch, write, binary: Path, tmp_path: Path):
    """A run of x' = u, u = 1, that behaves as its mood is."""
    monkeypatch.setenv(STEPPER, request.param)

    def system(mood: int, flags: str = EVENTS, more: str = "", links=(), **tables: str) -> System:
        path = tmp_path / "moody.fmu"
        archive(path, description(flags, more), binary, fmpy.platform_tuple)
        m = f'fmu = "moody.fmu"\nparameters = {{ mood = {mood} }}'
        return System.from_toml(write(links, m=m, **tables))

    return system


def test_events_inside_steps_are_handled_where_they_are(moody, tmp_path) -> None:
    results = moody(5).simulate(tmp_path)
    t = results.time
    np.testing.assert_allclose(results["m.x"], t + np.maximum(t - 0.25, 0.0), rtol=1e-12)


def test_without_event_mode_nothing_returns_early(moody, tmp_path) -> None:
    results = moody(5, flags="").simulate(tmp_path)
    np.testing.assert_allclose(results["m.x"], results.time, rtol=1e-12)


def test_discarded_step_is_taken_in_smaller_ones(moody, tmp_path) -> None:
    results = moody(4).simulate(tmp_path)
    np.testing.assert_allclose(results["m.x"], results.time, rtol=1e-12)


def test_warning_is_logged_and_the_run_goes_on(moody, tmp_path) -> None:
    assert moody(1).simulate(tmp_path).complete
    log = (tmp_path / "log.txt").read_text(encoding="utf-8").splitlines()
    assert set(log) == {"m: warning [logStatusWarning] late"}


@pytest.mark.parametrize(
    ("mood", "ending"),
    [(2, "a request to end the simulation"), (3, "fatal: broken"), (6, "error: this; and that")],
)
def test_run_that_ends_early_says_why_and_keeps_its_rows(moody, tmp_path, mood, ending) -> None:
    with pytest.raises(RunError) as raised:
        moody(mood).simulate(tmp_path)
    assert str(raised.value) == f"m at t = 0.3 s: the step of 0.1 s ended with {ending}"
    np.testing.assert_allclose(read(tmp_path / "results.h5").time, [0.0, 0.1, 0.2, 0.3])


def test_clocks_and_binary_variables_are_named_and_left_alone(moody, tmp_path) -> None:
    system = moody(0, more=OTHERS)
    assert "m: nothing can drive tick (Clock), data (Binary); left to the FMU" in system.graph.notes
    assert "clocks and binary ones:\n  m: tick, data\n" in text(explain(system))
    assert system.simulate(tmp_path).complete
    with pytest.raises(ConfigError, match=r"m\.tick is of the type Clock; only numbers can be"):
        moody(0, more=OTHERS, links=["m.x -> m.tick"])


def test_inputs_are_held_and_explain_says_so(moody, write, tmp_path) -> None:
    path = write(
        ["n.x -> m.u"], m='fmu = "moody.fmu"', n='fmu = "moody.fmu"',
        simulation='[simulation]\nstop_time = 1.0\nstep = 0.1\ncoupling = "linear"\n',
    ) if moody(0) else None  # fmt: skip
    steps = {s.instance: s.rate for s in explain(System.from_toml(path)).steps}
    assert steps == {"m": "inputs held: takes no derivatives of them", "n": ""}


SWITCH = """
<Boolean name="on" valueReference="5" causality="input" start="false"/>
<Boolean name="far" valueReference="6" causality="output"/>
<Int32 name="events" valueReference="7" causality="output"/>"""


@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
@pytest.mark.parametrize("isolated", [False, True])
def test_discrete_inputs_change_in_event_mode(moody, tmp_path, algorithm, isolated) -> None:
    simulation = f'[simulation]\nstop_time = 1.0\nstep = 0.1\nalgorithm = "{algorithm}"'
    n = 'fmu = "moody.fmu"'
    system = moody(0, more=SWITCH, links=["m.far -> n.on"], simulation=simulation, n=n)
    results = (system.isolated() if isolated else system).simulate(tmp_path)
    late = 1 if algorithm == "jacobi" else 0
    np.testing.assert_array_equal(results["n.events"], [0] * (3 + late) + [1] * (8 - late))
    np.testing.assert_array_equal(results["m.events"], 0)
