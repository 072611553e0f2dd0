"""Laws of joints that the library lacks; they follow the interface of `laws.py` of the concealed benches.

Parameters may be arrays over the runs, for what differs between poses or between runs.
"""

from dataclasses import dataclass

import numpy as np


class Memoryless:
    def start(self, runs: int) -> None:
        pass

    def commit(self) -> None:
        pass


@dataclass
class OneSided(Memoryless):
    """twist = c (side tau - threshold) where that is above zero: a crack, a flank, a foot that lifts."""

    c: np.ndarray | float
    threshold: float
    side: float

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        over = np.maximum(self.side * applied - self.threshold, 0.0)
        return self.side * self.c * over / (1.0 + self.c * stiffness)


@dataclass
class TwoStiffnesses(Memoryless):
    """twist = c tau one way round, part of it the other way."""

    c: float
    part: float

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        c = np.where(applied > 0.0, self.c, self.part * self.c)
        return c * applied / (1.0 + c * stiffness)


@dataclass
class SnapThrough:
    """Jumps by `jump` when |tau| passes `on`, back when it falls below `off`."""

    jump: float
    on: float
    off: float

    def start(self, runs: int) -> None:
        self.committed = np.zeros(runs, bool)
        self.trial = self.committed

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        size = np.abs(applied)
        self.trial = np.where(size > self.on, True, np.where(size < self.off, False, self.committed))
        return np.sign(applied) * self.jump * self.trial

    def commit(self) -> None:
        self.committed = self.trial


@dataclass
class SlippingBrake:
    """Stuck up to a moment, then it slips, the further the higher the moment has been, and never comes back."""

    c: float
    limit: float

    def start(self, runs: int) -> None:
        self.committed = np.zeros(runs)
        self.trial = self.committed

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        slipped = np.maximum(np.abs(applied) - self.limit, 0.0) / (stiffness + 1.0 / self.c)
        farther = slipped > np.abs(self.committed)
        self.trial = np.where(farther, np.sign(applied) * slipped, self.committed)
        return self.trial

    def commit(self) -> None:
        self.committed = self.trial


@dataclass
class ServoRecovers:
    """A drive that gives way at once and brings the joint back in the time under load."""

    c: np.ndarray  # runs x steps, what is left of the compliance at each reading

    def start(self, runs: int) -> None:
        self.step = 0

    def twist(self, applied: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
        c = self.c[:, self.step]
        return c * applied / (1.0 + c * stiffness)

    def commit(self) -> None:
        self.step += 1
