"""FMUs in processes of their own: the same bits, and whatever they do there the run can tell."""

from __future__ import annotations

import gc
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sightline.fmus.build import build
from sightline.orchestrator.errors import RunError
from sightline.orchestrator.results.file import Results, read
from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

from . import foreign

BLOCKS = Path(__file__).with_name("blocks.py").as_posix()
COMPILER = pytest.mark.skipif(shutil.which("cc") is None, reason="writes FMUs in C")
SOURCE = r"""
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <stddef.h>
#include <signal.h>
#include <unistd.h>
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct { Logger log; } Callbacks;
typedef struct { double u, x; int mood; Logger log; const char *name; } Fmu;
typedef const unsigned *Refs;
void *fmi2Instantiate(const char *n, int t, const char *g, const char *r, const Callbacks *c,
                      int v, int l)
{
    Fmu *f = calloc(1, sizeof(Fmu));
    f->log = c->log; f->name = n; f->u = 1.0;
    return f;
}
void fmi2FreeInstance(void *c) { if (((Fmu *)c)->mood == 7) abort(); free(c); }
int fmi2SetupExperiment(void *c, int d, double t, double a, int e, double b) { return 0; }
int fmi2EnterInitializationMode(void *c) { if (((Fmu *)c)->mood == 8) _exit(0); return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2SetReal(void *c, Refs r, size_t n, const double *v)
{
    if (((Fmu *)c)->mood >= 10 && v[0] > 0.25 && v[0] < 0.9) return ((Fmu *)c)->mood - 8;
    for (size_t i = 0; i < n; i++) ((double *)c)[r[i]] = v[i];
    return 0;
}
int fmi2GetReal(void *c, Refs r, size_t n, double *v)
{
    if (((Fmu *)c)->mood == 6 && ((Fmu *)c)->x > 0.02) return 3;
    for (size_t i = 0; i < n; i++) v[i] = ((double *)c)[r[i]];
    return 0;
}
int fmi2SetInteger(void *c, Refs r, size_t n, const int *v) { ((Fmu *)c)->mood = v[0]; return 0; }
int fmi2GetInteger(void *c, Refs r, size_t n, int *v) { v[0] = ((Fmu *)c)->mood; return 0; }
int fmi2DoStep(void *c, double t, double h, int x)
{
    Fmu *f = c;
    if (f->mood && t > 0.25) f->log(0, f->name, 1, "logStatusWarning", "a bad mood");
    if (t > 0.25) switch (f->mood) {
        case 1: raise(SIGSEGV); break;
        case 2: exit(3);
        case 3: for (;;) pause();
        case 4: raise(SIGFPE); break;
        case 5: raise(SIGSTOP); break;
    }
    f->x += h * f->u;
    return 0;
}
int fmi2GetBooleanStatus(void *c, int kind, int *v) { return 3; }
int fmi2GetRealStatus(void *c, int kind, double *v) { return 3; }
"""
DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="unruly" guid="unruly">
<CoSimulation modelIdentifier="unruly" canBeInstantiatedOnlyOncePerProcess="true"/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="1"/></ScalarVariable>
<ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="mood" valueReference="0" causality="parameter" variability="fixed">
  <Integer start="0"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>"""


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU that dies in many ways."""
    folder = tmp_path_factory.mktemp("unruly")
    return foreign.archive(
        folder / "unruly.fmu", DESCRIPTION, foreign.library(folder, "unruly", SOURCE)
    )


@pytest.fixture
def unruly(write, archive: Path) -> Callable[..., Path]:
    """The config of some of these, isolated; moods m0, m1, ..."""

    def config(*moods: int, limit: float = 60.0, **more: str) -> Path:
        tables = {
            f"m{i}": f'fmu = "{archive.as_posix()}"\nparameters = {{ mood = {mood} }}\n'
                     f"isolate = true\ntime_limit = {limit}"
            for i, mood in enumerate(moods)
        }  # fmt: skip
        return write(**tables, **more)

    return config


def block(name: str, text: str = "") -> str:
    return f'component = "{BLOCKS}:{name}"\n{text}'


def block_table(instance: str, name: str, text: str) -> str:
    return f"[instances.{instance}]\n{block(name, text)}\n"


def affine(target: str) -> str:
    sampled = Path(__file__).with_name("sampled.py").as_posix()
    return f'component = "{sampled}:Affine"\ntarget = "{target}"'


def command(*arguments: object) -> list[str]:
    program = [sys.executable, "-m", "sightline.orchestrator.cli"]
    return [*program, *(str(a) for a in arguments)]


