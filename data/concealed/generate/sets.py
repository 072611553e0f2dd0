"""Which benches are for development and which are the proof, and the files that hold the answers."""

import json
from pathlib import Path

import seal


def every_third(modes: list[str]) -> list[int]:
    """Places of every third bench of a mode; not the same steps of every ladder."""
    places, seen = [], {}
    for place, mode in enumerate(modes):
        count = seen[mode] = seen.get(mode, sum(mode.encode())) + 1
        if count % 3 == 0:
            places.append(place)
    return places


def split(answers: dict) -> tuple[list[str], list[str]]:
    """Every third bench of a mode is for development, so that both sets hold all modes."""
    names = list(answers)
    development = {names[place] for place in every_third([answer["mode"] for answer in answers.values()])}
    return sorted(development), sorted(set(answers) - development)


def listed(name: str, ids: list[str]) -> str:
    lines = [", ".join(f'"{one}"' for one in ids[k : k + 8]) for k in range(0, len(ids), 8)]
    return f"{name} = [\n" + "".join(f"  {line},\n" for line in lines) + "]\n"


def write(folder: Path, answers: dict) -> None:
    development, proof = split(answers)
    (folder / "sets.toml").write_text(
        'schema = "stiffbench/concealed-sets/1"\n'
        "# Answers of the first list are also in development-answers.json; look at the second only through the scorer.\n"
        + listed("development", development) + listed("proof", proof)
    )
    head = {"schema": "stiffbench/concealed-answers/1"}
    ordered = {name: answers[name] for name in sorted(answers)}
    plain = json.dumps({**head, "benches": ordered}, separators=(",", ":"), sort_keys=True).encode()
    (folder / "answers.sealed").write_text(seal.seal(plain))
    assert seal.unseal((folder / "answers.sealed").read_text()) == plain
    shown = {**head, "benches": {name: answers[name] for name in development}}
    (folder / "development-answers.json").write_text(json.dumps(shown, indent=1, sort_keys=True) + "\n")


def write_second(folder: Path, answers: dict) -> None:
    """The second proof list, beside the others."""
    file = folder / "sets.toml"
    file.write_text(file.read_text().split("second = ")[0] + listed("second", sorted(answers)))
    ordered = {name: answers[name] for name in sorted(answers)}
    plain = json.dumps({"schema": "stiffbench/concealed-answers/1", "benches": ordered}, separators=(",", ":"), sort_keys=True).encode()
    (folder / "answers-second.sealed").write_text(seal.seal(plain))
