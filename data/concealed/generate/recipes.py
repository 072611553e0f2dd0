"""Draws of effects: law, place and shape by chance, size by the standard errors asked for."""

import numpy as np

from effects import Effect
from information import Information, orthonormal
from rivals import Library, left_by_library

# No effect may change a reading of a loaded robot by more than this share: it has to be overlooked.
LARGEST_SHARE = 0.12
LIMITS = {"joint-compliance": 3e-3, "joint-friction": 3e-3, "joint-backlash": 2e-2, "joint-nonlinearity": 3e-3,
          "base-compliance": 1e-4, "gauge-stand-compliance": 2e-5, "load-misalignment": 0.1, "thermal-drift": 1e-3,
          "creep": 0.05, "setting-in": 0.1, "force-gauge-nonlinearity": 2e-3, "gauge-periodic": 3e-5, "slip": 2e-3}


class NotReachable(Exception):
    """No place of this bench allows the effect at the wanted size."""


def share(information: Information, effect: Effect, others: tuple[Effect, ...] = ()) -> float:
    """Largest change of a reading by an effect, relative to the reading."""
    bench = information.bench
    loaded = np.abs(bench.table.target) >= 20.0
    change = np.abs(bench.displacement([*others, effect]) - bench.displacement(list(others)))
    return float(np.max(change[loaded] / np.maximum(np.abs(information.clean[loaded]), 1e-9)))


def absorbed(information: Information, effect: Effect) -> float:
    change = information.effect(effect)
    return 1.0 - float(np.sum(information.unabsorbed(change) ** 2) / np.sum(change**2))


def joint(physics: str, only: tuple[str, ...] = (), avoid: tuple[str, ...] = (), absorbed_from: float = 0.0,
          inner: bool = False):
    """A joint law at a joint drawn by chance; `inner` leaves out joints that only carry lever x force."""

    def draw(information: Information, rng: np.random.Generator, standard_errors: float) -> Effect:
        bench = information.bench
        ids = [name for name in (only or bench.actions[0].ids) if name not in avoid]
        for name in rng.permutation(ids):
            effect = _shaped(bench, physics, str(name), rng)
            index = bench.actions[0].ids.index(name)
            if effect is None or inner and bench.actions[0].stiffness[index, index] < 1.0:
                continue
            sized = information.sized(effect, standard_errors, 1e-10, LIMITS[physics])
            if sized and share(information, sized) <= LARGEST_SHARE and absorbed(information, sized) >= absorbed_from:
                return sized
        raise NotReachable(physics)

    return draw


def _shaped(bench, physics: str, name: str, rng: np.random.Generator) -> Effect | None:
    top = float(np.abs(bench.applied_moments(name)).max())
    if top < 1e-3:
        return None
    place = {"joint": name}
    if physics == "joint-compliance":
        return Effect(physics, place, {"c": 1.0}, "c")
    moment = float(f"{rng.uniform(0.06, 0.3) * top:.3g}")
    if physics == "joint-backlash":
        return Effect(physics, place, {"play": 1.0, "seat_moment": moment}, "play")
    if physics == "joint-friction":
        return Effect(physics, place, {"c": 1.0, "friction_moment": moment}, "c")
    bend = rng.choice([-1.0, 1.0]) * rng.uniform(0.35, 0.45) if rng.random() < 0.5 else rng.uniform(0.8, 1.6)
    return Effect(physics, place, {"c": 1.0, "q": float(f"{bend / top:.3g}")}, "c")


def only_elsewhere(training: tuple[int, ...] = (0, 2)):
    """Backlash that is not taken up in the training poses: in one other pose only, or else in several."""

    def draw(information: Information, rng: np.random.Generator, standard_errors: float) -> Effect:
        bench = information.bench
        alone, several = [], []
        for name in bench.actions[0].ids:
            moments = np.abs(bench.applied_moments(name))
            tops = np.array([moments[bench.table.pose == p].max() for p in range(len(bench.poses))])
            order, trained = np.argsort(tops), max(tops[p] for p in training)
            first, second = tops[order[-1]], tops[order[-2]]
            if order[-1] not in training and first > 1e-3 and first > 1.15 * second:
                alone.append((str(name), 1.03 * second))
            elif first > 1e-3 and first > 1.2 * trained:
                several.append((str(name), 1.03 * trained))
        options = [alone[k] for k in rng.permutation(len(alone))] + [several[k] for k in rng.permutation(len(several))]
        for name, seat in options:
            effect = Effect("joint-backlash", {"joint": name}, {"play": 1.0, "seat_moment": float(f"{seat:.4g}")}, "play")
            sized = information.sized(effect, standard_errors, 1e-10, LIMITS["joint-backlash"])
            if sized and share(information, sized) <= 2.0 * LARGEST_SHARE:
                return sized
        raise NotReachable("joint-backlash outside the training poses")

    return draw


