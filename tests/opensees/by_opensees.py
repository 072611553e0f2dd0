"""A structure of `robot_file.py` in OpenSees: the compliance of its end, and how it sags under its own weight."""

import math

import numpy as np
import openseespy.opensees as ops

GRAVITY = 9.80665
# OpenSees ties nodes about global axes only: where a joint is rigid about an axis of its own it has these stiffnesses, N/m and N m/rad.
# What they give is taken off by a second solution with stiffnesses STIFFER times as large (Richardson's extrapolation).
RIGID = [1e11] * 3 + [1e10] * 3
STIFFER = 10.0


def groups(structure):
    """The first point of each rigid group by point."""
    group = {point: point for point in structure.places}
    tied = list(structure.rigid)
    tied += [spring.points for spring in structure.springs if all(math.isinf(k) for k in spring.stiffness)]
    for first, second in tied:
        a, b = group[first], group[second]
        group = {point: a if known == b else known for point, known in group.items()}
    return group


def build(structure, shear, stiffer):
    """The structure in OpenSees with rigid joints so much stiffer; tags of points, and of beams in their order."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 6)
    tags = {point: tag for tag, point in enumerate(structure.places, start=1)}
    for point, tag in tags.items():
        ops.node(tag, *map(float, structure.places[point]))
    group = groups(structure)
    held = {group[point] for point in structure.held}
    for point, first in group.items():
        if first in held:
            ops.fix(tags[point], *[1] * 6)
        elif point != first:
            ops.rigidLink("beam", tags[first], tags[point])
    element = 0
    for spring in structure.springs:
        if group[spring.points[0]] == group[spring.points[1]]:
            continue
        element += 1
        materials, directions = [], []
        for place, stiffness in enumerate(spring.stiffness):
            if stiffness > 0:
                materials.append(6 * element + place)
                directions.append(place + 1)
                ops.uniaxialMaterial("Elastic", materials[-1], stiffness if math.isfinite(stiffness) else stiffer * RIGID[place])
        ends = [tags[point] for point in spring.points]
        x, y = (map(float, spring.axes[:, column]) for column in (0, 1))
        ops.element("zeroLength", element, *ends, "-mat", *materials, "-dir", *directions, "-orient", *x, *y)
    beams = []
    for beam in structure.beams:
        element += 1
        beams.append(element)
        # OpenSees: local y = vecxz cross x.
        x, _, _ = local_axes(structure, beam)
        ops.geomTransf("Linear", element, *map(float, np.cross(x, beam.width)))
        ends = [tags[point] for point in beam.ends]
        s = beam.section
        if shear:
            areas = [coefficient * s.area for coefficient in s.shear]
            constants = [s.young, s.shear_modulus, s.area, s.j, s.iy, s.iz, *areas]
            ops.element("ElasticTimoshenkoBeam", element, *ends, *map(float, constants), element)
        else:
            ops.element("elasticBeamColumn", element, *ends, *map(float, (s.area, s.young, s.shear_modulus, s.j, s.iy, s.iz)), element)
    return tags, beams


def local_axes(structure, beam):
    first, second = (structure.places[point] for point in beam.ends)
    x = (second - first) / np.linalg.norm(second - first)
    y = beam.width - x * (beam.width @ x)
    y /= np.linalg.norm(y)
    return x, y, np.cross(x, y)


def solved(tag):
    """Motion of a node under the loads of the model."""
    ops.constraints("Transformation")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.algorithm("Linear")
    ops.integrator("LoadControl", 1.0)
    ops.analysis("Static", "-noWarnings")
    if ops.analyze(1) != 0:
        raise RuntimeError("OpenSees could not solve the structure")
    return np.array([ops.nodeDisp(tag, k + 1) for k in range(6)])


def of_rigid(found):
    """What `found(stiffer)` tends to as rigid joints become rigid."""
    return (STIFFER * found(STIFFER) - found(1.0)) / (STIFFER - 1.0)


def compliance(structure, loaded, shear=False):
    """6 x 6, of the point that is loaded."""

    def column(load):
        def found(stiffer):
            tags, _ = build(structure, shear, stiffer)
            ops.timeSeries("Constant", 1)
            ops.pattern("Plain", 1, 1)
            ops.load(tags[loaded], *map(float, load))
            return solved(tags[loaded])

        return of_rigid(found)

    return np.column_stack([column(load) for load in np.eye(6)])


def sag(structure, loaded, up):
    """Motion of the loaded point under the weight of all."""

    def found(stiffer):
        tags, beams = build(structure, False, stiffer)
        ops.timeSeries("Constant", 1)
        ops.pattern("Plain", 1, 1)
        for tag, beam in zip(beams, structure.beams):
            weight = -beam.section.kg_per_m * GRAVITY * up
            x, y, z = local_axes(structure, beam)
            ops.eleLoad("-ele", tag, "-type", "-beamUniform", *(float(weight @ one) for one in (y, z, x)))
        for point, kg, centre in structure.masses:
            force = -kg * GRAVITY * up
            ops.load(tags[point], *map(float, force), *map(float, np.cross(centre - structure.places[point], force)))
        return solved(tags[loaded])

    return of_rigid(found)


def mass(structure):
    """Of all, kg."""
    lengths = (np.linalg.norm(structure.places[first] - structure.places[second]) for first, second in (beam.ends for beam in structure.beams))
    beams = sum(beam.section.kg_per_m * length for beam, length in zip(structure.beams, lengths))
    return float(beams + sum(kg for _, kg, _ in structure.masses))
