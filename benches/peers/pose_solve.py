#!/usr/bin/env python3
"""End stiffness in x, y and z from given node coordinates: three Python peers on one core.

    python pose_solve.py [ROBOT] [--json]

One pose is: element matrices, assembly, factorisation, three unit loads at the end, three
stiffnesses.  Coordinates and plane normals are given, as arrays over poses.

  dense   NumPy, assembly over the batch, batched np.linalg.solve
  band    NumPy, assembly of the band over the batch (reverse Cuthill-McKee), LAPACK dpbsv per pose
  fronts  NumPy, every operation an array over poses: nodes eliminated one by one in 6 x 6 blocks,
          minimum degree, end last
"""

import argparse
import csv
from pathlib import Path

import structures
from structures import DEFAULT_ROBOT, ROOT, Layout, Robot, dense_matrices, element_blocks, measure

import numpy as np
from scipy.linalg import lapack
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

FACTORS = "m_fsd"
# Best of 16 to 1024; 128 costs the dense solver 7 per cent more, 512 twice the time for the band.
BATCH = {"dense": 64, "band": 32, "fronts": 256}


def dense_solver(layout: Layout):
    loads = np.zeros((1, 6 * layout.free, 3))
    loads[0, 6 * layout.end + np.arange(3), np.arange(3)] = 1.0

    def solve(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        matrices = dense_matrices(layout, element_blocks(layout, points, normals))
        moved = np.linalg.solve(matrices, loads)
        return 1.0 / moved[:, 6 * layout.end + np.arange(3), np.arange(3)]

    return solve


def band_solver(layout: Layout):
    pairs = [(i, j) for i, j in layout.free_ends if i >= 0 and j >= 0]
    rows, columns = np.array(pairs).T
    graph = csr_matrix((np.ones(len(pairs)), (rows, columns)), shape=(layout.free, layout.free))
    order = reverse_cuthill_mckee((graph + graph.T).tocsr(), symmetric_mode=True)
    place = np.empty(layout.free, dtype=int)
    place[order] = np.arange(layout.free)
    n = 6 * layout.free
    band = 6 * max(abs(place[i] - place[j]) for i, j in pairs) + 5

    # Each entry of the three blocks of an element goes to one place of the lower band, stored
    # column by column, or nowhere.
    targets, sources = [], []
    elements = len(layout.free_ends)
    for kind in range(3):
        for e, ends in enumerate(layout.free_ends):
            i, j = ((0, 0), (0, 1), (1, 1))[kind]
            if ends[i] < 0 or ends[j] < 0:
                continue
            for r in range(6):
                for c in range(6):
                    row, column = 6 * place[ends[i]] + r, 6 * place[ends[j]] + c
                    if kind == 1 and row < column:
                        row, column = column, row
                    if row >= column:
                        targets.append(column * (band + 1) + row - column)
                        sources.append(((kind * elements + e) * 6 + r) * 6 + c)
    scatter = csr_matrix(
        (np.ones(len(targets)), (targets, sources)), shape=(n * (band + 1), 3 * elements * 36)
    )
    end = 6 * place[layout.end] + np.arange(3)
    loads = np.zeros((n, 3), order="F")
    loads[end, np.arange(3)] = 1.0

    def solve(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        count = len(points)
        blocks = element_blocks(layout, points, normals)
        entries = np.concatenate([block.reshape(count, -1) for block in blocks], axis=1)
        bands = np.ascontiguousarray((scatter @ entries.T).T).reshape(count, n, band + 1)
        result = np.empty((count, 3))
        for pose in range(count):
            _, moved, info = lapack.dpbsv(bands[pose].T, loads, lower=1, overwrite_ab=1)
            if info != 0:
                raise np.linalg.LinAlgError(f"dpbsv: {info}")
            result[pose] = 1.0 / moved[end, np.arange(3)]
        return result

    solve.half_band = band
    return solve


def elimination_order(layout: Layout) -> list[tuple[int, list[int]]]:
    """Free nodes by minimum degree with the end last, each with its neighbours at that moment."""
    neighbours = {node: set() for node in range(layout.free)}
    for i, j in layout.free_ends:
        if i >= 0 and j >= 0:
            neighbours[i].add(j)
            neighbours[j].add(i)
    order = []
    while len(neighbours) > 1:
        node = min((n for n in neighbours if n != layout.end), key=lambda n: (len(neighbours[n]), n))
        around = sorted(neighbours.pop(node))
        for other in around:
            neighbours[other] |= set(around)
            neighbours[other] -= {node, other}
        order.append((node, around))
    return order


def fronts_solver(layout: Layout):
    order = elimination_order(layout)

    def solve(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        # Pose last, so that every operation runs along contiguous memory.
        first, across, second = (
            np.ascontiguousarray(np.moveaxis(block, 0, -1))
            for block in element_blocks(layout, points, normals)
        )
        count = len(points)
        blocks: dict[tuple[int, int], np.ndarray] = {}

        def add(i: int, j: int, value: np.ndarray) -> None:
            if i > j:
                i, j, value = j, i, np.swapaxes(value, 0, 1)
            if (i, j) in blocks:
                blocks[i, j] += value
            else:
                blocks[i, j] = value.copy()

        for e, (i, j) in enumerate(layout.free_ends):
            if i >= 0:
                add(i, i, first[e])
            if j >= 0:
                add(j, j, second[e])
            if i >= 0 and j >= 0:
                add(i, j, across[e])
        for node, around in order:
            width = 6 * len(around)
            rows = np.empty((6, 6 + width, count))
            rows[:, :6] = blocks.pop((node, node))
            for place, other in enumerate(around):
                block = blocks.pop((min(node, other), max(node, other)))
                rows[:, 6 * place + 6 : 6 * place + 12] = block if node < other else np.swapaxes(block, 0, 1)
            scaled = np.empty((6, width, count))
            for k in range(6):
                row = rows[k, k + 1 :]
                multiple = row / rows[k, k]
                scaled[k] = multiple[5 - k :]
                if k < 5:
                    rows[k + 1 :, k + 1 :] -= multiple[: 5 - k, None] * row
            for place, one in enumerate(around):
                for other_place, other in enumerate(around[place:], start=place):
                    left = scaled[:, 6 * place : 6 * place + 6]
                    right = rows[:, 6 + 6 * other_place : 12 + 6 * other_place]
                    add(one, other, -np.einsum("kip,kjp->ijp", left, right))
        last = np.moveaxis(blocks[layout.end, layout.end], -1, 0)
        flexibility = np.linalg.solve(last, np.eye(6)[None, :, :3])
        return 1.0 / flexibility[:, np.arange(3), np.arange(3)]

    return solve


def check(robot_path: Path, robot: Robot, mechanism: str, values: np.ndarray) -> float | None:
    """Largest relative distance to the stored OpenSees solution at the poses of the robot file."""
    path = ROOT / "fixtures" / "opensees" / "compliance.csv"
    if not path.exists() or "host-parasite" not in robot.data["name"]:
        return None
    with open(path, newline="") as file:
        rows = {
            row["pose"]: row
            for row in csv.DictReader(file)
            if (row["robot"], row["mechanism"], row["factors"]) == ("host-parasite", mechanism, FACTORS)
        }
    gaps = [
        abs(values[index, k] * float(rows[pose][f"c_u{axis}_F{axis}"]) - 1.0)
        for index, pose in enumerate(robot.data["poses"])
        for k, axis in enumerate("xyz")
    ]
    return max(gaps)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot", nargs="?", type=Path, default=DEFAULT_ROBOT)
    parser.add_argument("--mechanism", default="F")
    parser.add_argument("--only", choices=list(BATCH), help="one peer instead of all")
    parser.add_argument("--batch", type=int, help="poses per batch, for all peers")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=0.5, help="work per round")
    parser.add_argument("--core", type=int, help="core to stay on (default: the first allowed)")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    core = structures.stay_on_one_core(arguments.core)
    structures.keep_freed_memory()
    robot = Robot(str(arguments.robot))
    layout = Layout.of(robot, arguments.mechanism, FACTORS)
    solvers = {"dense": dense_solver(layout), "band": band_solver(layout), "fronts": fronts_solver(layout)}
    names = [arguments.only] if arguments.only else list(solvers)
    result = {
        "benchmark": "pose_solve", "mechanism": arguments.mechanism, "factors": FACTORS,
        "elements": len(layout.ends), "free_nodes": layout.free, "loads": 3, "core": core,
        "rounds": arguments.rounds, "numpy": np.__version__, "peers": {},
    }
    text = []
    for name in names:
        batch = arguments.batch or BATCH[name]
        poses = structures.random_poses(robot, batch, seed=1)
        points, normals = structures.coordinates(robot, layout, arguments.mechanism, poses)
        gap = check(arguments.robot, robot, arguments.mechanism, solvers[name](points, normals))
        if gap is not None and gap > 1e-8:
            raise SystemExit(f"{name}: {gap:.1e} from the stored OpenSees solution")
        timing = measure(lambda: solvers[name](points, normals), arguments.rounds, arguments.seconds)
        spread = timing.per(batch)
        result["peers"][name] = {"batch": batch, "us_per_pose": spread, "cpu_share": timing.cpu_share,
                                   "distance_to_opensees": gap}
        text.append(
            f"pose_solve {name}: {spread['median']:.1f} us per pose (median of {arguments.rounds} rounds, "
            f"{spread['min']:.1f} to {spread['max']:.1f}), mechanism {arguments.mechanism}, 3 loads, "
            f"batch {batch}, one core, cpu/wall {timing.cpu_share:.2f}"
            + (f", {gap:.0e} from OpenSees" if gap is not None else "")
        )
    structures.report(result, text, arguments.json)


if __name__ == "__main__":
    main()
