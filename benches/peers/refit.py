#!/usr/bin/env python3
"""A thousand refits of the four beam factors to twelve stiffness values, by SciPy on one core.

    python refit.py [ROBOT] [--json]

The values are the end stiffnesses in x, y, z at the poses P1 to P4 of mechanism F, with the factors
m_fsd, times lognormal scatter of 2 % (standard deviation of the logarithm), drawn anew for every
refit.  Fitted are the logarithms of the beam factors of A, Iy, Iz, J, from m_fsd, within a tenth and
ten times the start; link factors stay at m_fsd.  Residual: log stiffness.  The stiffness matrix is
linear in the factors, so the four parts are assembled once, and the derivative of a compliance is
-u^T K_i u.  scipy.optimize.least_squares, method trf, analytic Jacobian, default tolerances; Cholesky
(LAPACK dposv) for the four structures of an evaluation.
"""

import argparse
import statistics
import subprocess
import sys
import time

import structures
from structures import DEFAULT_ROBOT, Layout, Robot, Timing, dense_matrices, element_blocks

import numpy as np
from scipy.linalg import lapack
from scipy.optimize import least_squares

MECHANISM = "F"
FACTORS = "m_fsd"
FITTED = ("A", "Iy", "Iz", "J")
SCATTER = 0.02
RANGE = 10.0


class Refit:
    """Twelve log stiffnesses and their derivatives as functions of four log factors."""

    def __init__(self, path: str) -> None:
        robot = Robot(path)
        layout = Layout.of(robot, MECHANISM, FACTORS)
        poses = [robot.pose_variables(drop_notes(robot, spec)) for spec in robot.data["poses"].values()]
        points, normals = structures.coordinates(robot, layout, MECHANISM, poses)
        self.start = np.log([robot.data["factors"][FACTORS]["beam"][name] for name in FITTED])
        unfactored = Layout.of(robot, MECHANISM, "unit").section
        link = {name: np.where(layout.is_beam, 0.0, value) for name, value in layout.section.items()}
        self.links = self._assemble(layout, points, normals, link)
        self.parts = np.stack(
            [
                self._assemble(
                    layout,
                    points,
                    normals,
                    {
                        key: value if key in ("E", "G") else np.where(layout.is_beam, value, 0.0) * (key == name)
                        for key, value in unfactored.items()
                    },
                )
                for name in FITTED
            ],
            axis=1,
        )
        self.end = 6 * layout.end + np.arange(3)
        self.loads = np.zeros((6 * layout.free, 3), order="F")
        self.loads[self.end, np.arange(3)] = 1.0
        self._at: np.ndarray | None = None

    @staticmethod
    def _assemble(layout: Layout, points: np.ndarray, normals: np.ndarray, section: dict) -> np.ndarray:
        return dense_matrices(layout, element_blocks(layout, points, normals, section))

    def evaluate(self, log_factors: np.ndarray) -> None:
        """Solve at new factors; the results serve the residual and the Jacobian."""
        if self._at is not None and np.array_equal(log_factors, self._at):
            return
        factors = np.exp(log_factors)
        matrices = self.links + np.tensordot(factors, self.parts, axes=(0, 1))
        moved = np.empty((len(matrices), *self.loads.shape))
        for pose, matrix in enumerate(matrices):
            _, moved[pose], info = lapack.dposv(matrix.T, self.loads, lower=1, overwrite_a=1)
            if info != 0:
                raise np.linalg.LinAlgError(f"dposv: {info}")
        compliance = moved[:, self.end, np.arange(3)]
        energy = np.einsum("pnl,pfnl->plf", moved, self.parts @ moved[:, None])
        self.log_stiffness = -np.log(compliance).ravel()
        self.jacobian = (energy * factors / compliance[:, :, None]).reshape(-1, len(FITTED))
        self._at = log_factors.copy()

    def fit(self, measured: np.ndarray):
        def residual(log_factors: np.ndarray) -> np.ndarray:
            self.evaluate(log_factors)
            return self.log_stiffness - measured

        def jacobian(log_factors: np.ndarray) -> np.ndarray:
            self.evaluate(log_factors)
            return self.jacobian

        width = np.log(RANGE)
        bounds = (self.start - width, self.start + width)
        return least_squares(residual, self.start, jac=jacobian, bounds=bounds, method="trf")

    def truth(self) -> np.ndarray:
        self.evaluate(self.start)
        return self.log_stiffness.copy()


