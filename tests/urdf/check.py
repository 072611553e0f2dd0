"""Makes robot files of public URDFs with `stiffbench robot new --urdf` and compares where their tools are with Pinocchio.

    python3 -m venv venv && venv/bin/pip install pin example-robot-data pybullet
    venv/bin/python tests/urdf/check.py target/release/stiffbench            compare
    venv/bin/python tests/urdf/check.py target/release/stiffbench --write    write fixtures/urdf/kinematics.json again, for tests/robot_new.rs

Nothing is changed by hand: the file that the command writes gets the poses, and `robot check` says where the tool is. The position must
agree to 1e-9 m, the mass of all that moves on the base to a millionth, its centre in the URDF that `robot export` writes with all joints at zero to 1e-6 m. The fixture holds, for each robot, joint names and values (rad, m), position (m) and the rows of the rotation matrix of
the tip in the axes of the base; the URDFs stay in their packages.
"""

import argparse
import json
import math
import random
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "robots"))

from compared_robots import PACKAGES, PUBLIC

POSES = 20
KEPT_POSES = 3
TOLERANCE_M = 1e-9
TOLERANCE_OF_MASS = 1e-6
TOLERANCE_OF_CENTRE_M = 1e-6
FIXTURE = Path(__file__).resolve().parents[2] / "fixtures" / "urdf" / "kinematics.json"


def by_pinocchio(pin, path, base, tip, count):
    """Base, tip, kinds of the joints between them, the mass of all that moves on the base, and random poses with the place of the tip in the axes of the base."""
    model = pin.buildModelFromUrdf(str(PACKAGES / path))
    data = model.createData()
    frames = {frame.name: i for i, frame in enumerate(model.frames) if frame.type == pin.FrameType.BODY}
    base = base or next(f.name for f in model.frames if f.type == pin.FrameType.BODY)
    if tip is None:
        leaves = [n for n, i in frames.items() if not any(j.parentFrame == i for j in model.frames)]
        assert len(leaves) == 1, leaves
        tip = leaves[0]
    # Joints that do not lie between base and tip take no part.
    chain = {}
    joint = model.frames[frames[tip]].parentJoint
    while joint != model.frames[frames[base]].parentJoint:
        chain[model.names[joint]] = "slides" if model.joints[joint].shortname().startswith("JointModelP") else "turns"
        joint = model.parents[joint]
    held = model.frames[frames[base]].parentJoint
    moved = [joint for joint in range(1, model.njoints) if held in model.supports[joint] and joint != held]
    mass_kg = sum(model.inertias[joint].mass for joint in moved)
    pin.framesForwardKinematics(model, data, pin.neutral(model))
    at_zero_m = data.oMf[frames[base]].actInv(centre(model, data, moved))
    poses = []
    for _ in range(count):
        q = pin.neutral(model)
        values = {}
        for joint in range(1, model.njoints):
            i = model.joints[joint].idx_q
            if model.joints[joint].nq == 2:
                angle = random.uniform(-3, 3)
                q[i], q[i + 1] = math.cos(angle), math.sin(angle)
                values[model.names[joint]] = angle
            else:
                low, high = model.lowerPositionLimit[i], model.upperPositionLimit[i]
                q[i] = random.uniform(max(low, -3.0), min(high, 3.0))
                values[model.names[joint]] = float(q[i])
        pin.framesForwardKinematics(model, data, q)
        place = data.oMf[frames[base]].actInv(data.oMf[frames[tip]])
        values = {name: value for name, value in values.items() if name in chain}
        poses.append({"values": values, "position_m": place.translation.tolist(), "rotation": place.rotation.tolist()})
    return base, tip, chain, (mass_kg, at_zero_m), poses


def centre(model, data, joints):
    """Centre of mass of what moves with these joints, m."""
    moment = sum(model.inertias[joint].mass * data.oMi[joint].act(model.inertias[joint].lever) for joint in joints)
    return moment / sum(model.inertias[joint].mass for joint in joints)


