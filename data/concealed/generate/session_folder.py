"""The folder of a session: readings.csv and session.toml."""

from pathlib import Path

import numpy as np

from noise import Noise
from plan import Plan, Table

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
