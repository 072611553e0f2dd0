"""Robot files with further poses: the shipped text, and a few poses at its end."""

from structures import ROOT

HEAD = "# {source} of this project with further poses; everything but the poses is as shipped.\n"
EXTRA = {
    "hp-robot-more-poses.toml": ("hp-robot.toml", """
# ---------------------------------------------------------------- further poses
[poses.N1]
theta2 = 386.5
theta3 = 311.2
[poses.N2]
theta2 = 364.8
theta3 = 297.4
[poses.N3]         # another wrist angle
theta2 = 378.0
theta3 = 306.0
theta4 = 78.0
[poses.N4]         # the waist turned
theta1 = 382.0
theta2 = 390.0
theta3 = 322.0
"""),
    "serial-arm-more-poses.toml": ("serial-arm.toml", """
# ---------------------------------------------------------------- further poses
[poses.N1]
theta2 = 58.0
theta3 = -42.0
theta4 = -15.0
[poses.N2]
theta2 = 80.0
theta3 = 12.0
theta4 = -35.0
[poses.N3]         # the post turned
theta1 = -24.0
theta2 = 40.0
theta3 = -15.0
theta4 = 5.0
"""),
}


def write() -> None:
    for name, (source, poses) in EXTRA.items():
        text = (ROOT / "data" / "robots" / source).read_text()
        target = ROOT / "data" / "concealed" / "robots" / name
        target.write_text(HEAD.format(source=source) + text.rstrip("\n") + "\n" + poses)
