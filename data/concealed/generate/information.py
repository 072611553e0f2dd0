"""How much of an effect can be seen: its length in standard errors, what the factors take, its rivals."""

from functools import cached_property

import numpy as np
from scipy.optimize import brentq

from bench import Bench
from effects import Effect
from noise import Noise, Whitener


class Information:
    """Whitened readings of a bench with the four beam factors projected out."""

    def __init__(self, bench: Bench, noise: Noise) -> None:
        self.bench, self.noise = bench, noise
        self.clean = bench.displacement([])
        self.whiten = Whitener(noise, self.clean, bench.table.force)
        self.factors = orthonormal(self.whiten(bench.factor_columns))

    @cached_property
    def factor_weights(self) -> np.ndarray:
        return self.whiten(self.bench.factor_columns)

    def whitened(self, displacement: np.ndarray) -> np.ndarray:
        return self.whiten(displacement.ravel())

    def effect(self, effect: Effect, others: tuple[Effect, ...] = ()) -> np.ndarray:
        """Whitened change that one effect makes beside the others."""
        with_it = self.bench.displacement([*others, effect])
        return self.whitened(with_it - (self.bench.displacement(list(others)) if others else self.clean))

    def unabsorbed(self, vector: np.ndarray) -> np.ndarray:
        return vector - self.factors @ (self.factors.T @ vector)

    def length(self, effect: Effect) -> float:
        """Standard errors."""
        return float(np.linalg.norm(self.unabsorbed(self.effect(effect))))

    def sized(self, effect: Effect, standard_errors: float, start: float, limit: float = np.inf) -> Effect | None:
        """The effect of the wanted length, found from `start`; None if it cannot be reached below `limit`."""
        def gap(log_size: float) -> float:
            try:
                return self.length(effect.scaled(sign * np.exp(log_size))) - standard_errors
            except ValueError:
                return np.inf

        sign = np.sign(start)
        low = high = np.log(abs(start))
        while gap(low) > 0.0:
            low -= 1.5
        while gap(high) < 0.0:
            high += 0.7
            if high > np.log(limit) or high > np.log(abs(start)) + 25.0:
                return None
        value = float(np.exp(brentq(gap, low, high, xtol=1e-6)))
        return effect.scaled(sign * float(f"{value:.5g}")) if value <= limit else None


def orthonormal(columns: np.ndarray) -> np.ndarray:
    """Basis of what columns span; directions that vanish beside the longest are left out."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    u, s, _ = np.linalg.svd(scaled, full_matrices=False)
    return u[:, s > 1e-9 * s[0]]


def parameter_errors(information: Information, effects: list[Effect]) -> list[dict[str, float]]:
    """Expected relative standard error of every parameter, factors and all other parameters free."""
    bench = information.bench
    columns, labels = [information.factor_weights], []
    for k, effect in enumerate(effects):
        for name, value in effect.parameters.items():
            if name == "per_kelvin":
                continue
            step = 1e-3 * (abs(value) if value else 1.0)
            sides = []
            for side in (step, -step):
                changed = Effect(effect.physics, effect.place, {**effect.parameters, name: value + side}, effect.size)
                sides.append(bench.displacement([*effects[:k], changed, *effects[k + 1 :]]))
            columns.append(information.whitened(sides[0] - sides[1])[:, None] / (2.0 * step / max(abs(value), 1e-30)))
            labels.append((k, name))
    jacobian = np.hstack(columns)
    norms = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    covariance = np.linalg.pinv((jacobian / norms).T @ (jacobian / norms), rcond=1e-13)
    errors = np.sqrt(np.maximum(np.diag(covariance), 0.0)) / norms
    found: list[dict[str, float]] = [{} for _ in effects]
    skip = information.factor_weights.shape[1]
    for (k, name), error in zip(labels, errors[skip:]):
        found[k][name] = float(f"{error:.4g}")
    return found
