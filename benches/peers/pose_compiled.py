#!/usr/bin/env python3
"""End stiffness in x, y and z from given node coordinates: compiled peers on one core.

    python pose_compiled.py [ROBOT] [--json]

  numba space   node elimination as `pose_solve.py fronts`, 6 x 6 blocks, compiled by Numba, poses in the innermost loop
  numba plane   the same for what lies above A2, which stands in one plane: motion in the plane and across it apart, two problems of
                3 x 3 blocks; the compliance below A2 is worked out before and added, carried rigidly to the end
  opensees      OpenSeesPy: the structure built anew for every pose, reverse Cuthill-McKee, BandSPD, factorised once for three loads

As in `pose_solve.py`, coordinates are given and the robot file is not timed; the waist stands at its nominal angle, where the plane is x = 0.
Results are checked against batched NumPy before anything is timed.
"""

import argparse
from dataclasses import dataclass, replace
from pathlib import Path

import structures
from structures import DEFAULT_ROBOT, Layout, Robot, dense_matrices, element_blocks, measure

import numba
import numpy as np

from pose_solve import FACTORS, elimination_order

# Poses in the innermost loop: the best of 8 to 128.
LANES = 32
BATCH = 256
CUT = "A2"


@dataclass(frozen=True)
class Plan:
    """Slots of the blocks and who updates whom, as arrays that Numba takes."""

    slots: int
    elements: np.ndarray  # elements x 4: slot of first end, of second, between them, whether that is transposed
    diagonals: np.ndarray  # by order of elimination
    starts: np.ndarray  # of each node's panels
    panels: np.ndarray
    update_starts: np.ndarray
    updates: np.ndarray  # rows x 3: panel, panel, target

    @classmethod
    def of(cls, layout: Layout) -> "Plan":
        order = [*elimination_order(layout), (layout.end, [])]
        place = {node: k for k, (node, _) in enumerate(order)}
        slot = {(k, k): k for k in range(len(order))}
        around = [sorted(place[n] for n in neighbours) for _, neighbours in order]
        for k, later in enumerate(around):
            for j in later:
                slot[k, j] = len(slot)
        panels, starts, updates, update_starts = [], [0], [], [0]
        for k, later in enumerate(around):
            panels += [slot[k, j] for j in later]
            starts.append(len(panels))
            updates += [
                (slot[k, a], slot[k, b], slot[a, b]) for i, a in enumerate(later) for b in later[i:]
            ]
            update_starts.append(len(updates))
        elements = []
        for i, j in layout.free_ends:
            a, b = place.get(i, -1), place.get(j, -1)
            between = slot[min(a, b), max(a, b)] if a >= 0 and b >= 0 else -1
            elements.append((a, b, between, int(a > b)))
        return cls(
            len(slot), np.array(elements), np.arange(len(order)), np.array(starts), np.array(panels),
            np.array(update_starts), np.array(updates),
        )


@numba.njit(fastmath=True)
def scatter(blocks, element, first, second, between):
    a, b, across, transposed = element
    n = first.shape[0]
    for i in range(n):
        for j in range(n):
            if a >= 0:
                for w in range(LANES):
                    blocks[a, i, j, w] += first[i, j, w]
            if b >= 0:
                for w in range(LANES):
                    blocks[b, i, j, w] += second[i, j, w]
            if across >= 0:
                r, c = (j, i) if transposed else (i, j)
                for w in range(LANES):
                    blocks[across, r, c, w] += between[i, j, w]


@numba.njit(fastmath=True)
def eliminate(blocks, diagonals, starts, panels, update_starts, updates, undivided):
    n = blocks.shape[1]
    for k in range(len(diagonals)):
        d = blocks[diagonals[k]]
        for c in range(n):
            for w in range(LANES):
                d[c, c, w] = 1.0 / d[c, c, w]
            for i in range(c + 1, n):
                for j in range(i, n):
                    for w in range(LANES):
                        d[i, j, w] -= d[c, i, w] * d[c, c, w] * d[c, j, w]
            for i in range(c + 1, n):
                for w in range(LANES):
                    d[c, i, w] *= d[c, c, w]
        for place in range(starts[k], starts[k + 1]):
            panel, kept = blocks[panels[place]], undivided[panels[place]]
            for c in range(n):
                for i in range(n):
                    for m in range(i):
                        for w in range(LANES):
                            panel[i, c, w] -= d[m, i, w] * panel[m, c, w]
            for i in range(n):
                for c in range(n):
                    for w in range(LANES):
                        kept[i, c, w] = panel[i, c, w]
                        panel[i, c, w] *= d[i, i, w]
        for place in range(update_starts[k], update_starts[k + 1]):
            rows, columns = blocks[updates[place, 0]], undivided[updates[place, 1]]
            target = blocks[updates[place, 2]]
            for i in range(n):
                for j in range(n):
                    for m in range(n):
                        for w in range(LANES):
                            target[i, j, w] -= rows[m, i, w] * columns[m, j, w]


