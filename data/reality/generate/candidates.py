"""All names and places that a diagnosis may give: the library of the concealed benches, further laws, and the set-up.

A candidate is one or two columns (readings per unit of size, whitened).  Set-up columns are finite
differences of the structure; joint laws without history are columns of the first order, twist(moment of
the rigid joint).
"""

from dataclasses import dataclass

import numpy as np

import robot_text
import shared  # noqa: F401
from judge import APART, place_text
from effects import Effect
from information import Information
from real_bench import RealBench
from rivals import PLAUSIBLE, POSITIVE, SHARES, Candidate, Library, loose_members
from structures import PROPERTIES

SETUP = ("link-length", "joint-offset", "section-error", "factor-group", "wrong-mechanism", "gauge-scale", "gauge-misalignment")
# Compliance of a joint times the stiffness of the structure around it, to which a column of the first order holds well enough.
SOFTEST = 1.0
# Finite differences: small beside the tolerance, large beside rounding.
STEPS = {"link-length": 1e-4, "joint-offset": 1e-4, "section-error": 1e-3, "factor-group": 1e-3}


@dataclass
class Session:
    """What the finder is given: the text of the robot file, its name among ours, the poses."""

    robot: str
    text: str
    poses: tuple[str, ...]


class WideLibrary(Library):
    """Every law and every set-up finding, at every place it can have on this bench."""

    positive = (*POSITIVE, "end-stop", "preloaded-backlash", "relaxation")
    plausible = {
        **PLAUSIBLE, "link-length": 0.05, "joint-offset": 0.09, "section-error": 2.0, "factor-group": 2.3, "gauge-scale": 0.3,
        "gauge-misalignment": 0.1, "constant-force": 21.0,
    }

    def __init__(self, information: Information, session: Session) -> None:
        self.session = session
        super().__init__(information)
        self._joint_curves()
        self._bench_laws()
        self._setup()

    def possible(self, effect: Effect, sizes: np.ndarray) -> np.ndarray:
        """Whether sizes (columns x cases) are ones that the law or the tolerance allows."""
        first = sizes[0]
        if len(sizes) == 1:
            fine = np.abs(first) <= self.plausible.get(effect.physics, np.inf)
            if effect.physics in self.positive:
                fine &= first >= 0.0
            if effect.physics in ("joint-compliance", "joint-friction"):
                fine &= first * self._own_stiffness(effect.place["joint"]) <= SOFTEST
            return fine
        second = sizes[1]
        match effect.physics:
            case "joint-nonlinearity":
                return (first >= 0.0) & (first + second >= 0.0)
            case "odd-polynomial":
                return (first >= 0.0) & (first + 3.0 * second >= 0.0)
            case "end-stop":
                return (first >= 0.0) & (second <= 0.0) & (first + second >= 0.0)
            case "gauge-periodic":
                return np.hypot(first, second) <= effect.parameters["period"] / (2.0 * np.pi)
        return np.ones_like(first, bool)

    def _own_stiffness(self, joint: str) -> float:
        """Stiffness of the structure against a rotation of one joint, N m/rad, mean over poses."""
        actions = self.information.bench.actions
        index = actions[0].ids.index(joint)
        return float(np.mean([action.stiffness[index, index] for action in actions]))

    def _amplitude(self, candidate: Candidate, columns: np.ndarray, target: np.ndarray, whole: float):
        norms = np.linalg.norm(columns, axis=0)
        if np.any(norms <= 1e-7 * np.linalg.norm(candidate.columns, axis=0)):
            return None, 0.0  # the factors take all of it
        sizes = np.linalg.lstsq(columns / norms, target, rcond=None)[0] / norms
        if not self.possible(candidate.effect, sizes[:, None])[0]:
            return None, 0.0
        rest = target - columns @ sizes
        return sizes, float(np.sqrt(max(min(rest @ rest, whole), 0.0)))

    def _column(self, effect: Effect, change: np.ndarray, unit: float) -> None:
        """A candidate of one column from the change of all readings, m, at size `unit`."""
        column = self.information.whitened(change)
        if np.linalg.norm(column) > 0.0:
            self.candidates.append(Candidate(effect, column[:, None] / unit, unit))

    def _pair(self, effect: Effect, changes: list[np.ndarray]) -> None:
        columns = np.array([self.information.whitened(change) for change in changes]).T
        if np.all(np.linalg.norm(columns, axis=0) > 0.0):
            self.candidates.append(Candidate(effect, columns, 1.0))

    def add_shape_of(self, effect: Effect) -> None:
        """The exact shape (seat moment, period, decay) of an effect beside the grids."""
        if effect.physics == "gauge-periodic":
            sides = []
            for phase in (0.0, np.pi / 2):
                p = {"amplitude": 1e-9, "period": effect.parameters["period"], "phase": phase}
                sides.append(self.information.effect(Effect(effect.physics, effect.place, p)) / 1e-9)
            shape = Effect(effect.physics, effect.place, {**effect.parameters, "amplitude": 1.0, "phase": 0.0}, "amplitude")
            self.candidates.append(Candidate(shape, np.array(sides).T, 1e-9))
        elif effect.physics not in ("joint-nonlinearity", "slip", "loose-member"):
            self._add(effect.scaled(1.0), 1e-3 * effect.parameters[effect.size])

    def _joint_curves(self) -> None:
        """Further joint laws without history, to the first order."""
        bench: RealBench = self.information.bench
        ids, pose, direction = bench.actions[0].ids, bench.table.pose, bench.table.direction
        levers = np.array([action.lever for action in bench.actions])
        for index, joint in enumerate(ids):
            lever, place = levers[pose, index, direction], {"joint": joint}
            moment = lever * bench.table.force
            top = float(np.abs(moment).max())
            if top < 1e-6:
                continue
            straight = lever * moment / top
            self._pair(Effect("odd-polynomial", place, {"c": 1.0, "c3": 1.0}, "c"), [straight, lever * (moment / top) ** 3])
            for share in (0.25, 0.45, 0.65, 0.85):
                over = np.sign(moment) * np.maximum(np.abs(moment) / top - share, 0.0)
                self._pair(Effect("end-stop", place, {"c": 1.0, "onset": share}, "c"), [straight, lever * over])
            for share in SHARES:
                for side in (1.0, -1.0):
                    step = lever * (side * moment > share * top)
                    self._column(Effect("preloaded-backlash", place, {"play": 1.0, "middle": side * share * top}, "play"), step, 1.0)

    def _bench_laws(self) -> None:
        bench: RealBench = self.information.bench
        table = bench.table
        for d in "xyz":
            effect = Effect("constant-force", {"direction": d}, {"w": 1.0}, "w")
            self._column(effect, bench.displacement([effect]) - self.information.clean, 1.0)
        clean = self.information.clean
        for tau in (2.0, 10.0, 40.0):
            self._column(Effect("relaxation", {"structure": True}, {"k": 1.0, "tau": tau}, "k"), clean * (1.0 - np.exp(-table.hold / tau)), 1.0)
        for decay in (0.5, 1.5, 4.0):
            later = np.exp(-(table.repeat - 1) / decay)
            self._column(Effect("softening", {"structure": True}, {"k": 1.0, "decay": decay}, "k"), clean * np.abs(table.force) / 70.0 * later, 1.0)
        change = np.concatenate([[True], (np.diff(table.pose[:, 0]) != 0) | (np.diff(table.direction[:, 0]) != 0)])
        since = table.time - np.maximum.accumulate(np.where(change, table.time[:, 0], 0.0))[:, None]
        for tau in (60.0, 200.0, 600.0, 1800.0):
            grown = -np.exp(-since / tau)
            self._column(Effect("warm-up", {"clock": True}, {"rise": 1.0, "tau": tau}, "rise"), grown - grown[:, :1], 1.0)

    def _setup(self) -> None:
        bench: RealBench = self.information.bench
        clean, robot = self.information.clean, bench.robot
        for gauge in ("force", "displacement"):
            self._column(Effect("gauge-scale", {"gauge": gauge}, {"scale": 1.0}, "scale"), clean, 1.0)
        for d in "xyz":
            for t in "xyz":
                if t != d:
                    effect = Effect("gauge-misalignment", {"direction": d, "toward": t}, {"angle": 1e-5}, "angle")
                    self._column(effect.scaled(1.0), bench.displacement([effect]) - clean, 1e-5)
        for parameter, body in robot_text.LENGTHS[self.session.robot].items():
            value = robot.data["parameters"].get(parameter)
            text = robot_text.with_number(self.session.text, "parameters", parameter, value + STEPS["link-length"])
            self._structural(Effect("link-length", {"body": body}, {"length": 1.0, "parameter": parameter}, "length"), text)
        for variable, (joint, _) in robot_text.ANGLES[self.session.robot].items():
            poses = [{**pose, variable: self._angle(pose, variable) + np.degrees(STEPS["joint-offset"])} for pose in bench.poses]
            self._other(Effect("joint-offset", {"joint": joint}, {"angle": 1.0}, "angle"), robot, poses, bench.multipliers["link"])
        for name, used in sections_used(robot, bench.mechanism).items():
            text = self.session.text
            for p in PROPERTIES:
                text = robot_text.with_number(text, f"sections.{name}", p, robot.data["sections"][name][p] * (1.0 + STEPS["section-error"]))
            for element in used:
                self._structural(Effect("section-error", {"element": element}, {"share": 1.0}, "share"), text)
        if any(element["class"] == "link" for element in robot.elements(bench.mechanism)):
            link = bench.multipliers["link"]
            for p in PROPERTIES:
                changed = {**link, p: link[p] * (1.0 + STEPS["factor-group"])}
                self._other(Effect("factor-group", {"group": "link"}, {p: 1.0}, p), robot, bench.poses, changed)
            changed = {p: link[p] * (1.0 + STEPS["factor-group"]) for p in PROPERTIES}
            self._other(Effect("factor-group", {"group": "link"}, {"all": 1.0}, "all"), robot, bench.poses, changed)

    def _angle(self, pose: dict, variable: str) -> float:
        return self.information.bench.robot.pose_variables(pose)[variable]

    def _structural(self, effect: Effect, text: str) -> None:
        robot = robot_text.parsed(text)
        self._other(effect, robot, robot_text.poses_of(robot, self.session.poses), self.information.bench.multipliers["link"])

    def _other(self, effect: Effect, robot, poses: list[dict], link: dict) -> None:
        bench: RealBench = self.information.bench
        key = (id(robot), str(poses), str(link))
        if getattr(self, "_last", (None, None))[0] != key:
            other = RealBench(robot, bench.mechanism, poses, bench.multipliers["beam"], link, bench.table)
            self._last = (key, other.mechanics([]) - self.information.clean, robot)
        self._column(effect, self._last[1], STEPS[effect.physics])


