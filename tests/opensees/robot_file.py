"""Reader and kinematics of the robot format `stiffbench/robot/2`, written from docs/robot-file.md, and the structure that a file describes.

A structure holds points, each of one body in one pose. Points that nothing separates move as one rigid group; between the groups stand
beams and joints with springs. Nothing here comes from the toolkit.
"""

import math
import tomllib
from dataclasses import dataclass, field

import numpy as np

UNITS = {
    "m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "deg": 1.0, "rad": 180.0 / math.pi, "kg": 1.0, "g": 1e-3,
    "Nm_per_rad": 1.0, "kNm_per_rad": 1e3, "rad_per_Nm": 1.0, "urad_per_Nm": 1e-6,
    "N_per_m": 1.0, "N_per_mm": 1e3, "N_per_um": 1e6, "m_per_N": 1.0, "um_per_N": 1e-6,
    "Pa": 1.0, "GPa": 1e9, "m2": 1.0, "mm2": 1e-6, "m4": 1.0, "mm4": 1e-12, "kg_per_m3": 1.0, "kg_per_m": 1.0,
}  # fmt: skip
# E, G in Pa and density in kg/m3, as docs/robot-file.md lists them.
MATERIALS = {
    "steel": (210e9, 81e9, 7850.0),
    "aluminium": (70e9, 27e9, 2700.0),
    "titanium": (114e9, 44e9, 4430.0),
}
# Height, width, web, flange and fillet in mm, EN 10365.
I_SECTIONS = {"IPE 200": (200.0, 100.0, 5.6, 8.5, 12.0), "HEB 140": (140.0, 140.0, 7.0, 12.0, 12.0)}
# Sine of the angle to a beam below which an axis does not say how its section is turned.
PARALLEL = 0.02
SAME_PLACE_M = 1e-9


def quantity(row, key, otherwise=None):
    """The value of a key that may end in a unit, in SI; angles are degrees."""
    for name, value in row.items():
        unit = name[len(key) + 1 :]
        if name == key:
            return value
        if name.startswith(key + "_") and unit in UNITS:
            return np.multiply(value, UNITS[unit])
    return otherwise


def axis(given):
    """A unit vector from a word or a vector."""
    if isinstance(given, str):
        sign = -1.0 if given.startswith("-") else 1.0
        return sign * np.eye(3)["xyz".index(given[-1])]
    return np.array(given) / np.linalg.norm(given)


def turned(about, degrees):
    """Rotation matrix of a right-handed turn about an axis (Rodrigues)."""
    x, y, z = about
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = math.radians(degrees)
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


def roll_pitch_yaw(degrees):
    x, y, z = np.eye(3)
    return turned(z, degrees[2]) @ turned(y, degrees[1]) @ turned(x, degrees[0])


def i_section(h, b, tw, tf, r):
    """A, Iy, Iz of an I section: flanges, web, and four fillets by Gauss-Legendre integration over their angle, exact to rounding."""
    web = h / 2 - tf
    nodes, weights = np.polynomial.legendre.leggauss(40)
    angle = math.pi / 4 * (1 + nodes)
    # At an angle from the web a fillet is at the height z, and the section half as wide as `half`.
    z, half = web - r + r * np.sin(angle), tw / 2 + r - r * np.cos(angle)

    def of_fillet(f):
        return math.pi / 4 * float(weights @ (f(z, half) * r * np.cos(angle)))

    area = 2 * b * tf + 2 * tw * (web - r) + 4 * of_fillet(lambda z, half: half)
    iy = 2 * b * (tf**3 / 12 + tf * (h / 2 - tf / 2) ** 2) + tw * (2 * (web - r)) ** 3 / 12
    iy += 4 * of_fillet(lambda z, half: half * z * z)
    iz = 2 * tf * b**3 / 12 + 2 * (web - r) * tw**3 / 12 + 4 * of_fillet(lambda z, half: half**3 / 3)
    return area, iy, iz


