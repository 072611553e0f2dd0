"""A bench with the set-up effects that the concealed benches lack, and a structure with all six freedoms of its end."""

from dataclasses import replace

import numpy as np

import shared  # noqa: F401
import openseespy.opensees as ops
from bench import Bench
from effects import Effect, joint_law
from laws import solve_twists
from structures import Model


class RealBench(Bench):
    """`Bench` with constant force, wrong scale of a gauge, and a leaning displacement gauge."""

    def with_beam(self, beam: dict) -> "RealBench":
        return RealBench(self.robot, self.mechanism, self.poses, beam, self.multipliers["link"], self.table)

    def forces(self, effects: list[Effect]) -> np.ndarray:
        vector = super().forces(effects)
        for effect in effects:
            p = effect.parameters
            if effect.physics == "gauge-scale" and effect.place["gauge"] == "force":
                vector = vector * (1.0 + p["scale"])
            if effect.physics == "constant-force":
                axis = "xyz".index(effect.place["direction"])
                here = (self.table.direction == axis) & (self.table.target != 0.0)
                vector = vector + np.where(here, p["w"], 0.0)[..., None] * np.eye(3)[axis]
        return vector

    def mechanics(self, effects: list[Effect]) -> np.ndarray:
        total = super().mechanics(effects)
        for effect in effects:
            if effect.physics == "gauge-misalignment":
                if any(joint_law(other) for other in effects):
                    raise ValueError("a leaning gauge beside a joint law is not modelled")
                a, b = ("xyz".index(effect.place[key]) for key in ("direction", "toward"))
                angle = effect.parameters["angle"]
                lean = np.sin(angle) * np.eye(3)[b] + (np.cos(angle) - 1.0) * np.eye(3)[a]
                compliance = self.compliances()[self.table.pose]
                more = np.einsum("k,rskl,rsl->rs", lean, compliance, self.forces(effects))
                total = total + np.where(self.table.direction == a, more, 0.0)
        return total

    def displacement(self, effects: list[Effect]) -> np.ndarray:
        total = super().displacement(effects)
        for effect in effects:
            if effect.physics == "gauge-scale" and effect.place["gauge"] == "displacement":
                total = total * (1.0 + effect.parameters["scale"])
        return total

    def at_forces(self, force: np.ndarray) -> "RealBench":
        """The same bench under other forces: with `table.rounded`, what a model computes from the record."""
        table = replace(self.table, force=force)
        return RealBench(self.robot, self.mechanism, self.poses, self.multipliers["beam"], self.multipliers["link"], table)

    def own_compliance(self) -> np.ndarray:
        """Compliance of the end along the load of each reading, m/N."""
        return self.compliances()[self.table.pose, self.table.direction, self.table.direction]

    def hinge(self, joint: str, law) -> np.ndarray:
        """Displacement that one joint adds when it follows `law`, in the manner of `laws.py`."""
        index = [self.actions[0].ids.index(joint)]
        pose, direction = self.table.pose[:, 0], self.table.direction[:, 0]
        lever = np.array([action.lever[index] for action in self.actions])[pose]
        stiffness = np.array([action.stiffness[np.ix_(index, index)] for action in self.actions])[pose]
        applied = np.einsum("rjk,rsk->rsj", lever, self.forces([]))
        twists = solve_twists([law], applied, stiffness)
        along = lever[np.arange(self.shape[0]), :, direction]
        return np.einsum("rj,rsj->rs", along, twists)

    def at_end_of(self, point: str) -> np.ndarray:
        """Position of a node in each pose, m, poses x 3."""
        robot = self.robot
        placed = [Model(robot, self.mechanism, pose, self.multipliers).placement for pose in self.poses]
        return np.array([np.array(one.node(point), dtype=float) for one in placed])

    def first_support(self) -> str:
        used = {node for element in self.robot.elements(self.mechanism) for node in element["nodes"]}
        return next(node for node in self.robot.data["support"]["fixed"] if node in used)

    def end_compliances(self) -> np.ndarray:
        """Compliance of the end in six freedoms, poses x 6 x 6; forces and translations first."""
        return np.array([end_compliance_6(self.robot, self.mechanism, pose, self.multipliers) for pose in self.poses])

    def bent_by(self, element_id: str, axis: str) -> np.ndarray:
        """Displacement of the end for one 1/m of stress-free curvature of an element, poses x 3."""
        moved = []
        for pose in self.poses:
            model = Model(self.robot, self.mechanism, pose, self.multipliers)
            element = next(e for e in model.elements if e["id"] == element_id)
            _, _, y, z = model.placement.element_axes(element)
            section = self.robot.data["sections"][element["section"]]
            inertia = section["I" + axis] * self.multipliers[element["class"]]["I" + axis]
            moment = self.robot.data["materials"][section["material"]]["E"] * inertia
            about = np.concatenate([np.zeros(3), moment * np.array(y if axis == "y" else z, dtype=float)])
            ends = [model.split.point_of[element_id, node] for node in element["nodes"]]
            model.solve([(ends[0], -about), (ends[1], about)])
            moved.append(model.end_displacement())
        return np.array(moved)


def end_compliance_6(robot, mechanism: str, pose: dict, multipliers: dict) -> np.ndarray:
    model = Model(robot, mechanism, pose, multipliers)
    columns = []
    for k in range(6):
        model.solve([(model.split.end, np.eye(6)[k])])
        columns.append([ops.nodeDisp(model.tag[model.split.end], dof + 1) for dof in range(6)])
        model.clear()
    return np.array(columns).T


def cross_matrix(vector: np.ndarray) -> np.ndarray:
    """Matrix that forms the cross product with a vector."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
