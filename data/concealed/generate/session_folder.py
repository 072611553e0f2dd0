"""The folder of a session: readings.csv and session.toml; of the proof lists all folders in one archive."""

import shutil
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

import numpy as np

from noise import Noise
from plan import Plan, Table

ARCHIVE = "proof-sessions.zip"
COLUMNS = "pose,direction,branch,step,target_N,repeat,force_N,displacement_um,hold_s,t_s,temp_degC"


def write_session(folder: Path, robot: str, mechanism: str, plan: Plan, noise: Noise, table: Table, readings: np.ndarray) -> None:
    """`robot`: path of the robot file from the folder; the folder's name is the id."""
    folder.mkdir(parents=True)
    digits = 0 if noise.res_um >= 1.0 else 1
    lines = [COLUMNS]
    for run, step in np.ndindex(readings.shape):
        force = table.rounded[run, step]
        lines.append(",".join([
            table.names[table.pose[run, step]], "xyz"[table.direction[run, step]],
            "loading" if table.step[run, step] <= 7 else "unloading", str(table.step[run, step]),
            f"{table.target[run, step]:.0f}", str(table.repeat[run, step]), f"{force + 0.0:.1f}",
            f"{readings[run, step] + 0.0:.{digits}f}", f"{table.hold[run, step]:.1f}", f"{table.time[run, step]:.2f}",
            f"{table.temperature[run, step]:.2f}",
        ]))
    (folder / "readings.csv").write_text("\n".join(lines) + "\n")
    quoted = lambda items: "[" + ", ".join(f'"{item}"' for item in items) + "]"
    branches = ["loading", "unloading"] if plan.unloading else ["loading"]
    (folder / "session.toml").write_text(f'''schema = "stiffbench/session/1"
id = "{folder.name}"
robot = "{robot}"
mechanism = "{mechanism}"
factors = "m_fsd"            # link factors are those of this set; beam factors are to be fitted

[procedure]
text = "{plan.text()}"
poses = {quoted(plan.poses)}
directions = {quoted(plan.directions)}
loads_N = [0, -10, -20, -30, -40, -50, -60, -70]
branches = {quoted(branches)}
repeats = {plan.repeats}
repeat_order = "sweep"
zero = "run"
holds_s = [{", ".join(f"{hold:g}" for hold in plan.holds_s)}]

[procedure.settle]
force_tolerance_N = 0.5

[instruments.force]
resolution_N = {noise.force_resolution_N}
[instruments.displacement]
resolution_um = {noise.res_um}
''')


def pack(out: Path, names: list[str]) -> None:
    """Moves session folders into the archive of the proof lists, beside what is in it already."""
    archive = out / ARCHIVE
    files = {}
    if archive.exists():
        with ZipFile(archive) as old:
            files = {name: old.read(name) for name in old.namelist()}
    for name in names:
        folder = out / "sessions" / name
        files.update({f"sessions/{name}/{path.name}": path.read_bytes() for path in folder.iterdir()})
        shutil.rmtree(folder)
    with ZipFile(archive, "w") as new:
        for name in sorted(files):
            new.writestr(ZipInfo(name), files[name], ZIP_DEFLATED, 9)