@dataclass
class Section:
    """Constants of a beam in SI, and its shear areas over its area."""

    area: float
    iy: float
    iz: float
    j: float
    shear: tuple
    young: float = 0.0
    shear_modulus: float = 0.0
    kg_per_m: float = 0.0


def profile(text):
    """A section from a profile, dimensions in mm."""
    if text in I_SECTIONS:
        h, b, tw, tf, r = (1e-3 * size for size in I_SECTIONS[text])
        area, iy, iz = i_section(h, b, tw, tf, r)
        # Torsion as ArcelorMittal states it for rolled sections (Sections and merchant bars, notations and formulae).
        d = ((r + tw / 2) ** 2 + (r + tf) ** 2 - r * r) / (2 * r + tf)
        j = 2 / 3 * (b - 0.63 * tf) * tf**3 + (h - 2 * tf) * tw**3 / 3 + 2 * tw / tf * (0.145 + 0.1 * r / tf) * d**4
        return Section(area, iy, iz, j, (5 / 6 * 2 * b * tf / area, h * tw / area))
    word, sizes = text.split()
    sizes = [1e-3 * float(size) for size in sizes.split("x")]
    if word in ("round", "tube"):
        outer = sizes[0] / 2
        inner = outer - sizes[1] if word == "tube" else 0.0
        i = math.pi / 4 * (outer**4 - inner**4)
        return Section(math.pi * (outer**2 - inner**2), i, i, 2 * i, (0.5 if inner else 0.9,) * 2)
    h, b = sizes[:2]
    if word == "bar":
        # Torsion of a rectangle: Roark, 8th edition, table 10.7 case 4.
        a, c = max(h, b) / 2, min(h, b) / 2
        j = a * c**3 * (16 / 3 - 3.36 * c / a * (1 - (c / a) ** 4 / 12))
        return Section(h * b, b * h**3 / 12, h * b**3 / 12, j, (5 / 6,) * 2)
    t = sizes[2]
    area = 2 * t * (h + b - 2 * t)
    iy, iz = ((w * d**3 - (w - 2 * t) * (d - 2 * t) ** 3) / 12 for w, d in ((b, h), (h, b)))
    # Torsion of a thin closed wall (Bredt).
    enclosed, around = (h - t) * (b - t), 2 * (h - t + b - t)
    return Section(area, iy, iz, 4 * enclosed**2 * t / around, (2 * t * b / area, 2 * t * h / area))


@dataclass(frozen=True)
class Frame:
    """Where a body is: its origin and the axes of the file, as columns."""

    origin: np.ndarray
    axes: np.ndarray

    def point(self, at):
        return self.origin + self.axes @ at


@dataclass
class Beam:
    ends: tuple
    body: str
    section: Section
    # Direction of its local y.
    width: np.ndarray


@dataclass
class Springs:
    """Between two points in one place: stiffness along and about three axes, N/m and N m/rad; `inf` is rigid."""

    points: tuple
    axes: np.ndarray
    stiffness: list


@dataclass
class Structure:
    """Points are (body, name)."""

    places: dict = field(default_factory=dict)
    beams: list = field(default_factory=list)
    springs: list = field(default_factory=list)
    rigid: list = field(default_factory=list)
    held: list = field(default_factory=list)
    # (point that it hangs on, kg, centre of mass).
    masses: list = field(default_factory=list)


