"""Hangs a load on models that `stiffbench robot export --format mjcf` writes, in MuJoCo, and compares the displacement of the end.

    python3 -m venv venv && venv/bin/pip install mujoco yourdfpy pin pybullet example-robot-data
    venv/bin/python tests/mujoco/check.py target/release/stiffbench            compare
    venv/bin/python tests/mujoco/check.py target/release/stiffbench --write    write fixtures/mujoco again

MuJoCo steps each model until it is at rest; nothing of stiffbench takes part. The displacement must lie within 1 % of what the compliance that
`robot compliance --load` prints under the same load gives, relative to its length. yourdfpy reads each URDF and places its end.

Masses: of every shipped robot, every template, 60 random robots and robots made of public URDFs, MuJoCo, yourdfpy, Pinocchio and PyBullet load what is exported. Mass
and centre of mass must agree, with the robot file and among them; inertias of the SDF must be those of a body; links must be visible. MuJoCo's sag under gravity must
lie within 1 % of `robot map --sag`.
"""

import argparse
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "robots"))

from compared_robots import apart, robots, sag_of, set_to

FORCE_N = 70.0
# MuJoCo is at rest when no displacement changes by more than this share over a tenth of a second; its friction creeps a little.
AT_REST = 3e-4
MOST_S = 6.0
# The load grows over this time: a sudden one would overshoot, and friction would hold that.
GROWS_S = 1.0
TOLERANCE = 0.01
# Of a whole mass, kg, and of coordinates of its centre, m.
SAME_MASS = 1e-6
SAME_CENTRE_M = 1e-6
# At most this sag, m, is compared.
SMALL_SAG_M = 1e-3
FOLDER = pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "mujoco"


def export(program, arguments, form):
    command = [program, "robot", "export", "--format", form, "--quiet", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def compliance(program, arguments, axis):
    """Of the end under the force along an axis: joints that stick or have play by their secant."""
    if "--fit" in arguments:
        return json.loads(export(program, arguments, "json"))["poses"][0]["compliance"]
    force = ",".join(str(FORCE_N if i == axis else 0) for i in range(3))
    command = [program, "robot", "compliance", "--json", *arguments, f"--load={force}"]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["data"]["compliance"]


def moved(mujoco, model, force, gravity):
    """Displacement of the site `end` under a force on it and a gravity, m."""
    import numpy as np

    model.opt.gravity[:] = 0.0
    site = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, "end")
    body = model.site_bodyid[site]
    chunk = round(0.1 / model.opt.timestep)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    start = data.site_xpos[site].copy()
    before = np.full(3, np.inf)
    while True:
        for _ in range(chunk):
            data.qfrc_applied[:] = 0.0
            grown = min(data.time / GROWS_S, 1.0)
            model.opt.gravity[:] = grown * np.array(gravity)
            mujoco.mj_applyFT(model, data, grown * np.array(force), np.zeros(3), data.site_xpos[site], body, data.qfrc_applied)
            mujoco.mj_step(model, data)
        mujoco.mj_forward(model, data)
        now = data.site_xpos[site] - start
        if data.time > GROWS_S and np.abs(now - before).max() <= AT_REST * np.linalg.norm(now):
            return [float(x) for x in now]
        if data.time > MOST_S:
            sys.exit(f"not at rest after {MOST_S} s")
        before = now


def displacements(mujoco, text):
    """Displacement of the site `end` under the force along x, y and z, m: a row a force."""
    model = mujoco.MjModel.from_xml_string(text)
    forces = [[FORCE_N if i == axis else 0.0 for i in range(3)] for axis in range(3)]
    return [moved(mujoco, model, force, [0.0] * 3) for force in forces]


def by_mujoco(mujoco, text):
    """The model, its mass, kg, and the centre of mass, m."""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return model, (model.body_mass.sum(), (model.body_mass[:, None] * data.xipos).sum(0) / model.body_mass.sum())


def in_axes_of_robot(text, centre):
    """A place in a URDF in the axes of the robot file, which may have y upwards."""
    x, y, z = centre
    return [x, y, z] if "axes of the robot file, 0 0 1 is up" in text else [x, z, -y]


def by_yourdfpy(text):
    """Mass, kg, and centre of mass, m, of a URDF."""
    import yourdfpy

    robot = yourdfpy.URDF.load(io.BytesIO(text.encode()), build_scene_graph=True, load_meshes=False)
    links = [link for link in robot.robot.links if link.inertial]
    places = [robot.get_transform(link.name, "world") @ link.inertial.origin for link in links]
    mass = sum(link.inertial.mass for link in links)
    centre = sum(link.inertial.mass * place[:3, 3] for link, place in zip(links, places)) / mass
    return mass, in_axes_of_robot(text, centre)


def by_pinocchio(text):
    """Mass, kg, and centre of mass, m, of a URDF."""
    import pinocchio as pin

    model = pin.buildModelFromXML(text)
    data = model.createData()
    pin.forwardKinematics(model, data, pin.neutral(model))
    mass = sum(inertia.mass for inertia in model.inertias)
    centre = sum(inertia.mass * place.act(inertia.lever) for inertia, place in zip(model.inertias, data.oMi)) / mass
    return mass, in_axes_of_robot(text, centre)


