"""What is physically there: a jack that pushes, and a specimen that gives way.

The truth is a closed form of time, so it can be asked for any moment, also long after it has passed.
Forces are N and displacements um, both along the positive axis: a push against the axis is negative.
Times are those of time.monotonic().
"""

import bisect
import math
import random


class Rig:
    """A spring under a jack."""

    def __init__(self, um_per_n=36.0, seed=1, jitter_n=0.003, relax=0.0):
        self.um_per_n = um_per_n
        self.relax = relax          # share of a step of load that the jack loses by itself within a second or so
        self.jitter_n = jitter_n
        dice = random.Random(seed)
        self._waves = [(dice.uniform(0.7, 6.0), dice.uniform(0, 6.28), dice.uniform(0.3, 1.0)) for _ in range(4)]
        self._ramps = [(0.0, 0.0, 0.0, 0.0)]   # begin, end, force before, force after
        self._begins = [0.0]
        self._moved = []            # (time, um): the specimen itself moved
        self._stand = []            # (time, um): the stand of the dial gauge moved; the specimen did not
        self._bumps = []            # (begin, end, N): a short push on top

    def ramp(self, now, to_n, seconds):
        """From now on the jack goes to a force."""
        from_n = self._steady(now)
        self._ramps.append((now, now + max(seconds, 0.05), from_n, to_n))
        self._begins.append(now)

    def move_specimen(self, now, um):
        self._moved.append((now, um))

    def move_stand(self, now, um):
        self._stand.append((now, um))

    def bump(self, now, seconds, newton):
        self._bumps.append((now, now + seconds, newton))

    def busy(self, now):
        return now < self._ramps[-1][1]

    def end_of_ramp(self):
        return self._ramps[-1][1]

    def when_within(self, newton):
        """When the last ramp comes within so many newton of its end."""
        begin, end, before, after = self._ramps[-1]
        for i in range(201):
            t = begin + (end - begin) * i / 200
            if abs(self._on_ramp(self._ramps[-1], t) - after) <= newton:
                return t
        return end

    @staticmethod
    def _on_ramp(ramp, t):
        begin, end, before, after = ramp
        if t >= end:
            return after
        x = max(0.0, (t - begin) / (end - begin))
        return before + (after - before) * x * x * (3 - 2 * x)

    def _steady(self, t):
        ramp = self._ramps[max(0, bisect.bisect_right(self._begins, t) - 1)]
        force = self._on_ramp(ramp, t)
        if self.relax and t > ramp[1] and abs(ramp[3]) > 0.5:
            force -= self.relax * (ramp[3] - ramp[2]) * (1 - math.exp(-(t - ramp[1]) / 0.4))
        return force

    def force_n(self, t):
        """The true force."""
        force = self._steady(t)
        force += sum(n for begin, end, n in self._bumps if begin <= t < end)
        if abs(force) > 0.05:
            force += self.jitter_n * sum(a * math.sin(w * t + p) for w, p, a in self._waves) / 2
        return force

    def displacement_um(self, t):
        """How far the specimen has truly moved."""
        return self.um_per_n * self.force_n(t) + sum(um for at, um in self._moved if at <= t)

    def dial_um(self, t):
        """How far the plunger of the dial gauge is pushed: the stand counts too."""
        return self.displacement_um(t) + sum(um for at, um in self._stand if at <= t)
