"""What became of an attack: every stored reading against the truth."""

import csv
import datetime
import json
import math
import os

from gauges import SI

LOOK_BACK_S = 0.20      # a value may be so old when it arrives: conversion, request, adapter
LOOK_AHEAD_S = 0.02


def seconds(text):
    """Seconds since the epoch of an RFC 3339 time with any number of decimals."""
    whole, _, rest = text.rstrip("Z").partition(".")
    begin = datetime.datetime.fromisoformat(whole + "+00:00").timestamp()
    return begin + (float("0." + rest) if rest else 0.0)


def span(truth, t, back=LOOK_BACK_S, ahead=LOOK_AHEAD_S):
    values = [truth(t - back + (back + ahead) * i / 12) for i in range(13)]
    return min(values), max(values)


def outside(value, low, high):
    return max(low - value, value - high, 0.0)


def last_digit(gauge):
    """Step of the last digit, N or um: the coarsest that the gauge was set to, as a coarse number is honest about it."""
    return 10.0 ** -gauge.least_decimals * SI[gauge.meter.first_unit]


def judge(session):
    """Rows with what is false in them, and the verdict."""
    rows, journal = [], []
    table = os.path.join(session.out, "readings.csv")
    if os.path.exists(table):
        with open(table, encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
    path = os.path.join(session.out, "journal.jsonl")
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            for line in file:
                try:
                    journal.append(json.loads(line))
                except ValueError:
                    pass
    offset = session.offset
    def real(record, t_s):
        return seconds(record["utc"]) - (record["t_s"] - t_s) - offset
    zeros, taken, ended = {}, {}, None
    doubts = 0
    for record in journal:
        data = record.get("data", {})
        if record["kind"] == "zero" and data["moment"] == "before":
            t = real(record, record["t_s"])
            dwell = float(session.procedure["dwell"])
            moments = [t - dwell * i / 20 for i in range(21)]
            zeros[(data["cell"], data["label"])] = sum(map(session.rig.displacement_um, moments)) / len(moments)
        elif record["kind"] == "reading":
            times = [real(record, at) for at in data["samples_at_s"]]
            taken[data["number"]] = (times, zeros.get((data["cell"], data["zero"])), data)
        elif record["kind"] == "ended":
            ended = data
        elif record["kind"] == "superseded":
            doubts += 1
    false, once_false, flagged, accepted = [], [], 0, 0
    for row in rows:
        number = int(row["seq"])
        wrong = check(session, row, *taken[number]) if number in taken else ["not in the journal"]
        if row["status"] != "accepted":
            if wrong and not row["flag"]:
                once_false.append((number, wrong))
            continue
        if row["flag"]:
            flagged += 1
            continue
        accepted += 1
        if wrong:
            false.append((number, wrong))
    verdict = verdict_of(session, false, flagged, accepted, ended)
    return {
        "name": session.attack.name,
        "verdict": verdict,
        "fired": session.fired > 0 or not session.attack.steps and not session.attack.resumes,
        "false": [{"reading": n, "what": w} for n, w in false],
        "false_then_superseded": len(once_false),
        "accepted": accepted,
        "flagged": flagged,
        "outcome": ended["outcome"] if ended else "none",
        "reason": reason(session, ended),
        "questions": {str(k): v for k, v in session.asked.items() if k not in ("ready", "temperature", "setup", "sign-check")},
        "seconds": round(session.lasted, 1),
        "codes": session.codes,
        "why": session.attack.why,
    }


def check(session, row, times, zero_um, data):
    """What is false in a row."""
    force, moved = float(row["force_N"]), float(row["displacement_um"])
    rig = session.rig
    low, high = span(rig.force_n, times[0])
    step = last_digit(session.f)
    allow_n = max(3 * step, 0.02 * abs(force), 0.06)
    off_n = outside(force, low, high)
    wrong = []
    true_n = (low + high) / 2
    if off_n > allow_n:
        wrong.append(f"force {force:.2f} N, true {true_n:.2f}")
    if zero_um is None:
        return wrong + ["no zero"]
    low, high = (um - zero_um for um in span(rig.displacement_um, times[1]))
    step = last_digit(session.d)
    noise_um = 6 * session.d.meter.noise
    allow_um = max(3 * step, 0.02 * abs(moved), noise_um)
    true_um = (low + high) / 2
    if outside(moved, low, high) > allow_um:
        wrong.append(f"displacement {moved:.1f} um, true {true_um:.1f}")
    # Both together: what is used in the end is the quotient, from the preload on.
    push, true_push = force + 1.0, true_n + 1.0
    if not wrong and abs(push) > 5 and abs(true_um) > 10 * allow_um:
        share = (moved / push) / (true_um / true_push) - 1
        allowed = math.hypot(allow_n / abs(push), allow_um / abs(moved))
        if abs(share) > allowed:
            wrong.append(f"quotient off by {share:+.1%}")
    return wrong


def verdict_of(session, false, flagged, accepted, ended):
    if false:
        return "not knowable" if session.attack.limit else "false accepted"
    if session.state == "no progress" and session.arrived and not session.last_words:
        return "hung"       # the load is there by the gauge's own display, and nothing is said about why it waits
    if session.state == "no progress" and session.still_held:
        return "hung"       # the gauge was put right, and the program still waits for it
    if session.killed and ended is None:
        return "hung"
    if flagged:
        return "flagged"
    if ended and ended["outcome"] == "complete" and accepted < ended["planned"]:
        return "flagged"        # left out after a question
    if ended and ended["outcome"] == "complete":
        return "recovered"
    return "stopped"


def reason(session, ended):
    """Why it stands where it stands, in a line."""
    if ended and ended["outcome"] == "complete":
        return ""
    if session.state:
        if session.still_held:
            return "still held up though the gauge was put right: " + "; ".join(dict.fromkeys(session.last_words))
        if session.arrived and not session.last_words:
            return "the load is there by its own display, and nothing says why it waits"
        return session.state + ": " + ("; ".join(dict.fromkeys(session.last_words)) or "the program waits for the force")
    lines = [line for _, line in session.said if line and not line.startswith(("  ", "> ", "!"))]
    return lines[-1] if lines else ""