def by_pybullet(text, form):
    """Mass, kg, and centre of mass, m, of a URDF or SDF."""
    import numpy as np
    import pybullet

    with tempfile.NamedTemporaryFile("w", suffix=f".{form}") as file:
        file.write(text)
        file.flush()
        client = pybullet.connect(pybullet.DIRECT)
        try:
            body = pybullet.loadSDF(file.name)[0] if form == "sdf" else pybullet.loadURDF(file.name, useFixedBase=True)
            links = range(pybullet.getNumJoints(body))
            masses = np.array([pybullet.getDynamicsInfo(body, i)[0] for i in [-1, *links]])
            places = [pybullet.getLinkState(body, i, computeForwardKinematics=1)[0] for i in links]
            places.insert(0, pybullet.getBasePositionAndOrientation(body)[0])
            return masses.sum(), in_axes_of_robot(text, masses @ np.array(places) / masses.sum())
        finally:
            pybullet.disconnect(client)


def by_sdf(text):
    """Mass, kg, and centre of mass, m, of an SDF in the axes of its model, and whether each inertia is that of a body."""
    import numpy as np

    mass, moment, are_bodies = 0.0, np.zeros(3), True
    for link in xml.etree.ElementTree.fromstring(text).iter("link"):
        numbers = [[float(word) for word in link.findtext(path).split()] for path in ("pose", "inertial/pose", "inertial/mass")]
        mass += numbers[2][0]
        moment += numbers[2][0] * (np.array(numbers[0][:3]) + numbers[1][:3])
        xx, xy, xz, yy, yz, zz = (float(link.findtext(f"inertial/inertia/{name}")) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
        least, middle, most = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        are_bodies &= least > 0 and least + middle > most
    return (mass, moment / mass), are_bodies


def masses_and_sag(mujoco, program, robot):
    """What is wrong with the masses of the exports of a robot in a random pose, and a line about them."""
    import numpy as np

    wrong = []
    weighed = sag_of(program, robot)
    arguments, mass, sag = ["--robot", robot], 0.0, None
    if weighed:
        values, mass, sag = weighed
        arguments += set_to(values)
    files = {form: export(program, arguments, form) for form in ("mjcf", "urdf", "sdf")}
    model, found = by_mujoco(mujoco, files["mjcf"])
    of_sdf, are_bodies = by_sdf(files["sdf"])
    loaded = {"MJCF": found, "yourdfpy": by_yourdfpy(files["urdf"]), "Pinocchio": by_pinocchio(files["urdf"]), "SDF": of_sdf}
    loaded["PyBullet, URDF"] = by_pybullet(files["urdf"], "urdf")
    # PyBullet has no loops in SDF: a link with two joints above it would be there twice.
    if "URDF holds no loops" not in files["urdf"]:
        loaded["PyBullet, SDF"] = by_pybullet(files["sdf"], "sdf")
    if not are_bodies:
        wrong.append("an inertia of the SDF is that of no body")
    if model.ngeom == 0 or "<visual" not in files["urdf"] or "<visual" not in files["sdf"]:
        wrong.append("nothing can be seen")
    for name, (own, centre) in loaded.items():
        if abs(own - mass) > SAME_MASS * max(mass, 1.0):
            wrong.append(f"{name}: {own} kg")
        if weighed and np.abs(np.array(centre) - found[1]).max() > SAME_CENTRE_M:
            wrong.append(f"centre of mass: MJCF {found[1]}, {name} {centre}")
    line = f"{mass:.6g} kg"
    if sag:
        # MuJoCo's displacements are large ones: of a robot that sags far a part of its weight is hung on.
        share = min(1.0, SMALL_SAG_M / np.linalg.norm(sag))
        off = apart(moved(mujoco, model, [0.0] * 3, share * model.opt.gravity), share * np.array(sag))
        line += f", sag {1e3 * np.linalg.norm(sag):.3g} mm differs by {100 * off:.3f} %"
        if off > TOLERANCE:
            wrong.append("sag")
    return line, wrong


def urdf_differs_m(yourdfpy, program, arguments):
    """How far the link `end` of the URDF at zero lies from the end of the robot, m; a vertical y is turned to z there."""
    text = export(program, arguments, "urdf")
    robot = yourdfpy.URDF.load(io.BytesIO(text.encode()), build_scene_graph=True, load_meshes=False)
    found = robot.get_transform("end", "world")[:3, 3]
    ours = json.loads(export(program, arguments, "json"))["poses"][0]["end_m"]
    return max(abs(a - b) for a, b in zip(in_axes_of_robot(text, found), ours))


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
            worst = max(worst, apart(row, expected))
        ok = worst <= TOLERANCE
        failed += not ok
        print(f"{name}: differs by {100 * worst:.3f} % at most{'' if ok else '  FAILED'}")
        if options.write:
            (FOLDER / f"{name}.xml").write_text(text)
    if options.write:
        kept = {"mujoco": mujoco.__version__, "force_N": FORCE_N, "displacement_m": found}
        (FOLDER / "displacements.json").write_text(json.dumps(kept, indent=1) + "\n")
    try:
        import pinocchio  # noqa: F401
        import pybullet  # noqa: F401
        import yourdfpy
    except ImportError:
        print("URDF and masses skipped: yourdfpy, pin or pybullet is not installed (pip install yourdfpy pin pybullet)")
        return 1 if failed else 0
    for name, arguments in cases.items():
        apart_m = urdf_differs_m(yourdfpy, options.program, arguments)
        failed += apart_m > 1e-9
        print(f"{name}: the end of the URDF differs by {apart_m:.1e} m")
    with tempfile.TemporaryDirectory() as folder:
        for robot in robots(options.program, folder):
            line, wrong = masses_and_sag(mujoco, options.program, robot)
            failed += bool(wrong)
            print(f"{pathlib.Path(robot).stem}: {line}{'  FAILED: ' + '; '.join(wrong) if wrong else ''}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