@numba.njit(fastmath=True)
def inverse_diagonal(d, count, out):
    """The first entries of the diagonal of the inverse of a factorised block."""
    n = d.shape[0]
    for w in range(LANES):
        for axis in range(count):
            total = 0.0
            column = np.zeros(n)
            for i in range(axis, n):
                value = 1.0 if i == axis else 0.0
                for m in range(axis, i):
                    value -= d[m, i, w] * column[m]
                column[i] = value
                total += value * value * d[i, i, w]
            out[axis, w] = total


@numba.njit(fastmath=True)
def solve_space(points, normals, ends, constants, elements, diagonals, starts, panels, update_starts, updates,
                blocks, undivided, first, second, between, result):
    """points: nodes x 3 x poses; normals: elements x 3 x poses; result: 3 x poses."""
    out = np.empty((3, LANES))
    x, y, z = np.empty((3, LANES)), np.empty((3, LANES)), np.empty((3, LANES))
    weights = np.empty((6, LANES))
    for begin in range(0, points.shape[2], LANES):
        blocks[:] = 0.0
        for e in range(len(ends)):
            a, b = ends[e]
            ea, ey, ez, gj = constants[e]
            for w in range(LANES):
                p = begin + w
                dx, dy, dz = (points[b, 0, p] - points[a, 0, p], points[b, 1, p] - points[a, 1, p],
                              points[b, 2, p] - points[a, 2, p])
                inverse = 1.0 / np.sqrt(dx * dx + dy * dy + dz * dz)
                x[0, w], x[1, w], x[2, w] = dx * inverse, dy * inverse, dz * inverse
                y[0, w], y[1, w], y[2, w] = normals[e, 0, p], normals[e, 1, p], normals[e, 2, p]
                z[0, w] = x[1, w] * y[2, w] - x[2, w] * y[1, w]
                z[1, w] = x[2, w] * y[0, w] - x[0, w] * y[2, w]
                z[2, w] = x[0, w] * y[1, w] - x[1, w] * y[0, w]
                weights[0, w], weights[1, w] = ea * inverse, gj * inverse
                weights[2, w], weights[3, w] = ey * inverse, ez * inverse
                weights[4, w] = 6.0 * ey * inverse * inverse
                weights[5, w] = 6.0 * ez * inverse * inverse
            for i in range(3):
                for j in range(3):
                    for w in range(LANES):
                        inverse = weights[4, w] / (6.0 * weights[2, w])
                        xx, yy, zz = x[i, w] * x[j, w], y[i, w] * y[j, w], z[i, w] * z[j, w]
                        sway = weights[0, w] * xx + 2.0 * inverse * (weights[4, w] * zz + weights[5, w] * yy)
                        couple = weights[5, w] * y[i, w] * z[j, w] - weights[4, w] * z[i, w] * y[j, w]
                        turn = weights[2, w] * yy + weights[3, w] * zz
                        twist = weights[1, w] * xx
                        first[i, j, w] = second[i, j, w] = sway
                        between[i, j, w] = -sway
                        first[i, 3 + j, w] = first[3 + j, i, w] = couple
                        second[i, 3 + j, w] = second[3 + j, i, w] = -couple
                        between[i, 3 + j, w] = couple
                        between[3 + j, i, w] = -couple
                        first[3 + i, 3 + j, w] = second[3 + i, 3 + j, w] = 4.0 * turn + twist
                        between[3 + i, 3 + j, w] = 2.0 * turn - twist
            scatter(blocks, elements[e], first, second, between)
        eliminate(blocks, diagonals, starts, panels, update_starts, updates, undivided)
        # The displacements come first in a block: all of its inverse belongs to the end.
        inverse_diagonal(blocks[diagonals[-1]], 3, out)
        for axis in range(3):
            for w in range(LANES):
                result[axis, begin + w] = 1.0 / out[axis, w]


