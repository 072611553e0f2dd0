"""Other names and places that could stand for an effect, and what each leaves unexplained.

Every law of the library is tried at every place it can have.  A rival is first fitted with its size
as a linear parameter, over a grid of its other parameters; those that come close are then fitted with
the law itself.
"""

import os
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from effects import Effect
from information import Information, orthonormal

SMALL = {"c": 1e-12, "play": 1e-12, "angle": 1e-7, "q": 1e-10, "k": 1e-7, "rate": 1e-14, "amplitude": 1e-12}
POSITIVE = ("joint-compliance", "joint-backlash", "joint-friction", "base-compliance", "gauge-stand-compliance", "creep")
# Beyond these a size is no longer a rival but nonsense.
PLAUSIBLE = {
    "load-misalignment": 0.1, "creep": 0.3, "setting-in": 0.5, "force-gauge-nonlinearity": 5e-3, "joint-compliance": 0.1,
    "joint-friction": 0.1, "joint-backlash": 0.1, "base-compliance": 1e-2, "gauge-stand-compliance": 1e-3,
}
JOINT = ("joint-compliance", "joint-backlash", "joint-friction", "joint-nonlinearity")
SHARES = (0.03, 0.1, 0.25, 0.45, 0.65, 0.85)


@dataclass
class Candidate:
    """A law at a place with its shape fixed: one or two columns per unit of size."""

    effect: Effect
    columns: np.ndarray
    unit: float


def key(effect: Effect) -> tuple:
    return effect.physics, str(effect.place)


