"""The mishaps of `mishaps.toml`: what each does to the displacements of a bench."""

import tomllib
from dataclasses import dataclass
from typing import Callable

import numpy as np
from scipy.optimize import brentq

import shared
from information import Information
from laws import Compliance
from mishap_laws import OneSided, ServoRecovers, SlippingBrake, SnapThrough, TwoStiffnesses
from real_bench import RealBench, cross_matrix
from robot_text import end_body
from structures import Model

LIST = tomllib.loads((shared.HERE / "mishaps.toml").read_text())
KINDS = tuple(name for name in LIST if name != "schema")
UNLOADING = ("force-gauge-hysteresis", "ramp-overshoots", "snap-through", "brake-slips", "plunger-sticks", "cable-drags-by-pose", "loose-clamp")
HOLDS = ("servo-recovers", "jack-relaxes")


@dataclass
class Mishap:
    """Displacement added by a mishap of a size, m; what else was drawn; where it sits."""

    change: Callable[[float], np.ndarray]
    drawn: dict
    place: dict[str, str]


def sized(kind: str, information: Information, rng: np.random.Generator, standard_errors: float) -> tuple[Mishap, float] | None:
    """A mishap of the wanted length within its range; None if the draw cannot have it."""
    mishap = DRAWS[kind.replace("-", "_")](information.bench, rng)
    if mishap is None:
        return None
    low, high = (LIST[kind]["size"][key] for key in ("low", "high"))

    def gap(log_size: float) -> float:
        change = information.whitened(mishap.change(float(np.exp(log_size))))
        return float(np.linalg.norm(information.unabsorbed(change))) - standard_errors

    ends = np.log([low, high])
    if gap(ends[0]) > 0.0 or gap(ends[1]) < 0.0:
        return None
    return mishap, float(f"{np.exp(brentq(gap, *ends, xtol=1e-4)):.5g}")


def also_right(kind: str, mishap: Mishap) -> list[str]:
    """The patterns of the list with the places of the bench put in."""
    patterns = []
    for pattern in LIST[kind]["also_right"]:
        law, place = pattern.split("@")
        if place == "{runs}":
            patterns += [f"{law}@{run}.*" for run in mishap.place["runs"].split()]
        else:
            patterns.append(f"{law}@{place.format(**mishap.place)}")
    return patterns


def _between(rng, low: float, high: float) -> float:
    return float(f"{rng.uniform(low, high):.4g}")


def _joint(bench: RealBench, rng) -> tuple[str, float]:
    """A joint that a load moves, and the largest moment on it."""
    tops = {name: float(np.abs(bench.applied_moments(name)).max()) for name in bench.actions[0].ids}
    name = str(rng.choice([name for name, top in tops.items() if top > 1e-3]))
    return name, tops[name]


def _from_zero(values: np.ndarray) -> np.ndarray:
    return values - values[:, :1]


def room_swings(bench: RealBench, rng) -> Mishap:
    period, phase = _between(rng, 300.0, 720.0), _between(rng, 0.0, 6.28)
    wave = _from_zero(np.sin(2.0 * np.pi * bench.table.time / period + phase))
    return Mishap(lambda size: size * wave, {"period_s": period, "phase": phase}, {})


def crack_opens(bench: RealBench, rng) -> Mishap | None:
    name, top = _joint(bench, rng)
    joint = next(j for j in bench.robot.data["joints"] if j["id"] == name)
    ends = [e["id"] for e in bench.robot.elements(bench.mechanism) if joint["node"] in e["nodes"] and e["body"] == joint["bodies"][1]]
    if len(ends) != 1:
        return None  # the hinge of the crack has to lie in one member
    side, shut = float(rng.choice([-1.0, 1.0])), _between(rng, 0.05, 0.4) * top
    change = lambda size: bench.hinge(name, OneSided(size, shut, side))
    return Mishap(change, {"side": side, "opens_at_Nm": shut}, {"joint": name, "element": ends[0]})


def snap_through(bench: RealBench, rng) -> Mishap:
    name, top = _joint(bench, rng)
    on = _between(rng, 0.25, 0.8) * top
    off = _between(rng, 0.3, 0.8) * on
    return Mishap(lambda size: bench.hinge(name, SnapThrough(size, on, off)), {"on_Nm": on, "off_Nm": off}, {"joint": name})


