"""Faults in a run: numbers that are none, exceptions in Python, full disks, signals."""

from __future__ import annotations

import platform
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from pythonfmu.builder import FmuBuilder

from sightline.orchestrator.errors import RunError
from sightline.orchestrator.results.file import read
from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

from .foreign import archive, library

BLOCKS = Path(__file__).with_name("blocks.py").as_posix()
COMPILER = pytest.mark.skipif(shutil.which("cc") is None, reason="writes FMUs in C")
SOURCE = r"""
#define _GNU_SOURCE
#include <fenv.h>
#include <signal.h>
#include <stdlib.h>
#include <stddef.h>
#ifdef __x86_64__
#include <xmmintrin.h>
#endif
typedef struct { double u, x, after; } Fmu;
typedef const unsigned *Refs;
void *fmi2Instantiate(const char *n, int t, const char *g, const char *r, const void *c, int v,
                      int l)
{
    feenableexcept(FE_DIVBYZERO | FE_INVALID);
#ifdef __x86_64__
    _mm_setcsr(_mm_getcsr() | 0x8040); /* tiny numbers are zero */
#endif
    return calloc(1, sizeof(Fmu));
}
void fmi2FreeInstance(void *c) { free(c); }
int fmi2SetupExperiment(void *c, int d, double t, double a, int e, double b) { return 0; }
int fmi2EnterInitializationMode(void *c) { feenableexcept(FE_DIVBYZERO); return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2SetReal(void *c, Refs r, size_t n, const double *v)
{
    for (size_t i = 0; i < n; i++) ((double *)c)[r[i]] = v[i];
    return 0;
}
int fmi2GetReal(void *c, Refs r, size_t n, double *v)
{
    for (size_t i = 0; i < n; i++) v[i] = ((double *)c)[r[i]];
    return 0;
}
int fmi2DoStep(void *c, double t, double h, int x)
{
    Fmu *f = c;
#ifdef TRAPS
    if (t > 0.25) {
        TRAPS;
    }
#endif
    f->x = t > 0.25 ? f->u / f->after : 1.0;
    return 0;
}
"""
DESCRIPTION = """<fmiModelDescription fmiVersion="2.0" modelName="divide" guid="divide">
<CoSimulation modelIdentifier="divide"/>
<ModelVariables>
<ScalarVariable name="u" valueReference="0" causality="input"><Real start="0"/></ScalarVariable>
<ScalarVariable name="x" valueReference="1" causality="output"><Real/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2" dependencies=""/></Outputs></ModelStructure>
</fmiModelDescription>"""
RAISING = '''
from pythonfmu import Fmi2Slave, Fmi2Causality, Real


class Raising(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y = 1.0
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, time, step):
        if time > 0.25:
            raise ZeroDivisionError("nothing to divide by")
        return True
'''
OWN = """
import math

from sightline.components import Component, Input, Output


class Careless(Component):
    '''y = sqrt(1/4 - t)'''

    x = Input((), "1", doc="idle")
    y = Output((), "1", doc="output")

    def outputs(self, time, x):
        return {"y": math.sqrt(0.25 - float(time)) + x}
"""


@pytest.fixture(scope="module")
def divide(tmp_path_factory: pytest.TempPathFactory) -> str:
    """An FMU whose output becomes u / 0 and which wants this to end the process."""
    folder = tmp_path_factory.mktemp("divide")
    fmu = archive(folder / "divide.fmu", DESCRIPTION, library(folder, "divide", SOURCE))
    return f'fmu = "{fmu.as_posix()}"\nstart = {{ u = %s }}'


def block(name: str, text: str = "") -> str:
    return f'component = "{BLOCKS}:{name}"\n{text}'


def program(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "sightline.orchestrator.cli", *(str(a) for a in arguments)]


def sightline(*arguments: object, **options: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(program(*arguments), capture_output=True, text=True, check=False,
                          **options)  # type: ignore[call-overload, no-any-return]


@COMPILER
@pytest.mark.parametrize(("u", "value"), [("1.0", "inf"), ("0.0", "nan")])
def test_division_that_would_trap_is_told_by_its_result(
    divide: str, write, tmp_path: Path, u: str, value: str
) -> None:
    done = sightline("run", write(a=divide % u), "--out", tmp_path / "out")
    assert done.returncode == 1  # a trap would have ended it with a signal
    assert (
        f"a at t = 0.4 s: the output x is {value}, and the FMU said nothing of it\n" in done.stderr
    )
    results = read(tmp_path / "out" / "results.h5")
    np.testing.assert_allclose(results.time, [0.0, 0.1, 0.2, 0.3, 0.4])
    assert np.isfinite(results["a.x"]).tolist() == [True, True, True, True, False]


INTEL = pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="only Intel's processors trap"
)


