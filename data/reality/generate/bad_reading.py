"""One reading that is off, and its deleted residual against the repeats of its cell, step and branch."""

import numpy as np

import shared  # noqa: F401
from information import orthonormal
from real_bench import RealBench
from real_noise import RealNoise


def deleted_residual(bench: RealBench, noise: RealNoise, readings_um: np.ndarray, run: int, step: int,
                     force: np.ndarray | None = None) -> tuple[float, float]:
    """Deleted residual of one reading, um, and its standard error, um; zero and slope of every run free.

    What is common to the repeats is free at each step; the loads' departures from their targets are
    taken out with the true compliance and the recorded force.
    """
    table = bench.table
    expected_um = 1e6 * bench.at_forces(table.rounded if force is None else force).displacement([])
    cell = np.flatnonzero((table.pose[:, 0] == table.pose[run, 0]) & (table.direction[:, 0] == table.direction[run, 0]))
    runs, steps = len(cell), table.force.shape[1]
    covariance = noise.own_covariances(expected_um[cell], table.force[cell])
    whiten = [np.linalg.inv(np.linalg.cholesky(one)) for one in covariance]
    design = np.zeros((runs, steps, steps + 2 * runs))
    for k in range(runs):
        design[k, :, :steps] = np.eye(steps)
        design[k, :, steps + k] = 1.0
        design[k, :, steps + runs + k] = expected_um[cell[k]]
    single = np.zeros((runs, steps))
    own = int(np.flatnonzero(cell == run)[0])
    single[own, step] = 1.0
    rest = (readings_um - expected_um)[cell]
    x = np.concatenate([w @ d for w, d in zip(whiten, design)])
    v = np.concatenate([w @ s for w, s in zip(whiten, single)])
    y = np.concatenate([w @ r for w, r in zip(whiten, rest)])
    basis = orthonormal(x)
    free = v - basis @ (basis.T @ v)
    information = float(free @ free)
    return float(free @ y) / information, 1.0 / np.sqrt(information)


def spoil(bench: RealBench, noise: RealNoise, readings_um: np.ndarray, off_um: float, rng: np.random.Generator) -> tuple[np.ndarray, dict]:
    """The readings with one of them off, either way; what the answer says about it."""
    table = bench.table
    run, step = int(rng.integers(readings_um.shape[0])), int(rng.integers(readings_um.shape[1]))
    shift = float(rng.choice([-1.0, 1.0])) * off_um
    spoiled = readings_um.copy()
    spoiled[run, step] += shift
    _, error = deleted_residual(bench, noise, readings_um, run, step)
    seen, _ = deleted_residual(bench, noise, spoiled, run, step)
    return spoiled, {
        "line": 2 + run * readings_um.shape[1] + step,
        "place": {
            "pose": table.names[table.pose[run, step]], "direction": "xyz"[table.direction[run, step]],
            "repeat": int(table.repeat[run, step]), "step": int(table.step[run, step]),
            "branch": "loading" if table.step[run, step] <= 7 else "unloading",
        },
        "value": float(spoiled[run, step]), "true_value": float(readings_um[run, step]), "unit": "um",
        "standard_errors": round(abs(shift) / error, 2), "standard_errors_seen": round(seen / error, 2),
    }
