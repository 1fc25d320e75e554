"""FMUs of other makers: step limits, discards, warnings, requests to end, FMUs that cannot."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sightline.orchestrator.errors import LoopError, RunError
from sightline.orchestrator.results.file import read
from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

from .conftest import SIMULATION
from .foreign import archive, library

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="writes FMUs in C")
SOURCE = r"""
#include <stdlib.h>
#include <stddef.h>
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger log; } Callbacks;
typedef struct {
    double u, x, largest, time, y;
    int mood, ended, running;
    Logger log;
    const char *name;
} Fmu;
typedef const unsigned *Refs;
void *fmi2Instantiate(const char *n, int t, const char *g, const char *r, const Callbacks *c,
                      int v, int l)
{
    Fmu *f = calloc(1, sizeof(Fmu));
    f->log = c->log; f->name = n; f->u = 1.0;
    return f;
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int d, double t, double a, int e, double b) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { ((Fmu *)c)->running = 1; return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2SetReal(void *c, Refs r, size_t n, const double *v)
{
    for (size_t i = 0; i < n; i++) ((double *)c)[r[i]] = v[i];
    return 0;
}
int fmi2GetReal(void *c, Refs r, size_t n, double *v)
{
    Fmu *f = c;
    if (!f->running) f->y = 0.5 * f->u; /* later only steps change it */
    for (size_t i = 0; i < n; i++) v[i] = ((double *)c)[r[i]];
    return 0;
}
int fmi2SetInteger(void *c, Refs r, size_t n, const int *v) { ((Fmu *)c)->mood = v[0]; return 0; }
int fmi2GetInteger(void *c, Refs r, size_t n, int *v) { v[0] = ((Fmu *)c)->mood; return 0; }
int fmi2DoStep(void *c, double t, double h, int x)
{
    Fmu *f = c;
    f->time = t;
    if (f->largest > 0 && h > f->largest * (1 + 1e-9)) {
        if (f->mood == 4) { /* goes as far as it can */
            f->x += f->largest * f->u;
            f->time = t + f->largest;
        }
        return 2;
    }
    if (f->mood == 1 && t > 0.25) { f->log(0, f->name, 1, "logStatusWarning", "t %% late"); }
    if (f->mood == 2 && t > 0.25) { f->ended = 1; return 2; }
    if (f->mood == 3 && t > 0.25) { f->log(0, f->name, 4, "logStatusFatal", "broken"); return 4; }
    f->x += h * f->u;
    f->y = 0.5 * f->u;
    return f->mood == 1;
}
int fmi2GetBooleanStatus(void *c, int kind, int *v) { *v = ((Fmu *)c)->ended; return 0; }
int fmi2GetRealStatus(void *c, int kind, double *v) { *v = ((Fmu *)c)->time; return 0; }
"""
DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="moody" guid="moody">
<CoSimulation modelIdentifier="moody" {flags}/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="1"/></ScalarVariable>
<ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="y" valueReference="4" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="largest" valueReference="2" causality="parameter" variability="fixed">
  <Real start="0"/></ScalarVariable>
<ScalarVariable name="mood" valueReference="0" causality="parameter" variability="fixed">
  <Integer start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2" dependencies=""/>
<Unknown index="3" dependencies="1"/></Outputs></ModelStructure>
</fmiModelDescription>"""
VARIABLE = 'canHandleVariableCommunicationStepSize="true"'


@pytest.fixture(scope="module")
def binary(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The FMU's shared library."""
    return library(tmp_path_factory.mktemp("moody"), "moody", SOURCE)


@pytest.fixture(params=["python", "compiled"])
def moody(request, monkeypatch, write, binary: Path, tmp_path: Path):
    """A run of integrators of 1, with their parameters."""
    monkeypatch.setenv(STEPPER, request.param)

    def system(*instances: str, flags: str = VARIABLE, **options: Any) -> System:
        archive(tmp_path / "moody.fmu", DESCRIPTION.format(flags=flags), binary)
        tables = {
            f"m{i}": f'fmu = "moody.fmu"\nparameters = {{ {text} }}'
            for i, text in enumerate(instances)
        }
        return System.from_toml(write(**options, **tables))

    return system


@pytest.mark.parametrize("mood", [0, 4])  # 4: it says how far it came
def test_fmu_with_a_step_limit_is_substepped(moody, tmp_path, mood: int) -> None:
    results = moody(f"largest = 0.03, mood = {mood}").simulate(tmp_path)
    np.testing.assert_allclose(results["m0.x"], results.time, rtol=1e-12)


def test_limit_that_is_known_is_kept_from_the_start(write, moody, tmp_path) -> None:
    system = moody("largest = 0.03")
    text = (tmp_path / "system.toml").read_text(encoding="utf-8") + "max_step = 0.025\n"
    (tmp_path / "system.toml").write_text(text, encoding="utf-8")
    system = System.from_toml(tmp_path / "system.toml")
    assert system.plan.units[0].parts == 4
    results = system.simulate(tmp_path)
    np.testing.assert_allclose(results["m0.x"], results.time, rtol=1e-12)


def test_fmu_of_one_step_size_is_not_substepped(moody, tmp_path) -> None:
    with pytest.raises(RunError, match=r"m0 at t = 0 s: the step of 0\.1 s ended with discard"):
        moody("largest = 0.03", flags="").simulate(tmp_path)


def test_warning_is_logged_and_the_run_goes_on(moody, tmp_path) -> None:
    results = moody("mood = 0", "mood = 1").simulate(tmp_path)
    assert results.complete
    log = (tmp_path / "log.txt").read_text(encoding="utf-8").splitlines()
    assert set(log) == {"m1: warning [logStatusWarning] t % late"}


def test_request_to_end_stops_the_run_and_keeps_the_rows(moody, tmp_path) -> None:
    with pytest.raises(RunError, match=r"m0 at t = 0\.3 s: the step of 0\.1 s ended with discard"):
        moody("mood = 2").simulate(tmp_path)
    results = read(tmp_path / "results.h5")
    np.testing.assert_allclose(results.time, [0.0, 0.1, 0.2, 0.3])
    assert not results.complete


def test_fatal_is_the_last_word_of_an_fmu(moody, tmp_path) -> None:
    with pytest.raises(RunError, match=r"m0 at t = 0\.3 s: .* ended with fatal: broken"):
        moody("mood = 3").simulate(tmp_path)


def test_fmu_for_one_instance_in_a_process_is_not_loaded_twice(moody, tmp_path) -> None:
    once = 'canBeInstantiatedOnlyOncePerProcess="true"'
    with pytest.raises(RunError, match="m1 at t = 0 s: loading ended with error: its FMU allows"):
        moody("mood = 0", "mood = 0", flags=once).simulate(tmp_path)


def test_loop_of_an_fmu_that_answers_only_by_steps_is_refused_or_broken(moody, tmp_path) -> None:
    loop = "m0.y -> m0.u"
    with pytest.raises(LoopError) as raised:
        moody("mood = 0", connections=[loop]).simulate(tmp_path)
    assert str(raised.value) == (
        "m0 at t = 0 s: the algebraic loop cannot be solved: the outputs of m0 do not follow its "
        "inputs between steps; put an FMU with a state into the loop, or let one connection be a "
        "step late: simulation.delay"
    )
    broken = moody("mood = 0", connections=[loop], simulation=f'{SIMULATION}delay = ["{loop}"]\n')
    y = broken.simulate(tmp_path)["m0.y"]
    np.testing.assert_allclose(y[1:], 0.5 * y[:-1], rtol=1e-15)