class RobotFile:
    """A robot file."""

    def __init__(self, text):
        self.data = tomllib.loads(text)
        self.joints = self.data["joints"]
        self.placing = {name: row for name, row in self.joints.items() if "point" not in row}
        self.carrier, before = {}, "base"
        for name, row in self.placing.items():
            self.carrier[name] = row.get("on", before)
            before = row.get("body", name)
        self.tool_body = self.data.get("tool", {}).get("on", before)
        # The joint that places a body.
        self.entry = {row.get("body", name): name for name, row in self.placing.items()}
        self.up = axis(self.data["up"])
        variables = dict.fromkeys(variable for joint in self.placing for variable in self.terms(joint))
        self.nominal = {variable: self.nominal_of(variable) for variable in variables}

    def poses(self):
        """Values of variables, degrees and m, by name, in each pose of the file; those that a pose leaves out are nominal."""
        found = {}
        for key, row in self.data.get("poses", {}).items():
            if isinstance(row, list):
                name, _, unit = key.rpartition("_")
                found[name] = dict(zip(self.nominal, np.multiply(row, UNITS[unit])))
            else:
                found[key] = {variable: quantity(row, variable, nominal) for variable, nominal in self.nominal.items()}
        return found

    def nominal_of(self, variable):
        row = self.joints.get(variable, {})
        low, high = quantity(row, "min", -math.inf), quantity(row, "max", math.inf)
        return quantity(row, "nominal", min(max(0.0, low), high))

    def terms(self, joint):
        angle = self.joints[joint].get("angle", {joint: 1.0})
        return {name: c for name, c in angle.items() if not name.startswith("offset")}

    def slides(self, joint):
        return self.joints[joint].get("kind") == "sliding"

    def stiffness(self, row):
        """Of a spring row; `inf` for a rigid one."""
        if row is None:
            return math.inf
        if row.get("spring") == "tied":
            return self.stiffness(self.joints[row["tied_to"].removeprefix("joint.").split(".")[0]])
        if row.get("spring") == "pinned":
            return 0.0
        stiffness, compliance = quantity(row, "stiffness"), quantity(row, "compliance")
        if stiffness is not None:
            return float(stiffness)
        return 1.0 / float(compliance) if compliance else math.inf

    def six(self, rows):
        return [self.stiffness(rows.get(name)) for name in ("x", "y", "z", "rx", "ry", "rz")]

    def section(self, text):
        """A section that a link names, with its material."""
        row = self.data.get("sections", {}).get(text)
        if row is None:
            words = text.split()
            named = words[-1] if words[-1].isalpha() and len(words) > 1 else None
            found, material, per_m = profile(" ".join(words[:-1] if named else words)), named or "steel", None
        else:
            constants = [quantity(row, key) for key in ("A", "Iy", "Iz", "J")]
            found = profile(row["profile"]) if "profile" in row else Section(*map(float, constants), (5 / 6,) * 2)
            material, per_m = row.get("material", "steel"), quantity(row, "mass")
        own = self.data.get("materials", {}).get(material)
        of_file = own and [quantity(own, key) for key in ("E", "G", "density")]
        found.young, found.shear_modulus, density = of_file or MATERIALS[material]
        found.kg_per_m = per_m if per_m is not None else (density or 0.0) * found.area
        return found


