"""One session on the rig: the program, two gauges, and an operator who does what is asked.

The operator reads the plain lines of the program, works the jack by what the force gauge shows, answers honestly, and puts a
gauge right once the program (or a display that stands still) tells that something is wrong. Whatever an attack wants otherwise
it says: see attacks.py.
"""

import fcntl
import heapq
import itertools
import os
import random
import re
import select
import shutil
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass

import gauges
from rig import Rig

PROCEDURE = """schema = "stiffbench/procedure/1"
name = "attack"
directions = {directions}
loads_N = {loads}
branches = {branches}
repeats = {repeats}
preload_N = -1.0
zero = "{zero}"
[settle]
force_tolerance_N = 0.5
dwell_s = {dwell}
spread_um = {spread}
slope_um_per_s = {slope}
"""

# Short: most attacks. Slow: the shipped limits, where the speed of a fault against the dwell is what counts.
PROCEDURES = {
    "short": dict(dwell=0.5, spread=2.0, slope=4.0, repeats=2),
    "once": dict(dwell=0.5, spread=2.0, slope=4.0, repeats=1),
    "slow": dict(dwell=2.0, spread=2.0, slope=0.5, repeats=1),
    "cells": dict(dwell=0.5, spread=2.0, slope=4.0, repeats=1, directions='["x", "y"]'),
    "back": dict(dwell=0.5, spread=2.0, slope=4.0, repeats=1, branches='["loading", "unloading"]', loads="[0, -15, -30]"),
    "stiff": dict(dwell=0.5, spread=1.0, slope=2.0, repeats=2),
    "stiff once": dict(dwell=0.5, spread=1.0, slope=2.0, repeats=1),
}

# How a question is known, and what an honest operator says the first, second, ... time; the last answer is given from then on.
QUESTIONS = [
    ("ready", r"bench ready", ["yes"]),
    ("temperature", r"How warm", ["21.5"]),
    ("humidity", r"relative humidity", [""]),
    ("bench-note", r"worth a note", [""]),
    ("setup", r"Set pose", ["yes"]),
    ("sign-check", r"Which way along", ["minus"]),
    ("sign-differs", r"counts the other way under compression", ["again", "again", "use"]),
    ("zero-not-shown", r"was zeroed, and shows", ["again", "again", "stop"]),
    ("force-offset", r"Is it hanging free", ["zero"]),
    ("force-sign", r"where .* is wanted", ["wait"]),
    ("frozen", r"while the (force|displacement) moved", ["again", "again", "skip"]),
    ("displacement-sign", r"against a force", ["again", "again", "skip"]),
    ("implausible", r"off the prediction", ["again", "again", "skip"]),
    ("not-settled", r"not settled yet|outside its band", ["wait"]),
    ("drift", r"zero moved by .* allowed are", ["redo", "redo", "keep"]),
    ("changed", r"Before the interruption", ["again", "again", "flag"]),
    ("other-gauge", r"the session began with", ["no", "no", "stop"]),
    ("skip-reason", r"Why is .* left out", ["instrument doubtful"]),
    ("note", r"What should the note say", ["nothing"]),
    ("redo-cell", r"Measure it again", ["no"]),
]
# For questions that are not in the list: the first of these that is among the choices.
CAUTIOUS = ["again", "wait", "redo", "no", "skip"]
DOUBTS = {"zero-not-shown", "force-offset", "force-sign", "frozen", "displacement-sign", "implausible", "drift", "other-gauge", "changed"}

PUT_RIGHT_S = 2.5       # the operator needs so long to put a gauge right once told
STILL_S = 7.0           # without progress so long, the operator looks for what is wrong by himself
LONGEST_S = 140.0       # a session never lasts longer


@dataclass
class Goal:
    """Where the operator is to bring the force."""

    name: str
    target: float
    due: float                  # not before
    tries: int = 0
    before: float = None        # what the gauge showed at the last turn of the jack
    idle: int = 0               # turns that the display did not follow
    there_since: float = None   # since when the gauge shows the load
    seen: bool = False


LIVE = set()            # programs that run now


