"""The worked examples run, as modules and as a user starts them."""

import subprocess
import sys

from conftest import ROOT

EXAMPLES = ROOT / "python/examples"


def run(name, *words):
    done = subprocess.run([sys.executable, EXAMPLES / name, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_stiffness_of_a_csv(tmp_path):
    rows = ["pose,direction,repeat,force_N,displacement_um"]
    # 0.05 N/um with a little noise that changes from repeat to repeat.
    for repeat in range(1, 6):
        for step in range(6):
            noise = [0.7, -1.1, 0.4, 0.9, -0.6][(repeat * 2 + step) % 5]
            rows.append(f"P1,x,{repeat},{-10.0 * step:.1f},{-200.0 * step + noise:.1f}")
    data = tmp_path / "mine.csv"
    data.write_text("\n".join(rows) + "\n")
    (line,) = run("stiffness_of_csv.py", data, "0.2N", "2um")
    assert line.startswith("P1 x: K = 0.0") and "U = " in line and "unknown" not in line
    value = float(line.split("K = ")[1].split()[0])
    assert abs(value - 0.05) < 0.0005


def test_diagnose_a_session(sprung, tmp_path):
    lines = run("diagnose_session.py", sprung, tmp_path / "results")
    assert lines[0].endswith("in 12 cells")
    assert lines[1] == "verdict: explained"
    assert lines[3].startswith("joint-compliance at A3: c = ")
    assert (tmp_path / "results/diagnosis.json").exists()


def test_workspace():
    lines = run("workspace.py", "hp-robot", 4000)
    assert lines[0].startswith("host-parasite") and lines[-1].startswith("weakest: ")
    assert [line[:3] for line in lines[1:4]] == ["x: ", "y: ", "z: "]


def test_the_page_shows_the_examples():
    page = (ROOT / "docs/python.md").read_text()
    for example in EXAMPLES.glob("*.py"):
        assert f"```python\n{example.read_text()}```\n" in page, example.name
