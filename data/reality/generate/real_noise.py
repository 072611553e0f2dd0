"""Noise as real benches have it: serial correlation, growth with travel, long tails, a coarse gauge."""

from dataclasses import dataclass

import numpy as np

import shared  # noqa: F401
from noise import Noise


@dataclass(frozen=True)
class RealNoise(Noise):
    """Beside `Noise`: the scatter of single readings may be correlated, grow, or have long tails."""

    ar1: float = 0.0  # correlation of the scatter of neighbouring readings of a run
    growth: float = 0.0  # standard deviation that grows with travel, share of it, beside sigma
    tails: float = 0.0  # degrees of freedom of Student's t with standard deviation sigma; 0: normal

    def readings_um(self, clean_m: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        runs = clean_m.shape[0]
        zero = self.sigma0 * rng.standard_normal((runs, 1))
        slope = self.slope * rng.standard_normal((runs, 1))
        total = 1e6 * clean_m * (1.0 + slope) + zero + self.scatter_um(clean_m, rng)
        return np.round(total / self.res_um) * self.res_um

    def scatter_um(self, clean_m: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Scatter of the readings of each run, before the steps of the gauges."""
        if self.tails:
            fresh = rng.standard_t(self.tails, clean_m.shape) / np.sqrt(self.tails / (self.tails - 2.0))
        else:
            fresh = rng.standard_normal(clean_m.shape)
        unit = fresh.copy()
        for k in range(1, unit.shape[1]):
            unit[:, k] = self.ar1 * unit[:, k - 1] + np.sqrt(1.0 - self.ar1**2) * fresh[:, k]
        return unit * np.sqrt(self.scatter_variances(1e6 * clean_m))

    def scatter_variances(self, baseline: np.ndarray) -> np.ndarray:
        return self.sigma**2 + (self.growth * baseline) ** 2

    def own_covariances(self, baseline: np.ndarray, force: np.ndarray) -> np.ndarray:
        """Covariance without the zero and slope of the run, um^2, runs x steps x steps."""
        steps = baseline.shape[1]
        lag = np.abs(np.subtract.outer(np.arange(steps), np.arange(steps)))
        spread = np.sqrt(self.scatter_variances(baseline))
        serial = self.ar1**lag * spread[:, :, None] * spread[:, None, :]  # 0 to the power 0 is 1
        gauges = self.own_variances(baseline, force) - self.scatter_variances(baseline)
        return serial + gauges[:, :, None] * np.eye(steps)

    def covariances(self, baseline: np.ndarray, force: np.ndarray) -> np.ndarray:
        slopes = self.slope**2 * baseline[:, :, None] * baseline[:, None, :]
        return self.own_covariances(baseline, force) + self.sigma0**2 + slopes


# What the rows are named by: fixed values, or ranges from which a bench draws.
KINDS = {
    "assumed": {}, "ar04": {"ar1": 0.4}, "ar08": {"ar1": 0.8}, "growing": {"growth": 0.0015}, "t4": {"tails": 4.0},
    "coarse": {"res_um": 10.0, "sigma": (0.2, 0.8), "sigma0": (0.2, 0.8), "slope": (0.0002, 0.0008)},
}


def draw(kind: str, robot: str, rng: np.random.Generator) -> RealNoise:
    """Noise of one bench: the ranges of the concealed benches, less on the stiffer arms, then what the kind fixes."""
    scale = 1.0 if robot == "hp" else 0.6
    ranges = {"sigma": (0.9 * scale, 2.2 * scale), "sigma0": (1.2 * scale, 3.0 * scale), "slope": (0.0012, 0.003)}
    drawn = {}
    for name, value in {**ranges, **KINDS[kind]}.items():
        drawn[name] = value if isinstance(value, float) else float(f"{rng.uniform(*value):.3g}")
    return RealNoise(**drawn)
