"""Hangs a load on models that `stiffbench model export --format mjcf` writes, in MuJoCo, and compares the displacement of the end.

    python3 -m venv venv && venv/bin/pip install mujoco yourdfpy
    venv/bin/python tests/mujoco/check.py target/release/stiffbench            compare
    venv/bin/python tests/mujoco/check.py target/release/stiffbench --write    write fixtures/mujoco again

MuJoCo steps each model until it is at rest; nothing of stiffbench takes part. The displacement must lie within 1 % of what the compliance that
`robot compliance --load` prints under the same load gives, relative to its length. yourdfpy reads each URDF and places its end.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

FORCE_N = 70.0
# MuJoCo is at rest when no displacement changes by more than this share over a tenth of a second; its friction creeps a little.
AT_REST = 3e-4
MOST_S = 6.0
# The load grows over this time: a sudden one would overshoot, and friction would hold that.
GROWS_S = 1.0
TOLERANCE = 0.01
FOLDER = pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "mujoco"


def export(program, arguments, form):
    command = [program, "model", "export", "--format", form, "--quiet", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def compliance(program, arguments, axis):
    """Of the end under the force along an axis: joints that stick or have play by their secant."""
    if "--fit" in arguments:
        return json.loads(export(program, arguments, "json"))["poses"][0]["compliance"]
    force = ",".join(str(FORCE_N if i == axis else 0) for i in range(3))
    command = [program, "robot", "compliance", "--json", *arguments, f"--load={force}"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["data"]["compliance"]


def displacements(mujoco, text):
    """Displacement of the site `end` under the force along x, y and z, m: a row a force."""
    import numpy as np

    model = mujoco.MjModel.from_xml_string(text)
    model.opt.gravity[:] = 0.0
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "end")
    body = model.site_bodyid[site]
    chunk = round(0.1 / model.opt.timestep)
    rows = []
    for axis in range(3):
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        start = data.site_xpos[site].copy()
        force = np.zeros(3)
        force[axis] = FORCE_N
        before = np.full(3, np.inf)
        while True:
            for _ in range(chunk):
                data.qfrc_applied[:] = 0.0
                grown = min(data.time / GROWS_S, 1.0) * force
                mujoco.mj_applyFT(model, data, grown, np.zeros(3), data.site_xpos[site], body, data.qfrc_applied)
                mujoco.mj_step(model, data)
            mujoco.mj_forward(model, data)
            moved = data.site_xpos[site] - start
            if data.time > GROWS_S and np.abs(moved - before).max() <= AT_REST * np.linalg.norm(moved):
                break
            if data.time > MOST_S:
                sys.exit(f"not at rest after {MOST_S} s")
            before = moved
        rows.append([float(x) for x in moved])
    return rows


def urdf_differs_m(yourdfpy, program, arguments):
    """How far the link `end` of the URDF at zero lies from the end of the robot, m; a vertical y is turned to z there."""
    import io

    text = export(program, arguments, "urdf")
    robot = yourdfpy.URDF.load(io.BytesIO(text.encode()), build_scene_graph=True, load_meshes=False)
    found = robot.get_transform("end", "world")[:3, 3]
    x, y, z = json.loads(export(program, arguments, "json"))["poses"][0]["end_m"]
    ours = (x, y, z) if "axes of the robot file, 0 0 1 is up" in text else (x, -z, y)
    return max(abs(a - b) for a, b in zip(found, ours))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--write", action="store_true", help="write what MuJoCo finds to fixtures/mujoco")
    options = parser.parse_args()
    try:
        import mujoco
    except ImportError:
        print("skipped: MuJoCo is not installed (pip install mujoco)")
        return 0
    options.program = str(pathlib.Path(options.program).resolve())
    os.chdir(FOLDER)
    cases = json.loads((FOLDER / "cases.json").read_text())
    found, failed = {}, 0
    for name, arguments in cases.items():
        text = export(options.program, arguments, "mjcf")
        rows = displacements(mujoco, text)
        found[name] = rows
        worst = 0.0
        for axis, row in enumerate(rows):
            ours = compliance(options.program, arguments, axis)
            expected = [FORCE_N * ours[i][axis] for i in range(3)]
            length = sum(x * x for x in expected) ** 0.5
            worst = max(worst, sum((a - b) ** 2 for a, b in zip(row, expected)) ** 0.5 / length)
        ok = worst <= TOLERANCE
        failed += not ok
        print(f"{name}: differs by {100 * worst:.3f} % at most{'' if ok else '  FAILED'}")
        if options.write:
            (FOLDER / f"{name}.xml").write_text(text)
    if options.write:
        kept = {"mujoco": mujoco.__version__, "force_N": FORCE_N, "displacement_m": found}
        (FOLDER / "displacements.json").write_text(json.dumps(kept, indent=1) + "\n")
    try:
        import yourdfpy
    except ImportError:
        print("URDF skipped: yourdfpy is not installed (pip install yourdfpy)")
        return 1 if failed else 0
    for name, arguments in cases.items():
        apart_m = urdf_differs_m(yourdfpy, options.program, arguments)
        failed += apart_m > 1e-9
        print(f"{name}: the end of the URDF differs by {apart_m:.1e} m")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
