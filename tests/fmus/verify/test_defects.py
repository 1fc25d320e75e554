"""One broken FMU per defect: each is caught by the check meant for it, and only sound ones pass."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from sightline.fmus.build import build
from sightline.fmus.native.platforms import compile_library, own_platform
from sightline.fmus.safe_archive import extract
from sightline.fmus.verify.bench import Options, verify
from sightline.fmus.verify.findings import Report, Verdict
from sightline.fmus.verify.registry import checks

Check = Callable[..., Report]
Make = Callable[..., Path]

IN_THE_SOURCE = [
    ("MISSING_FUNCTION", "description.binaries", "lacks fmi2GetDirectionalDerivative"),
    ("ANY_TOKEN", "description.token", "instantiation with another token: gives an instance"),
    ("REFUSES", "calls.legal", "no inputs during initialisation"),
    ("STEP_ANYWHERE", "calls.illegal", "a step in mode instantiated: accepted"),
    ("DAMAGE", "calls.illegal", "afterwards, reset, y after step 0"),
    ("DAMAGE", "calls.storm", "afterwards, reset, y after step 0"),
    ("ADDRESS", "determinism.instances", "a second instance: differs: y after step 0"),
    ("SHARED_STATE", "determinism.independence", "differs: y after step"),
    ("RESET", "determinism.reset", "after reset: differs: x after step 0"),
    ("PROCESS", "determinism.processes", "another process: differs: y after step 0"),
    ("STATE", "state.restore", "values, restored once: differs: x"),
    ("STATE_MODE", "state.modes", "setup of the experiment: Error"),
    ("COUNTS_STEPS", "state.rollback", "differs: y after step 0"),
    ("SERIALIZE", "state.serialize", "continued in the same instance: differs"),
    ("ANY_BYTES", "state.damaged", "deserialising random bytes: accepted"),
    ("EULER", "steps.partition", "usual steps: "),
    ("DRIFT", "steps.drift", "internal time at the end"),
    ("NAN", "inputs.running", "u = nan: der(x), y not finite after setting, with status OK"),
    ("NAN", "inputs.start", "k = nan"),
    ("NAN_LARGE_STEP", "steps.partition", "reading the variables at 1 s: y not finite"),
    ("NAN_LARGE_STEP", "steps.drift", "y not finite, with status OK"),
    ("NAN_LATER", "steps.partition", "y not finite, with status OK"),
    ("NAN_LATER", "steps.drift", "y not finite, with status OK"),
    ("NAN_LATER", "determinism.instances", "y not finite, with status OK"),
    ("NO_MESSAGE", "inputs.running", "u = nan: refused on setting without a message"),
    ("CRASH_ON_NAN", "inputs.running", "u = nan, fmi2SetReal: crashed the process (SIGABRT)"),
    ("DERIVATIVE", "derivatives.directional", "by x: d z is"),
    ("EXCHANGE", "interfaces", "by model exchange"),
    ("EXCHANGE_LITTLE", "interfaces", "der(x) after step 1, at the same states"),
    ("DISCARDS", "calls.legal", "Discard (no message)"),
    ("LEAK_STEP", "resources.steps", "bytes a step"),
    ("LEAK_INSTANCE", "resources.instances", "bytes an instance"),
    ("OPEN_FILE", "resources.instances", "/dev/null left open"),
    ("CHDIR", "resources.surroundings", "working directory: changed"),
    ("WRITES_FILE", "resources.surroundings", "debug.txt written"),
    ("CRASH", "calls.legal", "crashed the process (SIGSEGV)"),
    ("EXIT", "calls.legal", "ended the process with exit code 3"),
]
IN_THE_DESCRIPTION = [
    (' modelName="Bench"', ' modelName="Bench" colour="red"', "description.schema", "colour"),
    ('      <Unknown index="5" dependencies="1 3"/>\n      <Unknown index="6" dependencies="8"/>\n'
     '      <Unknown index="7" dependencies="3"/>\n    </InitialUnknowns>',
     '      <Unknown index="6" dependencies="8"/>\n'
     '      <Unknown index="7" dependencies="3"/>\n    </InitialUnknowns>',
     "description.structure", "y: is not an initial unknown"),
    ('<Unknown index="7" dependencies="3"/>', '<Unknown index="7" dependencies="5"/>',
     "description.structure", "z: depends on y, a output"),
    ('name="z"', 'name="y"', "description.validation", 'name "y" (line'),
    ('unit="m2"', 'unit="m3"', "description.units", "z: the unit m3 is not defined"),
    ('<BaseUnit m="2"/>', '<BaseUnit m="3"/>', "description.units",
     "m2: is defined as m3; expected m2"),
    ('start="1.0" min="0.1"', 'start="0.0" min="0.1"', "description.start", "k: starts at 0"),
    ('start="1.0" min="0.1"', 'start="2.0" min="0.1"', "description.values",
     "k: is 1 at the start; expected 2 as declared"),
    ('guid="{bench}"', 'guid="{other}"', "description.token", "wrong token"),
    ('<Unknown index="5" dependencies="1 3"/>', '<Unknown index="5" dependencies="3"/>',
     "dependencies", "y: changes with u; expected no change"),
]  # fmt: skip


def test_the_sound_fmu_passes_every_check(make: Make, check: Check) -> None:
    report = check(make(), effort=0.2)
    assert report.failures == ()
    skipped = {r.check for r in report.results if r.verdict is Verdict.NOT_APPLICABLE}
    assert skipped == {"derivatives.adjoint", "agreement", "reference"}


@pytest.mark.parametrize(("defect", "meant", "found"), IN_THE_SOURCE)
def test_a_defect_of_the_source_is_caught(
    defect: str, meant: str, found: str, make: Make, check: Check
) -> None:
    report = check(make(defect), only=(meant,))
    assert report.result(meant).verdict is Verdict.FAILED
    assert found in "\n".join(map(str, report.failures))


@pytest.mark.parametrize(("old", "new", "meant", "found"), IN_THE_DESCRIPTION)
def test_a_defect_of_the_description_is_caught(
    old: str, new: str, meant: str, found: str, make: Make, check: Check
) -> None:
    report = check(make("", (old, new)), only=(meant,))
    assert report.result(meant).verdict is Verdict.FAILED
    assert found in "\n".join(map(str, report.failures))


def test_a_hanging_fmu_is_ended_and_its_last_call_named(make: Make, check: Check) -> None:
    report = check(make("HANG"), only=("calls.storm",), time_limit=1.0)
    assert "did not come back within 1 s" in str(report.failures[0])
    assert report.failures[0].where.startswith("fmi2DoStep(")


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
def test_processes_that_an_fmu_forks_end_with_the_check(
    make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MARK", str(tmp_path))
    began = time.monotonic()
    (report,) = verify([make("FORKS")], Options(("determinism",)))
    assert report.passed
    assert time.monotonic() - began < 20.0  # not the time limits, of 60 s each
    assert not _marked(tmp_path)


def _marked(path: Path) -> list[str]:
    """Processes that were started with a path in their environment."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if str(path) in (folder / "environ").read_text(errors="replace"):
                found.append(folder.name)
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="looks for processes in /proc")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_an_interrupted_verify_leaves_no_process(
    number: signal.Signals, make: Make, tmp_path: Path
) -> None:
    path = make("HANG")
    arguments = ["-m", "sightline.orchestrator.cli", "verify", str(path), "--only", "calls.storm"]
    (tmp_path / "temporary").mkdir()
    command = subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env={**os.environ, "TMPDIR": str(tmp_path / "temporary")},
    )  # fmt: skip
    deadline = time.monotonic() + 20.0
    while not list(tmp_path.glob("temporary/*/trace")) and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(0.5)  # it hangs now
    command.send_signal(number)
    output, _ = command.communicate(timeout=10.0)  # until the process of the checks, too, has ended
    assert not _marked(tmp_path)
    assert b"Traceback" not in output
    if number != signal.SIGKILL:
        assert command.returncode == 130
        assert not list((tmp_path / "temporary").iterdir())


