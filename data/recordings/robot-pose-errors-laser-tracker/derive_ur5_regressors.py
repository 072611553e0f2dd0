"""Writes derived_ur5_regressors.csv: what a rigid robot, its joint compliance and its gears can do to the tool position.

Needs numpy. Run in this folder: python derive_ur5_regressors.py
"""

import csv

import numpy as np

# Link geometry and masses as the maker publishes them for the UR5 (standard Denavit-Hartenberg, mm, kg; centres of mass in link axes).
A_MM = [0.0, -425.0, -392.25, 0.0, 0.0, 0.0]
D_MM = [89.159, 0.0, 0.0, 109.15, 94.65, 82.3]
ALPHA = [np.pi / 2, 0.0, 0.0, np.pi / 2, -np.pi / 2, 0.0]
MASS_KG = [3.7, 8.393, 2.33, 1.219, 1.219, 0.1879]
CENTRE_MM = [
    [0.0, -25.61, 1.93],
    [212.5, 0.0, 113.36],
    [119.93, 0.0, 26.5],
    [0.0, -1.8, 16.34],
    [0.0, 1.8, 16.34],
    [0.0, 0.0, -1.159],
]
# With this reflector on the flange the stated targets follow from the stated joint angles to 0.02 mm.
TOOL_MM = np.array([0.0, 0.0, 31.0])
GRAVITY = np.array([0.0, 0.0, -9.80665])
RIGID = 25


def axes(q, a, d, alpha, theta, beta):
    """Homogeneous transforms of base and links; beta turns a link about its y axis, which parallel axes need (Hayati)."""
    total = np.tile(np.eye(4), (len(q), 1, 1))
    found = [total]
    for i in range(6):
        t = q[:, i] + theta[i]
        c, s, ca, sa = np.cos(t), np.sin(t), np.cos(alpha[i]), np.sin(alpha[i])
        link = np.zeros((len(q), 4, 4))
        link[:, 0, 0], link[:, 0, 1], link[:, 0, 2], link[:, 0, 3] = c, -s * ca, s * sa, a[i] * c
        link[:, 1, 0], link[:, 1, 1], link[:, 1, 2], link[:, 1, 3] = s, c * ca, -c * sa, a[i] * s
        link[:, 2, 1], link[:, 2, 2], link[:, 2, 3], link[:, 3, 3] = sa, ca, d[i], 1.0
        turn = np.eye(4)
        turn[0, 0] = turn[2, 2] = np.cos(beta[i])
        turn[0, 2], turn[2, 0] = np.sin(beta[i]), -np.sin(beta[i])
        total = total @ link @ turn
        found.append(total)
    return found


def tool(q, values):
    """Tool position in mm for 30 link values, three of the tool and six of the base."""
    links, offset, turn, shift = np.split(values, [30, 33, 36])
    end = axes(q, *links.reshape(5, 6))[6]
    point = end[:, :3, 3] + end[:, :3, :3] @ (TOOL_MM + offset)
    return point + np.cross(turn, point) + shift


def rigid_basis(q):
    """Orthogonal basis of every tool displacement that a change of rigid geometry can cause, root mean square 1 mm each."""
    nominal = np.concatenate([A_MM, D_MM, ALPHA, np.zeros(12 + 3 + 6)])
    columns = []
    for i in range(len(nominal)):
        step = np.zeros_like(nominal)
        step[i] = 1e-3 if i < 12 or 30 <= i < 33 or i >= 36 else 1e-6
        columns.append(((tool(q, nominal + step) - tool(q, nominal - step)) / (2 * step[i])).ravel())
    columns = np.column_stack(columns)
    length = np.linalg.norm(columns, axis=0)
    # A turn of joint 6 leaves a tool on its axis where it is.
    moving = length > 1e-6 * length.max()
    left, size, _ = np.linalg.svd(columns[:, moving] / length[moving], full_matrices=False)
    # A gap of three decades behind the 25th: the other combinations move the tool in no pose.
    assert size[RIGID - 1] > 1e3 * size[RIGID], size
    return left[:, :RIGID] * np.sqrt(len(columns))


def joint_columns(q):
    """Tool displacement per radian of joints 1 to 5, mm, and the own-weight moment about each, N m."""
    found = axes(q, A_MM, D_MM, ALPHA, np.zeros(6), np.zeros(6))
    point = found[6][:, :3, 3] + found[6][:, :3, :3] @ TOOL_MM
    centre = [found[i + 1][:, :3, 3] + found[i + 1][:, :3, :3] @ np.array(CENTRE_MM[i]) for i in range(6)]
    arms, moments = [], []
    for i in range(5):
        origin, axis = found[i][:, :3, 3], found[i][:, :3, 2]
        arms.append(np.cross(axis, point - origin))
        moment = sum(np.cross((centre[j] - origin) * 1e-3, MASS_KG[j] * GRAVITY) for j in range(i, 6))
        moments.append(np.einsum("ni,ni->n", axis, moment))
    return arms, moments


def main():
    grid = np.genfromtxt("ur5_grid_1000.csv", delimiter=",", names=True)
    q = np.radians(np.column_stack([grid[f"joint_{i}"] for i in range(1, 7)]))
    error = np.column_stack([grid[f"{axis}_dif"] for axis in "xyz"]).ravel()
    basis = rigid_basis(q)
    arms, moments = joint_columns(q)
    # The moment about joint 1 is zero: its axis is vertical.
    compliance = [(arms[i] * moments[i][:, None] * 1e-4).ravel() for i in range(1, 5)]
    header = ["pose", "axis", "error_mm"] + [f"rigid{i:02d}" for i in range(1, RIGID + 1)]
    header += [f"joint{i}_compliance_mm_per_1e-4rad_per_Nm" for i in range(2, 6)]
    header += [f"joint{i}_arm_mm_per_rad" for i in range(1, 6)]
    arms = [arm.ravel() for arm in arms]
    with open("derived_ur5_regressors.csv", "w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(header)
        for i in range(len(error)):
            values = [f"{error[i]:.6f}", *(f"{b:.4f}" for b in basis[i])]
            values += [f"{c[i]:.5f}" for c in compliance] + [f"{a[i]:.3f}" for a in arms]
            rows.writerow([i // 3, "xyz"[i % 3], *values])


if __name__ == "__main__":
    main()
