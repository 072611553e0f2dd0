"""Each function against the JSON of its command."""

import pickle
import shutil
import subprocess
import sys

import pytest
import stiffbench
from conftest import ROOT


def test_the_version_is_that_of_the_program(program, demo):
    assert stiffbench.__version__ == program("stiffness", demo)["tool"]["version"]


@pytest.mark.parametrize(
    "words, options",
    [
        ([], {}),
        (["--branches", "both", "--budget"], {"branches": "both", "budget": True}),
        (["--force-u", "0.2N", "--displacement-u", "2um"], {"force_u": "0.2N", "displacement_u": "2um", "trust_csv": False}),
    ],
)
def test_stiffness(program, demo, words, options):
    assert stiffbench.stiffness(demo, **options) == program("stiffness", demo, *words)


def test_stiffness_of_a_gauges_own_log(program):
    log = ROOT / "fixtures/sessions/gauge.log"
    expected = program("stiffness", log, "--pose", "P1", "--direction", "x")
    assert expected["ok"]
    assert stiffbench.stiffness(str(log), pose="P1", direction="x") == expected


def test_fit(program, demo):
    assert stiffbench.fit(demo, train=["P1", "P3"]) == program("fit", demo, "--train", "P1,P3")
    words = ["--parameter", "beam.J=fixed,beam.A=0.001..0.01", "--bootstrap", 40, "--seed", 4]
    options = {"parameter": ("beam.J=fixed", "beam.A=0.001..0.01"), "bootstrap": 40, "seed": 4}
    assert stiffbench.fit(demo, **options) == program("fit", demo, *words)


def test_fit_of_the_papers_values(program):
    expected = program("fit", "paper-experiment", "--robot", "hp-robot", "--method", "paper", "--train", "P1,P3")
    found = stiffbench.fit("paper-experiment", robot="hp-robot", method="paper", train="P1,P3")
    assert expected["ok"] and found == expected


def test_diagnose(program, sprung, tmp_path):
    options = {"mechanism": "A", "seed": 2, "no_figures": True, "out": tmp_path / "out"}
    words = ["--mechanism", "A", "--seed", 2, "--no-figures", "--out", tmp_path / "out"]
    expected = program("diagnose", sprung, *words)
    found = stiffbench.diagnose(sprung, **options)
    assert expected["data"]["verdict"] != "nothing-missing"
    assert found == expected
    assert (tmp_path / "out/verdict.txt").exists()


def test_several_sessions(program, demo):
    assert program("simulate", "second", "--seed", 9)["ok"]
    second = demo.parent / "second"
    expected = program("fit", demo, second, "--train", "P1,P3")
    assert expected["ok"]
    assert stiffbench.fit(demo, second, train="P1,P3") == expected


@pytest.mark.parametrize(
    "data, options, code, exit_code",
    [
        ("not-there", {}, "stiffbench::input", 11),
        ("--not-there", {}, "stiffbench::input", 11),
        ("demo", {"branch": "both"}, "stiffbench::usage", 2),
        ("demo", {"branches": "some"}, "stiffbench::usage", 2),
    ],
)
def test_failures(program, demo, monkeypatch, data, options, code, exit_code):
    monkeypatch.chdir(demo.parent)
    with pytest.raises(stiffbench.StiffbenchError) as raised:
        stiffbench.stiffness(data, **options)
    error = raised.value
    words = [f"--{name}={value}" for name, value in options.items()]
    expected = program("stiffness", data, *words) if not data.startswith("--") else None
    assert error.code.startswith(code) and error.exit_code == exit_code
    assert error.message in str(error)
    if expected:
        assert not expected["ok"]
        assert expected["error"] == {
            "code": error.code,
            "message": error.message,
            "help": error.help,
            "exit_code": error.exit_code,
        }
        assert expected["warnings"] == error.warnings
    again = pickle.loads(pickle.dumps(error))
    assert (again.code, again.help, again.exit_code) == (error.code, error.help, error.exit_code)


def test_the_configuration_counts_as_it_does_for_the_command(program, demo, tmp_path, monkeypatch):
    monkeypatch.setenv("STIFFBENCH_ROBOT", "serial-arm")
    monkeypatch.chdir(tmp_path)
    # Alone: a session.toml beside it would name the robot.
    readings = shutil.copy(demo / "readings.csv", tmp_path / "alone.csv")
    configured = stiffbench.fit(readings)
    assert configured == program("fit", readings)
    named = stiffbench.fit(readings, robot="hp-robot")
    assert named == program("fit", readings, "--robot", "hp-robot")
    assert named["inputs"]["robot"] != configured["inputs"]["robot"]


def test_nothing_is_printed(demo):
    code = f"import stiffbench; stiffbench.fit({str(demo)!r}, train='P1,P3', bootstrap=40)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