def cable_drags_by_pose(bench: RealBench, rng) -> Mishap:
    shares = np.round(rng.uniform(0.2, 1.0, len(bench.poses)), 3)
    compliance, force = bench.own_compliance(), bench.table.force
    share, stiff = shares[bench.table.pose[:, 0]], 50.0 / np.maximum(compliance.max(axis=1), 1e-12)

    def change(size: float) -> np.ndarray:
        held, moved, drag = size * share, np.zeros(len(force)), np.zeros(len(force))
        total = np.zeros(force.shape)
        for k in range(force.shape[1]):
            c, f = compliance[:, k], force[:, k]
            stuck = (c * (f - drag + stiff * moved)) / (1.0 + c * stiff)
            drag = np.clip(drag + stiff * (stuck - moved), -held, held)
            moved = c * (f - drag)
            total[:, k] = moved
        return total - compliance * force

    return Mishap(change, {"share_of_poses": shares.tolist()}, {})


def _rocking(bench: RealBench, rng) -> tuple[np.ndarray, np.ndarray, str]:
    """Moment about an axis through the first support, and way of the end per angle, both runs x steps."""
    axis = str(rng.choice(["x", "z"]))
    arm = bench.at_end_of(bench.robot.end_node) - bench.at_end_of(bench.first_support())
    way = np.cross(np.eye(3)["xyz".index(axis)], arm)[bench.table.pose, bench.table.direction]
    return way * bench.table.force, way, axis


def soft_foot(bench: RealBench, rng) -> Mishap:
    moment, way, axis = _rocking(bench, rng)
    side, lifts = float(rng.choice([-1.0, 1.0])), _between(rng, 0.0, 0.4) * float(np.abs(moment).max())
    rocked = side * np.maximum(side * moment - lifts, 0.0) * way
    return Mishap(lambda size: size * rocked, {"axis": axis, "side": side, "lifts_at_Nm": lifts}, {})


def loose_clamp(bench: RealBench, rng) -> Mishap:
    share, load = np.round(rng.uniform(0.0, 1.0, bench.shape[0]), 3), _between(rng, 10.0, 40.0)
    largest = np.maximum.accumulate(np.abs(bench.table.force), axis=1)
    seat = -share[:, None] * (1.0 - np.exp(-largest / load))
    return Mishap(lambda size: size * seat, {"seats_at_N": load}, {})


def base_loosens_halfway(bench: RealBench, rng) -> Mishap:
    moment, way, axis = _rocking(bench, rng)
    first = int(rng.uniform(0.3, 0.7) * bench.shape[0])
    rocked = np.where(np.arange(bench.shape[0])[:, None] >= first, moment * way, 0.0)
    return Mishap(lambda size: size * rocked, {"axis": axis, "first_run": first}, {})


def operators_hand(bench: RealBench, rng) -> Mishap:
    runs = sorted(map(int, rng.choice(bench.shape[0], rng.integers(2, 5), replace=False)))
    steps, compliance = bench.shape[1], bench.compliances()
    pushed = np.zeros(bench.shape)
    for run in runs:
        begin = int(rng.integers(1, steps - 2))
        end = int(rng.integers(begin + 2, steps + 1))
        push = rng.normal(size=3)
        push *= rng.uniform(0.5, 1.0) / np.linalg.norm(push)
        moved = compliance[bench.table.pose[run, 0]] @ push
        pushed[run, begin:end] = moved[bench.table.direction[run, 0]]
    return Mishap(lambda size: size * pushed, {"runs": runs}, {"runs": _named(bench, runs)})


def _named(bench: RealBench, runs: list[int]) -> str:
    table = bench.table
    return " ".join(f"{table.names[table.pose[r, 0]]}.{'xyz'[table.direction[r, 0]]}.{table.repeat[r, 0]}" for r in runs)


def ramp_overshoots(bench: RealBench, rng) -> Mishap:
    steps = np.sign(np.diff(bench.table.target, axis=1, prepend=0.0))
    over = steps * np.round(rng.uniform(0.6, 1.4, bench.shape), 3) * (bench.table.target != 0.0)
    return Mishap(lambda size: -size * over * bench.own_compliance(), {}, {})


