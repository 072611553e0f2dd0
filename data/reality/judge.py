"""The rules by which a diagnosis is counted; README.md states them.  Standard library only."""

import fnmatch
from dataclasses import asdict, dataclass, field

FLAT = ("is", "mostly")
NAMING = ("explained", "ambiguous")
APART = 4.0  # standard errors
CERTAIN = 1e-6  # a printed test below it contradicts a headline that nothing is left
OMNIBUS = 0.01  # level of the test that something is left
LEFT_PAGE, LEFT_TRUTH = 6.0, 10.0  # standard errors left: printed, true
DATA_OF_ONE = ("bad-reading", "decimal-point", "sign")

# Laws that hold another at the same joint: they cannot be separated from it, whatever the readings.
RICHER = {
    "joint-compliance": ("joint-friction", "joint-nonlinearity", "odd-polynomial", "end-stop", "maxwell-slip", "load-dependent-friction"),
    "joint-friction": ("maxwell-slip", "load-dependent-friction"),
    "joint-backlash": ("preloaded-backlash",),
}


def place_text(place: dict) -> str:
    """A place as `--effect` writes it; `*` where there is none."""
    if "run" in place:
        run = place["run"]
        return ".".join(str(part) for part in (run["pose"], run["direction"], run["repeat"], place.get("step", "*")))
    if "toward" in place:
        return f"{place['direction']}>{place['toward']}"
    for key in ("structure", "clock"):
        if key in place:
            return key
    return ".".join(str(value) for value in place.values()) or "*"


def name_of(finding: dict) -> str:
    name = f"{finding['physics']}@{place_text(finding.get('place') or {})}"
    rate = (finding.get("parameters") or {}).get("rate") or {}
    return name + ":per-kelvin" if finding["physics"] == "thermal-drift" and rate.get("unit") == "m/K" else name


def matches(name: str, pattern: str) -> bool:
    """A name and a pattern; a place may be given more exactly than the pattern asks for."""
    return fnmatch.fnmatchcase(name, pattern) or fnmatch.fnmatchcase(name, pattern + ".*")


def is_richer(name: str, truth: str) -> bool:
    """A law at the joint of the truth that holds the true law."""
    (law, place), (true_law, true_place) = name.split("@", 1), truth.split("@", 1)
    return place == true_place and law in RICHER.get(true_law, ())


def groups_of(findings: list[dict]) -> list[list[str]]:
    """Names of findings, those of one alternative group together."""
    groups: dict = {}
    for k, finding in enumerate(findings):
        group = finding.get("alternative_group")
        groups.setdefault(("group", group) if group is not None else ("single", k), []).append(name_of(finding))
    return list(groups.values())


def is_truth(name: str, truth: dict) -> bool:
    return any(matches(name, pattern) for pattern in truth.get("names", [truth["name"]]))


def cannot_be_separated(name: str, truth: dict) -> bool:
    if is_truth(name, truth) or is_richer(name, truth["name"]):
        return True
    return any(matches(name, other["name"]) and other["standard_errors_left"] < APART for other in truth["near"])


@dataclass
class Naming:
    """What named findings are worth against known effects."""

    right: bool = False
    inseparable: bool = False  # not right, but nothing named can be separated from the truth
    exact: bool = False  # every effect alone, by its own name


def naming(groups: list[list[str]], truths: list[dict]) -> Naming:
    """Right: each effect has a group of its own, its true name alone or a set without a separable member; no group is left."""
    if len(groups) != len(truths):
        return Naming()
    worth = [[_worth(group, truth) for group in groups] for truth in truths]
    best = max((tuple(sorted(row[k] for row, k in zip(worth, order))) for order in _orders(len(groups))), default=())
    return Naming(right=bool(best) and min(best) >= 2, inseparable=bool(best) and min(best) == 1, exact=bool(best) and min(best) >= 3)


def _worth(group: list[str], truth: dict) -> int:
    if len(group) == 1:
        if is_truth(group[0], truth):
            return 3
        return int(cannot_be_separated(group[0], truth))
    return 2 if all(cannot_be_separated(name, truth) for name in group) else 0


def _orders(count: int) -> list[tuple[int, ...]]:
    if count == 0:
        return []
    shorter = _orders(count - 1) or [()]
    return [(*order[:k], count - 1, *order[k:]) for order in shorter for k in range(count)]


@dataclass
class Judged:
    """One session, counted."""

    id: str
    row: str
    kind: str
    size: float | None
    standard_errors: float
    verdict: str | None = None
    grade: str | None = None
    named: list[list[str]] = field(default_factory=list)
    data: list[str] = field(default_factory=list)
    right: bool = False
    exact: bool = False
    inseparable: bool = False
    alarm: bool = False
    flat: bool = False
    unknown_with_place: bool = False
    misled: bool = False
    bad_named: bool = False
    good_named_bad: bool = False
    unsaid_page: bool = False
    unsaid_truth: bool = False
    observer_right: bool | None = None
    observer_misled: bool | None = None
    seconds: float = 0.0
    error: str | None = None

    def record(self) -> dict:
        return asdict(self)


def judge(name: str, answer: dict, data: dict | None, error: str | None, seconds: float) -> Judged:
    """Count one diagnosis; `data` is the envelope's, None where the program failed."""
    truths = answer["truth"]
    whole = max((truth["standard_errors"] for truth in truths), default=0.0)
    out = Judged(name, answer["row"], answer["kind"], answer.get("size"), whole, seconds=round(seconds, 2), error=error)
    if answer.get("observer") is not None and answer["expected"] != "mishap":
        out.observer_right = naming(answer["observer"], truths).right
    if data is None:
        return out
    out.verdict, out.grade = data["verdict"], data.get("grade")
    naming_verdict = out.verdict in NAMING
    out.named = groups_of(data["findings"]) if naming_verdict else []
    out.flat = naming_verdict and (out.grade is None or out.grade in FLAT)
    _count_names(out, answer, data)
    _count_data(out, answer, data)
    _count_unsaid(out, answer, data)
    return out