def simple(physics: str, **given):
    """Any law that is not of a joint; what `given` leaves open is drawn."""

    def draw(information: Information, rng: np.random.Generator, standard_errors: float) -> Effect:
        for _ in range(24):
            effect, start = _simple(physics, given, information, rng)
            sized = information.sized(effect, standard_errors, start, LIMITS[physics])
            if sized and (physics == "slip" or share(information, sized) <= LARGEST_SHARE):
                return sized
        raise NotReachable(physics)

    return draw


def _simple(physics: str, given: dict, information: Information, rng: np.random.Generator) -> tuple[Effect, float]:
    sign = given.get("sign", float(rng.choice([-1.0, 1.0])))
    table = information.bench.table
    match physics:
        case "base-compliance":
            return Effect(physics, {"axis": given.get("axis", str(rng.choice(["x", "z"])))}, {"c": 1.0}, "c"), 1e-9
        case "gauge-stand-compliance":
            place = {"direction": given.get("direction", str(rng.choice(["x", "y", "z"])))}
            return Effect(physics, place, {"c": 1.0}, "c"), 1e-9
        case "load-misalignment":
            pairs = given.get("pairs", (("y", "z"), ("z", "y")))
            a, b = pairs[rng.integers(len(pairs))]
            return Effect(physics, {"direction": a, "toward": b}, {"angle": 1.0}, "angle"), sign * 1e-4
        case "force-gauge-nonlinearity":
            return Effect(physics, {"gauge": "force"}, {"q": 1.0}, "q"), sign * 1e-7
        case "creep":
            return Effect(physics, {"structure": True}, {"k": 1.0, "t0": float(rng.choice([0.5, 1.0, 2.0]))}, "k"), 1e-6
        case "thermal-drift":
            kelvin = {"per_kelvin": True} if given.get("per_kelvin") else {}
            return Effect(physics, {"clock": True}, {"rate": 1.0, **kelvin}, "rate"), sign * 1e-11
        case "setting-in":
            decay = given.get("decay") or float(np.round(rng.uniform(0.7, 2.0), 2))
            return Effect(physics, {"structure": True}, {"k": 1.0, "decay": decay}, "k"), sign * 1e-6
        case "gauge-periodic":
            p = {"amplitude": 1.0, "period": float(rng.choice([1e-4, 1.5e-4, 2e-4, 2.5e-4, 4e-4])),
                 "phase": float(np.round(rng.uniform(0.0, 6.2), 2))}
            return Effect(physics, {"gauge": "displacement"}, p, "amplitude"), 1e-9
        case "slip":
            run = int(rng.integers(table.pose.shape[0]))
            last = int(table.step[run].max())
            place = {
                "run": {"pose": table.names[table.pose[run, 0]], "direction": "xyz"[table.direction[run, 0]],
                        "repeat": int(table.repeat[run, 0])},
                "step": int(rng.integers(2, last - 1)),
            }
            return Effect(physics, place, {"jump": 1.0}, "jump"), sign * 1e-8
    raise ValueError(physics)


def loose():
    """A member whose loss is worth about the wanted standard errors; it has no size of its own."""

    def draw(information: Information, rng: np.random.Generator, standard_errors: float) -> Effect:
        from rivals import loose_members

        none = np.zeros(information.clean.size)
        lengths = [
            (abs(np.log(left / standard_errors)), effect)
            for left, effect in loose_members(information, none, information.factors)
            if left > 0.6 * standard_errors and share(information, effect) < 3.0
        ]
        if not lengths:
            raise NotReachable("loose-member")
        return min(lengths, key=lambda item: item[0])[1]

    return draw


def outside(physics: str):
    """Something the library does not hold, sized by what three library effects leave of it."""

    def draw(information: Information, rng: np.random.Generator, standard_errors: float) -> Effect:
        library = Library(information)
        for _ in range(60 if physics == "brace" else 12):
            effect, start = _outside(physics, information, rng)
            if physics == "brace" and not _tempting(information, library, effect.scaled(start)):
                continue
            size = start
            for _ in range(6):
                change = information.effect(effect.scaled(size))
                left = left_by_library(library, change)[-1]["standard_errors_left"]
                if left <= 0.0 or abs(np.log(left / standard_errors)) < 0.02:
                    break
                size *= float(np.clip(standard_errors / left, 0.01, 100.0))
            found = effect.scaled(float(f"{size:.5g}"))
            if abs(np.log(max(left, 1e-9) / standard_errors)) < 0.1 and share(information, found) <= 2.0 * LARGEST_SHARE:
                return found
        raise NotReachable(physics)

    return draw