def test_garbage_in_all_files_is_a_finding(make: Make, check: Check) -> None:
    report = check(make("GARBAGE"), only=("description.start", "calls.legal", "determinism.reset"))
    assert "wrote into the bench's own channel" in str(report.result("calls.legal").findings[0])
    assert report.result("description.start").verdict is Verdict.PASSED


def test_a_crash_in_one_trial_does_not_hide_the_others(make: Make, check: Check) -> None:
    report = check(make("CRASH_ON_NAN"), only=("inputs.running",))
    assert [f.where for f in report.failures] == [
        f"u = {value}, fmi2SetReal" for value in ("nan", "inf", "-inf")
    ]
    sound = check(make(), only=("inputs.running",)).result("inputs.running")
    assert report.result("inputs.running").tried["values"] == sound.tried["values"]


def test_a_check_is_given_up_where_every_trial_crashes(make: Make, check: Check) -> None:
    failures = check(make("ABORTS"), only=("calls.illegal",)).failures
    assert [f.where.split(", fmi2")[0] for f in failures[:3]] == [
        f"a step in mode {mode}" for mode in ("instantiated", "initialisation", "terminated")
    ]
    assert len({f.where for f in failures}) == 8
    assert failures[-1].remedy == "what comes after that in this check was not tried"


def test_a_hang_in_one_trial_does_not_hide_the_next(make: Make, check: Check) -> None:
    failures = check(make("STUCK"), only=("calls.illegal",), time_limit=1.0).failures
    assert [f.where for f in failures] == [
        f"a step in mode {mode}, fmi2DoStep(0, 0.05)" for mode in ("instantiated", "initialisation")
    ]
    assert all("did not come back within" in f.found for f in failures)