def _count_names(out: Judged, answer: dict, data: dict) -> None:
    truths = answer["truth"]
    all_names = [name for group in out.named for name in group]
    match answer["expected"]:
        case "nothing":
            out.right = out.verdict == "nothing-missing"
            out.alarm = not out.right
        case "named" | "setup":
            found = naming(out.named, truths)
            out.right, out.inseparable, out.exact = found.right, found.inseparable, found.exact
            if answer["expected"] == "setup" and out.verdict == "unknown":
                out.unknown_with_place = _place_is_right(answer, data)
        case "mishap":
            accepted = any(matches(name, pattern) for name in all_names for pattern in answer["also_right"])
            out.right = bool(all_names) and accepted or out.verdict == "unknown"
            left = [_left_after(name, truths[0]) for name in all_names]
            out.inseparable = bool(all_names) and not accepted and min(left) < APART
            out.misled = bool(all_names) and not accepted and not out.inseparable
            if "observer_left_p" in answer:
                out.observer_misled = _misled_observer(answer)


def _misled_observer(answer: dict) -> bool:
    """Whether the observer names something else, and its omnibus test passes at the program's level."""
    names = [name for group in answer["observer"] for name in group]
    accepted = any(matches(name, pattern) for name in names for pattern in answer["also_right"])
    apart = bool(names) and min(_left_after(name, answer["truth"][0]) for name in names) >= APART
    return apart and not accepted and answer["observer_left_p"] > OMNIBUS


def _left_after(name: str, truth: dict) -> float:
    """What the observer has left after a name; where it was not worked out, all."""
    near = [other["standard_errors_left"] for other in truth["near"] if matches(name, other["name"])]
    worked_out = [left for other, left in truth.get("left_after", {}).items() if matches(name, other)]
    return min([*near, *worked_out, truth["standard_errors"]])


def _left_after_all(groups: list[list[str]], truth: dict) -> float:
    """What the observer has left after all that is named: after the best single name, or after slips, whose runs do not overlap."""
    whole, best_of_run = truth["standard_errors"], {}
    names = [name for group in groups for name in group]
    for name in (name for name in names if name.startswith("slip@")):
        run = name.rpartition(".")[0]
        explained = whole**2 - _left_after(name, truth) ** 2
        best_of_run[run] = max(explained, best_of_run.get(run, 0.0))
    after_slips = max(whole**2 - sum(best_of_run.values()), 0.0) ** 0.5
    return min([after_slips, *(_left_after(name, truth) for name in names)])


def _place_is_right(answer: dict, data: dict) -> bool:
    """The right name as a part, or a cell (pose and direction) that holds at least half as much as the fullest one."""
    truth = answer["truth"][0]
    if any(cannot_be_separated(name_of(finding), truth) for finding in data["findings"]):
        return True
    full = {(c["pose"], c["direction"]) for c in answer["cells"] if c["standard_errors"] >= 0.5 * answer["cells"][0]["standard_errors"]}
    places = [(where.get("pose"), where.get("direction")) for where in [*data.get("where", []), data.get("left_over") or {}]]
    cells = [place for place in places if all(place)]
    return bool(cells) and cells[0] in full


def _count_data(out: Judged, answer: dict, data: dict) -> None:
    bad = answer.get("bad")
    for finding in data.get("data_findings") or []:
        reading = (finding.get("place") or {}).get("reading") or {}
        hit = bad is not None and finding["kind"] in DATA_OF_ONE and _is_reading(finding, reading, bad)
        out.bad_named |= hit
        out.good_named_bad |= not hit or len(finding.get("lines") or [1]) > 1
        out.data.append(f"{finding['kind']} {finding.get('lines')}")


def _is_reading(finding: dict, reading: dict, bad: dict) -> bool:
    if bad["line"] in (finding.get("lines") or []):
        return True
    keys = ("pose", "direction", "repeat", "step", "branch")
    return bool(reading) and all(reading.get(key, bad["place"][key]) == bad["place"][key] for key in keys)


def _count_unsaid(out: Judged, answer: dict, data: dict) -> None:
    grade = out.grade or {"explained": "is", "ambiguous": "is", "nothing-missing": "nothing"}.get(out.verdict, "unknown")
    if grade not in ("is", "nothing"):
        return
    left, omnibus = data.get("left_over") or {}, data.get("omnibus") or {}
    tests = [left.get("p"), omnibus.get("p")]
    if grade == "nothing":
        tests += [where.get("p_family") for where in data.get("where", [])]
    out.unsaid_page = any(p is not None and p < CERTAIN for p in tests) or (left.get("standard_errors") or 0.0) >= LEFT_PAGE
    truths = answer["truth"]
    if not truths:
        return
    if grade == "nothing":
        out.unsaid_truth = out.standard_errors >= LEFT_TRUTH
    elif answer["expected"] != "named" and not (answer["expected"] == "setup" and out.right):
        out.unsaid_truth = bool(out.named) and _left_after_all(out.named, truths[0]) >= LEFT_TRUTH
    elif answer["expected"] == "named" and not out.right:
        missed = [t["standard_errors"] for t in truths if not any(cannot_be_separated(n, t) for g in out.named for n in g)]
        out.unsaid_truth = max(missed, default=0.0) >= LEFT_TRUTH
