"""What the peers share: one core, the beam structure as arrays over poses, timing, output.

Import this module before NumPy: it limits the BLAS to one thread.  The robot file is read by
fixtures/opensees/linkage.py; placing the nodes is not part of any timing.
"""

import ctypes
import json
import os
import statistics
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "fixtures" / "opensees"))

from linkage import Placement, Robot  # noqa: E402

DEFAULT_ROBOT = ROOT / "data" / "robots" / "hp-robot.toml"


def stay_on_one_core(core: int | None) -> int | None:
    """Pin the process; the core used, or None where the system cannot pin."""
    if not hasattr(os, "sched_setaffinity"):
        return None
    chosen = min(os.sched_getaffinity(0)) if core is None else core
    os.sched_setaffinity(0, {chosen})
    return chosen


def keep_freed_memory() -> None:
    """Let glibc keep what arrays give back.

    By default every array above 128 KiB is mapped afresh until the process has freed a larger one,
    and the page faults double the time of the faster peers.
    """
    m_trim_threshold, m_mmap_max = -1, -4
    try:
        libc = ctypes.CDLL("libc.so.6")
        libc.mallopt(m_mmap_max, 0)
        libc.mallopt(m_trim_threshold, 1 << 30)
    except (OSError, AttributeError):
        print("no glibc: freed memory may be mapped again for every batch", file=sys.stderr)


@dataclass(frozen=True)
class Layout:
    """One mechanism without its coordinates: connectivity, sections, supports, end.

    Free nodes are numbered 0 .. free - 1; a supported node has the number -1.  `ends` is elements x 2
    into the list of all nodes, `free_ends` the same in free numbers.
    """

    nodes: list[str]
    free: int
    ends: np.ndarray
    free_ends: np.ndarray
    end: int
    section: dict[str, np.ndarray]
    is_beam: np.ndarray

    @classmethod
    def of(cls, robot: Robot, mechanism: str, factors: str) -> "Layout":
        elements = robot.elements(mechanism)
        present = {node for element in elements for node in element["nodes"]}
        nodes = [node for node in robot.data["nodes"] if node in present]
        fixed = set(robot.data["support"]["fixed"])
        number = {node: index for index, node in enumerate(n for n in nodes if n not in fixed)}
        sections = [robot.section(element, factors) for element in elements]
        return cls(
            nodes=nodes,
            free=len(number),
            ends=np.array([[nodes.index(node) for node in element["nodes"]] for element in elements]),
            free_ends=np.array([[number.get(node, -1) for node in element["nodes"]] for element in elements]),
            end=number[robot.end_node],
            section={name: np.array([s[name] for s in sections]) for name in sections[0]},
            is_beam=np.array([element["class"] == "beam" for element in elements]),
        )