def sections_used(robot, mechanism: str) -> dict[str, list[str]]:
    """Elements of a mechanism by their section."""
    used: dict[str, list[str]] = {}
    for element in robot.elements(mechanism):
        used.setdefault(element["section"], []).append(element["id"])
    return used


def near(library: WideLibrary, target: np.ndarray, beside: np.ndarray, apart: float = APART, loose: bool = True) -> list[dict]:
    """Names and places that leave less than `apart` standard errors of a projected target, nearest first."""
    found: dict[tuple, tuple[float, Effect]] = {}

    def keep(left: float, effect: Effect) -> None:
        name = (effect.physics, str(effect.place), bool(effect.parameters.get("per_kelvin")))
        if left < apart and (name not in found or left < found[name][0]):
            found[name] = (left, effect)

    refined = 0
    for left, effect, _ in library.fit(target, beside):
        keep(left, effect)
        if apart <= left < 2.0 * apart and refined < 6 and effect.physics in ("joint-backlash", "joint-friction", "joint-nonlinearity", "gauge-periodic"):
            refined += 1
            keep(*library.best(effect, target, beside, left))
    if loose:
        for left, effect in loose_members(library.information, target, beside):
            keep(left, effect)
    for left, place in slips(library.information, target, beside, apart):
        keep(left, Effect("slip", place))
    ordered = sorted(found.values(), key=lambda item: item[0])
    return [{"name": title(effect), "standard_errors_left": round(left, 2)} for left, effect in ordered]