@numba.njit(fastmath=True)
def solve_plane(points, ends, constants, elements, diagonals, starts, panels, update_starts, updates,
                within, across, undivided, first, second, between, below, cut, end, result):
    """points: nodes x 2 (y, z) x poses; below: compliance 6 x 6 at the cut; result: 3 x poses."""
    flat, up = np.empty((3, LANES)), np.empty((3, LANES))
    cosine, sine, inverse = np.empty(LANES), np.empty(LANES), np.empty(LANES)
    for begin in range(0, points.shape[2], LANES):
        within[:] = 0.0
        across[:] = 0.0
        for e in range(len(ends)):
            a, b = ends[e]
            ea, ey, ez, gj = constants[e]
            for w in range(LANES):
                p = begin + w
                dp, dq = points[b, 0, p] - points[a, 0, p], points[b, 1, p] - points[a, 1, p]
                inverse[w] = 1.0 / np.sqrt(dp * dp + dq * dq)
                cosine[w], sine[w] = dp * inverse[w], dq * inverse[w]
            for w in range(LANES):
                c, s, v = cosine[w], sine[w], inverse[w]
                stretch, couple = ea * v, 6.0 * ey * v * v
                sway, bend = 2.0 * v * couple, ey * v
                pp, pq, qq = stretch * c * c + sway * s * s, (stretch - sway) * c * s, stretch * s * s + sway * c * c
                pn, qn = -couple * s, couple * c
                first[0, 0, w] = second[0, 0, w] = pp
                first[0, 1, w] = second[0, 1, w] = first[1, 0, w] = second[1, 0, w] = pq
                first[1, 1, w] = second[1, 1, w] = qq
                first[0, 2, w] = first[2, 0, w] = pn
                first[1, 2, w] = first[2, 1, w] = qn
                second[0, 2, w] = second[2, 0, w] = -pn
                second[1, 2, w] = second[2, 1, w] = -qn
                first[2, 2, w] = second[2, 2, w] = 4.0 * bend
                between[0, 0, w], between[1, 1, w] = -pp, -qq
                between[0, 1, w] = between[1, 0, w] = -pq
                between[0, 2, w], between[1, 2, w] = pn, qn
                between[2, 0, w], between[2, 1, w] = -pn, -qn
                between[2, 2, w] = 2.0 * bend
            scatter(within, elements[e], first, second, between)
            for w in range(LANES):
                c, s, v = cosine[w], sine[w], inverse[w]
                twist, bend, couple = gj * v, ez * v, 6.0 * ez * v * v
                nn, np_, nq = 2.0 * v * couple, couple * s, -couple * c
                first[0, 0, w] = second[0, 0, w] = nn
                between[0, 0, w] = -nn
                first[0, 1, w] = first[1, 0, w] = between[0, 1, w] = np_
                first[0, 2, w] = first[2, 0, w] = between[0, 2, w] = nq
                second[0, 1, w] = second[1, 0, w] = between[1, 0, w] = -np_
                second[0, 2, w] = second[2, 0, w] = between[2, 0, w] = -nq
                first[1, 1, w] = second[1, 1, w] = 4.0 * bend * s * s + twist * c * c
                first[2, 2, w] = second[2, 2, w] = 4.0 * bend * c * c + twist * s * s
                mixed = (twist - 4.0 * bend) * c * s
                first[1, 2, w] = first[2, 1, w] = second[1, 2, w] = second[2, 1, w] = mixed
                between[1, 1, w] = 2.0 * bend * s * s - twist * c * c
                between[2, 2, w] = 2.0 * bend * c * c - twist * s * s
                between[1, 2, w] = between[2, 1, w] = (-twist - 2.0 * bend) * c * s
            scatter(across, elements[e], first, second, between)
        eliminate(within, diagonals, starts, panels, update_starts, updates, undivided)
        eliminate(across, diagonals, starts, panels, update_starts, updates, undivided)
        inverse_diagonal(within[diagonals[-1]], 2, flat)
        inverse_diagonal(across[diagonals[-1]], 1, up)
        for w in range(LANES):
            p = begin + w
            dy, dz = points[end, 0, p] - points[cut, 0, p], points[end, 1, p] - points[cut, 1, p]
            # Displacements of the end by those and turns of the cut: u + r x d.
            x = (below[0, 0] + 2.0 * (below[0, 4] * dz - below[0, 5] * dy) + below[4, 4] * dz * dz
                 - 2.0 * below[4, 5] * dy * dz + below[5, 5] * dy * dy)
            y = below[1, 1] - 2.0 * below[1, 3] * dz + below[3, 3] * dz * dz
            z = below[2, 2] + 2.0 * below[2, 3] * dy + below[3, 3] * dy * dy
            result[0, p] = 1.0 / (up[0, w] + x)
            result[1, p] = 1.0 / (flat[0, w] + y)
            result[2, p] = 1.0 / (flat[1, w] + z)