def tool_changed(bench: RealBench, rng) -> Mishap:
    first = int(rng.integers(1, len(bench.poses)))
    along = np.array([_end_axis(bench, pose) for pose in range(len(bench.poses))])
    whole = bench.end_compliances()
    table = bench.table

    def change(size: float) -> np.ndarray:
        compliances = []
        for pose, matrix in enumerate(whole):
            reach = size * along[pose] if pose >= first else np.zeros(3)
            lift = np.vstack([np.eye(3), cross_matrix(reach)])
            compliances.append(lift.T @ matrix @ lift)
        own = np.array(compliances)[table.pose, table.direction, table.direction]
        return own * table.force - bench.own_compliance() * table.force

    return Mishap(change, {"first_pose": table.names[first]}, {"body": end_body(bench.robot)})


def _end_axis(bench: RealBench, pose: int) -> np.ndarray:
    placement = Model(bench.robot, bench.mechanism, bench.poses[pose], bench.multipliers).placement
    return np.array(placement.body_axes(end_body(bench.robot)).z, dtype=float)


def stiffness_by_angle(bench: RealBench, rng) -> Mishap:
    name, _ = _joint(bench, rng)
    phase = _between(rng, 0.0, 6.28)
    angles = np.radians([sum(bench.robot.pose_variables(pose).values()) for pose in bench.poses])
    share = 0.5 * (1.0 + np.cos(2.0 * angles + phase))
    per_run = share[bench.table.pose[:, 0]]
    return Mishap(lambda size: bench.hinge(name, Compliance(size * per_run)), {"share_of_poses": np.round(share, 3).tolist()}, {"joint": name})


def force_gauge_hysteresis(bench: RealBench, rng) -> Mishap:
    table, full = bench.table, 70.0
    off = table.step > int(np.argmin(table.target[0]))
    shape = np.where(off, 4.0 * np.abs(table.force) / full * (1.0 - np.abs(table.force) / full), 0.0)
    return Mishap(lambda size: size * full * shape * bench.own_compliance(), {}, {})


def sun_bends_beam(bench: RealBench, rng) -> Mishap:
    elements = [e["id"] for e in bench.robot.elements(bench.mechanism) if e["class"] == "beam"]
    element, axis = str(rng.choice(elements)), str(rng.choice(["y", "z"]))
    time, sign = bench.table.time, float(rng.choice([-1.0, 1.0]))
    middle, width = _between(rng, 0.2, 0.8) * float(time.max()), _between(rng, 300.0, 1200.0)
    moved = sign * bench.bent_by(element, axis)[bench.table.pose, bench.table.direction]
    bent = _from_zero(np.exp(-0.5 * ((time - middle) / width) ** 2) * moved)
    return Mishap(lambda size: size * bent, {"element": element, "axis": axis, "middle_s": middle, "width_s": width}, {})


def plunger_sticks(bench: RealBench, rng) -> Mishap:
    clean = bench.displacement([])

    def change(size: float) -> np.ndarray:
        shown, total = np.zeros(len(clean)), np.zeros(clean.shape)
        for k in range(clean.shape[1]):
            shown = np.clip(shown, clean[:, k] - 0.5 * size, clean[:, k] + 0.5 * size)
            total[:, k] = shown
        return total - clean

    return Mishap(change, {}, {})


def curved_target(bench: RealBench, rng) -> Mishap:
    table, sign = bench.table, float(rng.choice([-1.0, 1.0]))
    moved = np.einsum("rskl,rsl->rsk", bench.compliances()[table.pose], bench.forces([]))
    across = np.sum(moved**2, axis=-1) - np.take_along_axis(moved, table.direction[..., None], axis=-1)[..., 0] ** 2
    return Mishap(lambda size: 0.5 * sign * size * across, {"sign": sign}, {})


def one_way_joint(bench: RealBench, rng) -> Mishap | None:
    name, top = _joint(bench, rng)
    moments = bench.applied_moments(name)
    if min(moments.max(), -moments.min()) < 0.1 * top:
        return None  # turned one way only, it is a compliant joint
    part = _between(rng, 0.0, 0.5)
    return Mishap(lambda size: bench.hinge(name, TwoStiffnesses(size, part)), {"other_way": part}, {"joint": name})


def brake_slips(bench: RealBench, rng) -> Mishap:
    name, top = _joint(bench, rng)
    limit = _between(rng, 0.3, 0.8) * top
    return Mishap(lambda size: bench.hinge(name, SlippingBrake(size, limit)), {"slips_at_Nm": limit}, {"joint": name})