def test_after_a_crash_the_other_checks_run(make: Make, check: Check) -> None:
    report = check(make("CRASH"))
    verdicts = {r.check: r.verdict for r in report.results}
    assert list(verdicts) == ["archive", *checks()]
    assert verdicts["steps.partition"] is Verdict.FAILED
    assert verdicts["description.binaries"] is Verdict.PASSED


def test_fmus_of_one_model_that_disagree_are_caught(make: Make, check: Check) -> None:
    files = make(name="one"), make("GAIN", name="two")
    report = check(*files, only=("agreement",))
    assert "y after step" in str(report.failures[0])
    assert "as one.fmu" in str(report.failures[0])


def test_a_value_that_is_no_number_agrees_with_none(make: Make, check: Check) -> None:
    for names in (("one", "two"), ("two", "one")):
        files = (make("", name=names[0]), make("NAN_LATER", name=names[1]))
        report = check(*files, only=("agreement",))
        assert "y not finite, with status OK" in str(report.failures[0])


def test_fmus_of_one_model_that_agree_pass(make: Make, check: Check) -> None:
    report = check(make(name="one"), make(name="two"), only=("agreement",))
    assert report.result("agreement").verdict is Verdict.PASSED


REFERENCE = '"time","x"\n0,1\n0.5,0.8032653298563167\n1,0.6839397205857212\n'  # u = 0.5


def test_a_reference_beside_the_fmu_is_followed(make: Make, check: Check) -> None:
    path = make()
    path.with_name("bench_ref.csv").write_text(REFERENCE, encoding="utf-8")
    result = check(path, only=("reference",)).result("reference")
    assert (result.verdict, result.tried) == (Verdict.PASSED, {"values": 3})


def test_a_reference_with_inputs_is_followed(make: Make, check: Check) -> None:
    path = make()
    given = path.with_name("given_ref.csv")
    given.write_text("time,x,y\n0,1,3\n1,1,3\n", encoding="utf-8")
    path.with_name("given_in.csv").write_text("time,u\n0,1\n1,1\n", encoding="utf-8")
    assert check(path, only=("reference",), reference=given).passed