def left_after(library: WideLibrary, target: np.ndarray, beside: np.ndarray) -> dict[str, float]:
    """What each name and place leaves of a projected target, standard errors; shapes on their grids, set-up findings of one pose and jumps too."""
    found: dict[str, float] = {}

    def keep(left: float, name: str) -> None:
        found[name] = min(round(left, 2), found.get(name, np.inf))

    for left, effect, _ in library.fit(target, beside):
        keep(left, title(effect))
    for left, name in offsets_of_one_pose(library, target, beside):
        keep(left, name)
    whole = float(np.linalg.norm(target))
    for left, place in slips(library.information, target, beside, whole - 0.05):
        keep(left, title(Effect("slip", place)))
    return found


def offsets_of_one_pose(library: WideLibrary, target: np.ndarray, beside: np.ndarray) -> list[tuple[float, str]]:
    """What an angle of a joint that is wrong in one pose only leaves; each run has one pose, and runs are whitened apart."""
    table, whole, found = library.information.bench.table, float(target @ target), []
    for candidate in library.candidates:
        if candidate.effect.physics != "joint-offset":
            continue
        column = candidate.columns[:, 0].reshape(table.pose.shape)
        for index, pose in enumerate(table.names):
            free = np.where(table.pose == index, column, 0.0).ravel()
            length = np.linalg.norm(free)
            free = free - beside @ (beside.T @ free)
            norm = np.linalg.norm(free)
            if norm > 1e-6 * length and abs(target @ free) / norm**2 <= library.plausible["joint-offset"]:
                left = np.sqrt(max(whole - (target @ free / norm) ** 2, 0.0))
                found.append((float(left), f"{title(candidate.effect)}.{pose}"))
    return found


