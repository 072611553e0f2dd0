"""Robot files of random robots: chains of hinges and slides with springs along, about and across their axes, beams and rigid links, posts of
two beams, coupled joints, tied springs, branches that turn or slide, rows of Denavit and Hartenberg, point masses, a payload and yielding
bases. The same seed gives the same robot."""

import random

SECTIONS = ["box 120x80x5 aluminium", "tube 90x6", "round 60 titanium", "IPE 200", "bar 80x40 aluminium"]


def listed(values):
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"


def random_robot(seed):
    """Text of a robot file. Every third robot has joints in the axes of the world, every fifth gives its beams no mass. From number 40 on
    every fourth has rows of Denavit and Hartenberg, the others have posts, and slides yield across and follow hinges."""
    rng, more = random.Random(seed), random.Random(f"more of {seed}")
    is_early = seed < 40
    dh = more.choice(["standard", "modified"]) if seed % 4 == 1 and not is_early else None
    is_straight = seed % 3 == 0
    up = rng.choice("yz")
    count = rng.randint(2, 6)
    joints, masses, pose = [], [], []

    def place(least, most):
        values = [rng.uniform(-150, 150), rng.uniform(-150, 150), rng.uniform(least, most)]
        return [round(value, 1) for value in values]

    def axis():
        if is_straight:
            return f'"{rng.choice(["x", "y", "z", "-x", "-y"])}"'
        return listed(round(rng.uniform(-1, 1), 3) or 0.5 for _ in range(3))

    hinges, beams = [], 0
    for number in range(1, count + 1):
        name = f"J{number}"
        slides = rng.random() < 0.25
        keys = [f"at_mm = {listed(place(150, 500))}", f"axis = {axis()}"]
        if dh:
            keys = [f"alpha_deg = {90 * more.randint(-1, 1)}", f"a_mm = {more.randint(100, 400)}"]
            keys += [f"theta_deg = {more.randint(-60, 60)}", f"d_mm = {more.randint(50, 400)}"]
        if slides:
            bearing = rng.choice(["fixed", "moving"])
            keys += ['kind = "sliding"', f'bearing = "{bearing}"', "min_mm = 0", "max_mm = 400"]
            keys.append(f"stiffness_N_per_um = {rng.uniform(5, 100):.2f}")
            if not is_early:
                keys.append(f"across = {{ {', '.join(f'{one} = {{ stiffness_Nm_per_rad = {more.uniform(2e5, 2e6):.4g} }}' for one in 'xyz')} }}")
            if hinges and not is_early:
                keys.append(f"angle = {{ {hinges[0]} = {more.choice([5e-4, -5e-4])}, {name} = 1 }}")
        else:
            keys += ["min_deg = -120", "max_deg = 120"]
            if hinges and rng.random() < 0.25:
                keys.append(f'spring = "tied", tied_to = "joint.{rng.choice(hinges)}"')
            else:
                keys.append(f"stiffness_Nm_per_rad = {10 ** rng.uniform(4.5, 6):.4g}")
                hinges.append(name)
            if rng.random() < 0.3:
                keys.append(f"across = {{ y = {{ stiffness_Nm_per_rad = 2e6 }}, z = {{ stiffness_Nm_per_rad = {rng.uniform(1e6, 4e6):.4g} }} }}")
            if len(hinges) > 1 and rng.random() < 0.3:
                keys.append(f"angle = {{ {hinges[0]} = -1, {name} = 1, offset_deg = {rng.randint(-30, 30)} }}")
        if not is_straight and rng.random() < 0.4 and not dh:
            keys.append(f"turn_deg = {listed(rng.randint(-90, 90) for _ in range(3))}")
        if rng.random() < 0.5:
            beams += 1
            section = "light" if seed % 5 == 0 else rng.choice(SECTIONS)
            keys.append(f'link = "{section}"')
        joints.append(f"{name} = {{ {', '.join(keys)} }}")
        pose.append(f"{name}_mm = {rng.randint(20, 380)}" if slides else f"{name}_deg = {rng.randint(-70, 70)}")
        for which in range(rng.choice([0, 1, 1, 2])):
            masses.append(f'm{number}{which} = {{ mass_kg = {10 ** rng.uniform(-1, 1.5):.3g}, on = "{name}", at_mm = {listed(place(0, 300))} }}')
    branch = rng.randint(1, count)
    if rng.random() < 0.4:
        slides = more.random() < 0.5 and not is_early
        moves = 'kind = "sliding", min_mm = 0, max_mm = 100' if slides else "min_deg = -90, max_deg = 90"
        joints.append(f'B1 = {{ on = "J{branch}", at_mm = {listed(place(50, 200))}, axis = {axis()}, {moves} }}')
        masses.append(f'side = {{ mass_kg = 2.5, on = "B1", at_mm = {listed(place(50, 100))} }}')
        value = rng.randint(-60, 60)
        pose.append(f"B1_mm = {abs(value)}" if slides else f"B1_deg = {value}")
    lines = ['schema = "stiffbench/robot/2"', f'name = "random robot {seed}"', f'up = "{up}"', *([f'dh = "{dh}"'] if dh else []), "[joints]", *joints]
    lines += ["[tool]", f'on = "J{count}"', f"at_mm = {listed(place(150, 400))}"]
    if rng.random() < 0.4:
        lines.append(f"payload = {{ mass_kg = 3, at_mm = {listed(place(0, 60))} }}")
    if rng.random() < 0.3:
        lines.append("springs = { x = { stiffness_N_per_um = 20 }, rz = { stiffness_Nm_per_rad = 3e5 } }")
    if rng.random() < 0.3:
        lines += ["[base]", "springs = { rx = { stiffness_Nm_per_rad = 2e6 }, ry = { stiffness_Nm_per_rad = 3e6 }, z = { stiffness_N_per_um = 300 } }"]
    if beams and seed % 5 == 0:
        lines += ["[sections]", "light = { A_mm2 = 900, Iy_mm4 = 4e5, Iz_mm4 = 3e5, J_mm4 = 6e5, material = \"resin\" }"]
        lines += ["[materials]", "resin = { E_GPa = 70, G_GPa = 27 }"]
    if not dh and not is_early:
        lines += ["[points]", f"knee = {{ at_mm = {listed(place(50, 120))} }}", "[links]"]
        lines.append('post1 = { between = ["base", "knee"], section = "HEB 140" }')
        lines.append('post2 = { between = ["knee", "J1"], section = "tube 140x8", width = [0.3, 1, 0.2] }')
    if masses:
        lines += ["[masses]", *masses]
    lines += ["[poses]", f"P1 = {{ {', '.join(pose)} }}"]
    return "\n".join(lines) + "\n"
