"""The robot's beams in OpenSees: end compliance, and what each joint sees and moves.

The reader of the robot file and the kinematics are those of `fixtures/opensees`; every number of the
mechanics below comes out of an OpenSees solution.
"""

import os
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import openseespy.opensees as ops

ROOT = Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "fixtures" / "opensees"))

import linkage
from linkage import Placement, Robot, cross

DIRECTIONS = ("x", "y", "z")
PROPERTIES = ("A", "Iy", "Iz", "J")
# Rotational spring that stands in each joint while its law is condensed, N m/rad; the result does not
# depend on it, rounding does.
PLACEHOLDER = 1.0e5


@dataclass(frozen=True)
class Changes:
    """What differs from the robot file: a member that carries nothing, extra members, a rocking base."""

    loose: str | None = None
    braces: tuple[tuple[str, str, float], ...] = ()  # two nodes, area in m2
    base: tuple[str, float] | None = None  # axis, rad/(N m)


@dataclass
class Split:
    """The joints of a mechanism and the element ends that turn on them."""

    joints: list[dict]
    point_of: dict[tuple[str, str], str]  # (element, node) -> point
    nodes: list[str]
    end: str
    fixed: list[str] = field(default_factory=list)


def present_nodes(robot: Robot, elements: list[dict]) -> list[str]:
    used = {node for element in elements for node in element["nodes"]}
    return [node for node in robot.data["nodes"] if node in used]


def joints_of(robot: Robot, mechanism: str, elements: list[dict] | None = None) -> list[dict]:
    """The joints that exist in a mechanism: both bodies have an element end there, or it is a support."""
    elements = robot.elements(mechanism) if elements is None else elements
    bodies: dict[str, set[str]] = {}
    for element in elements:
        for node in element["nodes"]:
            bodies.setdefault(node, set()).add(element["body"])
    supports = set(robot.data["support"]["fixed"])
    found = []
    for joint in robot.data["joints"]:
        there = bodies.get(joint["node"], set())
        both = set(joint["bodies"]) <= there
        on_support = joint["node"] in supports and joint["bodies"][1] in there
        if both or on_support:
            found.append(joint)
    return found


def split(robot: Robot, elements: list[dict], joints: list[dict]) -> Split:
    """Give the element ends of each joint's second body a point of their own."""
    nodes = present_nodes(robot, elements)
    point_of = {(element["id"], node): node for element in elements for node in element["nodes"]}
    end = robot.end_node
    for joint in joints:
        moved = [
            (element["id"], joint["node"])
            for element in elements
            if joint["node"] in element["nodes"] and element["body"] == joint["bodies"][1]
        ]
        for key in moved:
            if point_of[key] != joint["node"]:
                raise ValueError(f"joints {point_of[key]} and {joint['id']} turn the same body")
            point_of[key] = f"joint {joint['id']}"
        if joint["node"] == robot.end_node:
            end = f"joint {joint['id']}"
    fixed = [node for node in robot.data["support"]["fixed"] if node in nodes]
    return Split(joints, point_of, nodes, end, fixed)


def frame(placement: Placement, joints: list[dict]) -> np.ndarray:
    """Axes (rows) in which every joint turns about the first or the second of them."""
    normals: list[np.ndarray] = []
    for joint in joints:
        normal = np.array(placement.normal(joint["axis"]), dtype=float)
        if not any(abs(abs(normal @ known) - 1.0) < 1e-12 for known in normals):
            normals.append(normal)
    if not normals or all(max(abs(normal)) > 1.0 - 1e-14 for normal in normals):
        return np.eye(3)
    if len(normals) == 1:
        helper = np.eye(3)[int(np.argmin(abs(normals[0])))]
        normals.append(np.cross(normals[0], helper) / np.linalg.norm(np.cross(normals[0], helper)))
    if len(normals) > 2 or abs(normals[0] @ normals[1]) > 1e-12:
        raise ValueError("the joints' axes do not fit one orthogonal frame")
    return np.array([normals[0], normals[1], np.cross(normals[0], normals[1])])


def placeholder(tag: int) -> None:
    """The material of a joint whose law is condensed."""
    ops.uniaxialMaterial("Elastic", tag, PLACEHOLDER)


