"""What the tests share: the program whose JSON the results must equal, and sessions."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = os.environ.get("STIFFBENCH", str(ROOT / "target/release/stiffbench"))


@pytest.fixture
def program(tmp_path):
    """Runs the program in a folder of its own and returns the object that it prints."""

    def run(*words):
        words = [PROGRAM, *map(str, words), "--json", "--quiet"]
        done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path)
        return json.loads(done.stdout)

    return run


@pytest.fixture
def demo(tmp_path):
    """A copy of the shipped session."""
    return Path(shutil.copytree(ROOT / "data/sessions/demo", tmp_path / "demo"))


@pytest.fixture
def sprung(tmp_path):
    """A simulated session of mechanism A with a joint that yields."""
    words = "simulate sprung --robot hp-robot --mechanism A --seed 3 --effect joint-compliance@A3:c=20urad/(N*m)"
    subprocess.run([PROGRAM, *words.split()], check=True, cwd=tmp_path, capture_output=True)
    return tmp_path / "sprung"