def impossible_rival(information: Information, effect: Effect) -> dict | None:
    """The joint whose negative compliance would explain most of an effect, and what it would leave."""
    target = information.unabsorbed(information.effect(effect))
    best = None
    for name in information.bench.actions[0].ids:
        change = information.effect(Effect("joint-compliance", {"joint": name}, {"c": 1e-11}))
        column = information.unabsorbed(change)
        if np.linalg.norm(column) <= 1e-7 * np.linalg.norm(change):
            continue  # the factors take all of it
        size = float(column @ target / (column @ column))
        left = float(np.linalg.norm(target - size * column))
        if size < 0.0 and (best is None or left < best["standard_errors_left"]):
            value = {"value": float(f"{size * 1e-11:.4g}"), "unit": "rad/(N*m)"}
            best = {"physics": "joint-compliance", "place": {"joint": name}, "c": value, "standard_errors_left": left}
    if best:
        best["standard_errors_left"] = float(f"{best['standard_errors_left']:.4g}")
    return best


def _tempting(information: Information, library: Library, effect: Effect) -> bool:
    """Whether an impossible negative compliance explains an effect better than any single law can."""
    change = information.effect(effect)
    whole = float(np.linalg.norm(information.unabsorbed(change)))
    impossible = impossible_rival(information, effect)
    allowed = left_by_library(library, change, steps=1)[-1]["standard_errors_left"]
    return impossible is not None and impossible["standard_errors_left"] < min(0.6 * whole, 0.8 * allowed)


def _outside(physics: str, information: Information, rng: np.random.Generator) -> tuple[Effect, float]:
    bench = information.bench
    table = bench.table
    if physics in ("joint-plasticity", "joint-asymmetric-cubic"):
        name = str(rng.choice([j for j in bench.actions[0].ids if np.abs(bench.applied_moments(j)).max() > 1e-3]))
        top = float(np.abs(bench.applied_moments(name)).max())
        if physics == "joint-plasticity":
            p = {"strength": 1.0, "scale": float(f"{top:.3g}"), "exponent": float(np.round(rng.uniform(2.5, 5.0), 2))}
            return Effect(physics, {"joint": name}, p, "strength"), 1e-7 * top
        p = {"c": 1.0, "even": float(f"{rng.choice([-1.0, 1.0]) * 0.35 / top:.3g}"), "hardening": float(f"{0.1 / top**2:.3g}")}
        return Effect(physics, {"joint": name}, p, "c"), 1e-7
    if physics == "quadratic-drift":
        turn = float(np.round(rng.uniform(0.35, 0.65) * table.time.max(), 0))
        return Effect(physics, {"clock": True}, {"rate": 1.0, "turn": turn}, "rate"), float(rng.choice([-1, 1])) * 1e-9
    if physics == "load-dependent-creep":
        return Effect(physics, {"structure": True}, {"k": 1.0, "t0": 0.5}, "k"), 1e-3
    if physics == "gauge-two-harmonics":
        p = {"amplitude": 1.0, "period": float(rng.choice([1.2e-4, 1.8e-4, 3e-4]))}
        return Effect(physics, {"gauge": "displacement"}, p, "amplitude"), 1e-6
    if physics == "brace":
        nodes = [node for node in bench.robot.data["nodes"] if node in {n for e in bench.robot.elements(bench.mechanism) for n in e["nodes"]}]
        tied = {frozenset(element["nodes"]) for element in bench.robot.elements(bench.mechanism)}
        main = [n for n in nodes if n not in bench.robot.data["support"]["fixed"]]
        pairs = [(a, b) for i, a in enumerate(main) for b in main[i + 1 :] if frozenset((a, b)) not in tied]
        a, b = pairs[rng.integers(len(pairs))]
        return Effect(physics, {"between": [a, b]}, {"area": 1.0}, "area"), 1e-7
    raise ValueError(physics)


def beside(information: Information, effect: Effect, others: list[Effect]) -> float:
    """Standard errors that stay of an effect when the factors and the sizes of the others are free."""
    change = information.effect(effect, tuple(others))
    basis = information.factors
    if others:
        columns = [information.effect(other)[:, None] for other in others]
        basis = orthonormal(np.hstack([information.factors, *columns]))
    return float(np.linalg.norm(change - basis @ (basis.T @ change)))
