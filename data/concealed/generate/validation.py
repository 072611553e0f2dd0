"""The published validation: factors fitted to the stiffness table of two poses, judged on all cells."""

import numpy as np
from scipy.optimize import least_squares

from bench import Bench
from structures import PROPERTIES


def stiffness_table(bench: Bench, readings_um: np.ndarray) -> dict[tuple[int, int], float]:
    """Mean of force over displacement per cell, N/um, over the loaded readings of the loading branch."""
    table = bench.table
    up = (table.target != 0.0) & (table.step <= 7) & (table.hold < 20.0)
    usable = up & (readings_um != 0.0)
    cells = {}
    for pose in range(len(bench.poses)):
        for direction in range(3):
            here = usable & (table.pose == pose) & (table.direction == direction)
            if here.any():
                cells[pose, direction] = float(np.mean(table.rounded[here] / readings_um[here]))
    return cells


def passes(bench: Bench, start: dict, readings_um: np.ndarray, training: tuple[int, ...]) -> tuple[bool | None, float]:
    """Whether every cell is within 3 %, and the worst; None if the plan has fewer than two poses."""
    if len(bench.poses) < 2:
        return None, float("nan")
    cells = stiffness_table(bench, readings_um)
    if any(value <= 0.0 for value in cells.values()):
        return False, float("inf")
    measured = np.array([cells[cell] for cell in cells])
    train = np.array([cell[0] in training for cell in cells])

    def log_ratio(logs: np.ndarray) -> np.ndarray:
        beam = {name: start[name] * np.exp(x) for name, x in zip(PROPERTIES, logs)}
        compliances = bench.with_beam(beam).compliances()
        predicted = np.array([1e-6 / compliances[pose, d, d] for pose, d in cells])
        return np.log(predicted / measured)

    edge = np.log(10.0)
    fit = least_squares(lambda x: log_ratio(x)[train], np.zeros(4), bounds=(-edge, edge), diff_step=1e-5)
    worst = 100.0 * float(np.max(np.abs(np.expm1(log_ratio(fit.x)))))
    return worst <= 3.0, worst
