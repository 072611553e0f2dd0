"""The observer beside whom the program is judged: it knows the covariance and has the same candidates.

It adds the likeliest candidate while the family's p, calibrated by draws, is below the level, and
names with it all that lie within three units of log likelihood.  Laws with a shape (seat moment, period, decay,
onset) are on the grids of `candidates.py`, to which the true shape is added, and not refined.
"""

import numpy as np
from scipy.stats import chi2

import shared  # noqa: F401
from candidates import WideLibrary, title
from effects import Effect
from information import orthonormal

LEVEL = 0.03  # of the family of all laws and set-up findings (verdict rules, 2)
DRAWS = 400
ALIKE = 6.0  # in chi squared: three units of log likelihood
MOST = 3  # effects
RICHER = ("joint-friction", "joint-nonlinearity", "odd-polynomial", "end-stop")


class Observer:
    def __init__(self, library: WideLibrary, rng: np.random.Generator) -> None:
        self.library, self.information = library, library.information
        self.effects = [candidate.effect for candidate in library.candidates]
        self.columns = [candidate.columns for candidate in library.candidates]
        for place, column in _jumps(self.information):
            self.effects.append(Effect("slip", place))
            self.columns.append(column[:, None])
        self.names = [title(effect) for effect in self.effects]
        self.groups = [effect.physics for effect in self.effects]
        self.laws = sorted(set(self.groups))
        self.noise = rng.standard_normal((self.information.clean.size, DRAWS))

    def decide(self, readings: np.ndarray) -> list[list[str]]:
        """Sets of names, one a found effect, from whitened readings less the model at the true factors."""
        vectors, kept = np.column_stack([readings, self.noise]), []
        for _ in range(MOST):
            scores, ranks = self._scores(vectors, self._beside(kept))
            if not self._seen(scores):
                break
            kept.append(int(np.argmax(self._favoured(scores[:, 0], ranks))))
            kept = self._replaced(vectors[:, :1], kept)[0]
        self.kept, alike = self._replaced(vectors[:, :1], kept)
        return [self._set(one) for one in alike]

    def left_p(self, readings: np.ndarray) -> float:
        """Chance of as large a sum of all squares after what was decided last: the observer's own omnibus test."""
        beside = self._beside(self.kept)
        rest = readings - beside @ (beside.T @ readings)
        return float(chi2.sf(rest @ rest, readings.size - beside.shape[1]))

    def _replaced(self, readings: np.ndarray, kept: list[int]) -> tuple[list[int], list[list[int]]]:
        """Each kept candidate chosen again beside the others, and what is alike to it there."""
        kept, alike = list(kept), [[] for _ in kept]
        for _ in range(3 if len(kept) > 1 else 1):
            for place in range(len(kept)):
                others = kept[:place] + kept[place + 1 :]
                scores, ranks = self._scores(readings, self._beside(others))
                worth = self._favoured(scores[:, 0], ranks)
                best = int(np.argmax(worth))
                kept[place] = best
                alike[place] = [int(k) for k in np.flatnonzero(worth[best] - worth < ALIKE)]
        return kept, alike

    def _favoured(self, scores: np.ndarray, ranks: list[int]) -> np.ndarray:
        """Squares less what a second column, or the best of all jumps, takes of noise alone."""
        jumps = np.array([group == "slip" for group in self.groups])
        return scores - 2.0 * (np.array(ranks) - 1) - 2.0 * np.log(jumps.sum()) * jumps

    def _beside(self, kept: list[int]) -> np.ndarray:
        if not kept:
            return self.information.factors
        return orthonormal(np.hstack([self.information.factors, *(self.columns[k] for k in kept)]))

    def _scores(self, vectors: np.ndarray, beside: np.ndarray) -> tuple[np.ndarray, list[int]]:
        """Squares that each candidate takes of each vector, candidates x vectors, zero for impossible sizes; columns of each."""
        stacked = np.hstack(self.columns)
        free = stacked - beside @ (beside.T @ stacked)
        lengths, norms = np.linalg.norm(stacked, axis=0), np.linalg.norm(free, axis=0)
        products, place = free.T @ vectors, 0
        scores, ranks = np.zeros((len(self.columns), vectors.shape[1])), []
        for k, columns in enumerate(self.columns):
            part = slice(place, place + columns.shape[1])
            place = part.stop
            ranks.append(columns.shape[1])
            if np.any(norms[part] <= 1e-6 * lengths[part]):
                continue
            gram = free[:, part].T @ free[:, part]
            scale = np.sqrt(np.diag(gram))
            if columns.shape[1] == 2 and abs(gram[0, 1]) > (1.0 - 1e-8) * scale[0] * scale[1]:
                continue
            sizes = np.linalg.solve(gram / np.outer(scale, scale), products[part] / scale[:, None]) / scale[:, None]
            scores[k] = np.where(self.library.possible(self.effects[k], sizes), np.sum(sizes * products[part], axis=0), 0.0)
        return scores, ranks

    def _seen(self, scores: np.ndarray) -> bool:
        """Whether the smallest p over the laws passes the level, both from the draws."""
        logs = np.empty((len(self.laws), scores.shape[1]))
        for row, law in enumerate(self.laws):
            top = scores[[k for k, group in enumerate(self.groups) if group == law]].max(axis=0)
            null = np.sort(top[1:])
            tail = null[-20]  # beyond it the tail of chi squared, as the draws begin it
            rank = 1.0 - np.searchsorted(null, top, side="left") / len(null)
            logs[row] = np.where(top > tail, np.log(20.0 / len(null)) - 0.5 * (top - tail), np.log(np.maximum(rank, 1.0 / len(null))))
        least = logs.min(axis=0)
        return bool(least[0] < np.quantile(least[1:], LEVEL))

    def _set(self, alike: list[int]) -> list[str]:
        named = {self.names[k] for k in alike}
        plain = {name.split("@")[1] for name in named if name.startswith("joint-compliance@")}
        return sorted(name for name in named if not (name.split("@")[0] in RICHER and name.split("@")[1] in plain))


def _jumps(information) -> list[tuple[dict, np.ndarray]]:
    """Every single jump with two later readings, whitened."""
    table, inverse = information.bench.table, information.whiten.inverse
    runs, steps, _ = inverse.shape
    found = []
    for run in range(runs):
        place = {"pose": table.names[table.pose[run, 0]], "direction": "xyz"[table.direction[run, 0]], "repeat": int(table.repeat[run, 0])}
        for k in range(1, steps - 1):
            column = np.zeros((runs, steps))
            column[run] = inverse[run] @ (np.arange(steps) >= k)
            found.append(({"run": place, "step": int(table.step[run, k])}, column.ravel()))
    return found