class Library:
    """Candidates of one bench, whitened, before and after the factors are projected out."""

    positive, plausible = POSITIVE, PLAUSIBLE

    def __init__(self, information: Information, slips: bool = False) -> None:
        self.information, self.slips = information, slips
        self.candidates: list[Candidate] = []
        self._joints()
        self._linear()
        self._gauges()

    def _add(self, effect: Effect, unit: float) -> None:
        column = self.information.effect(effect.scaled(unit))
        if np.linalg.norm(column) > 0.0:
            self.candidates.append(Candidate(effect, column[:, None] / unit, unit))

    def _joints(self) -> None:
        bench = self.information.bench
        for joint in bench.actions[0].ids:
            place, top = {"joint": joint}, float(np.abs(bench.applied_moments(joint)).max())
            if top < 1e-6:
                continue
            self._add(Effect("joint-compliance", place, {"c": 1.0}, "c"), SMALL["c"])
            for share in SHARES:
                seat = share * top
                self._add(Effect("joint-backlash", place, {"play": 1.0, "seat_moment": seat}, "play"), SMALL["play"])
                self._add(Effect("joint-friction", place, {"c": 1.0, "friction_moment": seat}, "c"), SMALL["c"])
            straight = self.information.effect(Effect("joint-compliance", place, {"c": SMALL["c"]}, "c")) / SMALL["c"]
            bent = Effect("joint-nonlinearity", place, {"c": SMALL["c"], "q": SMALL["c"] / top}, "c")
            square = self.information.effect(bent) / SMALL["c"] - straight
            if np.linalg.norm(square) > 0.0:
                effect = Effect("joint-nonlinearity", place, {"c": 1.0, "q": 1.0 / top}, "c")
                self.candidates.append(Candidate(effect, np.array([straight, square]).T, SMALL["c"]))

    def _linear(self) -> None:
        for axis in ("x", "z"):
            self._add(Effect("base-compliance", {"axis": axis}, {"c": 1.0}, "c"), 1e-9)
        for d in "xyz":
            self._add(Effect("gauge-stand-compliance", {"direction": d}, {"c": 1.0}, "c"), 1e-9)
            for t in "xyz":
                if t != d:
                    place = {"direction": d, "toward": t}
                    self._add(Effect("load-misalignment", place, {"angle": 1.0}, "angle"), SMALL["angle"])
        self._add(Effect("force-gauge-nonlinearity", {"gauge": "force"}, {"q": 1.0}, "q"), SMALL["q"])
        for t0 in (0.3, 1.0, 3.0, 10.0):
            self._add(Effect("creep", {"structure": True}, {"k": 1.0, "t0": t0}, "k"), SMALL["k"])
        for decay in (0.2, 0.5, 1.0, 2.0, 4.0):
            self._add(Effect("setting-in", {"structure": True}, {"k": 1.0, "decay": decay}, "k"), SMALL["k"])
        self._add(Effect("thermal-drift", {"clock": True}, {"rate": 1.0}, "rate"), 1e-9)
        self._add(Effect("thermal-drift", {"clock": True}, {"rate": 1.0, "per_kelvin": True}, "rate"), 1e-6)

    def _gauges(self) -> None:
        for period in np.geomspace(2e-5, 2e-3, 80):
            sides = []
            for phase in (0.0, np.pi / 2):
                p = {"amplitude": 1e-9, "period": float(period), "phase": phase}
                sides.append(self.information.effect(Effect("gauge-periodic", {"gauge": "displacement"}, p)) / 1e-9)
            effect = Effect("gauge-periodic", {"gauge": "displacement"}, {"amplitude": 1.0, "period": float(period), "phase": 0.0})
            self.candidates.append(Candidate(effect, np.array(sides).T, 1e-9))

    def fit(self, target: np.ndarray, beside: np.ndarray) -> list[tuple[float, Effect, np.ndarray]]:
        """Each candidate's best: what it leaves of the projected target, its effect, its columns."""
        best: dict[tuple, tuple[float, Effect, np.ndarray]] = {}
        whole = float(target @ target)
        for candidate in self.candidates:
            columns = candidate.columns - beside @ (beside.T @ candidate.columns)
            size, left = self._amplitude(candidate, columns, target, whole)
            if size is None:
                continue
            name = key(candidate.effect)
            if name not in best or left < best[name][0]:
                best[name] = (left, self._with_size(candidate, size), candidate.columns)
        return sorted(best.values(), key=lambda item: item[0])

    def _amplitude(self, candidate: Candidate, columns: np.ndarray, target: np.ndarray, whole: float):
        norms = np.linalg.norm(columns, axis=0)
        if np.any(norms <= 1e-7 * np.linalg.norm(candidate.columns, axis=0)):
            return None, 0.0  # the factors take all of it
        if columns.shape[1] == 1:
            size = float(columns[:, 0] @ target / norms[0] ** 2)
            physics = candidate.effect.physics
            if size < 0.0 and physics in self.positive or abs(size) > self.plausible.get(physics, np.inf):
                return None, 0.0
            sizes = np.array([size])
        else:
            sizes = np.linalg.lstsq(columns / norms, target, rcond=None)[0] / norms
            if candidate.effect.physics == "joint-nonlinearity" and not (sizes[0] >= 0.0 and sizes.sum() >= 0.0):
                return None, 0.0
        rest = target - columns @ sizes
        return sizes, float(np.sqrt(max(min(rest @ rest, whole), 0.0)))

    @staticmethod
    def _with_size(candidate: Candidate, sizes: np.ndarray) -> Effect:
        effect = candidate.effect
        if effect.physics == "joint-nonlinearity":
            q = sizes[1] * effect.parameters["q"]
            return Effect(effect.physics, effect.place, {"c": float(sizes[0]), "q": float(q)}, "c")
        if effect.physics == "gauge-periodic":
            p = {**effect.parameters, "amplitude": float(np.hypot(*sizes)), "phase": float(np.arctan2(sizes[1], sizes[0]))}
            return Effect(effect.physics, effect.place, p, "amplitude")
        return effect.scaled(float(sizes[0]))

    def refine(self, effect: Effect, target: np.ndarray, beside: np.ndarray) -> tuple[float, Effect]:
        """Fit the law itself, all its parameters free, from the linear fit."""
        names = [name for name in effect.parameters if name != "per_kelvin"]
        start = np.array([effect.parameters[name] for name in names])
        fixed_sign = ("play", "seat_moment", "friction_moment", "c", "t0", "decay", "period", "amplitude")

        def at(x: np.ndarray) -> Effect:
            values = {
                name: float(s * np.exp(np.clip(v, -12, 12)) if name in fixed_sign else s * (1.0 + v))
                for name, s, v in zip(names, start, x)
            }
            return Effect(effect.physics, effect.place, {**effect.parameters, **values}, effect.size)

        def left(x: np.ndarray) -> float:
            trial = at(x)
            if abs(trial.parameters.get(trial.size, 0.0)) > self.plausible.get(trial.physics, np.inf):
                return 1e9
            try:
                change = self.information.effect(trial)
            except ValueError:
                return 1e9
            rest = target - (change - beside @ (beside.T @ change))
            return float(np.linalg.norm(rest))

        found = minimize(left, np.zeros(len(names)), method="Nelder-Mead",
                         options={"maxfev": 120, "xatol": 1e-3, "fatol": 1e-3, "initial_simplex": simplex(len(names))})
        return float(found.fun), at(found.x)


    def best(self, effect: Effect, target: np.ndarray, beside: np.ndarray, linear: float) -> tuple[float, Effect]:
        """What the law itself leaves at its best: a joint in a closed loop gives no more than a pin would, however large its size."""
        found = []
        for part in (1.0, 0.1, 0.01):
            start = effect.scaled(part * effect.parameters[effect.size])
            found.append(self.refine(start, target, beside))
            if effect.physics not in JOINT or found[0][0] < linear + 0.05:
                break
        return min(found, key=lambda item: item[0])


def simplex(n: int) -> np.ndarray:
    return np.vstack([np.zeros(n), 0.35 * np.eye(n)])


