"""Stiffness of a robot over its workspace with NumPy: python workspace.py [ROBOT] [POSES]"""

import sys

import numpy as np

import stiffbench


def report(name="hp-robot", count=50_000):
    """Stiffness along each axis over random poses within the limits, and where the robot is weakest."""
    robot = stiffbench.Robot(name)
    low, high = robot.limits.T
    poses = np.random.default_rng(0).uniform(low, high, size=(int(count), len(low)))
    poses = poses[robot.within_limits(poses)]

    compliance = robot.compliance(poses)[:, :3, :3]
    along = 1e-6 / np.diagonal(compliance, axis1=1, axis2=2)  # N/um
    # The largest eigenvalue is the displacement per force in the weakest direction.
    weakest = 1e-6 / np.linalg.eigvalsh((compliance + compliance.transpose(0, 2, 1)) / 2)[:, -1]
    at = int(np.argmin(weakest))

    lines = [f"{robot.name}: {len(poses)} poses"]
    for axis, k in zip("xyz", along.T):
        low, median, high = np.quantile(k, [0.05, 0.5, 0.95])
        lines.append(f"{axis}: median {median:.4g} N/um, 5 % {low:.4g}, 95 % {high:.4g}")
    values = ", ".join(f"{name} {value:.1f}" for name, value in zip(robot.variables, poses[at]))
    lines.append(f"weakest: {weakest[at]:.4g} N/um at {np.round(robot.positions(poses[at : at + 1])[0], 3)} m, {values}")
    return "\n".join(lines)


if __name__ == "__main__":
    print(report(*sys.argv[1:]))
