"""Gauges as their makers describe them, on pseudo-terminals.

Written from the makers' protocols alone. A gauge is a Meter (what its display would show) and a way to speak.
Everything that an attack does to a gauge is a field of its Meter or of its Gauge.
"""

import errno
import math
import os
import pty
import random
import tty

SI = {"N": 1.0, "kgf": 9.80665, "lbf": 4.4482216152605, "kN": 1000.0,
      "um": 1.0, "mm": 1000.0, "in": 25400.0}     # newton; um


class Meter:
    """What a display shows, in N or um in the gauge's own sense."""

    def __init__(self, truth, sign, unit, decimals, noise, seed):
        self.truth = truth          # of time, along the axis
        self.sign = sign            # 1: counts along the positive axis
        self.unit = unit
        self.first_unit = unit
        self.decimals = decimals    # by unit
        self.noise = noise
        self.dice = random.Random(seed)
        self.tare = 0.0             # taken off, own sense
        self.bias = 0.0             # own sense; an error that no key takes away but zeroing
        self.drift_per_s = 0.0
        self.drift_from = 0.0
        self.delay_s = 0.0          # an adapter that hands on what was there so long ago
        self.refresh_s = 0.0        # an adapter that looks at the gauge so seldom
        self.tau_s = 0.0            # low-pass filter
        self.held = None            # hold key, or a frozen display
        self.peak = None            # peak mode: the largest so far
        self.clip = None            # the largest that it can show
        self.coarse = 1             # the last digit goes in steps of so many
        self.stuck = 0              # so many last digits stand still
        self.stuck_digits = None
        self.absolute = False       # the sign is not sent
        self.zero_does = "all"      # or "nothing"; or a share as a float; or ("leaves", value)
        self._slow = None
        self._looked = None

    def _raw(self, t):
        if self.refresh_s:
            t = math.floor(t / self.refresh_s) * self.refresh_s
        value = self.sign * self.truth(t - self.delay_s) + self.bias
        if self.drift_per_s:
            value += self.drift_per_s * max(0.0, t - self.drift_from)
        return value

    def _filtered(self, t):
        """The raw value through the filter; steps of 20 ms at most."""
        if not self.tau_s:
            self._slow, self._looked = None, t
            return self._raw(t)
        if self._slow is None or self._looked is None:
            self._slow, self._looked = self._raw(t), t
        while self._looked < t - 1e-6:
            step = min(0.02, t - self._looked)
            self._looked += step
            self._slow += (self._raw(self._looked) - self._slow) * (1 - math.exp(-step / self.tau_s))
        return self._slow

    def quiet(self, t):
        """What is shown, without noise."""
        value = self._filtered(t) - self.tare
        if self.peak is not None:
            if abs(value) > abs(self.peak):
                self.peak = value
            value = self.peak
        if self.held is not None:
            value = self.held
        if self.clip is not None:
            value = max(-self.clip, min(self.clip, value))
        return abs(value) if self.absolute else value

    def shown(self, t):
        still = self.held is not None or self.peak is not None
        return self.quiet(t) + (0.0 if still else self.dice.gauss(0.0, self.noise))

    def number(self, t):
        """Sign and digits as they stand in the display: (negative, text without sign)."""
        decimals = self.decimals[self.unit]
        step = 10.0 ** -decimals * self.coarse
        value = round(self.shown(t) / SI[self.unit] / step) * step
        text = f"{abs(value):.{decimals}f}"
        if self.stuck:
            digits = text.replace(".", "")
            if self.stuck_digits is None:
                self.stuck_digits = digits[-self.stuck:]
            digits = digits[:-self.stuck] + self.stuck_digits
            text = digits[:-decimals] + "." + digits[-decimals:]
        return value < 0 and float(text) != 0, text

    def hold(self, t):
        self.held = self.quiet(t)

    def release(self):
        self.held = None

    def zero(self, t):
        """The zero command, or the zero key."""
        if self.zero_does == "nothing" or self.held is not None:
            return
        full = self._filtered(t)
        if isinstance(self.zero_does, tuple):
            self.tare = full - self.zero_does[1]
        elif self.zero_does == "all":
            self.tare = full
        else:
            self.tare += (full - self.tare) * self.zero_does
        if self.peak is not None:
            self.peak = 0.0

    def key_zero(self, t):
        """Somebody presses zero, whatever the gauge does with the command."""
        self.tare = self._filtered(t)

    def peak_on(self, t):
        self.peak = self._filtered(t) - self.tare