def slip_gain(information: Information, target: np.ndarray, beside: np.ndarray) -> tuple[float, dict | None]:
    """Best single jump of any run and step (two later readings at least): what it leaves, and where."""
    table, inverse = information.bench.table, information.whiten.inverse
    runs, steps, _ = inverse.shape
    heaviside = np.tril(np.ones((steps, steps)))[:, 1 : steps - 1]
    best, where, whole = 0.0, None, float(target @ target)
    basis = beside.reshape(runs, steps, -1)
    rest = target.reshape(runs, steps)
    for run in range(runs):
        columns = inverse[run] @ heaviside
        own = np.einsum("sc,sc->c", columns, columns) - ((basis[run].T @ columns) ** 2).sum(axis=0)
        gains = (rest[run] @ columns) ** 2 / np.maximum(own, 1e-12)
        k = int(np.argmax(gains))
        if gains[k] > best:
            best = float(gains[k])
            place = {"pose": table.names[table.pose[run, 0]], "direction": "xyz"[table.direction[run, 0]]}
            where = {"run": {**place, "repeat": int(table.repeat[run, 0])}, "step": int(table.step[run, k + 1])}
    return float(np.sqrt(max(whole - best, 0.0))), where


def loose_members(information: Information, target: np.ndarray, beside: np.ndarray) -> list[tuple[float, Effect]]:
    """What each member that carries nothing would leave; members without which nothing stands are passed over."""
    found = []
    for element in information.bench.robot.elements(information.bench.mechanism):
        effect = Effect("loose-member", {"element": element["id"]})
        try:
            with silent():
                change = information.effect(effect)
        except Exception:  # OpenSees reports a singular structure in several ways
            continue
        rest = target - (change - beside @ (beside.T @ change))
        if np.all(np.isfinite(rest)):
            found.append((float(np.linalg.norm(rest)), effect))
    return found


@contextmanager
def silent():
    """Keep OpenSees' complaints about structures that cannot stand off the terminal."""
    kept, sink = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(sink)


def contains(rival: Effect, truth: Effect) -> bool:
    """Whether a rival is the truth itself, or a richer law at the same joint with the truth inside."""
    if key(rival) == key(truth):
        return truth.physics != "thermal-drift" or rival.parameters.get("per_kelvin") == truth.parameters.get("per_kelvin")
    same = rival.place == truth.place
    return same and truth.physics == "joint-compliance" and rival.physics in ("joint-friction", "joint-nonlinearity")


def rivals_of(library: Library, truth: Effect, others: list[Effect], limit: float = 8.0) -> list[dict]:
    """Other names and places for one effect of a bench, nearest first, in standard errors between them."""
    information = library.information
    change = information.effect(truth, tuple(others))
    beside = information.factors
    if others:
        columns = [information.effect(other)[:, None] for other in others]
        beside = orthonormal(np.hstack([beside, *columns]))
    target = change - beside @ (beside.T @ change)
    whole = float(np.linalg.norm(target))
    bound = max(limit, 0.85 * whole)
    found: list[tuple[float, Effect]] = []
    close = [item for item in library.fit(target, beside) if not contains(item[1], truth)]
    for count, (left, effect, _) in enumerate(close):
        if left > 0.97 * whole or count >= 14:
            break
        found.append(library.best(effect, target, beside, left))
    found += [item for item in loose_members(information, target, beside) if not contains(item[1], truth)]
    if truth.physics != "slip":
        left, where = slip_gain(information, target, beside)
        if where:
            found.append((left, Effect("slip", where)))
    return summary(found, bound)


def summary(found: list[tuple[float, Effect]], bound: float) -> list[dict]:
    """Nearest first; a richer law only where it explains clearly more than compliance at the same joint."""
    plain = {effect.place["joint"]: left for left, effect in found if effect.physics == "joint-compliance"}
    kept = []
    for left, effect in sorted(found, key=lambda item: item[0]):
        richer = effect.physics in ("joint-friction", "joint-nonlinearity")
        if richer and plain.get(effect.place["joint"], np.inf) - left < 1.0:
            continue
        if left < bound and len(kept) < 8:
            kept.append({"physics": effect.physics, "place": effect.place, "standard_errors_between": round(left, 2)})
    return kept


def left_by_library(library: Library, change: np.ndarray, steps: int = 3) -> list[dict]:
    """Greedy fits of up to three library effects to something outside it: each step's name and what stays."""
    information, beside, taken = library.information, library.information.factors, []
    for _ in range(steps):
        target = change - beside @ (beside.T @ change)
        names = [(fit["physics"], fit["place"]) for fit in taken]
        options = [item for item in library.fit(target, beside) if (item[1].physics, item[1].place) not in names]
        left, effect, columns = options[0] if options else (float(np.linalg.norm(target)), None, None)
        jump, where = slip_gain(information, target, beside)
        if effect is None or jump < left:
            taken.append({"physics": "slip", "place": where, "standard_errors_left": float(f"{jump:.4g}")})
            break
        taken.append({"physics": effect.physics, "place": effect.place, "standard_errors_left": float(f"{left:.4g}")})
        beside = orthonormal(np.hstack([beside, columns]))
    return taken
