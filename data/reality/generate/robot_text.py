"""Robot files with one number changed: the text as shipped, but for that number."""

import re
import tempfile
from functools import lru_cache
from pathlib import Path

import shared
from structures import Robot

FILES = {
    "hp": shared.ROOT / "data/robots/hp-robot.toml", "serial": shared.ROOT / "data/robots/serial-arm.toml",
    "stacker": shared.CONCEALED / "robots/stacker-arm.toml",
}


@lru_cache(maxsize=None)
def shipped(name: str) -> str:
    return FILES[name].read_text()


@lru_cache(maxsize=64)
def parsed(text: str) -> Robot:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "robot.toml"
        file.write_text(text)
        return Robot(str(file))


def with_number(text: str, table: str, key: str, value: float) -> str:
    """`key = value` in `[table]`; the rest of the line, its comment too, stays."""
    head, rest = _split_at(text, table)
    found = re.search(rf"(?m)^{re.escape(key)}\s*=\s*([-+0-9.eE]+)", rest)
    following = re.search(r"(?m)^\[", rest)
    if not found or following and following.start() < found.start():
        raise KeyError(f"{table}.{key}")
    return head + rest[: found.start(1)] + f"{value:.8g}" + rest[found.end(1) :]


def with_factor(text: str, group: str, values: dict[str, float]) -> str:
    """Another set of factors of one group in `[factors.m_fsd]`."""
    head, rest = _split_at(text, "factors.m_fsd")
    inside = ", ".join(f"{name} = {value:.6g}" for name, value in values.items())
    changed, count = re.subn(rf"(?m)^{group}\s*=\s*\{{[^}}]*\}}", f"{group} = {{ {inside} }}", rest, count=1)
    if count != 1:
        raise KeyError(f"factors.m_fsd.{group}")
    return head + changed


def _split_at(text: str, table: str) -> tuple[str, str]:
    found = re.search(rf"(?m)^\[{re.escape(table)}\][^\n]*\n", text)
    if not found:
        raise KeyError(table)
    return text[: found.end()], text[found.end() :]


# Lengths that a user types: parameter, and the body it is the length of.
LENGTHS = {
    "hp": {"l_A1A2": "ground", "l_A2A3": "waist", "l_A3A4": "upper_arm", "l_A4A5": "forearm", "l_A5F8": "end_link",
           "l_C": "crank_C", "l_D": "crank_D", "l_F": "crank_F8", "l_E": "crank_E1"},
    "serial": {"h": "post", "l1": "arm1", "l2": "arm2", "l3": "hand"},
    "stacker": {"h_foot": "ground", "h_post": "post", "l_boom": "boom", "l_stick": "stick", "l_tail": "stick",
                "l_crank": "crank", "l_pull": "pull_rod"},
}
# Variables, the joint that each turns, and the body it turns.
ANGLES = {
    "hp": {"theta1": ("A2", "waist"), "theta2": ("A3", "upper_arm"), "theta3": ("A4", "forearm"), "theta4": ("F8", "crank_F8")},
    "serial": {"theta1": ("S1", "post"), "theta2": ("S2", "arm1"), "theta3": ("S3", "arm2"), "theta4": ("S4", "hand")},
    "stacker": {"yaw": ("turn", "post"), "lift": ("shoulder", "boom"), "reach": ("elbow", "stick")},
}


def poses_of(robot: Robot, names: tuple[str, ...]) -> list[dict]:
    return [{k: v for k, v in robot.data["poses"][name].items() if k in robot.variables} for name in names]


def end_body(robot: Robot) -> str:
    return robot.data["nodes"][robot.end_node]["on"]