@COMPILER
@pytest.mark.parametrize(
    ("statement", "cause"),
    [
        pytest.param("f->x = (int)f->u / (int)f->after", "integer division by zero", marks=INTEL),
        pytest.param("feenableexcept(FE_DIVBYZERO)", "division by zero", marks=INTEL),
        pytest.param("f->u = 0.0; feenableexcept(FE_INVALID)", "an invalid operation", marks=INTEL),
        ("raise(SIGFPE)", "arithmetic"),
    ],
)
def test_trap_in_a_step_ends_the_run_and_is_told(
    statement: str, cause: str, write, tmp_path: Path
) -> None:
    binary = library(tmp_path, "divide", f"#define TRAPS {statement}\n{SOURCE}")
    archive(tmp_path / "divide.fmu", DESCRIPTION, binary)
    path = write(a='fmu = "divide.fmu"\nstart = { u = 1.0 }')
    done = sightline("run", path, "--out", tmp_path / "out")
    assert done.returncode == 1
    assert done.stderr.endswith(
        f"a at t = 0.3 s: the step of 0.1 s ended with a trap (SIGFPE): {cause}\n"
    )
    results = read(tmp_path / "out" / "results.h5")
    assert not results.complete
    np.testing.assert_allclose(results.time, [0.0, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(results["a.x"][1:], 1.0)


@COMPILER
@pytest.mark.parametrize("stepper", ["python", "compiled"])
@pytest.mark.parametrize("record", ["b.y", "a.x"])  # what is after the division; it alone
def test_first_output_that_is_no_number_is_named(
    divide: str, write, tmp_path: Path, monkeypatch, stepper: str, record: str
) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    path = write(
        ["a.x -> b.u"], a=divide % "0.0", b=block("Integrator"),
        rest=f'[record]\nsignals = ["{record}"]'.replace("b.y", "b.x"),
    )
    with pytest.raises(RunError, match=r"^a at t = 0\.[34] s: the output x is nan"):
        System.from_toml(path).simulate(tmp_path / "out")


@COMPILER
def test_tiny_numbers_stay_what_they_are(divide: str, write, tmp_path: Path) -> None:
    tiny = np.array([5e-324])  # the smallest of all
    with System.from_toml(write(a=divide % "0.0")).start():
        assert (tiny * 1.0)[0] > 0.0
        with np.errstate(divide="ignore"):
            assert np.isinf(1.0 / (0.0 * tiny))[0]  # and nothing traps


def test_exception_in_a_foreign_python_fmu_is_told(write, tmp_path: Path) -> None:
    (tmp_path / "raising.py").write_text(RAISING, encoding="utf-8")
    FmuBuilder.build_FMU(tmp_path / "raising.py", dest=tmp_path)
    done = sightline("run", write(a='fmu = "Raising.fmu"'), "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "a at t = 0.3 s: the step of 0.1 s ended with fatal: " in done.stderr
    assert done.stderr.endswith(": ZeroDivisionError('nothing to divide by')\n")


def test_exception_in_a_block_of_ones_own_is_told(write, tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(OWN, encoding="utf-8")
    path = write(a='component = "own.py:Careless"\ntarget = "python"')
    done = sightline("run", path, "--out", tmp_path / "out")
    assert done.returncode == 1
    assert "a at t = 0.3 s: getting outputs ended with fatal: " in done.stderr
    assert done.stderr.endswith(": ValueError('math domain error')\n")


LONG = "[simulation]\nstop_time = 200.0\nstep = 0.01\n"


def limited(size: int) -> Callable[[], None]:
    """Lets files grow to a size only, as a full disk would."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    return limit


def test_full_disk_leaves_what_was_written(write, tmp_path: Path) -> None:
    path = write(plant=block("Integrator", "start = { u = 1.0 }"), simulation=LONG)
    System.from_toml(path)  # builds the FMU
    done = sightline("run", path, "--out", tmp_path / "out", preexec_fn=limited(200_000))
    results = read(tmp_path / "out" / "results.h5")
    count = len(results.time)
    assert done.returncode == 1
    assert done.stderr.endswith(
        f"cannot write to {tmp_path}/out: File too large\n"
        f"results until then in {tmp_path}/out: results.h5 ({count} samples)\n"
    )
    assert not results.complete
    assert count > 1000
    np.testing.assert_allclose(results["plant.x"], results.time, atol=1e-9)  # sums of 20 000 steps


def test_disk_that_is_full_from_the_start_is_told(write, tmp_path: Path) -> None:
    path = write(plant=block("Integrator"))
    System.from_toml(path)
    done = sightline("run", path, "--out", tmp_path / "out", preexec_fn=limited(1000))
    assert done.returncode == 1
    assert done.stderr.endswith(f"cannot write to {tmp_path}/out: File too large\n")
    assert list((tmp_path / "out").iterdir()) == []


def test_full_disk_spoils_no_checkpoint(write, tmp_path: Path) -> None:
    path = write(plant=block("Integrator", "start = { u = 1.0 }"), simulation=LONG)
    out = tmp_path / "out"
    done = sightline("run", path, "--out", out, "--checkpoint-every", 0.5,
                     preexec_fn=limited(200_000))
    assert "File too large" in done.stderr
    resumed = sightline("run", path, "--out", out, "--resume", out / "checkpoint.h5")
    assert (resumed.returncode, read(out / "results.h5").complete) == (0, True)


@pytest.mark.parametrize(
    ("out", "why"),
    [("file", "it is a file, not a folder"), ("file/below", "Not a directory")],
)
def test_folder_that_cannot_be_is_told(write, tmp_path: Path, out: str, why: str) -> None:
    (tmp_path / "file").write_text("")
    done = sightline("run", write(plant=block("Integrator")), "--out", tmp_path / out)
    assert done.returncode == 1
    assert done.stderr.endswith(f"cannot write to {tmp_path}/{out}: {why}\n")


def test_folder_is_made_with_its_parents(write, tmp_path: Path) -> None:
    out = tmp_path / "a" / "b"
    assert sightline("run", write(plant=block("Integrator")), "--out", out).returncode == 0
    assert read(out / "results.h5").complete


@pytest.fixture
def endless(write) -> Path:
    """A system that runs for longer than a test."""
    path: Path = write(plant=block("Integrator", "start = { u = 1.0 }"), simulation=LONG)
    path.write_text(path.read_text().replace("200.0", "2e6"))
    System.from_toml(path)  # builds
    return path


@contextmanager
def running(path: Path, out: Path) -> Iterator[subprocess.Popen[str]]:
    """A run that has begun to write."""
    with subprocess.Popen(program("run", path, "--out", out), stderr=subprocess.PIPE,
                          stdout=subprocess.DEVNULL, text=True) as run:
        deadline = time.monotonic() + 20.0  # s: a busy machine
        while not (out / "results.h5").exists() or (out / "results.h5").stat().st_size < 50_000:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        yield run


@pytest.mark.skipif(sys.platform == "win32", reason="there the open file itself is in the way")
def test_second_run_into_a_folder_is_refused(endless: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with running(endless, out) as first:
        second = sightline("run", endless, "--out", out)
        first.terminate()
        _, said = first.communicate()
    assert (second.returncode, first.returncode) == (1, 130)
    assert second.stderr.endswith(f"cannot write to {out}: another run is writing there\n")
    reached = float(re.search("stopped at t = (.*) s", said)[1])
    assert read(out / "results.h5").time[-1] == pytest.approx(reached, rel=1e-5)


def test_request_to_terminate_ends_the_run_in_good_order(endless: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with running(endless, out) as run:
        run.terminate()
        _, said = run.communicate()
    assert run.returncode == 130
    assert "interrupted: stopped at t = " in said
    end = read(out / "results.h5").time[-1]
    plotted = sightline("plot", out / "results.h5", "--out", tmp_path, "--until", 1.0, "-s", "*")
    assert plotted.returncode == 0
    assert plotted.stderr == (
        f"{out}/results.h5 is incomplete: its run ended at t = {end:.6g} s, before its stop time\n"
    )