class Gauge:
    """A gauge on a line. Subclasses know the words."""

    name = ""
    channel = ""
    sends_unit = False
    rate_hz = 0.0           # sends by itself so often; 0: only when asked
    latency_s = 0.006
    unit_flag = None        # the unit to be named on the command line
    end = b"\r"

    def __init__(self, meter, link):
        self.meter = meter
        self.link = link            # path at which the program finds it
        self.master = self.keeper = None
        self.inbox = b""
        self.outbox = []            # (due, bytes)
        self.next_send = 0.0
        self.mangle = None          # of (bytes, time): what goes on the line instead; None or a list of (delay, bytes)
        self.mute = False
        self.extra_latency_s = 0.0
        self.late_once_s = 0.0
        self.sent_values = []       # the last packets
        self.packets = 0
        self.commands = 0
        self.serial = "12345678"
        self.on_zero = None
        self.least_decimals = meter.decimals[meter.first_unit]

    # The line.

    def plug(self):
        """A new pseudo-terminal under the old name."""
        self.unplug()
        self.master, self.keeper = pty.openpty()
        tty.setraw(self.keeper)
        os.set_blocking(self.master, False)
        new = self.link + ".new"
        os.symlink(os.ttyname(self.keeper), new)
        os.replace(new, self.link)

    def unplug(self):
        if os.path.islink(self.link):
            os.unlink(self.link)
        for fd in (self.keeper, self.master):
            if fd is not None:
                os.close(fd)
        self.master = self.keeper = None
        self.inbox, self.outbox = b"", []

    def readable(self, t):
        try:
            data = os.read(self.master, 4096)
        except OSError as error:
            if error.errno in (errno.EIO, errno.EAGAIN):
                return
            raise
        self.inbox += data
        self.listen(t)

    def put(self, data, t, latency=None):
        """A packet goes out, unless an attack does something else with it."""
        self.packets += 1
        late = (self.latency_s if latency is None else latency) + self.extra_latency_s + self.late_once_s
        self.late_once_s = 0.0
        pieces = [(0.0, data)]
        if self.mangle is not None:
            changed = self.mangle(data, t)
            if changed is not None:
                pieces = changed
        for delay, piece in pieces:
            self.outbox.append((t + late + delay, piece))
        self.outbox.sort(key=lambda entry: entry[0])

    def put_value(self, t):
        packet = self.packet(t)
        self.least_decimals = min(self.least_decimals, self.meter.decimals[self.meter.first_unit])
        self.sent_values = (self.sent_values + [packet])[-400:]
        self.put(packet, t)

    def tick(self, t):
        if self.master is None:
            return
        if self.rate_hz and t >= self.next_send and not self.mute:
            self.next_send = t + 1.0 / self.rate_hz
            self.put_value(t)
        while self.outbox and self.outbox[0][0] <= t:
            data = self.outbox.pop(0)[1]
            try:
                os.write(self.master, data)
            except OSError:
                pass        # nobody reads: a real line loses it too

    def due(self, t):
        times = [entry[0] for entry in self.outbox[:1]]
        if self.rate_hz and not self.mute:
            times.append(self.next_send)
        return min(times, default=t + 0.05)

    # The words.

    def listen(self, t):
        while self.end in self.inbox:
            line, self.inbox = self.inbox.split(self.end, 1)
            self.commands += 1
            if not self.mute:
                self.command(line.decode("ascii", "replace").strip(), t)

    def command(self, word, t):
        pass

    def packet(self, t):
        raise NotImplementedError

    def zeroed(self, t):
        self.meter.zero(t)
        if self.on_zero:
            self.on_zero(t)

    def believed(self, t):
        """What the program makes of the number, in N or um, own sense: without a unit in the packet it is taken for the first one."""
        unit = self.meter.unit if self.sends_unit else self.meter.first_unit
        minus, text = self.meter.number(t)
        return (-1 if minus else 1) * float(text) * SI[unit]


