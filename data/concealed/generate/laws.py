"""Laws of a joint: the twist that belongs to a moment, with the history of the run.

A law is solved together with the structure.  The structure gives moment = applied - stiffness x twist
(`structures.JointAction`), the law gives the twist of a moment; both hold at once at every reading.
Arrays run over the runs of a bench; every run starts without twist and with unstressed sliders.
"""

from dataclasses import dataclass

import numpy as np


@dataclass
class Compliance:
    """twist = c moment."""

    c: float

    def start(self, runs: int) -> None:
        pass

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        return self.c * applied / (1.0 + self.c * stiffness)

    def commit(self) -> None:
        pass


@dataclass
class Backlash:
    """No twist below the seat moment, then up to `play` at that moment, then rigid; no history."""

    play: float
    seat_moment: float

    def start(self, runs: int) -> None:
        pass

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        over = np.maximum(np.abs(applied) - self.seat_moment, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            taken = np.where(over > stiffness * self.play, self.play, over / stiffness)
        return np.sign(applied) * np.where(over > 0.0, taken, 0.0)

    def commit(self) -> None:
        pass


@dataclass
class Friction:
    """Spring 1/c beside a Coulomb slider."""

    c: float
    friction_moment: float

    def start(self, runs: int) -> None:
        self.committed = np.zeros(runs)
        self.trial = self.committed

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        slider = applied - (stiffness + 1.0 / self.c) * self.committed
        sliding = (applied - np.sign(slider) * self.friction_moment) / (1.0 / self.c + stiffness)
        self.trial = np.where(np.abs(slider) > self.friction_moment, sliding, self.committed)
        return self.trial

    def commit(self) -> None:
        self.committed = self.trial


@dataclass
class Nonlinearity:
    """twist = c moment + q moment |moment|."""

    c: float
    q: float

    def start(self, runs: int) -> None:
        pass

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        linear, square = 1.0 + self.c * stiffness, stiffness * self.q
        size = np.abs(applied)
        inside = linear**2 + 4.0 * square * size
        if np.any(inside <= 0.0):
            raise ValueError("the nonlinear joint has no state for this load")
        moment = 2.0 * size / (linear + np.sqrt(inside))
        return np.sign(applied) * (self.c * moment + self.q * moment**2)

    def commit(self) -> None:
        pass


class FromMoment:
    """Base of laws given as twist(moment), rising in it: solved with the structure by bisection."""

    def start(self, runs: int) -> None:
        pass

    def commit(self) -> None:
        pass

    def of_moment(self, moment: np.ndarray) -> np.ndarray:
        raise NotImplementedError

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        reach = np.abs(applied) + stiffness * np.abs(self.of_moment(np.zeros_like(applied))) + 1e-30
        low, high = -reach, reach.copy()
        for _ in range(90):
            middle = 0.5 * (low + high)
            above = middle + stiffness * self.of_moment(middle) > applied
            high, low = np.where(above, middle, high), np.where(above, low, middle)
        return self.of_moment(0.5 * (low + high))


@dataclass
class Plasticity(FromMoment):
    """Ramberg-Osgood: twist = strength (|moment|/scale)^exponent on first loading, Masing branches after.

    Made of many sliders in a row, so that loops nest and small ones are thinner than large ones.
    """

    strength: float
    scale: float
    exponent: float
    sliders: int = 60

    def start(self, runs: int) -> None:
        edges = 1.6 * self.scale * np.linspace(0.0, 1.0, self.sliders + 1)
        slope = self.strength * self.exponent * edges ** (self.exponent - 1) / self.scale**self.exponent
        self.weight, self.threshold = np.diff(slope), 0.5 * (edges[1:] + edges[:-1])
        self.committed = np.zeros((runs, self.sliders))
        self.trial = self.committed

    def of_moment(self, moment: np.ndarray) -> np.ndarray:
        upper, lower = moment[:, None] + self.threshold, moment[:, None] - self.threshold
        self.trial = np.clip(self.committed, lower, upper)
        return self.trial @ self.weight

    def commit(self) -> None:
        self.committed = self.trial


@dataclass
class AsymmetricCubic(FromMoment):
    """twist = c moment + even moment^2 - hardening moment^3: stiffer one way round than the other."""

    c: float
    even: float
    hardening: float

    def of_moment(self, moment: np.ndarray) -> np.ndarray:
        return self.c * moment + self.even * moment**2 - self.hardening * moment**3


def solve_twists(laws: list, levers: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Twists of all joints for all readings, load after load.

    `levers`: applied moments, runs x steps x joints; `stiffness`: runs x joints x joints.
    """
    runs, steps, joints = levers.shape
    for law in laws:
        law.start(runs)
    twists = np.zeros((runs, steps, joints))
    state = np.zeros((runs, joints))
    for step in range(steps):
        for _ in range(200 if joints > 1 else 1):
            before = state.copy()
            for j, law in enumerate(laws):
                coupled = np.einsum("rk,rk->r", stiffness[:, j, :], state) - stiffness[:, j, j] * state[:, j]
                state[:, j] = law.twist(levers[:, step, j] - coupled, stiffness[:, j, j])
            if np.all(np.abs(state - before) <= 1e-13 * (np.abs(state) + 1e-12)):
                break
        else:
            if joints > 1:
                raise RuntimeError("two joint laws did not come to rest together")
        for law in laws:
            law.commit()
        twists[:, step, :] = state
    return twists