def coordinates(
    robot: Robot, layout: Layout, mechanism: str, poses: list[dict[str, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """Node coordinates, poses x nodes x 3, and plane normals, poses x elements x 3."""
    elements = robot.elements(mechanism)
    points, normals = [], []
    for variables in poses:
        placement = Placement(robot, variables)
        points.append([placement.node(node) for node in layout.nodes])
        normals.append([placement.normal(element["plane"]) for element in elements])
    return np.array(points), np.array(normals)


def random_poses(robot: Robot, count: int, seed: int) -> list[dict[str, float]]:
    """The poses of the robot file, then uniformly drawn ones inside the limits.

    The first variable (the turn of the whole arm) and the last stay at their nominal values.
    """
    random = np.random.default_rng(seed)
    poses = [
        robot.pose_variables({name: value for name, value in spec.items() if name in robot.variables})
        for spec in robot.data["poses"].values()
    ]
    drawn = robot.variables[1:-1]
    while len(poses) < count:
        limits = [robot.data["variables"][name] for name in drawn]
        pose = {name: random.uniform(s["min"], s["max"]) for name, s in zip(drawn, limits)}
        variables = robot.pose_variables(pose)
        if not robot.outside_limits(variables):
            poses.append(variables)
    return poses[:count]


def outer(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., :, None] * b[..., None, :]


def element_blocks(
    layout: Layout, points: np.ndarray, normals: np.ndarray, section: dict[str, np.ndarray] | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The 6 x 6 blocks (1,1), (1,2), (2,2) of every element matrix, poses x elements x 6 x 6.

    Euler-Bernoulli, local y the plane normal, local z = x cross y, Iy bending about y.
    """
    s = layout.section if section is None else section
    gap = points[:, layout.ends[:, 1]] - points[:, layout.ends[:, 0]]
    length = np.sqrt(np.einsum("bek,bek->be", gap, gap))
    x, y = gap / length[..., None], normals
    z = np.cross(x, y)
    xx, yy, zz, yz = outer(x, x), outer(y, y), outer(z, z), outer(y, z)

    def weigh(stiffness: np.ndarray, dyad: np.ndarray) -> np.ndarray:
        return stiffness[..., None, None] * dyad

    bend_y, bend_z = s["E"] * s["Iy"] / length, s["E"] * s["Iz"] / length
    twist = weigh(s["G"] * s["J"] / length, xx)
    square = length * length
    sway = weigh(s["E"] * s["A"] / length, xx)
    sway += weigh(12 * bend_y / square, zz) + weigh(12 * bend_z / square, yy)
    couple = weigh(6 * bend_z / length, yz) - weigh(6 * bend_y / length, np.swapaxes(yz, -1, -2))
    turn = weigh(bend_y, yy) + weigh(bend_z, zz)
    back = np.swapaxes(couple, -1, -2)
    shape = (*length.shape, 6, 6)
    first, across, second = np.empty(shape), np.empty(shape), np.empty(shape)
    first[..., :3, :3] = second[..., :3, :3] = sway
    first[..., :3, 3:] = across[..., :3, 3:] = couple
    first[..., 3:, :3] = back
    second[..., :3, 3:], second[..., 3:, :3] = -couple, -back
    first[..., 3:, 3:] = second[..., 3:, 3:] = 4 * turn + twist
    across[..., :3, :3], across[..., 3:, :3] = -sway, -back
    across[..., 3:, 3:] = 2 * turn - twist
    return first, across, second


def dense_matrices(layout: Layout, blocks: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Stiffness matrices of the free dofs, poses x n x n."""
    first, across, second = blocks
    count, free = len(first), layout.free
    matrix = np.zeros((count, free, 6, free, 6))
    for e, (i, j) in enumerate(layout.free_ends):
        if i >= 0:
            matrix[:, i, :, i, :] += first[:, e]
        if j >= 0:
            matrix[:, j, :, j, :] += second[:, e]
        if i >= 0 and j >= 0:
            matrix[:, i, :, j, :] += across[:, e]
            matrix[:, j, :, i, :] += np.swapaxes(across[:, e], 1, 2)
    return matrix.reshape(count, 6 * free, 6 * free)


@dataclass(frozen=True)
class Timing:
    """Processor seconds per call, one entry per round, and the share of the wall time spent on the processor.

    A share well below 1 means that something else wanted the core: its caches were shared, so measure again.
    """

    rounds: list[float]
    cpu_share: float

    def per(self, count: int, unit: float = 1e-6) -> dict[str, float]:
        values = [seconds / count / unit for seconds in self.rounds]
        return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def measure(work: Callable[[], object], rounds: int, seconds: float) -> Timing:
    """Call `work` for about `seconds` in every round, after one call to warm up."""
    work()
    results = []
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(rounds):
        calls, start = 0, time.process_time()
        while (elapsed := time.process_time() - start) < seconds or calls == 0:
            work()
            calls += 1
        results.append(elapsed / calls)
    return Timing(results, (time.process_time() - cpu) / (time.perf_counter() - wall))


def report(result: dict, text: list[str], as_json: bool) -> None:
    print(json.dumps(result, indent=2) if as_json else "\n".join(text))
