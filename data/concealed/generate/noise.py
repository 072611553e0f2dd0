"""Noise of a bench, its covariance per run, and the whitening that follows from it."""

from dataclasses import asdict, dataclass

import numpy as np


@dataclass(frozen=True)
class Noise:
    """Standard deviations in µm; `slope` is relative."""

    sigma: float = 1.2
    sigma0: float = 2.0
    slope: float = 0.002
    res_um: float = 1.0
    force_resolution_N: float = 0.1
    shape: str = "normal"  # or "gamma", "lognormal": shifted to mean zero, same standard deviation

    def answer(self) -> dict:
        return asdict(self)

    def readings_um(self, clean_m: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Gauge readings: run zero, run slope, scatter of each reading, then the step of the gauge."""
        runs = clean_m.shape[0]
        zero = self.sigma0 * rng.standard_normal((runs, 1))
        slope = self.slope * rng.standard_normal((runs, 1))
        total = 1e6 * clean_m * (1.0 + slope) + zero + self.sigma * self._unit(clean_m.shape, rng)
        return np.round(total / self.res_um) * self.res_um

    def _unit(self, shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
        if self.shape == "gamma":
            return (rng.gamma(2.0, 1.0, shape) - 2.0) / np.sqrt(2.0)
        if self.shape == "lognormal":
            s = 0.5
            mean, variance = np.exp(s**2 / 2.0), (np.exp(s**2) - 1.0) * np.exp(s**2)
            return (np.exp(s * rng.standard_normal(shape)) - mean) / np.sqrt(variance)
        return rng.standard_normal(shape)

    def covariances(self, baseline: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Covariance of the readings of each run, um^2, runs x steps x steps; `baseline` in um."""
        own, slopes = self.own_variances(baseline, force), self.slope**2
        return np.array([
            np.diag(own[run]) + self.sigma0**2 + slopes * np.outer(baseline[run], baseline[run])
            for run in range(len(baseline))
        ])

    def own_variances(self, baseline: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Variance of each reading by itself: scatter and the steps of both gauges, um^2."""
        loaded = force != 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            compliance = np.where(loaded, np.abs(baseline / force), 0.0)
        # An unloaded reading has exactly no force: the step of the force gauge is not in it.
        return self.scatter_variances(baseline) + self.res_um**2 / 12.0 + (compliance * self.force_resolution_N) ** 2 / 12.0

    def scatter_variances(self, baseline: np.ndarray) -> np.ndarray | float:
        """Variance of the scatter alone, um^2."""
        return self.sigma**2


class Whitener:
    """Multiplies readings (runs x steps) by the inverse Cholesky factor of each run's covariance."""

    def __init__(self, noise: Noise, baseline_m: np.ndarray, force: np.ndarray) -> None:
        covariances = noise.covariances(1e6 * baseline_m, force)
        self.inverse = np.array([np.linalg.inv(np.linalg.cholesky(covariance)) for covariance in covariances])

    def __call__(self, values_m: np.ndarray) -> np.ndarray:
        """Readings in m (flat, or readings x columns) to whitened numbers of the same shape."""
        runs, steps, _ = self.inverse.shape
        columns = 1e6 * np.asarray(values_m).reshape(runs, steps, -1)
        return np.einsum("rij,rjc->ric", self.inverse, columns).reshape(np.shape(values_m))