class Mark10(Gauge):
    """Series 5: CR commands, `4.285 N` CR LF, compression without a sign."""

    name, channel, sends_unit = "mark10-series5", "force", True
    UNITS = {"N": "N", "kgf": "kgF", "lbf": "lbF", "kN": "kN"}
    full = True

    def packet(self, t):
        minus, digits = self.meter.number(t)
        text = ("-" if minus else "") + digits
        if self.full:
            text += " " + self.UNITS[self.meter.unit]
        return text.encode() + b"\r\n"

    def command(self, word, t):
        mode = "CUR" if self.meter.peak is None else "PC"
        if word in ("?C", "?"):
            # ?C is the running value whatever the mode; older units know only what is displayed.
            if word == "?C" and self.meter.peak is not None and not self.peak_in_c:
                kept, self.meter.peak = self.meter.peak, None
                self.put_value(t)
                self.meter.peak = kept
            else:
                self.put_value(t)
        elif word == "Z":
            self.zeroed(t)
        elif word == "CUR":
            self.meter.peak = None
        elif word in ("PT", "PC"):
            self.meter.peak_on(t)
        elif word == "LIST":
            unit = {"N": "N", "kgf": "KGF", "lbf": "LBF", "kN": "KN"}[self.meter.unit]
            form = "FULL" if self.full else "NUM"
            self.put(f"V1.00;{unit};{mode};FLTC8;FLTP1;AOUT00;AOFF0;{form};MIT;POL;B0\r\n".encode(), t)
        elif word == "RS":
            self.put(self.serial.encode() + b"\r\n", t)
        elif word in ("N", "KG", "LB"):
            self.meter.unit = {"N": "N", "KG": "kgf", "LB": "lbf"}[word]
        elif word.startswith("AOUT") or word.startswith("AOFF") or word in ("CLR", "FULL", "NUM"):
            pass
        elif word:
            self.put(b"*10\r\n", t)

    peak_in_c = False       # firmware whose ?C is what is displayed

    def believed(self, t):
        kept = self.meter.peak
        if not self.peak_in_c:
            self.meter.peak = None
        value = super().believed(t)
        self.meter.peak = kept
        return value


class Mark10Num(Mark10):
    """The same, set to send no unit."""

    full, sends_unit, unit_flag = False, False, "N"


class ImadaZts(Gauge):
    """X commands, CR: a marker, sign and digits in six places, eight bytes, index of the unit."""

    name, channel, unit_flag = "imada-zts", "force", "N"
    listed = True           # the key goes through the list; else the list itself changes

    def packet(self, t):
        minus, digits = self.meter.number(t)
        places = {"N": 0, "kgf": 1, "lbf": 2}
        index = places[self.meter.unit] if self.listed else 0
        digits = digits[:5] if "." in digits[:4] else digits.split(".")[0][:4] + "."
        return f"r{'-' if minus else '+'}{digits:0>5}00000000{index}\r".encode()

    def command(self, word, t):
        if word == "XAR":
            self.put_value(t)
        elif word == "XFC":
            code = {"N": "02", "kgf": "08", "lbf": "11"}[self.meter.unit]
            codes = "020811020202" if self.listed else code * 6
            self.put(f"XFC{codes}\r".encode(), t)


class SauterFh(Gauge):
    """One digit asks, seven bytes answer, no end mark: 0 push or 1 pull, then six characters."""

    name, channel, unit_flag = "sauter-fh", "force", "N"

    def packet(self, t):
        minus, digits = self.meter.number(t)
        whole = digits.split(".")[0]
        return (("0" if minus else "1") + (digits if len(whole) < 6 else "99999.").zfill(6)[:6]).encode()

    def listen(self, t):
        words, self.inbox = self.inbox.decode("ascii", "replace"), b""
        for word in words:
            self.commands += 1
            if self.mute:
                continue
            if word == "9":
                self.put_value(t)
            elif word == "2":
                self.zeroed(t)
            elif word == "6":
                self.meter.peak = None
            elif word == "7":
                self.meter.peak_on(t)


class Line(Gauge):
    """Any gauge or adapter that prints a number a line, by itself."""

    rate_hz = 15.0
    with_unit = True
    gap = " "

    def packet(self, t):
        minus, digits = self.meter.number(t)
        unit = {"N": "N", "kgf": "kgf", "lbf": "lbf", "mm": "mm", "in": "in"}[self.meter.unit]
        return f"{'-' if minus else ''}{digits}{self.gap + unit if self.with_unit else ''}\r\n".encode()


class LineForce(Line):
    name, channel, sends_unit = "generic-ascii", "force", True


class LineForceBare(LineForce):
    sends_unit, unit_flag, with_unit = False, "N", False


class LineDial(Line):
    name, channel, sends_unit = "generic-ascii-displacement", "displacement", True


class LineDialBare(LineDial):
    sends_unit, unit_flag, with_unit = False, "mm", False


class Mitutoyo(Gauge):
    """`1` CR asks, `01A+0000.123` CR answers; no unit and no zero over the line."""

    name, channel, unit_flag = "mitutoyo-01a", "displacement", "mm"
    latency_s = 0.04

    def packet(self, t):
        minus, digits = self.meter.number(t)
        return f"01A{'-' if minus else '+'}{digits:0>8}\r".encode()

    def command(self, word, t):
        if word == "1":
            self.put_value(t)
        elif word == "V":
            self.put(b"1ATTACK RIG V1\r", t)
        elif word:
            self.put(b"912\r", t)