def constants_of(layout: Layout) -> np.ndarray:
    s = layout.section
    return np.stack([s["E"] * s["A"], s["E"] * s["Iy"], s["E"] * s["Iz"], s["G"] * s["J"]], axis=1)


def work_blocks(plan: Plan, n: int, count: int) -> list[np.ndarray]:
    return [np.zeros((plan.slots, n, n, LANES)) for _ in range(count)]


def space_solver(layout: Layout, points: np.ndarray, normals: np.ndarray):
    plan = Plan.of(layout)
    lanes = [np.ascontiguousarray(np.moveaxis(array, 0, -1)) for array in (points, normals)]
    memory = [*work_blocks(plan, 6, 2), *(np.zeros((6, 6, LANES)) for _ in range(3))]
    result = np.empty((3, len(points)))

    def solve() -> np.ndarray:
        solve_space(*lanes, layout.ends, constants_of(layout), plan.elements, plan.diagonals, plan.starts, plan.panels,
                    plan.update_starts, plan.updates, *memory, result)
        return result.T

    return solve


def dense_compliance(layout: Layout, points: np.ndarray, normals: np.ndarray, node: int) -> np.ndarray:
    """Compliance of a free node, poses x 6 x 6."""
    matrices = dense_matrices(layout, element_blocks(layout, points, normals))
    inverse = np.linalg.inv(matrices)
    return inverse[:, 6 * node : 6 * node + 6, 6 * node : 6 * node + 6]


def parted(layout: Layout) -> tuple[Layout, Layout]:
    """What lies below the cut, with its end there, and what lies above, held there."""
    cut = layout.nodes.index(CUT)
    end = next(n for e, f in zip(layout.ends, layout.free_ends) for n, k in zip(e, f) if k == layout.end)
    above, grown = {end}, True
    while grown:
        ends = [set(map(int, pair)) for pair in layout.ends]
        more = {n for pair in ends if (pair - {cut}) & above for n in pair} - {cut} - above
        above, grown = above | more, bool(more)
    is_above = np.array([bool(set(map(int, pair)) & above) for pair in layout.ends])

    def part(keep: np.ndarray, held: set[int], last: int) -> Layout:
        ends = layout.ends[keep]
        was_free = {int(n): k >= 0 for e, f in zip(layout.ends, layout.free_ends) for n, k in zip(e, f)}
        free = [n for n in sorted(set(ends.ravel().tolist())) if was_free[n] and n not in held]
        number = {n: k for k, n in enumerate(free)}
        return replace(
            layout, free=len(free), ends=ends, end=number[last], is_beam=layout.is_beam[keep],
            free_ends=np.array([[number.get(int(n), -1) for n in pair] for pair in ends]),
            section={name: values[keep] for name, values in layout.section.items()},
        )

    return part(~is_above, set(), cut), part(is_above, {cut}, end)


def plane_solver(layout: Layout, points: np.ndarray, normals: np.ndarray):
    below, above = parted(layout)
    if np.abs(points[:, np.unique(above.ends), 0]).max() > 1e-12:
        raise SystemExit("what lies above the cut does not lie in the plane x = 0")
    is_below = np.array([any((pair == other).all() for other in below.ends) for pair in layout.ends])
    base = dense_compliance(below, points[:1], normals[:1, is_below], below.end)[0]
    plan = Plan.of(above)
    lanes = np.ascontiguousarray(np.moveaxis(points[:, :, 1:], 0, -1))
    memory = [*work_blocks(plan, 3, 3), *(np.zeros((3, 3, LANES)) for _ in range(3))]
    cut, result = layout.nodes.index(CUT), np.empty((3, len(points)))
    end = next(n for e, f in zip(above.ends, above.free_ends) for n, k in zip(e, f) if k == above.end)

    def solve() -> np.ndarray:
        solve_plane(lanes, above.ends, constants_of(above), plan.elements, plan.diagonals, plan.starts, plan.panels,
                    plan.update_starts, plan.updates, *memory, base, cut, end, result)
        return result.T

    return solve


