"""The robots that outside programs are compared on, and how they are asked for: shipped ones, templates, random ones, public URDFs."""

import json
import pathlib
import subprocess
import sysconfig

from random_robots import random_robot

RANDOM_ROBOTS = 60
PACKAGES = pathlib.Path(sysconfig.get_path("purelib"))
DATA = "cmeel.prefix/share/example-robot-data/robots"
# Public URDFs: file, base, tip.
PUBLIC = [
    (f"{DATA}/panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp"),
    (f"{DATA}/ur_description/urdf/ur3_robot.urdf", "base_link", "tool0"),
    (f"{DATA}/ur_description/urdf/ur5_robot.urdf", "base_link", "tool0"),
    (f"{DATA}/ur_description/urdf/ur10_robot.urdf", "base_link", "tool0"),
    (f"{DATA}/kinova_description/robots/kinova.urdf", "j2s6s200_link_base", "j2s6s200_end_effector"),
    (f"{DATA}/xarm_description/urdf/xarm7.urdf", None, "link_eef"),
    (f"{DATA}/talos_data/robots/talos_left_arm.urdf", None, "arm_left_7_link"),
    (f"{DATA}/baxter_description/urdf/baxter.urdf", "torso", "left_gripper"),
    (f"{DATA}/tiago_description/robots/tiago_no_hand.urdf", "base_link", "arm_tool_link"),
    (f"{DATA}/pr2_description/urdf/pr2.urdf", "torso_lift_link", "l_gripper_tool_frame"),
    (f"{DATA}/z1_description/urdf/z1.urdf", None, None),
    (f"{DATA}/so_arm_description/urdf/so100.urdf", None, None),
    ("pybullet_data/kuka_iiwa/model.urdf", None, "lbr_iiwa_link_7"),
    ("pybullet_data/xarm/xarm6_robot.urdf", "link_base", "link6"),
]
TEMPLATES = ["serial", "scara", "four-bar", "parallelogram", "gantry"]
SHIPPED = ["serial-arm", "fanuc-r2000ic", "franka-panda", "four-bar", "scara", "gantry", "hp-robot", "hp-robot-host-dominant"]


def printed(program, *arguments):
    run = subprocess.run([program, *arguments, "--json", "--quiet"], check=True, capture_output=True, text=True)
    return json.loads(run.stdout)["data"]


def with_stiffness(line):
    """A line of a robot file, its free spring with a stiffness to begin at: a URDF has none."""
    stiffness = "stiffness_N_per_um = 5" if 'kind = "sliding"' in line else "stiffness_Nm_per_rad = 5e4"
    return line.replace('spring = "free"', f'spring = "free", {stiffness}')


def robots(program, folder):
    """Names and files of shipped robots, of random ones, of templates, and of robots made of public URDFs where their packages are installed."""
    yield from SHIPPED
    for seed in range(RANDOM_ROBOTS):
        file = pathlib.Path(folder) / f"random-{seed}.toml"
        file.write_text(random_robot(seed))
        yield str(file)
    made = [(name, ["--template", name]) for name in TEMPLATES]
    for path, base, tip in PUBLIC:
        if (PACKAGES / path).exists():
            words = [("--urdf", str(PACKAGES / path)), ("--base", base), ("--tip", tip)]
            made.append((pathlib.Path(path).stem, [word for pair in words if pair[1] for word in pair]))
        else:
            print(f"{path}: not installed (pip install example-robot-data pybullet)")
    for name, words in made:
        file = str(pathlib.Path(folder) / f"{name}-{words[0][2:]}.toml")
        subprocess.run([program, "robot", "new", file, *words, "--quiet"], check=True, capture_output=True)
        if "--urdf" in words:
            text = pathlib.Path(file).read_text().splitlines()
            pathlib.Path(file).write_text("\n".join(with_stiffness(line) for line in text) + "\n")
        yield file


def sag_of(program, robot):
    """Values of the variables by name in a random pose, the mass, kg, and how far the tool sags there, m; `None` for a robot without masses."""
    if printed(program, "robot", "check", robot).get("mass_kg") is None:
        return None
    found = printed(program, "robot", "map", robot, "--sag", "--samples", "1")["sag"]["mechanisms"][0]
    names = [variable["name"] for variable in printed(program, "robot", "show", robot)["variables"]]
    values = dict(zip(names, found["displacement"]["worst"]["angles_deg"]))
    return values, found["mass_kg"], [1e-6 * found[f"displacement_{axis}"]["least"] for axis in "xyz"]


def set_to(values):
    """Options that set variables."""
    return ["--set", *(f"{name}={float(value)!r}" for name, value in values.items())]


def apart(found, expected):
    """Length of the difference of two vectors as a share of the length of the second."""
    return sum((a - b) ** 2 for a, b in zip(found, expected)) ** 0.5 / sum(b * b for b in expected) ** 0.5