def with_poses(text, chain, poses):
    """The robot file with other poses; joints keep their names, or end in `_joint` where the name means something else."""
    joints = tomllib.loads(text)["joints"]
    head, found, _ = text.partition("\n[poses]\n")
    assert found, "the file has no poses"
    rows = []
    for index, pose in enumerate(poses):
        cells = []
        for name, value in pose["values"].items():
            name_here = name if name in joints else f"{name}_joint"
            key, value = (f"{name_here}_m", value) if chain[name] == "slides" else (f"{name_here}_deg", math.degrees(value))
            cells.append(f'"{key}" = {value!r}')
        rows.append(f"Q{index} = {{ {', '.join(cells)} }}")
    names = [cell.split(" = ")[0] for cell in cells]
    rows.append(f"Zero = {{ {', '.join(f'{name} = 0' for name in names)} }}")
    return head + "\n[poses]\n" + "\n".join(rows) + "\n"


def exported_centre(pin, program, file):
    """Centre of mass of the URDF that is exported again with all joints at zero, m."""
    command = [program, "robot", "export", "--format", "urdf", "--robot", str(file), "--pose", "Zero", "--quiet"]
    model = pin.buildModelFromXML(subprocess.run(command, capture_output=True, text=True, check=True).stdout)
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    return centre(model, data, range(model.njoints))


def imported(pin, program, path, base, tip, chain, poses):
    """Notes of the import, the largest difference of a position, m, the mass, kg, and its centre with all joints at zero, m."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.toml"
        command = [program, "robot", "new", str(file), "--urdf", str(PACKAGES / path)]
        command += [word for name, value in (("--base", base), ("--tip", tip)) if value for word in (name, value)]
        made = subprocess.run([*command, "--json"], capture_output=True, text=True)
        if made.returncode:
            sys.exit(f"{path}: {made.stdout}{made.stderr}")
        file.write_text(with_poses(file.read_text(), chain, poses))
        checked = subprocess.run([program, "robot", "check", str(file), "--json", "--quiet"], capture_output=True, text=True)
        if checked.returncode:
            sys.exit(f"{path}: {checked.stdout}{checked.stderr}")
        checked = json.loads(checked.stdout)["data"]
        places = {row["pose"]: row["tool_m"] for row in checked["checked"]}
        at_zero_m = exported_centre(pin, program, file)
    worst = max(abs(a - b) for i, pose in enumerate(poses) for a, b in zip(pose["position_m"], places[f"Q{i}"]))
    return json.loads(made.stdout).get("warnings", []), worst, (checked["mass_kg"], at_zero_m)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--write", action="store_true", help="write what Pinocchio finds to fixtures/urdf/kinematics.json")
    options = parser.parse_args()
    try:
        import pinocchio as pin
    except ImportError:
        print("skipped: Pinocchio is not installed (pip install pin example-robot-data pybullet)")
        return 0
    program = str(Path(options.program).resolve())
    random.seed(23)
    kept, failed = [], 0
    print("| robot | from | to | joints | largest difference in 20 poses, m | mass, kg | warnings |\n| --- | --- | --- | --- | --- | --- | --- |")
    for path, base, tip in PUBLIC:
        base_found, tip_found, chain, (mass_kg, centre_m), poses = by_pinocchio(pin, path, base, tip, POSES)
        warnings, worst, (own_kg, own_centre_m) = imported(pin, program, path, base, tip, chain, poses)
        off_m = abs(own_centre_m - centre_m).max()
        same = worst <= TOLERANCE_M and abs(own_kg - mass_kg) <= TOLERANCE_OF_MASS * mass_kg and off_m <= TOLERANCE_OF_CENTRE_M
        failed += not same
        name = path.rsplit("/", 1)[1]
        mark = "" if same else f" **FAILED**, URDF {mass_kg:.6f} kg, centre {off_m:.1e} m off"
        print(f"| `{name}` | {base_found} | {tip_found} | {len(chain)} | {worst:.1e} | {own_kg:.6f}{mark} | {len(warnings)} |")
        kept.append({"package_path": path, "base": base_found, "tip": tip_found, "poses": poses[:KEPT_POSES]})
    if options.write:
        FIXTURE.write_text(json.dumps({"made_by": f"Pinocchio {pin.__version__}", "robots": kept}, indent=1) + "\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