class Placed:
    """A robot in a pose."""

    def __init__(self, robot, values):
        self.robot, self.values = robot, values
        self.frames = {"base": Frame(np.zeros(3), np.eye(3))}

    def travel(self, joint):
        if self.values is None:
            return 0.0
        row = self.robot.joints[joint].get("angle", {})
        return quantity(row, "offset", 0.0) + sum(c * self.values[name] for name, c in self.robot.terms(joint).items())

    def row_of_dh(self, joint):
        """alpha, a, theta, d of a joint; `None` if it has no row."""
        values = [quantity(self.robot.joints[joint], key) for key in ("alpha", "a", "theta", "d")]
        return None if all(value is None for value in values) else [0.0 if value is None else value for value in values]

    def joint_frame(self, joint):
        """Where a joint is on the body that carries it and how its axes stand there, before it moves; and its axis in them."""
        row, on = self.robot.joints[joint], self.frame(self.robot.carrier[joint])
        of_dh, (x, _, z) = self.row_of_dh(joint), np.eye(3)
        if of_dh is None:
            axes = on.axes @ roll_pitch_yaw(quantity(row, "turn", np.zeros(3)))
            return Frame(on.point(quantity(row, "at", np.zeros(3))), axes), axis(row.get("axis", "z"))
        alpha, a, theta, d = of_dh
        axes, origin = on.axes, on.origin
        if self.robot.data["dh"] == "modified":
            axes, origin = on.axes @ turned(x, alpha), on.point(a * x)
            origin = origin if self.robot.slides(joint) else origin + d * axes @ z
        return Frame(origin, axes @ turned(z, theta) if self.robot.slides(joint) else axes), z

    def frame(self, body):
        if body not in self.frames:
            self.frames[body] = self.by_points(body) if body in self.robot.data.get("bodies", {}) else self.by_joint(self.robot.entry[body])
        return self.frames[body]

    def moved(self, joint):
        """The axes of a joint after it has moved; with all joints at zero no angle of a row is taken either."""
        (place, about), of_dh = self.joint_frame(joint), self.row_of_dh(joint) or [0.0] * 4
        if self.robot.slides(joint):
            return Frame(place.origin + (self.travel(joint) + of_dh[3]) * place.axes @ about, place.axes)
        theta = of_dh[2] if self.values is not None else 0.0
        return Frame(place.origin, place.axes @ turned(about, self.travel(joint) + theta))

    def by_joint(self, joint):
        """The body that a joint moves."""
        moved, of_dh = self.moved(joint), self.row_of_dh(joint)
        if of_dh is None or self.robot.data["dh"] == "modified":
            return moved
        alpha, a, _, d = of_dh
        x, _, z = np.eye(3)
        return Frame(moved.point(a * x + (0.0 if self.robot.slides(joint) else d) * z), moved.axes @ turned(x, alpha))

    def by_points(self, body):
        row = self.robot.data["bodies"][body]
        first, second = (self.point(name) for name in row["along"])
        z = (second - first) / np.linalg.norm(second - first)
        x = self.normal(row["plane"])
        return Frame(first, np.column_stack([x, np.cross(z, x), z]))

    def normal(self, plane):
        row = self.robot.data["planes"][plane]
        return self.frame(row.get("on", "base")).axes @ axis(row["normal"])

    def point(self, name):
        """A point of the file, of a joint or of the tool in the world, m."""
        if name == "base":
            return np.zeros(3)
        if name == "tool":
            return self.frame(self.robot.tool_body).point(quantity(self.robot.data.get("tool", {}), "at", np.zeros(3)))
        if name in self.robot.joints:
            if "point" in self.robot.joints[name]:
                return self.point(self.robot.joints[name]["point"])
            if self.robot.joints[name].get("bearing") == "moving":
                return self.moved(name).origin
            return self.joint_frame(name)[0].origin
        row = self.robot.data["points"][name]
        if "centres" not in row:
            return self.frame(row.get("on", "base")).point(quantity(row, "at", np.zeros(3)))
        first, second = (self.point(centre) for centre in row["centres"])
        r1, r2 = quantity(row, "radii")
        gap = np.linalg.norm(second - first)
        u = (second - first) / gap
        along = (gap**2 + r1**2 - r2**2) / (2 * gap)
        return first + along * u + row["side"] * math.sqrt(r1**2 - along**2) * np.cross(self.normal(row["plane"]), u)

    def carried_axes(self, body, at_zero):
        """The axes of the world where all joints are at zero, carried along by a body; of a body along points its own."""
        if body in self.robot.data.get("bodies", {}):
            return self.frame(body).axes
        return self.frame(body).axes @ at_zero.frame(body).axes.T


def axes_of_joint(about, carried):
    """Axes of a joint: its own, and across it the axes of `carried` after that nearest to it, made perpendicular."""
    nearest = np.argmax(np.abs(carried.T @ about))
    y = carried[:, (nearest + 1) % 3]
    y = y - about * (y @ about)
    y /= np.linalg.norm(y)
    return np.column_stack([about, y, np.cross(about, y)])