def opensees_solver(layout: Layout, points: np.ndarray, normals: np.ndarray):
    import openseespy.opensees as ops

    s = layout.section
    free = {int(n): k >= 0 for e, f in zip(layout.ends, layout.free_ends) for n, k in zip(e, f)}
    end = 1 + next(int(n) for e, f in zip(layout.ends, layout.free_ends) for n, k in zip(e, f) if k == layout.end)

    rows = [list(map(float, (s["A"][e], s["E"][e], s["G"][e], s["J"][e], s["Iy"][e], s["Iz"][e]))) for e in range(len(layout.ends))]
    ends = (layout.ends + 1).tolist()

    def one(position: list[list[float]], z: list[list[float]]) -> list[float]:
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        for node, at in enumerate(position):
            ops.node(node + 1, *at)
            if not free[node]:
                ops.fix(node + 1, 1, 1, 1, 1, 1, 1)
        for e, (pair, row) in enumerate(zip(ends, rows), start=1):
            ops.geomTransf("Linear", e, *z[e - 1])
            ops.element("elasticBeamColumn", e, *pair, *row, e)
        ops.timeSeries("Constant", 1)
        ops.constraints("Plain")
        ops.numberer("RCM")
        ops.system("BandSPD")
        ops.algorithm("Linear", "-factorOnce")
        ops.integrator("LoadControl", 0.0)
        ops.analysis("Static", "-noWarnings")
        stiffness = []
        for axis in range(3):
            ops.pattern("Plain", axis + 1, 1)
            ops.load(end, *(1.0 if k == axis else 0.0 for k in range(6)))
            if ops.analyze(1) != 0:
                raise SystemExit("OpenSees did not solve a pose")
            stiffness.append(1.0 / ops.nodeDisp(end, axis + 1))
            ops.remove("loadPattern", axis + 1)
        return stiffness

    def solve() -> np.ndarray:
        # Local z, for all poses at once: made one by one these products cost more than the solution.
        spans = points[:, layout.ends[:, 1]] - points[:, layout.ends[:, 0]]
        z = np.cross(spans, normals).tolist()
        return np.array([one(*pose) for pose in zip(points.tolist(), z)])

    return solve


SOLVERS = {"numba space": space_solver, "numba plane": plane_solver, "opensees": opensees_solver}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot", nargs="?", type=Path, default=DEFAULT_ROBOT)
    parser.add_argument("--only", choices=list(SOLVERS), help="one peer instead of all")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--seconds", type=float, default=0.5, help="work per round")
    parser.add_argument("--core", type=int, help="core to stay on (default: the first allowed)")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    core = structures.stay_on_one_core(arguments.core)
    structures.keep_freed_memory()
    robot = Robot(str(arguments.robot))
    layout = Layout.of(robot, "F", FACTORS)
    poses = structures.random_poses(robot, BATCH, seed=1)
    points, normals = structures.coordinates(robot, layout, "F", poses)
    compliance = dense_compliance(layout, points, normals, layout.end)
    expected = 1.0 / compliance[:, np.arange(3), np.arange(3)]
    result = {"benchmark": "pose_compiled", "core": core, "rounds": arguments.rounds, "numba": numba.__version__, "peers": {}}
    text = []
    for name in [arguments.only] if arguments.only else list(SOLVERS):
        solve = SOLVERS[name](layout, points, normals)
        gap = float(np.abs(solve() / expected - 1.0).max())
        if gap > 1e-7:
            raise SystemExit(f"{name}: {gap:.1e} from batched NumPy")
        timing = measure(solve, arguments.rounds, arguments.seconds)
        spread = timing.per(BATCH)
        result["peers"][name] = {"us_per_pose": spread, "cpu_share": timing.cpu_share, "distance_to_numpy": gap}
        text.append(f"{name}: {spread['median']:.2f} us per pose ({spread['min']:.2f} to {spread['max']:.2f}), "
                    f"cpu/wall {timing.cpu_share:.2f}, {gap:.0e} from batched NumPy")
    structures.report(result, text, arguments.json)


if __name__ == "__main__":
    main()
