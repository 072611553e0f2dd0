"""Laws of springs, friction, play and time in their textbook form, written for this folder alone.

u is the quantity that is set, as a sequence in time; every run starts without stress at u = 0.
"""

import numpy as np


def play(u, radius, start=0.0):
    """Play operator: follows u at a distance of at most `radius` (Krasnosel'skii and Pokrovskii, Systems with Hysteresis, 1989, 2)."""
    return load_dependent_play(u, radius, 0.0, start)


def load_dependent_play(u, radius, growth, start=0.0):
    """Play operator whose radius grows with the load: radius + growth |u|."""
    out = np.empty(len(u))
    state = start
    for i, value in enumerate(u):
        reach = radius + growth * abs(value)
        state = max(value - reach, min(value + reach, state))
        out[i] = state
    return out


def stop(u, radius, start=0.0):
    """Stop operator: a spring behind a slider that slips at `radius` (one Jenkin element, unit stiffness)."""
    return u - play(u, radius, start)


def dead_zone(u, width):
    """Zero for |u| < width, then u less width with its sign."""
    return np.sign(u) * np.maximum(np.abs(u) - width, 0.0)


def maxwell_arm(t, u, tau):
    """The delayed part of a standard linear solid: s' = (u - s)/tau, u linear between readings (Findley et al., 1976, 5)."""
    out = np.zeros(len(u))
    state = 0.0
    for i in range(1, len(u)):
        dt = t[i] - t[i - 1]
        if dt <= 0.0:
            out[i] = state
            continue
        a = np.exp(-dt / tau)
        slope = (u[i] - u[i - 1]) / dt
        state = state * a + u[i - 1] * (1.0 - a) + slope * (dt - tau * (1.0 - a))
        out[i] = state
    return out


def log_memory(t, u, t0):
    """Superposition of log10(1 + age/t0) over all steps of u (Boltzmann; Findley et al., 1976, 5)."""
    steps = np.diff(u, prepend=0.0)
    out = np.empty(len(u))
    for i in range(len(u)):
        out[i] = steps[: i + 1] @ np.log10(1.0 + np.maximum(t[i] - t[: i + 1], 0.0) / t0)
    return out


def by_run(function, run, *columns):
    """Applies a function of columns to each run apart."""
    out = np.empty(len(run))
    for name in dict.fromkeys(run):
        rows = run == name
        out[rows] = function(*(column[rows] for column in columns))
    return out


def demean(values, run):
    """Values less the mean of their run."""
    out = np.array(values, dtype=float)
    for name in dict.fromkeys(run):
        rows = run == name
        out[rows] -= out[rows].mean(axis=0)
    return out


def least_squares(columns, answer):
    """Coefficients of least squares, columns scaled to unit length."""
    scale = np.sqrt((columns**2).sum(axis=0))
    scale[scale == 0.0] = 1.0
    return np.linalg.lstsq(columns / scale, answer, rcond=None)[0] / scale
