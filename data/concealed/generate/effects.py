"""Effects of the library and beyond it: names, places and parameters as in the contract of the laws."""

import copy
from dataclasses import dataclass, field

import laws


@dataclass(frozen=True)
class Effect:
    """One physical cause at one place.  Parameters in SI units, by the names of the contract."""

    physics: str
    place: dict
    parameters: dict = field(default_factory=dict)
    size: str = ""  # the parameter that scales the effect

    def scaled(self, value: float) -> "Effect":
        parameters = dict(self.parameters)
        if self.physics in ("joint-nonlinearity", "joint-asymmetric-cubic"):
            factor = value / self.parameters[self.size]
            parameters = {name: number * factor for name, number in parameters.items()}
        parameters[self.size] = value
        return Effect(self.physics, copy.deepcopy(self.place), parameters, self.size)


SIZE = {
    "joint-compliance": "c", "joint-backlash": "play", "joint-friction": "c", "joint-nonlinearity": "c",
    "base-compliance": "c", "gauge-stand-compliance": "c", "load-misalignment": "angle", "loose-member": "",
    "force-gauge-nonlinearity": "q", "creep": "k", "thermal-drift": "rate", "setting-in": "k", "slip": "jump",
    "gauge-periodic": "amplitude",
    # Outside the library:
    "joint-plasticity": "strength", "joint-asymmetric-cubic": "c", "quadratic-drift": "rate",
    "load-dependent-creep": "k", "gauge-two-harmonics": "amplitude", "brace": "area",
}
UNITS = {
    ("joint-backlash", "play"): "rad", ("joint-backlash", "seat_moment"): "N*m",
    ("joint-friction", "friction_moment"): "N*m", ("joint-nonlinearity", "q"): "rad/(N*m)^2",
    ("gauge-stand-compliance", "c"): "m/N", ("load-misalignment", "angle"): "rad",
    ("force-gauge-nonlinearity", "q"): "1/N", ("creep", "k"): "1/decade", ("creep", "t0"): "s",
    ("setting-in", "k"): "1", ("setting-in", "decay"): "repeats", ("slip", "jump"): "m",
    ("gauge-periodic", "amplitude"): "m", ("gauge-periodic", "period"): "m", ("gauge-periodic", "phase"): "rad",
    ("joint-compliance", "c"): "rad/(N*m)", ("joint-friction", "c"): "rad/(N*m)",
    ("joint-nonlinearity", "c"): "rad/(N*m)", ("base-compliance", "c"): "rad/(N*m)",
    ("joint-plasticity", "strength"): "rad", ("joint-plasticity", "scale"): "N*m",
    ("joint-plasticity", "exponent"): "1", ("joint-asymmetric-cubic", "c"): "rad/(N*m)",
    ("joint-asymmetric-cubic", "even"): "rad/(N*m)^2", ("joint-asymmetric-cubic", "hardening"): "rad/(N*m)^3",
    ("quadratic-drift", "rate"): "m/s", ("quadratic-drift", "turn"): "s",
    ("load-dependent-creep", "k"): "1/decade", ("load-dependent-creep", "t0"): "s",
    ("gauge-two-harmonics", "amplitude"): "m", ("gauge-two-harmonics", "period"): "m", ("brace", "area"): "m2",
}


def unit_of(effect: Effect, name: str) -> str:
    if effect.physics == "thermal-drift":
        return "m/K" if effect.parameters.get("per_kelvin") else "m/s"
    return UNITS[effect.physics, name]


def joint_law(effect: Effect):
    """The law of a joint effect, or None for any other."""
    p = effect.parameters
    match effect.physics:
        case "joint-compliance":
            return laws.Compliance(p["c"])
        case "joint-backlash":
            return laws.Backlash(p["play"], p["seat_moment"])
        case "joint-friction":
            return laws.Friction(p["c"], p["friction_moment"])
        case "joint-nonlinearity":
            return laws.Nonlinearity(p["c"], p["q"])
        case "joint-plasticity":
            return laws.Plasticity(p["strength"], p["scale"], p["exponent"])
        case "joint-asymmetric-cubic":
            return laws.AsymmetricCubic(p["c"], p["even"], p["hardening"])
    return None
