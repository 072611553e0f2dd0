"""A virtual bench without noise: robot, mechanism, factors, plan and effects to displacements."""

from functools import cached_property

import numpy as np

import structures
from effects import Effect, joint_law
from laws import solve_twists
from plan import Table
from structures import PROPERTIES, Changes, Robot

STEP = 1e-4  # of ln factor in the derivatives


class Bench:
    """Displacements of one session for given factors; positions and forces in SI."""

    def __init__(self, robot: Robot, mechanism: str, poses: list[dict], beam: dict, link: dict, table: Table) -> None:
        self.robot, self.mechanism, self.poses, self.table = robot, mechanism, poses, table
        self.multipliers = {"beam": dict(beam), "link": dict(link)}
        self.shape = table.force.shape
        self._compliances: dict = {}

    def with_beam(self, beam: dict) -> "Bench":
        return Bench(self.robot, self.mechanism, self.poses, beam, self.multipliers["link"], self.table)

    def compliances(self, changes: Changes = Changes()) -> np.ndarray:
        """End compliance in every pose."""
        if changes not in self._compliances:
            self._compliances[changes] = np.array([
                structures.end_compliance(self.robot, self.mechanism, pose, self.multipliers, changes)
                for pose in self.poses
            ])
        return self._compliances[changes]

    @cached_property
    def actions(self) -> list[structures.JointAction]:
        return self.joint_actions(Changes())

    def joint_actions(self, changes: Changes, ids: tuple[str, ...] | None = None) -> list[structures.JointAction]:
        return [
            structures.joint_action(self.robot, self.mechanism, pose, self.multipliers, ids, changes)
            for pose in self.poses
        ]

    @cached_property
    def base_patterns(self) -> dict[str, np.ndarray]:
        """Displacement per force and per rad/(N m) of the rocking base, for each axis."""
        patterns = {}
        for axis in ("x", "z"):
            rocking = self.compliances(Changes(base=(axis, 1e-5)))
            patterns[axis] = (rocking - self.compliances()) / 1e-5
        return patterns

    def forces(self, effects: list[Effect]) -> np.ndarray:
        """Force vectors that act on the end, runs x steps x 3."""
        force = self.table.force
        for effect in effects:
            if effect.physics == "force-gauge-nonlinearity":
                force = force * (1.0 + effect.parameters["q"] * np.abs(force))
        vector = np.eye(3)[self.table.direction]
        for effect in effects:
            if effect.physics == "load-misalignment":
                a, b = ("xyz".index(effect.place[key]) for key in ("direction", "toward"))
                angle = effect.parameters["angle"]
                turned = np.cos(angle) * np.eye(3)[a] + np.sin(angle) * np.eye(3)[b]
                vector = np.where((self.table.direction == a)[..., None], turned, vector)
        return force[..., None] * vector

    def mechanics(self, effects: list[Effect]) -> np.ndarray:
        """Displacement of the robot itself, m."""
        changes = Changes(
            loose=next((e.place["element"] for e in effects if e.physics == "loose-member"), None),
            braces=tuple((*e.place["between"], e.parameters["area"]) for e in effects if e.physics == "brace"),
        )
        force = self.forces(effects)
        compliance = self.compliances(changes)
        for effect in effects:
            if effect.physics == "base-compliance":
                compliance = compliance + effect.parameters["c"] * self.base_patterns[effect.place["axis"]]
        rows = compliance[self.table.pose, self.table.direction]
        total = np.einsum("rsk,rsk->rs", rows, force)
        jointed = [effect for effect in effects if joint_law(effect)]
        return total + self._joints(jointed, force, changes) if jointed else total

    def _joints(self, effects: list[Effect], force: np.ndarray, changes: Changes) -> np.ndarray:
        actions = self.actions if changes == Changes() else self.joint_actions(changes)
        index = [actions[0].ids.index(effect.place["joint"]) for effect in effects]
        lever = np.array([action.lever[index] for action in actions])[self.table.pose[:, 0]]
        stiffness = np.array([action.stiffness[np.ix_(index, index)] for action in actions])[self.table.pose[:, 0]]
        applied = np.einsum("rjk,rsk->rsj", lever, force)
        twists = solve_twists([joint_law(effect) for effect in effects], applied, stiffness)
        along = lever[np.arange(self.shape[0]), :, self.table.direction[:, 0]]
        return np.einsum("rj,rsj->rs", along, twists)

    def applied_moments(self, joint: str) -> np.ndarray:
        """Moment that each reading's force puts on a rigid joint, N m."""
        index = self.actions[0].ids.index(joint)
        lever = np.array([action.lever[index] for action in self.actions])
        return lever[self.table.pose, self.table.direction] * self.table.force

    def displacement(self, effects: list[Effect]) -> np.ndarray:
        """What the gauge shows without zero offset and noise, m; order of composition as in the contract."""
        table, total = self.table, self.mechanics(effects)
        growth = np.ones(self.shape)
        for effect in effects:
            p = effect.parameters
            match effect.physics:
                case "creep":
                    growth = growth + p["k"] * np.log10(1.0 + table.hold / p["t0"])
                case "load-dependent-creep":
                    share = (np.abs(table.force) / 70.0) ** 2
                    growth = growth + p["k"] * share * np.log10(1.0 + table.hold / p["t0"])
                case "setting-in":
                    growth = growth + p["k"] * np.exp(-(table.repeat - 1) / p["decay"])
        total = total * growth
        for effect in effects:
            total = total + self._beside(effect)
        for effect in effects:
            total = total + self._gauge(effect, total)
        return total

    def _beside(self, effect: Effect) -> np.ndarray | float:
        """Stand, drift and slip."""
        table, p = self.table, effect.parameters
        match effect.physics:
            case "gauge-stand-compliance":
                here = table.direction == "xyz".index(effect.place["direction"])
                return np.where(here, p["c"] * self.forces([])[..., :].sum(axis=-1), 0.0)
            case "thermal-drift":
                clock = table.temperature if p.get("per_kelvin") else table.time
                return p["rate"] * (clock - clock[:, :1])
            case "quadratic-drift":
                moved = table.time - table.time**2 / (2.0 * p["turn"])
                return p["rate"] * (moved - moved[:, :1])
            case "slip":
                run = effect.place["run"]
                there = (
                    (table.pose == table.names.index(run["pose"]))
                    & (table.direction == "xyz".index(run["direction"]))
                    & (table.repeat == run["repeat"])
                )
                return np.where(there & (table.step >= effect.place["step"]), p["jump"], 0.0)
        return 0.0

    def _gauge(self, effect: Effect, total: np.ndarray) -> np.ndarray | float:
        p = effect.parameters
        if effect.physics == "gauge-periodic":
            return p["amplitude"] * np.sin(2.0 * np.pi * total / p["period"] + p["phase"])
        if effect.physics == "gauge-two-harmonics":
            turn = 2.0 * np.pi * total / p["period"]
            return p["amplitude"] * (np.sin(turn) + 0.8 * np.sin(2.0 * turn + 1.9 * self.table.pose))
        return 0.0

    @cached_property
    def factor_columns(self) -> np.ndarray:
        """Derivative of the displacements by ln of each free beam factor, readings x 4."""
        columns = []
        for name in PROPERTIES:
            sides = []
            for sign in (1.0, -1.0):
                beam = dict(self.multipliers["beam"])
                beam[name] *= np.exp(sign * STEP)
                sides.append(self.with_beam(beam).mechanics([]))
            columns.append(((sides[0] - sides[1]) / (2.0 * STEP)).ravel())
        return np.array(columns).T
