"""Stiffness with its uncertainty from a CSV file of your own readings: python stiffness_of_csv.py readings.csv [U_FORCE U_DISPLACEMENT]

The file needs the columns pose, direction, repeat, force_N and displacement_um; the two uncertainties are those of the calibration of your
gauges, for example 0.2N and 1um.
"""

import sys

import stiffbench


def report(data, force_u=None, displacement_u=None):
    """K +- U of every cell, for 95 %."""
    result = stiffbench.stiffness(data, force_u=force_u, displacement_u=displacement_u)
    lines = []
    for cell in result["data"]["cells"]:
        k = cell["stiffness_regression"]
        expanded = "unknown" if k.get("U") is None else f"{k['U']:.2g}"
        lines.append(f"{cell['pose']} {cell['direction']}: K = {k['value']:.5g} {k['unit']}, U = {expanded} {k['unit']}")
    return "\n".join(lines)


if __name__ == "__main__":
    print(report(*sys.argv[1:]))