class Mahr(Gauge):
    """DK-U1: `?` CR, `-000.415 mm` CR; settings come back as their own text."""

    name, channel, sends_unit = "mahr-dk-u1", "displacement", True

    def packet(self, t):
        minus, digits = self.meter.number(t)
        inch = self.meter.unit == "in"
        return f"{'-' if minus else '+'}{digits:0>7} {'inch' if inch else 'mm'}\r".encode()

    def command(self, word, t):
        if word == "?":
            self.put_value(t)
        elif word == "RST":
            self.zeroed(t)
            self.put(b"RST\r", t)
        elif word in ("MM", "IN"):
            self.meter.unit = word.lower()
            self.put(word.encode() + b"\r", t)
        elif word == "UN?":
            self.put(b"inch\r" if self.meter.unit == "in" else b"mm\r", t)
        elif word == "ID?":
            self.put(f"T 4337661 S {self.serial}\r".encode(), t)
        elif word.startswith("OFF") or word in ("CDT0", "CDT1"):
            self.put(word.encode() + b"\r", t)
        elif word:
            self.put(b"ERR2\r", t)


class Sylvac(Gauge):
    """Opto-RS: `?` CR, `+012.345` CR; the unit only when asked."""

    name, channel = "sylvac-opto-rs", "displacement"
    latency_s = 0.03
    mode = "NOR"

    def packet(self, t):
        minus, digits = self.meter.number(t)
        return f"{'-' if minus else '+'}{digits:0>7}\r".encode()

    def command(self, word, t):
        word = word.upper()
        if word in ("?", "PRI"):
            self.put_value(t)
        elif word == "SET":
            self.zeroed(t)
        elif word in ("MM", "IN"):
            self.meter.unit = word.lower()
        elif word == "UNI?":
            self.put(self.meter.unit.upper().encode() + b"\r", t)
        elif word == "MOD?":
            self.put((self.mode if self.meter.peak is None else "MAX").encode() + b"\r", t)
        elif word == "ID?":
            self.put(self.serial.encode() + b"\r", t)
        elif word == "NOR":
            self.mode, self.meter.peak = "NOR", None
        elif word in ("OUT0", "OUT1", "ECO0", "STO0", "STO1"):
            pass
        elif word:
            self.put(b"ERR1\r", t)


class Magnescale(Gauge):
    """LT20A, basic form: `A+12.3456` CR LF, by itself; no unit."""

    name, channel, rate_hz, unit_flag = "magnescale-lt20a", "displacement", 12.0, "mm"

    def packet(self, t):
        minus, digits = self.meter.number(t)
        return f"A{'-' if minus else '+'}{digits:0>7}\r\n".encode()


class MagnescaleUnit(Magnescale):
    """The same with mode and unit in front."""

    sends_unit, unit_flag = True, None

    def packet(self, t):
        minus, digits = self.meter.number(t)
        letter = "I" if self.meter.unit == "in" else "M"
        return f"AN{letter}{'-' if minus else '+'}{digits:0>7}\r\n".encode()


# Sign of a push as the maker says, or as it is mounted here; digits behind the point; noise.
FORCE_DIGITS = {"N": 2, "kgf": 3, "lbf": 3}
DIAL_DIGITS = {"mm": 3, "in": 5}
KINDS = {
    "mark10": (Mark10, -1, FORCE_DIGITS, 0.008),
    "mark10-num": (Mark10Num, -1, FORCE_DIGITS, 0.008),
    "zts": (ImadaZts, 1, {"N": 2, "kgf": 3, "lbf": 3}, 0.008),
    "sauter": (SauterFh, 1, {"N": 2, "kgf": 3, "lbf": 3}, 0.008),
    "line-f": (LineForce, -1, FORCE_DIGITS, 0.008),
    "line-f-bare": (LineForceBare, -1, FORCE_DIGITS, 0.008),
    "mahr": (Mahr, 1, DIAL_DIGITS, 0.2),
    "mitutoyo": (Mitutoyo, -1, DIAL_DIGITS, 0.2),
    "sylvac": (Sylvac, 1, DIAL_DIGITS, 0.2),
    "line-d": (LineDial, 1, DIAL_DIGITS, 0.2),
    "line-d-bare": (LineDialBare, -1, DIAL_DIGITS, 0.2),
    "magnescale": (Magnescale, 1, {"mm": 4, "in": 5}, 0.04),
    "magnescale-unit": (MagnescaleUnit, 1, {"mm": 4, "in": 5}, 0.04),
}


def build(kind, rig, link, seed):
    """A gauge of a kind at a rig."""
    which, sign, decimals, noise = KINDS[kind]
    force = which.channel == "force"
    truth = rig.force_n if force else rig.dial_um
    meter = Meter(truth, sign, "N" if force else "mm", dict(decimals), noise, seed)
    return which(meter, link)