@pytest.mark.parametrize(
    ("reference", "found"),
    [
        (REFERENCE.replace("0.68", "0.69"), "x at 1 s: 0.683939721; expected 0.69"),
        (REFERENCE.replace('"x"', '"w"'), "the column w is no variable of the FMU"),
    ],
)
def test_a_reference_that_is_missed_is_a_failure(
    reference: str, found: str, make: Make, check: Check
) -> None:
    path = make()
    path.with_name("bench_ref.csv").write_text(reference, encoding="utf-8")
    assert found in str(check(path, only=("reference",)).failures[0])


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"", "bench_ref.csv: has no rows"),
        (b"time,x\n", "bench_ref.csv: has no rows"),
        (b"time\n0\n1\n", "bench_ref.csv: has one column only; expected a column of times"),
        (b"time;x\n0;1\n", "bench_ref.csv: has one column only; ';' does not separate"),
        ("time,x\n0,1\n".encode("utf-16"), "bench_ref.csv: cannot be read: 'utf-8' codec"),
        (b"time,x\n0,1\n1\n", "bench_ref.csv, line 3: has 1 values; expected 2"),
        (b"time,x\n0,one\n", "bench_ref.csv, line 2, column x: 'one'; expected a finite number"),
        (b"time,x\nnan,1\n", "bench_ref.csv, line 2, column time: 'nan'; expected a finite"),
        (b"time,x\n0,1\n2,1\n1,1\n", "bench_ref.csv, line 4: goes back in time"),
        (b"time,x,x\n0,1,1\n", "bench_ref.csv: has the column x more than once"),
    ],
)
def test_what_is_wrong_with_a_reference_file_is_said(
    content: bytes, found: str, make: Make, check: Check
) -> None:
    path = make()
    path.with_name("bench_ref.csv").write_bytes(content)
    assert found in str(check(path, only=("reference",)).failures[0])


@pytest.mark.parametrize(
    ("file", "old", "new", "meant"),
    [
        ("sensitivity.c", "gather(k, sum, result);",
         "gather(k, sum, result); for (size_t i = 0; i < n_result; i++) result[i] *= 1.01;",
         "derivatives.adjoint"),
        ("snapshot.c", "self->s = ((const Snapshot *)snapshot)->state;",
         "double x = self->s.v[STATES]; self->s = ((const Snapshot *)snapshot)->state;"
         "self->s.v[STATES] = x;", "state.restore"),
        ("sensitivity.c", "gather(u, ", "d[DERIVATIVES] *= 1.01; gather(u, ",
         "derivatives.directional"),
        ("fmi3_run.c", "ALLOW3(STEP);\n    Progress",
         "ALLOW3(INITIALIZATION | STEP);\n    Progress", "calls.illegal"),
    ],
)  # fmt: skip
def test_a_defect_of_an_fmi_3_fmu_is_caught(
    file: str, old: str, new: str, meant: str, tmp_path: Path, fmu_cache: None, check: Check
) -> None:
    sound = build("FreeRigidBody", target="native", fmi=3)
    platform = own_platform()
    assert platform is not None
    extract(sound, tmp_path / "fmu")
    source = tmp_path / "fmu/sources" / file
    text = source.read_text(encoding="utf-8")
    assert old in text
    source.write_text(text.replace(old, new), encoding="utf-8")
    binary = tmp_path / "fmu" / platform.binary(3, "FreeRigidBody")
    compile_library("FreeRigidBody", platform, tmp_path / "fmu/sources/fmu.c", binary)
    broken = Path(shutil.make_archive(str(tmp_path / "broken"), "zip", tmp_path / "fmu"))
    assert check(sound, only=(meant,)).passed
    assert check(broken, only=(meant,)).result(meant).verdict is Verdict.FAILED