@COMPILER
@pytest.mark.parametrize("stepper", ["python", "compiled"])
@pytest.mark.parametrize(
    ("mood", "ending"),
    [
        (1, "the death of its process by SIGSEGV (segmentation fault)"),
        (2, "the end of its process, exit status 3"),
        (3, "no answer within its time_limit of 0.3 s"),
        (4, "the death of its process by SIGFPE (floating point exception)"),
        (5, "no answer within its time_limit of 0.3 s"),
    ],
)
def test_end_of_an_isolated_fmu_is_told_and_rows_are_kept(
    unruly, tmp_path: Path, monkeypatch, stepper: str, mood: int, ending: str
) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    with pytest.raises(RunError) as caught:
        System.from_toml(unruly(mood, limit=0.3)).simulate(tmp_path)
    assert str(caught.value) == f"m0 at t = 0.3 s: the step of 0.1 s ended with {ending}"
    results = read(tmp_path / "results.h5")
    assert not results.complete
    np.testing.assert_allclose(results.time, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(results["m0.x"], results.time, rtol=1e-12)
    log = (tmp_path / "log.txt").read_text(encoding="utf-8")
    assert log == "m0: warning [logStatusWarning] a bad mood\n"


@COMPILER
@pytest.mark.parametrize("stepper", ["python", "compiled"])
@pytest.mark.parametrize(
    ("mood", "told"),
    [
        (6, "m0 at t = 0.3 s: getting outputs ended with error"),
        (10, "m0 at t = 0.3 s: setting inputs ended with discard"),
        (11, "m0 at t = 0.3 s: setting inputs ended with error"),
        (12, "m0 at t = 0.3 s: setting inputs ended with fatal"),
    ],
)
def test_refusal_of_an_isolated_fmu_is_told_like_any_other(
    unruly, monkeypatch, stepper: str, mood: int, told: str
) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    path = unruly(mood, rest=block_table("ramp", "Integrator", "start = { u = 1.0 }"))
    text = path.read_text().replace("connections = [", 'connections = [\n  "ramp.x -> m0.u",')
    for wanted in (text, text.replace("isolate = true\ntime_limit = 60.0", "")):
        path.write_text(wanted)
        with pytest.raises(RunError) as caught:
            System.from_toml(path).simulate()
        assert str(caught.value) == told


@COMPILER
def test_end_during_initialisation_is_told(unruly, tmp_path: Path) -> None:
    told = r"^m0 at t = 0 s: initialisation ended with the end of its process, exit status 0$"
    with pytest.raises(RunError, match=told):
        System.from_toml(unruly(8)).simulate(tmp_path)


@COMPILER
def test_end_while_being_freed_spoils_no_results(unruly, tmp_path: Path) -> None:
    assert System.from_toml(unruly(7)).simulate(tmp_path).complete
    last = (tmp_path / "log.txt").read_text(encoding="utf-8").splitlines()[-1]
    assert last == (
        "m0: warning [isolation] being freed ended with the death of its process by SIGABRT "
        "(aborted)"
    )


@COMPILER
def test_fmu_for_one_instance_in_a_process_runs_twice_when_isolated(unruly, tmp_path) -> None:
    results = System.from_toml(unruly(0, 0)).simulate(tmp_path)
    np.testing.assert_array_equal(results["m0.x"], results["m1.x"])


@COMPILER
def test_command_line_fails_with_one_and_names_what_there_is(unruly, tmp_path: Path) -> None:
    done = subprocess.run(command("run", unruly(1), "--out", tmp_path / "out"),
                          capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "m0 at t = 0.3 s: the step of 0.1 s ended with the death of its process by SIGSEGV" in (
        done.stderr
    )
    assert done.stdout == (
        f"results until then in {tmp_path}/out: results.h5 (4 samples of 1 signals), log.txt\n"
    )


@pytest.fixture
def mixed(write, tmp_path: Path) -> Callable[..., Path]:
    """A closed loop of a native FMU, a Python FMU and one of FMI 3.0, some of them isolated."""
    third = build(f"{BLOCKS}:Switch", target="native", fmi=3)

    def config(*isolated: str, simulation: str) -> Path:
        tables = {
            "plant": block("Integrator", "start = { x = 1.0 }"),
            "control": block("Gain", 'target = "python"'),
            "switch": f'fmu = "{third.as_posix()}"\n',
        }
        for name in isolated:
            tables[name] += "\nisolate = true"
        return write(
            ["plant.x -> control.x", "control.y -> plant.u", "switch.on -> switch.on_in"],
            simulation=f"[simulation]\nstop_time = 1.0\nstep = 0.1\n{simulation}", **tables,
        )

    return config


@COMPILER
@pytest.mark.parametrize("stepper", ["python", "compiled"])
@pytest.mark.parametrize(
    "simulation",
    ['coupling = "quadratic"', 'algorithm = "adaptive"'],
    ids=["fixed steps, courses of inputs", "adaptive"],
)
def test_isolation_does_not_change_a_bit(
    mixed, monkeypatch, stepper: str, simulation: str
) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    system = System.from_toml(mixed(simulation=simulation))
    assert_same(system.isolated().simulate(), system.simulate())


@COMPILER
def test_one_isolated_among_others_does_not_change_a_bit(mixed) -> None:
    system = System.from_toml(mixed("control", simulation=""))
    assert [n.name for n in system.graph.nodes if n.isolated] == ["control"]
    assert_same(system.simulate(), System.from_toml(mixed(simulation="")).simulate())


@COMPILER
def test_algebraic_loop_through_an_isolated_fmu_is_solved_to_the_same_bits(write) -> None:
    path = write(["a.y -> b.u", "b.y -> a.u"], a=affine("native"), b=affine("native"))
    system = System.from_toml(path)
    assert_same(system.isolated().simulate(), system.simulate())


@COMPILER
def test_states_pass_between_isolated_and_plain_runs(mixed) -> None:
    system = System.from_toml(mixed(simulation=""))
    with system.start() as plain, system.isolated().start() as isolated:
        plain.step(4)
        isolated.restore(plain.save())
        plain.step(5)
        isolated.step(5)
        assert isolated.values() == plain.values()


@COMPILER
def test_nothing_stays_open_or_alive(unruly, tmp_path: Path) -> None:
    path = unruly(0, 1)
    files = []
    for _ in range(2):
        with pytest.raises(RunError):
            System.from_toml(path).simulate(tmp_path)
        gc.collect()
        files.append(len(os.listdir("/proc/self/fd")))
    assert files[0] == files[1]
    assert servers() == []


@COMPILER
@pytest.mark.parametrize("mood", [3, 9])  # hanging, answering
def test_processes_end_with_a_run_that_is_killed(unruly, tmp_path: Path, mood: int) -> None:
    path = unruly(mood)
    path.write_text(path.read_text().replace("stop_time = 1.0", "stop_time = 1e6"))
    with subprocess.Popen(command("run", path, "--out", tmp_path)) as run:
        until((tmp_path / "log.txt").exists)  # it says something before it hangs
        (server,) = servers(run.pid)
        run.kill()
    until(lambda: not Path(f"/proc/{server}").exists())


@COMPILER
def test_interrupt_of_the_whole_terminal_ends_the_run_in_good_order(unruly, tmp_path) -> None:
    path = unruly(9)
    path.write_text(path.read_text().replace("stop_time = 1.0", "stop_time = 1e6"))
    with subprocess.Popen(command("run", path, "--out", tmp_path), start_new_session=True,
                          stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as run:
        until((tmp_path / "log.txt").exists)
        os.killpg(run.pid, signal.SIGINT)
        _, said = run.communicate()
    assert run.returncode == 130
    assert "interrupted: stopped at t = " in said
    assert len(read(tmp_path / "results.h5").time) > 1


def test_explain_says_which_are_isolated(write) -> None:
    path = write(
        ["plant.x -> control.x"],
        plant=block("Integrator"), control=block("Gain", "isolate = true\nevery = 2"),
    )
    text = subprocess.run(command("explain", path), capture_output=True, text=True,
                          check=True).stdout
    assert "2  control  Gain        FMI 2.0  isolated, steps every 0.2 s" in text
    assert text.count("isolated") == 1


def test_time_limit_of_what_is_not_isolated_is_a_problem(write, problems) -> None:
    path = write(plant=block("Integrator", "time_limit = 5.0"))
    assert problems(path) == [
        "system.toml:9: instances.plant.time_limit: can be kept by an isolated FMU only; "
        "add isolate = true"
    ]


def assert_same(found: Results, expected: Results) -> None:
    """Two results agree to the last bit."""
    assert found.time.tobytes() == expected.time.tobytes()
    assert set(found.series) == set(expected.series)
    for name in expected.series:
        assert found[name].tobytes() == expected[name].tobytes()


def servers(parent: int | None = None) -> list[int]:
    """The processes of isolated FMUs of a run, by default of this process."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            ppid = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
        except (OSError, ValueError):
            continue
        mine = ppid == (parent or os.getpid())
        if mine and b"sightline.orchestrator.isolation.server" in words:
            found.append(int(folder.name))
    return found


def until(holds: Callable[[], object]) -> None:
    """Wait until something holds."""
    deadline = time.monotonic() + 20.0  # s: a busy machine
    while not holds():
        assert time.monotonic() < deadline
        time.sleep(0.05)