def structure(robot, values):
    """The structure of a robot in a pose, and the point where loads act."""
    placed, at_zero, data = Placed(robot, values), Placed(robot, None), robot.data
    made = Structure()
    tool = data.get("tool", {})
    tool_springs = robot.six(tool.get("springs", {}))
    is_sprung = any(math.isfinite(k) for k in tool_springs)
    links = data.get("links", {})
    # The points of each body: name and place. Springs of a tool stand between its mount and its centre.
    points = {body: {} for body in ["base", *robot.entry, *data.get("bodies", {})]}
    held = data.get("base", {}).get("fixed", ["base"])

    def put(body, name, place=None):
        points[body].setdefault(name, placed.point(name) if place is None else place)

    for name in held:
        put("base", name)
    for name, row in robot.joints.items():
        if "point" in row:
            for body in (row["on"], row["body"]):
                put(body, row["point"])
            continue
        for body in (robot.carrier[name], row.get("body", name)):
            put(body, name)
    end = "tool"
    if is_sprung:
        end = "tool.mount"
        has_beam = data["joints"].get(robot.entry.get(robot.tool_body), {}).get("link", "rigid") != "rigid"
        behind = has_beam or any("tool" in row["between"] for row in links.values())
        put(robot.tool_body, end, placed.point("tool") if behind else placed.frame(robot.tool_body).origin)
    else:
        put(robot.tool_body, "tool")
    for name, row in data.get("bodies", {}).items():
        for point in row["along"]:
            put(name, point)
    beams_of = {body: [] for body in points}
    for name, row in links.items():
        ends = [end if point == "tool" else point for point in row["between"]]
        on = row.get("on")
        for point in row["between"]:
            # A point of the file lies on its body.
            own = data.get("points", {}).get(point, {})
            if "centres" not in own and point in data.get("points", {}):
                put(own.get("on", "base"), point)
        if on is None:
            on, *more = [body for body, known in points.items() if all(point in known for point in ends)]
            assert not more, f"{name} lies on several bodies"
        beams_of[on].append((ends, row))

    for body, known in points.items():
        for name, place in known.items():
            made.places[body, name] = place
        connect(placed, at_zero, made, body, beams_of[body])

    for name, row in robot.joints.items():
        if "point" in row:
            on, body, at = row["on"], row["body"], row["point"]
            about = placed.normal(row["plane"])
            carried = placed.carried_axes(data["planes"][row["plane"]].get("on", "base"), at_zero)
            is_pin = all(quantity(row, key) is None for key in ("spring", "stiffness", "compliance"))
            own = 0.0 if is_pin else robot.stiffness(row)
        else:
            on, body, at = robot.carrier[name], row.get("body", name), name
            place, own_axis = placed.joint_frame(name)
            about, carried, own = place.axes @ own_axis, placed.carried_axes(on, at_zero), robot.stiffness(row)
        about_axes = [robot.stiffness(row.get("across", {}).get(name)) for name in "xyz"]
        along = [math.inf] * 3
        if robot.slides(name):
            along[0] = own
        else:
            about_axes[0] = own
        made.springs.append(Springs(((on, at), (body, at)), axes_of_joint(about, carried), along + about_axes))
    base = robot.six(data.get("base", {}).get("springs", {}))
    ground = ("ground", "ground")
    made.places[ground] = made.places["base", held[0]]
    made.held = [ground]
    made.springs.append(Springs((ground, ("base", held[0])), np.eye(3), base))
    made.rigid += [(("base", held[0]), ("base", name)) for name in held[1:]]
    tool_axes = placed.frame(robot.tool_body).axes @ roll_pitch_yaw(quantity(tool, "turn", np.zeros(3)))
    loaded = (robot.tool_body, end)
    if is_sprung:
        loaded = ("tool", "tool")
        made.places["tool", "mount"], made.places[loaded] = made.places[robot.tool_body, end], placed.point("tool")
        made.springs.append(Springs(((robot.tool_body, end), ("tool", "mount")), tool_axes, tool_springs))
        made.rigid.append((("tool", "mount"), loaded))
    for row in data.get("masses", {}).values():
        centre = placed.frame(row["on"]).point(quantity(row, "at", np.zeros(3)))
        # A mass hangs on the nearest point that is fixed on its body; the bearing of a slide that runs along the body is not.
        known = points[row["on"]]
        fixed = [name for name in known if is_fixed(robot, row["on"], name)]
        fixed = fixed or [robot.entry.get(row["on"], next(iter(known)))]
        nearest = min(fixed, key=lambda name: np.linalg.norm(known[name] - centre))
        made.masses.append(((row["on"], nearest), quantity(row, "mass"), centre))
    if "payload" in tool:
        centre = placed.point("tool") + tool_axes @ quantity(tool["payload"], "at", np.zeros(3))
        made.masses.append((loaded, quantity(tool["payload"], "mass"), centre))
    return made, loaded


