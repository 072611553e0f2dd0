"""What is measured when: loads, repeats, clock and temperature of a session."""

from dataclasses import dataclass, field

import numpy as np

LOADS = (0, -10, -20, -30, -40, -50, -60, -70)


@dataclass(frozen=True)
class Plan:
    """The procedure of a session."""

    poses: tuple[str, ...]
    unloading: bool = True
    holds_s: tuple[float, ...] = ()
    repeats: int = 5
    directions: tuple[str, ...] = ("x", "y", "z")
    temperature: str = "walk"  # or "sine" (a day), "swing" (half an hour), "tent": up in the first half, then down

    def text(self) -> str:
        back = ", then back to 0 N in the same steps" if self.unloading else ""
        hold = ""
        if self.holds_s:
            hold = f"; at full load further readings after about {', '.join(f'{s:g}' for s in self.holds_s)} s"
        return (
            f"each pose, each direction: {self.repeats} runs of 0, -10, ..., -70 N{back}{hold}; "
            "the gauge is zeroed before each run"
        )


@dataclass
class Table:
    """The readings of a session, arrays of runs x steps; force is the true one, rounded the recorded."""

    pose: np.ndarray
    direction: np.ndarray
    repeat: np.ndarray
    step: np.ndarray
    target: np.ndarray
    force: np.ndarray
    hold: np.ndarray
    time: np.ndarray
    temperature: np.ndarray
    names: tuple[str, ...] = field(default=())

    @property
    def rounded(self) -> np.ndarray:
        return np.round(self.force, 1)


def steps_of(plan: Plan) -> list[tuple[int, int, float]]:
    """(step, target, hold) of one run; a hold of 0 means the usual few seconds."""
    sequence = [(step, load, 0.0) for step, load in enumerate(LOADS)]
    sequence += [(len(LOADS) - 1, LOADS[-1], hold) for hold in plan.holds_s]
    if plan.unloading:
        back = list(reversed(LOADS[:-1]))
        sequence += [(len(LOADS) + k, load, 0.0) for k, load in enumerate(back)]
    return sequence


def take(plan: Plan, rng: np.random.Generator) -> Table:
    """Draw loads and clock of a session; poses are indices into plan.poses, directions into x, y, z."""
    sequence = steps_of(plan)
    steps = np.array([step for step, _, _ in sequence])
    targets = np.array([load for _, load, _ in sequence], dtype=float)
    cells = [(p, "xyz".index(d)) for p in range(len(plan.poses)) for d in plan.directions]
    runs = [(p, d, r) for p, d in cells for r in range(1, plan.repeats + 1)]
    shape = (len(runs), len(sequence))
    force = targets + rng.uniform(-0.5, 0.5, shape)
    force[:, targets == 0.0] = 0.0
    hold = np.clip(rng.normal(5.0, 0.8, shape), 3.0, 8.0)
    time = np.zeros(shape)
    clock = rng.uniform(90.0, 150.0)
    for index, (pose, direction, repeat) in enumerate(runs):
        if repeat == 1:
            clock += rng.uniform(60.0, 120.0) if direction else (rng.uniform(300.0, 500.0) if index else 0.0)
        clock += rng.uniform(35.0, 60.0)
        for k, (_, _, held) in enumerate(sequence):
            if held:
                hold[index, k] = held + rng.normal(0.0, 1.2)
                force[index, k] = force[index, k - 1]
                clock += max(hold[index, k] - hold[index, k - 1], 1.0)
            else:
                clock += rng.uniform(10.0, 19.5)
            time[index, k] = clock
    hold, time = np.round(hold, 1), np.round(time, 2)
    temperature = np.round(_temperature(plan.temperature, time, rng), 2)
    column = [np.array([run[k] for run in runs]) for k in range(3)]
    spread = [np.broadcast_to(values[:, None], shape) for values in column]
    rows = [np.broadcast_to(values, shape) for values in (steps, targets)]
    return Table(*spread, *rows, force, hold, time, temperature, plan.poses)


def _temperature(kind: str, time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    flat = np.sort(time.ravel())
    walk = np.cumsum(rng.normal(0.0, 0.006, flat.size) * np.sqrt(np.diff(flat, prepend=flat[0]) / 15.0))
    slow = np.interp(time, flat, walk - walk.mean())
    start = rng.uniform(20.0, 21.2)
    if kind == "walk":
        return start + slow
    if kind == "tent":
        middle = 0.5 * (flat[0] + flat[-1])
        return start + 0.2 * slow + 3.0 * (1.0 - np.abs(time - middle) / (middle - flat[0]))
    period = 86400.0 if kind == "sine" else rng.uniform(1500.0, 3600.0)
    height = 0.9 if kind == "sine" else 0.45
    return start + 0.4 * slow + height * np.sin(2.0 * np.pi * time / period + rng.uniform(0.0, 2.0 * np.pi))