def slips(information: Information, target: np.ndarray, beside: np.ndarray, apart: float) -> list[tuple[float, dict]]:
    """Single jumps, of any run and step with two later readings, that leave less than `apart`."""
    table, inverse = information.bench.table, information.whiten.inverse
    runs, steps, _ = inverse.shape
    heaviside = np.tril(np.ones((steps, steps)))[:, 1 : steps - 1]
    whole, basis, rest = float(target @ target), beside.reshape(runs, steps, -1), target.reshape(runs, steps)
    found = []
    for run in range(runs):
        columns = inverse[run] @ heaviside
        own = np.einsum("sc,sc->c", columns, columns) - ((basis[run].T @ columns) ** 2).sum(axis=0)
        left = np.sqrt(np.maximum(whole - (rest[run] @ columns) ** 2 / np.maximum(own, 1e-12), 0.0))
        for k in np.flatnonzero(left < apart):
            place = {"pose": table.names[table.pose[run, 0]], "direction": "xyz"[table.direction[run, 0]], "repeat": int(table.repeat[run, 0])}
            found.append((float(left[k]), {"run": place, "step": int(table.step[run, k + 1])}))
    return found


def title(effect: Effect) -> str:
    name = f"{effect.physics}@{place_text(effect.place)}"
    return name + ":per-kelvin" if effect.parameters.get("per_kelvin") else name