def is_fixed(robot, body, name):
    """Whether a point of a body keeps its place on it in every pose, by the file."""
    if name in robot.placing:
        # A bearing is fixed on the body that carries it, one that moves on the other.
        moves_with = robot.joints[name].get("bearing") == "moving"
        return not robot.slides(name) or moves_with == (robot.entry.get(body) == name)
    point = robot.data.get("points", {}).get(name)
    if point is not None:
        along = robot.data.get("bodies", {}).get(body, {"along": [None]})["along"]
        on = None if "centres" in point else point.get("on", "base")
        return on == body or name == along[0]
    return name != "base" or body == "base"


def connect(placed, at_zero, made, body, links):
    """Beams between the points of a body, rigid links where no beam leads."""
    robot, entry = placed.robot, placed.robot.entry.get(body)
    names = [name for of, name in made.places if of == body]
    names.sort(key=lambda name: name != entry)
    group = {name: name for name in names}

    def join(first, second):
        a, b = group[first], group[second]
        for name, known in group.items():
            group[name] = a if known == b else known

    carried = placed.carried_axes(body, at_zero)

    def beam(ends, section, width):
        made.beams.append(Beam(tuple((body, name) for name in ends), body, section, width))
        join(*ends)

    def across(ends):
        """The width of a beam without one: the axis of the joint that moves its body or of one that it carries, else an axis of the world."""
        if body in robot.data.get("bodies", {}):
            return placed.normal(robot.data["bodies"][body]["plane"])
        span = made.places[body, ends[1]] - made.places[body, ends[0]]
        joints = [entry] if entry else []
        joints += [name for name in robot.placing if robot.carrier[name] == body and name in ends]
        axes = [place.axes @ own for place, own in map(placed.joint_frame, joints)]
        axes += list(carried.T)
        return next(one for one in axes if np.linalg.norm(np.cross(one, span)) > PARALLEL * np.linalg.norm(span))

    for ends, row in links:
        if "section" not in row:
            made.rigid.append(tuple((body, name) for name in ends))
            join(*ends)
        else:
            if "width" in row:
                width = placed.frame(body).axes @ axis(row["width"])
            else:
                width = placed.normal(row["plane"]) if "plane" in row else across(ends)
            beam(ends, robot.section(row["section"]), width)
    if body == "base":
        held = robot.data.get("base", {}).get("fixed", ["base"])
        for name in held[1:]:
            join(held[0], name)
    # Points in one place are one.
    for place, second in enumerate(names):
        for first in names[:place]:
            apart = np.linalg.norm(made.places[body, first] - made.places[body, second])
            if apart <= SAME_PLACE_M and group[first] != group[second]:
                made.rigid.append(((body, first), (body, second)))
                join(first, second)
    link = robot.joints[entry].get("link", "rigid") if entry else "rigid"
    for name in names[1:]:
        if group[name] == group[names[0]]:
            continue
        if link != "rigid":
            ends = (names[0], name)
            beam(ends, robot.section(link), across(ends))
        else:
            made.rigid.append(((body, names[0]), (body, name)))
            join(names[0], name)
