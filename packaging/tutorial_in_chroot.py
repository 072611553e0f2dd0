"""The tutorial with the static program alone: every command of docs/tutorial.md in an empty root folder, timed (needs root).

python3 packaging/tutorial_in_chroot.py target/x86_64-unknown-linux-musl/dist/stiffbench
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

program = Path(sys.argv[1])
tutorial = Path(__file__).parent.parent / "docs" / "tutorial.md"
commands = re.findall(r"^\$ stiffbench (.*)$", tutorial.read_text(), re.MULTILINE)
assert len(commands) > 5, "the tutorial has no commands"

root = Path(tempfile.mkdtemp())
for name in ["bin", "dev/pts", "tmp", "work"]:
    (root / name).mkdir(parents=True)
shutil.copy(program, root / "bin" / "stiffbench")
os.symlink("pts/ptmx", root / "dev" / "ptmx")
# Software gauges need pseudo-terminals.
subprocess.run(["mount", "-t", "devpts", "devpts", root / "dev/pts", "-o", "ptmxmode=0666,newinstance"], check=True)


def enter():
    os.chroot(root)
    os.chdir("/work")


failed = 0
total = 0.0
try:
    for command in commands:
        began = time.monotonic()
        done = subprocess.run(
            ["/bin/stiffbench", *command.split()],
            preexec_fn=enter,
            env={"TERM": "dumb"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )
        seconds = time.monotonic() - began
        total += seconds
        print(f"{seconds:7.2f} s  exit {done.returncode}  stiffbench {command}")
        if done.returncode != 0:
            failed += 1
            print(done.stdout + done.stderr)
    size = program.stat().st_size / 1e6
    print(f"{total:7.2f} s  {len(commands)} commands, {failed} failed; a program of {size:.1f} MB and nothing else")
finally:
    subprocess.run(["umount", root / "dev/pts"], check=True)
    shutil.rmtree(root)
sys.exit(failed > 0)