class Model:
    """One OpenSees model of a mechanism in one pose."""

    def __init__(
        self,
        robot: Robot,
        mechanism: str,
        pose: dict[str, float],
        multipliers: dict[str, dict[str, float]],
        joints: list[dict] = (),
        materials: dict[str, Callable[[int], None]] | None = None,
        changes: Changes = Changes(),
    ) -> None:
        self.robot, self.joints = robot, list(joints)
        self.placement = Placement(robot, robot.pose_variables(pose))
        self.elements = [e for e in robot.elements(mechanism) if e["id"] != changes.loose]
        self.split = split(robot, self.elements, self.joints)
        self.axes = frame(self.placement, self.joints)
        self._build(multipliers, materials or {}, changes)

    def _at(self, node: str) -> list[float]:
        return list(self.axes @ np.array(self.placement.node(node), dtype=float))

    def _build(self, multipliers: dict, materials: dict, changes: Changes) -> None:
        ops.wipe()
        ops.model("basic", "-ndm", 3, "-ndf", 6)
        self.tag: dict[str, int] = {}
        for node in self.split.nodes:
            self._node(node, node)
        for node in [] if changes.base else self.split.fixed:
            ops.fix(self.tag[node], 1, 1, 1, 1, 1, 1)
        self.constrained = bool(self.joints) or changes.base is not None
        self.axis_of: dict[str, tuple[str, str, int, float]] = {}
        for number, joint in enumerate(self.joints, start=1):
            self._joint(number, joint, materials.get(joint["id"], placeholder))
        if changes.base:
            self._rocking_base(*changes.base)
        self._members(multipliers, changes)

    def _node(self, name: str, at: str) -> None:
        self.tag[name] = len(self.tag) + 1
        ops.node(self.tag[name], *self._at(at))

    def _joint(self, number: int, joint: dict, material: Callable[[int], None]) -> None:
        point, node = f"joint {joint['id']}", joint["node"]
        self._node(point, node)
        normal = self.axes @ np.array(self.placement.normal(joint["axis"]), dtype=float)
        axis = int(np.argmax(abs(normal)))
        if abs(abs(normal[axis]) - 1.0) > 1e-12:
            raise ValueError(f"joint {joint['id']} does not turn about an axis of the model")
        shared = [k for k in range(6) if k != 3 + axis]
        if node in self.split.fixed:
            ops.fix(self.tag[point], *(int(k in shared) for k in range(6)))
        else:
            ops.equalDOF(self.tag[node], self.tag[point], *(k + 1 for k in shared))
        material(number)
        ops.element("zeroLength", 1000 + number, self.tag[node], self.tag[point], "-mat", number, "-dir", 4 + axis)
        self.axis_of[joint["id"]] = (node, point, 3 + axis, float(np.sign(normal[axis])))

    def _rocking_base(self, axis: str, compliance: float) -> None:
        """All supports hang on one rigid body that turns about `axis` through the first of them."""
        if self.joints:
            raise ValueError("the base rocks in a model of its own: it leaves the inner forces as they are")
        turning = 3 + DIRECTIONS.index(axis)
        first = self.split.fixed[0]
        self._node("ground", first)
        self._node("base", first)
        ops.fix(self.tag["ground"], 1, 1, 1, 1, 1, 1)
        ops.fix(self.tag["base"], *(int(k != turning) for k in range(6)))
        ops.uniaxialMaterial("Elastic", 900, 1.0 / compliance)
        ops.element("zeroLength", 1900, self.tag["ground"], self.tag["base"], "-mat", 900, "-dir", turning + 1)
        for node in self.split.fixed:
            ops.rigidLink("beam", self.tag["base"], self.tag[node])

    def _members(self, multipliers: dict, changes: Changes) -> None:
        for tag, element in enumerate(self.elements, start=1):
            _, x, y, _ = self.placement.element_axes(element)
            ops.geomTransf("Linear", tag, *(self.axes @ np.array(cross(x, y), dtype=float)))
            ends = [self.tag[self.split.point_of[element["id"], node]] for node in element["nodes"]]
            section = self.robot.data["sections"][element["section"]]
            material = self.robot.data["materials"][section["material"]]
            a, iy, iz, j = (section[name] * multipliers[element["class"]][name] for name in PROPERTIES)
            ops.element("elasticBeamColumn", tag, *ends, a, material["E"], material["G"], j, iy, iz, tag)
        for number, (first, second, area) in enumerate(changes.braces, start=1):
            ops.uniaxialMaterial("Elastic", 950 + number, 2.0e11)
            ops.element("truss", 1950 + number, self.tag[first], self.tag[second], area, 950 + number)

    def solve(self, loads: list[tuple[str, np.ndarray]]) -> None:
        """Solve for loads on points (six components each, in the model's axes)."""
        ops.timeSeries("Constant", 1)
        ops.pattern("Plain", 1, 1)
        for point, load in loads:
            ops.load(self.tag[point], *map(float, load))
        ops.constraints("Transformation" if self.constrained else "Plain")
        ops.numberer("RCM")
        ops.system("BandGeneral")
        ops.algorithm("Linear")
        ops.integrator("LoadControl", 1.0)
        ops.analysis("Static", "-noWarnings")
        if ops.analyze(1) != 0:
            raise RuntimeError("OpenSees could not solve the structure")

    def clear(self) -> None:
        """Take the loads away again; the next solution starts from the unloaded structure."""
        ops.wipeAnalysis()
        ops.remove("loadPattern", 1)
        ops.remove("timeSeries", 1)
        ops.reset()

    def end_displacement(self) -> np.ndarray:
        """Translation of the end, ground axes."""
        local = [ops.nodeDisp(self.tag[self.split.end], k + 1) for k in range(3)]
        return self.axes.T @ np.array(local)

    def twist(self, joint: str) -> float:
        node, point, dof, sign = self.axis_of[joint]
        return sign * (ops.nodeDisp(self.tag[point], dof + 1) - ops.nodeDisp(self.tag[node], dof + 1))

    def force(self, vector: np.ndarray) -> list[tuple[str, np.ndarray]]:
        return [(self.split.end, np.concatenate([self.axes @ vector, np.zeros(3)]))]

    def moment_pair(self, joint: str) -> list[tuple[str, np.ndarray]]:
        """A unit moment that opens the joint: on the second body, and its opposite on the rest."""
        node, point, dof, sign = self.axis_of[joint]
        load = np.zeros(6)
        load[dof] = sign
        return [(point, load)] if node in self.split.fixed else [(point, load), (node, -load)]