def servo_recovers(bench: RealBench, rng) -> Mishap:
    name, _ = _joint(bench, rng)
    tau = _between(rng, 5.0, 60.0)
    left = np.exp(-bench.table.hold / tau)
    return Mishap(lambda size: bench.hinge(name, ServoRecovers(size * left)), {"tau_s": tau}, {"joint": name})


def forklift_passes(bench: RealBench, rng) -> Mishap:
    time, count = bench.table.time, int(rng.integers(2, 5))
    shift, sign = np.zeros(bench.shape), float(rng.choice([-1.0, 1.0]))
    for _ in range(count):
        begin = rng.uniform(0.0, float(time.max()))
        stays = (time >= begin) & (time <= begin + rng.uniform(60.0, 240.0))
        shift = np.where(stays, sign * rng.uniform(0.5, 1.0), shift)
    runs = [int(run) for run in np.flatnonzero(np.any(shift != 0.0, axis=1))]
    moved = _from_zero(shift)
    if not np.any(moved):
        return None
    return Mishap(lambda size: size * moved, {"passes": count}, {"runs": _named(bench, runs)})


def force_gauge_warms_up(bench: RealBench, rng) -> Mishap:
    tau, sign = _between(rng, 600.0, 2400.0), float(rng.choice([-1.0, 1.0]))
    early = sign * bench.own_compliance() * bench.table.force * np.exp(-bench.table.time / tau)
    return Mishap(lambda size: size * early, {"tau_s": tau}, {})


def load_line_turns(bench: RealBench, rng) -> Mishap:
    a, b = [("y", "z"), ("z", "y")][rng.integers(2)]
    sign, table = float(rng.choice([-1.0, 1.0])), bench.table
    cross = bench.compliances()[table.pose, "xyz".index(a), "xyz".index(b)] * table.force
    here = table.direction == "xyz".index(a)

    def change(size: float) -> np.ndarray:
        angle = sign * size * np.abs(table.force) / 70.0
        own = bench.own_compliance() * table.force
        return np.where(here, (np.cos(angle) - 1.0) * own + np.sin(angle) * cross, 0.0)

    return Mishap(change, {"direction": a, "toward": b}, {"direction": a, "toward": b})


def load_off_axis(bench: RealBench, rng) -> Mishap:
    a = str(rng.choice(["x", "y", "z"]))
    across = str(rng.choice([d for d in "xyz" if d != a]))
    sign, table = float(rng.choice([-1.0, 1.0])), bench.table
    moment = np.cross(np.eye(3)["xyz".index(across)], np.eye(3)["xyz".index(a)])
    turned = np.array([matrix["xyz".index(a), 3:] @ moment for matrix in bench.end_compliances()])
    moved = np.where(table.direction == "xyz".index(a), sign * turned[table.pose] * table.force, 0.0)
    return Mishap(lambda size: size * moved, {"direction": a, "across": across}, {"direction": a, "body": end_body(bench.robot)})


def jack_relaxes(bench: RealBench, rng) -> Mishap:
    start = float(rng.choice([0.5, 1.0, 2.0]))
    lost = -bench.own_compliance() * bench.table.force * np.log10(1.0 + bench.table.hold / start)
    return Mishap(lambda size: size * lost, {"t0_s": start}, {})


def brake_open_in_one_pose(bench: RealBench, rng) -> Mishap:
    name, _ = _joint(bench, rng)
    pose = int(rng.integers(len(bench.poses)))
    here = (bench.table.pose[:, 0] == pose).astype(float)
    return Mishap(lambda size: bench.hinge(name, Compliance(size * here)), {"pose": bench.table.names[pose]}, {"joint": name})


def guard_touches(bench: RealBench, rng) -> Mishap:
    table, clean = bench.table, bench.displacement([])
    pose, direction = int(rng.integers(len(bench.poses))), int(rng.integers(3))
    here = (table.pose == pose) & (table.direction == direction)
    gap = _between(rng, 0.3, 0.8) * float(np.abs(clean[here]).max())
    beyond = np.where(here, np.sign(clean) * np.maximum(np.abs(clean) - gap, 0.0), 0.0)
    own = bench.own_compliance()
    change = lambda size: -beyond * own * size / (1.0 + own * size)
    return Mishap(change, {"pose": table.names[pose], "direction": "xyz"[direction], "gap_um": round(1e6 * gap, 1)}, {})


DRAWS = {name: value for name, value in globals().items() if name.replace("_", "-") in LIST}