class Session:
    """One run of the program, with what happened for the judge."""

    def __init__(self, attack, program, seed=1, longest_s=LONGEST_S):
        self.attack = attack
        self.program = program
        self.longest_s = longest_s
        self.folder = tempfile.mkdtemp(prefix="attack-")
        self.out = os.path.join(self.folder, "s")
        self.rig = Rig(attack.um_per_n, seed, relax=attack.relax)
        kinds = attack.pair
        self.f = gauges.build(kinds[0], self.rig, os.path.join(self.folder, "force"), seed * 7 + 1)
        self.d = gauges.build(kinds[1], self.rig, os.path.join(self.folder, "dial"), seed * 7 + 2)
        self.procedure = dict(PROCEDURES[attack.procedure])
        self.log = []
        self.said = []              # (time, line) of the program
        self.timers = []
        self.order = itertools.count()
        self.counts = {}
        self.fired = 0
        self.cured = None           # when the operator put things right
        self.told = None            # when the program first complained after the attack began
        self.asked = {}             # how often a question was asked
        self.held_up = []           # (time, why)
        self.offset = time.time() - time.monotonic()
        self.runs = 0
        self.proc = None
        self.goal = None
        self.note_n = 0.0
        self.progress = time.monotonic()
        self.quit_at = None
        self.killed = False
        self.codes = []
        self.state = ""
        self.last_words = []
        self.arrived = False
        self.still_held = False
        self.follow = attack.follow
        self.dice = random.Random(seed * 7 + 3)
        self.fresh_task = False
        self.live_n = []            # the force as the program showed it
        self.live_um = []           # and the displacement
        self.seen_n = 0.0

    # What attacks use.

    def now(self):
        return time.monotonic()

    def after(self, seconds, what):
        heapq.heappush(self.timers, (self.now() + seconds, next(self.order), what))

    def at(self, when, what):
        heapq.heappush(self.timers, (when, next(self.order), what))

    def type(self, line):
        self.write(f"    types {line!r}")
        try:
            self.proc.stdin.write(line.encode() + b"\n")
            self.proc.stdin.flush()
        except OSError:
            pass

    def interrupt(self):
        self.proc.send_signal(signal.SIGINT)

    def kill(self):
        self.proc.kill()

    def swap_links(self):
        """Each gauge is plugged in where the other was."""
        for gauge in (self.f, self.d):
            gauge.unplug()
        self.f.link, self.d.link = self.d.link, self.f.link

    def write(self, text):
        self.log.append(f"{self.now() - self.began:8.3f} {text}")

    def emit(self, event):
        """Something happened at which an attack may begin."""
        count = self.counts[event] = self.counts.get(event, 0) + 1
        for step in self.attack.steps:
            if step.event == event and step.nth in (0, count):
                self.after(step.delay, lambda step=step: self.do(step))

    def do(self, step):
        if step.attack:
            self.fired += 1
        self.write(f"  * {step.text or step.event}")
        step.action(self)

    # The program.

    def command(self, resumed):
        command = [self.program, "session", "resume" if resumed else "run", self.out, "--line", "--progress", "none"]
        if not resumed:
            path = os.path.join(self.folder, "procedure.toml")
            values = dict(directions='["x"]', loads="[0, -10, -20, -30]", branches='["loading"]', zero="run")
            values.update(self.procedure)
            values.update(self.attack.values)
            with open(path, "w", encoding="utf-8") as file:
                file.write(PROCEDURE.format(**values))
            command += ["--procedure", path, "--poses", "P1"]
        ports = [os.path.join(self.folder, "force"), os.path.join(self.folder, "dial")]
        for word, gauge, port in (("force", self.f, ports[0]), ("displacement", self.d, ports[1])):
            command += [f"--{word}-instrument", gauge.name, f"--{word}-port", port]
            if gauge.unit_flag:
                command += [f"--{word}-unit", gauge.unit_flag]
        return command + list(self.attack.arguments)

    def launch(self, resumed):
        for gauge in (self.f, self.d):
            gauge.plug()
        self.emit("launch")
        self.run_timers()
        self.proc = subprocess.Popen(
            self.command(resumed), stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            cwd=self.folder, start_new_session=True)
        LIVE.add(self.proc)
        flags = fcntl.fcntl(self.proc.stderr, fcntl.F_GETFL)
        fcntl.fcntl(self.proc.stderr, fcntl.F_SETFL, flags | os.O_NONBLOCK)
        self.text = b""
        self.prompt = None
        self.prompt_at = 0.0
        self.goal = None
        self.runs += 1
        self.progressed()

    def progressed(self):
        self.progress = self.now()

    def run(self):
        """Runs the attack to its end, resuming as often as the attack says."""
        self.began = self.now()
        try:
            self.launch(False)
            self.loop()
            for prepare in self.attack.resumes:
                prepare(self)
                self.fired += 1
                self.quit_at = None
                self.launch(True)
                self.loop()
        finally:
            if self.proc and self.proc.poll() is None:
                self.proc.kill()
                self.proc.wait()
            for gauge in (self.f, self.d):
                gauge.unplug()
        self.lasted = self.now() - self.began

    def loop(self):
        while True:
            t = self.now()
            self.run_timers()
            for gauge in (self.f, self.d):
                gauge.tick(t)
            self.work(t)
            self.patience(t)
            if self.proc.poll() is not None:
                self.read_lines()
                LIVE.discard(self.proc)
                self.codes.append(self.proc.returncode)
                self.write(f"    the program ended with {self.proc.returncode}")
                self.proc.stdin.close()
                self.proc.stderr.close()
                return
            due = min(self.f.due(t), self.d.due(t), t + 0.03)
            if self.timers:
                due = min(due, self.timers[0][0])
            by_fd = {gauge.master: gauge for gauge in (self.f, self.d) if gauge.master is not None}
            waits = list(by_fd) + [self.proc.stderr.fileno()]
            ready = select.select(waits, [], [], max(0.001, due - self.now()))[0]
            for fd in ready:
                if fd in by_fd and by_fd[fd].master == fd:
                    by_fd[fd].readable(self.now())
            self.read_lines()

    def run_timers(self):
        while self.timers and self.timers[0][0] <= self.now():
            heapq.heappop(self.timers)[2]()

    def read_lines(self):
        try:
            data = self.proc.stderr.read()
        except (OSError, ValueError):
            data = None
        if data:
            self.text += data
        while b"\n" in self.text:
            line, self.text = self.text.split(b"\n", 1)
            self.heard(line.decode("utf-8", "replace"))

    # What the program says.

    def heard(self, line):
        self.write("| " + line)
        self.said.append((self.now(), line))
        if line.startswith("? "):
            self.prompt, self.prompt_at = [line[2:]], self.now()
            return
        if self.prompt is not None and line.startswith("  ") and not line.startswith("  waiting: "):
            self.prompt.append(line.strip())
            return
        held = re.match(r"\s+waiting: (.*)", line)
        if held:
            self.held_up.append((self.now(), held.group(1)))
            # Before the first task both gauges are waited for anyway.
            if self.fired and (self.goal or "nothing comes" not in line):
                self.complained("waiting: " + held.group(1))
        live = re.match(r"  (-?[\d.]+) N\b.*?  (-?[\d.]+) um", line)
        if live:
            self.live_n.append(float(live.group(1)))
            self.live_um.append(live.group(2))
            if self.fresh_task:
                # What the program shows besides the number of the gauge: the operator reckons by the program.
                aside = self.face_n(self.now()) - self.live_n[-1]
                self.note_n = aside if abs(aside) > 0.06 else 0.0
                self.fresh_task = False
        if line.startswith("> "):
            self.fresh_task = True
            self.task(line[2:])
        elif line.startswith("let go, then push"):
            self.set_goal("push", None)
        elif re.match(r"reading \d+: ", line):
            self.progressed()
            self.emit(line.split(":")[0])
            self.emit("reading")
        elif re.match(r"zero \S+ is set", line):
            self.progressed()
            self.emit("zeroed")

    def complained(self, why):
        if self.told is None:
            self.told = self.now()
            self.write(f"    the operator is told: {why}")
            if self.attack.cure is not None:
                self.after(PUT_RIGHT_S, self.put_right)

    def put_right(self):
        if self.cured is None and self.attack.cure is not None:
            self.cured = self.now()
            self.write("    the operator puts the gauge right")
            self.attack.cure(self)
            self.progressed()

    def task(self, text):
        place, colon, what = text.partition(": ")
        if not colon:
            place, what = "", text
        repeat = re.search(r"repeat (\d+)/", place)
        repeat = repeat.group(1) if repeat else "0"
        number = re.search(r"to (-?[\d.]+) N", what)
        target = float(number.group(1)) if number else None
        if text.startswith("sign check"):
            return
        if text.startswith(("hold", "waiting", "paused")):
            return
        self.progressed()
        if what.startswith("take the gauge off"):
            self.set_goal("free", 0.0)
        elif what.startswith("preload"):
            self.set_goal("preload", target)
        elif what.startswith("release"):
            self.set_goal("release", target)
        elif what.startswith("back to"):
            self.set_goal("check", target)
        elif "not recorded" in what:
            self.set_goal("again", target)
        elif target is not None:
            self.set_goal(f"{target:g}", target)
        self.emit(f"go {self.goal.name}" if self.goal else "go")
        if repeat != "0":
            self.emit(f"go {self.goal.name} repeat {repeat}")

    def answer(self):
        text, rest = self.prompt[0], self.prompt[1:]
        self.prompt = None
        name = next((name for name, pattern, _ in QUESTIONS if re.search(pattern, text)), None)
        count = self.asked[name] = self.asked.get(name, 0) + 1
        if self.fired and (name in DOUBTS or name is None):
            self.complained(f"? {text}")
        if count <= 3:
            self.progressed()
        answers = self.attack.answers.get(name)
        if answers is None:
            answers = next((known for known_name, _, known in QUESTIONS if known_name == name), None)
        unit = re.search(r"The (\w+) gauge does not send its unit. Does its display show (\w+)", text)
        if unit:
            name = "unit"
            meter = (self.f if unit.group(1) == "force" else self.d).meter
            if answers is None:
                answers = ["same"] if meter.unit == unit.group(2) else ["other"]
            if answers == ["other"]:
                meter.unit = unit.group(2)      # set at its panel, as he is told
        if answers is None:
            words = [part.split(":")[0] for part in rest]
            answers = [next((word for word in CAUTIOUS if word in words), "no")]
            if count > 3 and "skip" in words:
                answers = ["skip"]
        word = answers[min(count, len(answers)) - 1]
        self.emit(f"question {name}")
        if word == "stop":
            self.stop("the operator cannot answer")
            return
        # Somebody who was asked to look takes a moment; with nothing to put right, less.
        fixing = self.attack.cure is not None and self.cured is None and self.fired and name in DOUBTS
        self.after(PUT_RIGHT_S + 1.0 if fixing else 0.25, lambda: self.type(word))

    def stop(self, why):
        if self.quit_at is None:
            self.write(f"    the operator ends it: {why}")
            self.quit_at = self.now()
            self.state = why
            self.last_words = self.words_since(self.quit_at - 12.0)
            since = self.goal.there_since if self.goal else None
            shown = self.live_n[-2:]
            # A dial that still moves is a reason to wait that everybody sees.
            um = [float(text) for text in self.live_um[-3:] if text != "-"]
            quiet = bool(um) and max(um) - min(um) <= 2.0
            self.arrived = quiet and since is not None and self.quit_at - since > 8.0 and all(
                abs(n - self.goal.target) <= 0.5 for n in shown)
            self.still_held = self.cured is not None and self.quit_at - self.cured > 8.0 and any(
                at > self.cured + 5.0 and at > self.quit_at - 12.0 for at, _ in self.held_up)
            self.interrupt()

    def words_since(self, t):
        """What the program said about why it waits."""
        words = [why for at, why in self.held_up if at >= t]
        for at, line in self.said:
            if at >= t and line and not line.startswith(("  ", "> ", "!", "let go", "zero ", "reading ")):
                words.append(line)
        return words

    def patience(self, t):
        if self.prompt is not None and t - self.prompt_at > 0.12:
            self.answer()
        still = t - self.progress
        if self.fired and still > STILL_S and self.cured is None and self.attack.cure is not None:
            self.put_right()
        if self.quit_at is None and still > self.attack.patience:
            self.stop("no progress")
        if self.quit_at is None and t - self.began > self.longest_s:
            self.stop("it takes too long")
        if self.quit_at is not None:
            if t - self.quit_at > 4.0 and self.proc.poll() is None and not self.killed:
                self.killed = True
                self.interrupt()        # once more: now
            if t - self.quit_at > 9.0 and self.proc.poll() is None:
                self.write("    it does not end: killed")
                self.proc.kill()

    # The hands.

    def set_goal(self, name, target):
        now = self.now()
        self.goal = Goal(name, target, now + 0.15)
        self.seen_n = 0.0

    def face_n(self, now):
        """Force along the axis as the number is taken, N."""
        return self.f.meter.sign * self.f.believed(now)

    def work(self, now):
        """Moves the jack toward the goal: a ramp, a look at the gauge, small corrections."""
        goal = self.goal
        if not goal or now < goal.due or self.rig.busy(now):
            return
        name, target, tries = goal.name, goal.target, goal.tries
        true_n = self.rig.force_n(now)
        if name == "push":
            self.push(now)
            return
        if name == "free":
            if tries == 0:
                self.rig.ramp(now, 0.0, 0.2 + abs(true_n) / 40.0)
                goal.tries = 1
                self.emit("free")
            return
        shown = self.face_n(now) - self.note_n
        error = target - (true_n if self.follow == "truth" else shown)
        near_n = 0.4 if abs(target) > 2 else 0.12
        if tries and abs(error) <= near_n:
            if goal.there_since is None:
                goal.there_since = now
                if not goal.seen:
                    goal.seen = True
                    self.emit(f"at {name}")
            goal.due = now + 0.2
            return
        goal.there_since = None
        if tries and abs(shown - self.seen_n) > 0.06:
            # The display still moves: look again before the next turn of the jack.
            self.seen_n = shown
            goal.due = now + 0.25
            self.progressed()
            return
        self.seen_n = shown
        if tries == 0:
            # A hand does not stop at the very target.
            aside = self.dice.uniform(-0.3, 0.3) if abs(target) > 2 else 0.0
            step = target + aside - true_n if abs(self.note_n) < 5 and abs(shown - true_n) < 0.4 else error
        else:
            if self.follow == "truth":
                goal.due = now + 0.2
                return
            # A display that does not follow: after some tries the operator stops and looks.
            if abs(shown - goal.before) > 0.02:
                goal.idle = 0
                self.progressed()
            else:
                goal.idle += 1
            if goal.idle > 3 and self.cured is None:
                goal.due = now + 0.4
                return
            step = max(-25.0, min(25.0, error))
        to_n = max(-130.0, min(60.0, true_n + step))
        way_n = abs(to_n - true_n)
        seconds = 0.12 + min(way_n, 15.0) / 15.0 + max(way_n - 15.0, 0.0) / 40.0
        self.rig.ramp(now, to_n, seconds)
        goal.tries, goal.before = tries + 1, shown
        goal.due = now + seconds + (1.2 if self.rig.relax else 0.3)
        if tries == 0:
            self.emit(f"move {name}")
            for word, newton in (("near", 6.0), ("band", 0.5)):
                self.at(self.rig.when_within(newton), lambda word=word: self.emit(f"{word} {name}"))
            end = self.rig.end_of_ramp()
            self.at(end, lambda: self.emit(f"end {name}"))

    def push(self, now):
        """By hand: let go, push, keep it for a moment, and again."""
        stage = self.goal.tries
        self.goal.tries += 1
        to_n, seconds, keep = [(0.0, 0.2, 1.6), (-6.0, 0.4, 2.5), (0.0, 0.3, 1.6), (-11.0, 0.5, 3.0)][stage % 4]
        self.rig.ramp(now, to_n, seconds)
        self.goal.due = now + seconds + keep

    def clean(self):
        shutil.rmtree(self.folder, ignore_errors=True)