def end_compliance(robot, mechanism, pose, multipliers, changes: Changes = Changes()) -> np.ndarray:
    """3 x 3 translational compliance of the end, rigid joints, m/N."""
    model = Model(robot, mechanism, pose, multipliers, changes=changes)
    columns = []
    for k in range(3):
        model.solve(model.force(np.eye(3)[k]))
        columns.append(model.end_displacement())
        model.clear()
    return np.array(columns).T


@dataclass(frozen=True)
class JointAction:
    """Joints of one pose, the structure between them condensed.

    With force F at the end and twists t in the joints: moments = lever F - stiffness t, and the end
    moves by compliance F + lever^T t.
    """

    ids: tuple[str, ...]
    lever: np.ndarray  # joints x 3, N m per N
    stiffness: np.ndarray  # joints x joints, N m/rad


def joint_action(robot, mechanism, pose, multipliers, ids=None, changes: Changes = Changes()) -> JointAction:
    """Condense the structure to its joints: unit forces, and a unit moment pair in each joint."""
    elements = [e for e in robot.elements(mechanism) if e["id"] != changes.loose]
    joints = [j for j in joints_of(robot, mechanism, elements) if ids is None or j["id"] in ids]
    model = Model(robot, mechanism, pose, multipliers, joints, changes=changes)
    names = [joint["id"] for joint in joints]
    twists, ends = [], []
    for load in [model.force(np.eye(3)[k]) for k in range(3)] + [model.moment_pair(name) for name in names]:
        model.solve(load)
        twists.append([model.twist(name) for name in names])
        ends.append(model.end_displacement())
        model.clear()
    a, b = np.array(twists[:3]).T, np.array(twists[3:]).T
    inverse = np.linalg.inv(b)
    stiffness = inverse - PLACEHOLDER * np.eye(len(names))
    return JointAction(tuple(names), inverse @ a, 0.5 * (stiffness + stiffness.T))