def drop_notes(robot: Robot, pose: dict) -> dict:
    return {name: value for name, value in pose.items() if name in robot.variables}


def derivative_gap(refit: Refit) -> float:
    """Largest difference between the analytic Jacobian and central differences at the start."""
    refit.evaluate(refit.start)
    analytic, step = refit.jacobian.copy(), 1e-3
    gap = 0.0
    for column in range(len(FITTED)):
        ends = []
        for sign in (1.0, -1.0):
            moved = refit.start.copy()
            moved[column] += sign * step
            refit.evaluate(moved)
            ends.append(refit.log_stiffness.copy())
        difference = (ends[0] - ends[1]) / (2.0 * step)
        gap = max(gap, float(np.max(np.abs(difference - analytic[:, column]))))
    return gap


def whole_process(robot: str, core: int | None, rounds: int) -> float:
    """Median seconds of a new Python process that imports, reads the robot file and fits once."""
    command = [sys.executable, __file__, str(robot), "--single"]
    if core is not None:
        command += ["--core", str(core)]
    seconds = []
    for _ in range(rounds + 1):
        start = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds[1:])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("robot", nargs="?", default=DEFAULT_ROBOT)
    parser.add_argument("--refits", type=int, default=100, help="refits measured in each round")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--core", type=int, help="core to stay on (default: the first allowed)")
    parser.add_argument("--single", action="store_true", help="one fit, then stop (for the cold start)")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()

    core = structures.stay_on_one_core(arguments.core)
    structures.keep_freed_memory()
    random = np.random.default_rng(2)
    scatter = SCATTER * random.standard_normal((arguments.refits, 12))

    # Cold: read the robot file, place the nodes, assemble, fit once.  The values to fit need the truth,
    # which a user would have measured; it costs one evaluation more.
    start = time.perf_counter()
    refit = Refit(str(arguments.robot))
    truth = refit.truth()
    refit.fit(truth + scatter[0])
    cold = time.perf_counter() - start
    if arguments.single:
        return

    gap = derivative_gap(refit)
    if gap > 1e-5:
        raise SystemExit(f"the analytic Jacobian differs from central differences by {gap:.1e}")

    rounds, evaluations, failed = [], [], 0
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(arguments.rounds):
        start = time.perf_counter()
        fits = [refit.fit(truth + noise) for noise in scatter]
        rounds.append(time.perf_counter() - start)
        evaluations = [fit.nfev for fit in fits]
        failed = sum(fit.status <= 0 for fit in fits)
    timing = Timing(rounds, (time.process_time() - cpu) / (time.perf_counter() - wall))
    process = whole_process(arguments.robot, core, rounds=5)
    per_fit = timing.per(arguments.refits, unit=1e-3)
    estimates = np.array([fit.x for fit in fits])
    on_bound = np.abs(np.abs(estimates - refit.start) - np.log(RANGE)) < 1e-3
    result = {
        "benchmark": "refit", "mechanism": MECHANISM, "values": 12, "factors": list(FITTED),
        "refits_measured": arguments.refits, "rounds": arguments.rounds, "core": core,
        "ms_per_refit": per_fit, "seconds_per_1000_scaled": per_fit["median"],
        "cpu_share": timing.cpu_share, "evaluations_mean": float(np.mean(evaluations)),
        "evaluations_max": int(max(evaluations)), "not_converged": failed,
        "sd_log_factor": dict(zip(FITTED, estimates.std(axis=0, ddof=1).tolist())),
        "refits_with_a_factor_on_its_bound": int(on_bound.any(axis=1).sum()),
        "sum_of_squares_median": float(np.median([2.0 * fit.cost for fit in fits])),
        "cold_single_refit_ms": 1e3 * cold, "cold_process_ms": 1e3 * process,
        "jacobian_gap": gap,
    }
    text = [
        f"refit: {per_fit['median']:.1f} s per 1000 refits (scaled from {arguments.refits} measured, median of "
        f"{arguments.rounds} rounds, {per_fit['min']:.1f} to {per_fit['max']:.1f}), "
        f"{result['evaluations_mean']:.1f} evaluations each (at most {result['evaluations_max']}), "
        f"{failed} not converged, cold single refit {1e3 * cold:.0f} ms, {1e3 * process:.0f} ms "
        f"with the start of Python and the imports, one core, "
        f"cpu/wall {timing.cpu_share:.2f}"
    ]
    structures.report(result, text, arguments.json)


if __name__ == "__main__":
    main()
