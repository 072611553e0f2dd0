"""The attacks: what is done to the gauges, the bench or the session, and when.

A moment is an event of the session (see Session.emit) and a delay behind it:
  launch            before the program starts
  free, go preload  while zeroing; zeroed: a zero was set
  go -20            the program asked for that load; move: the jack begins; near: 6 N before it; end: the jack stops
  band -20          the force comes within 0.5 N: the dwell begins
  at -20            the operator has seen that the load is there
  reading 3         that reading was taken; reading: any
  go check          the way back to look at the zero at the end
The n-th time only, unless nth is 0. Cures are what an operator can do once he is told.
"""

from dataclasses import dataclass, field


@dataclass
class Step:
    event: str
    action: object
    delay: float = 0.0
    nth: int = 1
    text: str = ""
    attack: bool = True


@dataclass
class Attack:
    name: str
    pair: tuple
    steps: list = field(default_factory=list)
    procedure: str = "short"
    values: dict = field(default_factory=dict)
    cure: object = None
    answers: dict = field(default_factory=dict)
    resumes: list = field(default_factory=list)
    follow: str = "gauge"
    um_per_n: float = 36.0
    relax: float = 0.0
    quick: bool = False
    why: str = ""
    limit: str = ""             # why nobody could know: what is false then is counted apart
    arguments: tuple = ()
    patience: float = 22.0      # without progress so long, the operator ends the session, s


ALL = []
NAMES = {}

M10_MAHR = ("mark10", "mahr")
NUM_MIT = ("mark10-num", "mitutoyo")
SAU_MIT = ("sauter", "mitutoyo")
ZTS_SYL = ("zts", "sylvac")
LINES = ("line-f", "line-d")
BARE = ("line-f-bare", "line-d-bare")
M10_MAG = ("mark10", "magnescale")
M10_MAGU = ("mark10", "magnescale-unit")
M10_BARE = ("mark10", "line-d-bare")
PAIRS = [M10_MAHR, NUM_MIT, SAU_MIT, ZTS_SYL, LINES, BARE, M10_MAG, M10_MAGU, M10_BARE]


def add(name, pair, *steps, **more):
    pair_name = f"{pair[0]}+{pair[1]}"
    full = f"{name} [{pair_name}]"
    assert full not in NAMES, full
    attack = Attack(full, pair, list(steps), **more)
    NAMES[full] = attack
    ALL.append(attack)
    return attack


def step(event, action, delay=0.0, nth=1, text="", attack=True):
    return Step(event, action, delay, nth, text, attack)


def f_set(**fields):
    def act(s):
        for key, value in fields.items():
            setattr(s.f.meter, key, value)
    return act


def d_set(**fields):
    def act(s):
        for key, value in fields.items():
            setattr(s.d.meter, key, value)
    return act


def both(*actions):
    def act(s):
        for action in actions:
            action(s)
    return act


f_hold = lambda s: s.f.meter.hold(s.now())
d_hold = lambda s: s.d.meter.hold(s.now())
f_free = lambda s: s.f.meter.release()
d_free = lambda s: s.d.meter.release()
f_key_zero = lambda s: s.f.meter.key_zero(s.now())
d_key_zero = lambda s: s.d.meter.key_zero(s.now())
f_peak = lambda s: s.f.meter.peak_on(s.now())
d_peak = lambda s: s.d.meter.peak_on(s.now())
free_both = both(f_free, d_free)
stop = lambda s: s.stop("the attack ends it")


def mangle(which, how, only=None):
    """Lets `how` change what goes on the line from now on."""
    def act(s):
        gauge = getattr(s, which)
        gauge.mangle = lambda data, t: how(s, data, t)
    return act


def unmangle(which):
    def act(s):
        getattr(s, which).mangle = None
    return act


def once(change):
    """Changes a single packet."""
    state = {}
    def how(s, data, t):
        if id(s) in state:
            return None
        changed = change(data)
        if changed == data:
            return None
        state[id(s)] = True
        return [(0.0, changed)]
    return how


def always(change):
    return lambda s, data, t: [(0.0, change(data))]


# Controls. ----------------------------------------------------------------------------------------------------------------------

for pair in PAIRS:
    add("control", pair, quick=pair in (M10_MAHR, BARE))
add("control slow", M10_MAHR, procedure="slow")
add("control slow", SAU_MIT, procedure="slow")
add("control slow", BARE, procedure="slow")
add("control two cells", M10_MAHR, procedure="cells")
add("control back", M10_MAHR, procedure="back")
add("control back", SAU_MIT, procedure="back")
add("control relaxing jack", SAU_MIT, relax=0.05)
add("control stiff", M10_MAG, procedure="stiff", um_per_n=0.3)
add("control by weights", SAU_MIT, follow="truth")
add("control resume", M10_MAHR, step("reading 3", lambda s: s.interrupt(), 0.2), resumes=[lambda s: None])
add("control specimen stepped and back", M10_MAHR,
    step("band -20", lambda s: (s.rig.move_specimen(s.now(), -60.0), s.rig.move_specimen(s.now() + 0.25, 60.0)), 0.15))
add("control force stepped and back", M10_MAHR, step("band -20", lambda s: s.rig.bump(s.now(), 0.15, -4.0), 0.25))

# Unit key. ----------------------------------------------------------------------------------------------------------------------

MOMENTS = {
    "before the start": ("launch", 0.0),
    "while zeroing": ("go preload", 0.05),
    "after reading 2": ("reading 2", 0.05),
    "on the way to -20": ("move -20", 0.2),
    "in the dwell at -20": ("band -20", 0.25),
}
f_back = f_set(unit="N")
d_back = d_set(unit="mm")
for pair, unit, moments, quick in [
    (M10_MAHR, "lbf", ["after reading 2", "in the dwell at -20"], []),
    (NUM_MIT, "lbf", ["before the start", "while zeroing", "after reading 2", "in the dwell at -20"], ["after reading 2"]),
    (NUM_MIT, "kgf", ["after reading 2"], []),
    (SAU_MIT, "lbf", ["before the start", "while zeroing", "after reading 2", "in the dwell at -20"], ["after reading 2"]),
    (SAU_MIT, "kgf", ["before the start", "after reading 2"], []),
    (ZTS_SYL, "lbf", ["before the start", "after reading 2"], ["after reading 2"]),
    (ZTS_SYL, "kgf", ["while zeroing"], []),
    (LINES, "lbf", ["after reading 2"], []),
    (BARE, "lbf", ["before the start", "after reading 2", "on the way to -20"], []),
]:
    for moment in moments:
        event, delay = MOMENTS[moment]
        add(f"force unit {unit} {moment}", pair, step(event, f_set(unit=unit), delay), cure=f_back, quick=moment in quick,
            why="unit key of the force gauge")
add("force unit list lbf after reading 2", ZTS_SYL, step("launch", lambda s: setattr(s.f, "listed", False), attack=False),
    step("reading 2", f_set(unit="lbf"), 0.05), cure=f_back, why="the list of units changes, the index stays")
add("force unit lbf one decimal after reading 2", NUM_MIT,
    step("reading 2", lambda s: (s.f.meter.decimals.update(lbf=2), setattr(s.f.meter, "unit", "lbf")), 0.05), cure=f_back,
    quick=True, why="unit key where the number of decimals stays")
for pair, moments, quick in [
    (M10_MAHR, ["after reading 2", "in the dwell at -20"], []),
    (SAU_MIT, ["before the start", "after reading 2"], []),
    (ZTS_SYL, ["before the start", "while zeroing", "after reading 2"], []),
    (BARE, ["before the start", "while zeroing", "after reading 2", "on the way to -20"], ["after reading 2"]),
    (M10_MAG, ["before the start", "after reading 2"], []),
    (M10_MAGU, ["after reading 2"], []),
]:
    for moment in moments:
        event, delay = MOMENTS[moment]
        add(f"dial unit inch {moment}", pair, step(event, d_set(unit="in"), delay), cure=d_back, quick=moment in quick,
            why="unit key of the dial gauge")
add("dial unit inch three decimals after reading 1", BARE,
    step("reading 1", lambda s: (s.d.meter.decimals.update({"in": 3}), setattr(s.d.meter, "unit", "in")), 0.05), cure=d_back,
    why="unit key where the number of decimals stays")
add("dial begins in inch, key to mm after zeroing", ZTS_SYL, step("launch", d_set(unit="in"), attack=False),
    step("zeroed", d_set(unit="mm"), 0.05), quick=True, why="the unit was asked for once; the decimals are right for neither")
add("dial unit inch for one load only", BARE, step("reading 1", d_set(unit="in"), 0.05), step("reading 2", d_back, 0.05),
    why="pressed by mistake, and pressed again")
add("dial unit inch before the zero look at the end", ZTS_SYL, step("reading 4", d_set(unit="in"), 0.05), cure=d_back)

# Tare. --------------------------------------------------------------------------------------------------------------------------

for pair in (M10_MAHR, SAU_MIT, ZTS_SYL, BARE):
    add("force tared under load after reading 2", pair, step("reading 2", f_key_zero, 0.1), quick=pair in (SAU_MIT,),
        why="somebody presses zero")
    add("dial tared under load after reading 2", pair, step("reading 2", d_key_zero, 0.1), quick=pair in (M10_MAHR,),
        why="somebody presses zero")
add("dial tared after reading 2, ended before the zero look", M10_MAHR, step("reading 2", d_key_zero, 0.1),
    step("reading 3", stop, 0.3, attack=False), quick=True)
add("force tared after reading 2, ended before the zero look", SAU_MIT, step("reading 2", f_key_zero, 0.1),
    step("reading 3", stop, 0.3, attack=False))
add("dial tared after reading 2, killed before the zero look", SAU_MIT, step("reading 2", d_key_zero, 0.1),
    step("reading 3", lambda s: s.kill(), 0.3, attack=False))
add("dial tared in the dwell at -10", SAU_MIT, step("band -10", d_key_zero, 0.25))
add("dial tared on the way to -20", M10_MAHR, step("move -20", d_key_zero, 0.3))
add("dial tared after reading 2, drift kept", M10_MAHR, step("reading 2", d_key_zero, 0.1), answers={"drift": ["keep"]},
    why="the operator keeps readings whose zero moved")
add("dial tared and set back", M10_MAHR, step("reading 2", d_key_zero, 0.1),
    step("reading 3", lambda s: setattr(s.d.meter, "tare", s.kept), 0.1), step("reading 1", lambda s: setattr(s, "kept", s.d.meter.tare),
    attack=False), quick=True, why="ABS key: relative zero on and off again, the look at the zero sees nothing")
add("force tared and set back", M10_MAHR, step("reading 2", f_key_zero, 0.1),
    step("reading 3", lambda s: setattr(s.f.meter, "tare", s.kept), 0.1), step("reading 1", lambda s: setattr(s, "kept", s.f.meter.tare),
    attack=False))
add("force tared under the preload after the zero", SAU_MIT, step("zeroed", f_key_zero, 0.05))
add("force tared under load, stiff", M10_MAG, step("reading 2", f_key_zero, 0.1), procedure="stiff", um_per_n=0.3, quick=True,
    why="a stiff specimen: the look at the zero under the preload sees little")
add("force tared while zeroing the dial", M10_MAHR, step("at preload", f_key_zero, 0.1))

# Peak mode. ---------------------------------------------------------------------------------------------------------------------

cur = lambda s: setattr(s.f.meter, "peak", None)
shown = step("launch", lambda s: setattr(s.f, "peak_in_c", True), attack=False)
for pair, quick in ((SAU_MIT, True), (M10_MAHR, False), (ZTS_SYL, False), (BARE, False)):
    add("force peak mode after reading 1, relaxing jack", pair, step("reading 1", f_peak, 0.05), relax=0.05, cure=cur, quick=quick,
        why="the peak stays while the force falls off")
add("force peak mode after reading 3, unloading", SAU_MIT, step("reading 3", f_peak, 0.05), procedure="back", cure=cur)
add("force peak mode before the start", SAU_MIT, step("launch", f_peak), relax=0.05, cure=cur)
add("force peak mode, ?C is what is displayed", M10_MAHR, shown, step("reading 1", f_peak, 0.05), relax=0.05, cure=cur,
    why="not as the maker says; LIST would tell")
add("dial maximum mode after reading 3, unloading", ZTS_SYL, step("reading 3", d_peak, 0.05), procedure="back",
    cure=d_set(peak=None))
add("dial maximum mode after reading 1, force overshoots", BARE, step("reading 1", d_peak, 0.05),
    step("end -10", lambda s: s.rig.bump(s.now(), 0.2, -1.5), 0.05, nth=0), cure=d_set(peak=None),
    why="the maximum belongs to a force that was there for a moment")

# Hold key, frozen displays. -----------------------------------------------------------------------------------------------------

for pair, loads in ((M10_MAHR, (-10, -20, -30)), (SAU_MIT, (-10, -20)), (ZTS_SYL, (-10,)), (BARE, (-10, -30)), (M10_MAG, (-20,))):
    for load in loads:
        number = -load // 10 + 1
        add(f"dial held 6 N before {load}, released after the reading", pair, step(f"near {load}", d_hold),
            step(f"reading {number}", d_free, 0.05, attack=False), cure=d_free, quick=(pair, load) in ((M10_MAHR, -10), (BARE, -30)),
            why="the display stands still on the way")
add("dial held 6 N before every load", M10_MAHR, step("near -10", d_hold, nth=0), step("near -20", d_hold, nth=0),
    step("near -30", d_hold, nth=0), step("reading", d_free, 0.05, nth=0, attack=False), cure=d_free, quick=True,
    why="always the same: repeats and line agree")
add("dial held 6 N before -20, released in the dwell", M10_MAHR, step("near -20", d_hold), step("band -20", d_free, 0.25, attack=False))
add("dial held 6 N before -20, released at capture", M10_MAHR, step("near -20", d_hold), step("band -20", d_free, 0.47, attack=False))
add("dial held 6 N before -20, released at capture, slow", M10_MAHR, step("near -20", d_hold),
    step("band -20", d_free, 1.95, attack=False), procedure="slow")
add("dial held 6 N before -20, slow", SAU_MIT, step("near -20", d_hold), step("reading 3", d_free, 0.05, attack=False),
    procedure="slow", cure=d_free, quick=True)
add("dial held 6 N before -10, slow", M10_MAHR, step("near -10", d_hold), step("reading 2", d_free, 0.05, attack=False),
    procedure="slow", cure=d_free)
add("force held 6 N before -20", M10_MAHR, step("near -20", f_hold), cure=f_free)
add("both held 6 N before -20", M10_MAHR, step("near -20", both(f_hold, d_hold)), cure=free_both)
add("force held at the load, jack falls off", SAU_MIT, step("band -20", f_hold, 0.02),
    step("band -20", lambda s: s.rig.ramp(s.now(), -16.5, 0.6), 0.03, attack=False), step("reading 3", f_free, 0.05, attack=False),
    cure=f_free, quick=True, why="hold pressed when the load is there; the load then falls off")
add("force held at the load, jack goes on", M10_MAHR, step("band -10", f_hold, 0.02),
    step("band -10", lambda s: s.rig.ramp(s.now(), -18.0, 0.3), 0.03, attack=False),
    step("reading 2", f_free, 0.05, attack=False), cure=f_free, why="the dial settles at another load than the held one")
for dwell, procedure, limit in (
    ("", "slow", ""),
    # Noise of 0.8 digits leaves one force after the other as it is in 4 of 10, one dial value of 0.2 digits in 8 of 10: six and three
    # values show one text each in 0.4^5 0.8^2 = 0.7 % of good readings, and a program that asked then would ask in clean sessions.
    (", in a quarter of the shipped dwell", "short", "in 0.7 % of good readings both stand still as long"),
):
    add(f"both held at the load, jack falls off{dwell}", SAU_MIT, step("band -20", both(f_hold, d_hold), 0.02),
        step("band -20", lambda s: s.rig.ramp(s.now(), -16.5, 0.6), 0.03, attack=False),
        step("reading 3", free_both, 0.05, attack=False), cure=free_both, procedure=procedure, limit=limit,
        why="both values belong together, but not to the moment of the reading")
add("dial held after reading 2, whole load", M10_MAHR, step("reading 2", d_hold, 0.05), cure=d_free)
add("dial held in the dwell after it settled", M10_MAHR, step("band -20", d_hold, 0.3), step("reading 3", d_free, attack=False),
    cure=d_free, why="held at the true value: nothing is false")
add("dial held between repeats", SAU_MIT, step("reading 4", d_hold, 0.05), cure=d_free)
add("dial held before the start", M10_BARE, step("launch", d_hold), cure=d_free)
add("dial held while zeroing", M10_BARE, step("go free", d_hold), cure=d_free, quick=True,
    why="the zero is taken from a held display")
add("dial held while zeroing, released with the zero", M10_BARE, step("go free", d_hold, 0.0), step("zeroed", d_free, 0.02, attack=False))
add("dial held on the way to the preload", BARE, step("move preload", d_hold, 0.03), step("zeroed", d_free, 0.02, attack=False))
add("dial held on the way to the preload from -30", BARE, step("move check", d_hold, 0.3), step("go 0 repeat 2", d_free, 0.02, attack=False))
add("force held while zeroing", BARE, step("move check", f_hold, 1.75), step("go preload repeat 2", f_free, 0.1, attack=False), cure=f_free)
add("held between cells", M10_MAHR, step("reading 4", d_hold, 0.05), procedure="cells", cure=d_free)

# Values that come late. ---------------------------------------------------------------------------------------------------------

for seconds in (0.8, 1.5, 3.0):
    for pair, quick in ((SAU_MIT, seconds == 3.0), (M10_BARE, False)):
        add(f"dial late by {seconds:g} s, slow", pair, step("reading 1", d_set(delay_s=seconds)), procedure="slow", quick=quick,
            cure=d_set(delay_s=0.0), why="an adapter that hands on old values")
add("dial late by 1 s", M10_MAHR, step("reading 1", d_set(delay_s=1.0)), cure=d_set(delay_s=0.0))
add("dial late by 3 s from the start, slow", SAU_MIT, step("launch", d_set(delay_s=3.0)), procedure="slow")
add("force late by 1.5 s, slow", SAU_MIT, step("reading 1", f_set(delay_s=1.5)), procedure="slow", cure=f_set(delay_s=0.0))
add("force late by 3 s, slow", SAU_MIT, step("reading 1", f_set(delay_s=3.0)), procedure="slow", cure=f_set(delay_s=0.0))
add("both late by 2.5 s, slow", BARE, step("reading 1", both(f_set(delay_s=2.5), d_set(delay_s=2.5))), procedure="slow")
add("dial late by 3 s after reading 2, slow", SAU_MIT, step("reading 2", d_set(delay_s=3.0)), procedure="slow", cure=d_set(delay_s=0.0),
    quick=True)
add("dial late by 1 s after reading 2", M10_BARE, step("reading 2", d_set(delay_s=1.0)), cure=d_set(delay_s=0.0))
for seconds in (2.0, 4.0):
    add(f"dial looked at every {seconds:g} s, slow", SAU_MIT, step("reading 1", d_set(refresh_s=seconds)), procedure="slow",
        cure=d_set(refresh_s=0.0), why="an adapter that caches")
add("dial cached while it moves", M10_BARE, step("move -20", d_hold, 0.5), step("end -20", d_free, 2.6, attack=False),
    step("move -30", d_hold, 0.5), step("end -30", d_free, 2.6, attack=False), procedure="slow",
    why="the display is updated again only long after the movement")

# Clipped, filtered, coarse, digits that stand still. ----------------------------------------------------------------------------

for pair, limit, quick in ((M10_MAHR, 600.0, False), (BARE, 300.0, True), (SAU_MIT, 900.0, False), (M10_MAG, 600.0, False)):
    add(f"dial stops at {limit:g} um from the zero", pair, step("zeroed", d_set(clip=limit), nth=0), cure=d_set(clip=None), quick=quick,
        why="end of the range") if pair is M10_MAHR else \
    add(f"dial stops at {limit:g} um", pair, step("launch", d_set(clip=limit)), cure=d_set(clip=None), quick=quick, why="end of the range")
add("force stops at 25 N", M10_MAHR, step("launch", f_set(clip=25.0)), cure=f_set(clip=None))
add("force stops at 30.2 N, jack overshoots", SAU_MIT, step("launch", f_set(clip=30.2)),
    step("end -30", lambda s: s.rig.ramp(s.now(), -36.0, 0.2), 0.02, attack=False), why="overload shown as the largest number")
add("force stops at 20 N, jack overshoots", M10_MAHR, step("launch", f_set(clip=20.0)),
    step("end -20", lambda s: s.rig.ramp(s.now(), -24.0, 0.2), 0.02, attack=False), quick=True, why="overload shown as the largest number")
for tau in (0.5, 2.0, 8.0):
    add(f"dial filter {tau:g} s, slow", SAU_MIT, step("reading 1", d_set(tau_s=tau)), procedure="slow", patience=60.0)
add("dial filter 60 s, small loads", M10_MAHR, step("reading 1", d_set(tau_s=60.0)), procedure="slow", values=dict(loads="[0, -3, -6]"),
    patience=90.0, why="the display creeps more slowly than the limit of slope while it is still far off")
add("dial filter 20 s, short", M10_MAHR, step("reading 1", d_set(tau_s=20.0)), values=dict(loads="[0, -5, -10]"), patience=40.0)
add("force filter 0.5 s, slow", SAU_MIT, step("reading 1", f_set(tau_s=0.5)), procedure="slow")
add("force filter 3 s, slow", M10_MAHR, step("reading 1", f_set(tau_s=3.0)), procedure="slow")
add("dial in steps of 0.01 mm after reading 2", M10_MAHR, step("reading 2", d_set(coarse=10)), why="resolution set to a coarser step")
add("dial in steps of 0.1 mm after reading 1", SAU_MIT, step("reading 1", d_set(coarse=100)), quick=True)
add("dial in steps of 0.05 mm from the start", BARE, step("launch", d_set(coarse=50)))
add("dial with two decimals after reading 2", M10_MAHR, step("reading 2", lambda s: s.d.meter.decimals.update(mm=2)),
    cure=lambda s: s.d.meter.decimals.update(mm=3), why="resolution set to fewer decimals; the text says so")
add("dial with one decimal after reading 1", BARE, step("reading 1", lambda s: s.d.meter.decimals.update(mm=1)),
    cure=lambda s: s.d.meter.decimals.update(mm=3))
add("force in steps of 1 N after reading 1", SAU_MIT, step("reading 1", f_set(coarse=100)))
add("force with no decimals after reading 1", NUM_MIT, step("reading 1", lambda s: s.f.meter.decimals.update(N=0)),
    cure=lambda s: s.f.meter.decimals.update(N=2))
add("last two digits of the dial stand still after reading 2", M10_MAHR, step("reading 2", d_set(stuck=2)), cure=d_set(stuck=0))
add("last two digits of the dial stand still from the start", BARE, step("launch", d_set(stuck=2)), quick=True)
add("last digit of the dial stands still", SAU_MIT, step("launch", d_set(stuck=1)))
add("last two digits of the force stand still after reading 1", M10_MAHR, step("reading 1", f_set(stuck=2)), cure=f_set(stuck=0))

# Zero. --------------------------------------------------------------------------------------------------------------------------

for pair in (M10_MAHR, SAU_MIT):
    add("force zero leaves 0.8 N", pair, step("launch", f_set(zero_does=("leaves", 0.8))), cure=f_set(zero_does="all"),
        quick=pair is M10_MAHR, why="the gauge takes the command and does not become zero")
add("force zero ignored, 0.8 N there", M10_MAHR, step("launch", f_set(zero_does="nothing", bias=0.8)), cure=f_set(zero_does="all"))
add("force zero ignored, 0.8 N, by weights", SAU_MIT, step("launch", f_set(zero_does="nothing", bias=0.8)), follow="truth",
    cure=f_set(zero_does="all"))
add("force zero ignored, 3 N there", M10_MAHR, step("launch", f_set(zero_does="nothing", bias=3.0)), cure=f_set(zero_does="all"))
for um, quick in ((40.0, False), (4.5, True)):
    add(f"dial zero leaves {um:g} um", M10_MAHR, step("launch", d_set(zero_does=("leaves", um))), cure=d_set(zero_does="all"), quick=quick)
add("dial zero leaves 4 um, stiff", ("mark10", "mahr"), step("launch", d_set(zero_does=("leaves", 4.0))), procedure="stiff", um_per_n=0.3)
add("dial zero ignored", ZTS_SYL, step("launch", d_set(zero_does="nothing")), cure=d_set(zero_does="all"))
add("dial zero ignored, subtracted", ZTS_SYL, step("launch", d_set(zero_does="nothing")), answers={"zero-not-shown": ["subtract"]},
    why="the operator says that it is right: nothing is false")
add("dial zero obeyed only after 1.5 s", ZTS_SYL,
    step("launch", lambda s: setattr(s.d.meter, "zero_does", "nothing")),
    step("launch", lambda s: setattr(s.d, "on_zero", lambda t: s.after(0.8, lambda: s.d.meter.key_zero(s.now()))), attack=False),
    answers={"zero-not-shown": ["subtract"]}, quick=True, why="the zero is subtracted, and then set by the gauge too")
add("force zero obeyed only after 0.8 s", M10_MAHR,
    step("launch", both(f_set(zero_does="nothing", bias=0.7), lambda s: setattr(s.f, "on_zero", lambda t: s.after(0.8, lambda: s.f.meter.key_zero(s.now()))))),
    why="the late zero falls into the preload")
add("zero of the dial drifts 1 um/s", M10_MAHR, step("zeroed", lambda s: d_set(drift_per_s=1.0, drift_from=s.now())(s)))
add("zero of the dial drifts 6 um/s", BARE, step("zeroed", lambda s: d_set(drift_per_s=6.0, drift_from=s.now())(s)))
add("zero of the force drifts 0.05 N/s", SAU_MIT, step("zeroed", lambda s: f_set(drift_per_s=0.05, drift_from=s.now())(s)), quick=True)
add("zero of the force drifts 0.2 N/s", M10_MAHR, step("zeroed", lambda s: f_set(drift_per_s=0.2, drift_from=s.now())(s)))
add("zero of the force drifts 0.5 N/s, stiff", M10_MAG, step("zeroed", lambda s: f_set(drift_per_s=0.5, drift_from=s.now())(s)),
    procedure="stiff", um_per_n=0.3)
add("zero of the dial drifts and comes back", M10_MAHR, step("reading 1", d_set(bias=60.0)), step("reading 4", d_set(bias=0.0)))
add("stand of the dial moved by 60 um, and back", SAU_MIT, step("reading 2", lambda s: s.rig.move_stand(s.now(), 60.0), 0.1),
    step("reading 3", lambda s: s.rig.move_stand(s.now(), -60.0), 0.1), quick=True, why="somebody leans on the stand for one load")
add("stand of the dial moved by 60 um for good", SAU_MIT, step("reading 2", lambda s: s.rig.move_stand(s.now(), 60.0), 0.1))
add("stand of the dial moved by 60 um in the dwell", M10_MAHR, step("band -20", lambda s: s.rig.move_stand(s.now(), 60.0), 0.2),
    step("reading 3", lambda s: s.rig.move_stand(s.now(), -60.0), 0.1))
add("gauge not hanging free while zeroed", SAU_MIT, step("go free", lambda s: s.set_goal("caught", -0.9), nth=0, delay=0.01),
    why="a cable pulls with 0.9 N while the force is zeroed")

# Line lost. ---------------------------------------------------------------------------------------------------------------------


def lost(which, seconds, change):
    """Unplugged; plugged in again with something changed."""
    def act(s):
        gauge = getattr(s, which)
        gauge.unplug()
        s.after(seconds, lambda: (change(s), gauge.plug(), s.write("    plugged in again")))
    return act


for pair, which, what, change, cure, quick in [
    (M10_MAHR, "f", "nothing changed", lambda s: None, None, False),
    (M10_MAHR, "d", "nothing changed", lambda s: None, None, False),
    (M10_MAHR, "f", "tared", f_key_zero, None, False),
    (M10_MAHR, "d", "tared", d_key_zero, None, True),
    (SAU_MIT, "f", "tared", f_key_zero, None, False),
    (SAU_MIT, "d", "tared", d_key_zero, None, False),
    (BARE, "f", "tared", f_key_zero, None, False),
    (ZTS_SYL, "d", "tared", d_key_zero, None, False),
    (NUM_MIT, "f", "in lbf", f_set(unit="lbf"), f_back, True),
    (SAU_MIT, "f", "in kgf", f_set(unit="kgf"), f_back, False),
    (M10_MAHR, "f", "in lbf", f_set(unit="lbf"), f_back, False),
    (ZTS_SYL, "f", "in lbf", f_set(unit="lbf"), f_back, False),
    (ZTS_SYL, "d", "in inch", d_set(unit="in"), d_back, False),
    (BARE, "d", "in inch", d_set(unit="in"), d_back, False),
    (SAU_MIT, "f", "in peak mode", f_peak, cur, False),
    (ZTS_SYL, "d", "in maximum mode", d_peak, d_set(peak=None), False),
    (M10_MAHR, "d", "counting the other way", d_set(sign=-1), d_set(sign=1), False),
]:
    word = "force" if which == "f" else "dial"
    add(f"{word} lost after reading 2, back {what}", pair, step("reading 2", lost(which, 1.2, change), 0.1), cure=cure, quick=quick,
        relax=0.05 if "peak" in what else 0.0, why="a gauge that was without power forgets its settings")
add("dial lost in the dwell, back tared", M10_MAHR, step("band -20", lost("d", 1.2, d_key_zero), 0.25))
add("dial lost on the way, back tared, ended before the zero look", M10_MAHR, step("move -20", lost("d", 1.2, d_key_zero), 0.2),
    step("reading 3", stop, 0.2, attack=False), quick=True)
add("force lost on the way, back tared, ended before the zero look", SAU_MIT, step("move -20", lost("f", 1.2, f_key_zero), 0.2),
    step("reading 3", stop, 0.2, attack=False))
add("dial lost while zeroing, back tared", M10_MAHR, step("at preload", lost("d", 1.2, d_key_zero), 0.2))
add("dial lost after reading 2, another of its kind comes back", BARE,
    step("reading 2", lost("d", 1.2, d_set(bias=-240.0)), 0.1), why="another gauge without identity")
add("dial lost after reading 2, another serial number comes back", M10_MAHR,
    step("reading 2", lost("d", 1.2, lambda s: (setattr(s.d, "serial", "999"), d_set(bias=-240.0)(s))), 0.1),
    cure=lambda s: (setattr(s.d, "serial", "12345678"), d_set(bias=0.0)(s)))
add("dial mute after reading 2, wakes tared", M10_MAHR,
    step("reading 2", lambda s: (setattr(s.d, "mute", True), s.after(5.0, lambda: (d_key_zero(s), setattr(s.d, "mute", False)))), 0.1),
    why="standby: the line stays, the gauge begins anew")
add("force mute after reading 2, wakes in lbf", NUM_MIT,
    step("reading 2", lambda s: (setattr(s.f, "mute", True), s.after(4.0, lambda: (f_set(unit="lbf")(s), setattr(s.f, "mute", False)))), 0.1),
    cure=f_back)


def old_packets(which, seconds):
    """After plugging in again the adapter first empties its buffer."""
    def act(s):
        gauge = getattr(s, which)
        kept = list(gauge.sent_values[-40:])
        gauge.unplug()
        def back():
            gauge.plug()
            end = s.now() + seconds
            turn = iter(kept * 20)
            gauge.mangle = lambda data, t: [(0.0, next(turn, data))] if t < end and data == (gauge.sent_values or [b""])[-1] else None
        s.after(1.2, back)
    return act


add("dial lost, back with old packets for 2.5 s", BARE, step("move -20", old_packets("d", 2.5), 0.05), quick=True,
    why="the adapter empties its buffer after plugging in")
add("dial lost, back with old packets for 4 s, slow", BARE, step("move -20", old_packets("d", 4.0), 0.05), procedure="slow")
add("force lost, back with old packets for 4 s", LINES, step("move -20", old_packets("f", 4.0), 0.05))

# Swapped gauges. ----------------------------------------------------------------------------------------------------------------


def swap_at_launch(s):
    s.swap_links()
    s.f.plug()
    s.d.plug()


def swap_later(s):
    s.swap_links()
    s.after(1.2, lambda: (s.f.plug(), s.d.plug()))


for pair in (BARE, LINES, M10_MAHR):
    add("swapped at the start", pair, step("launch", swap_at_launch), quick=pair is BARE)
    add("swapped after reading 2", pair, step("reading 2", swap_later, 0.1),
        cure=lambda s: (s.swap_links(), s.f.plug(), s.d.plug()))

# Bytes. -------------------------------------------------------------------------------------------------------------------------


def flip(data, place_from_end, mask):
    """One bit of a digit, so that another digit comes out."""
    digits = [i for i, byte in enumerate(data) if 48 <= byte <= 57]
    if len(digits) < place_from_end:
        return data
    i = digits[-place_from_end]
    other = data[i] ^ mask
    return data[:i] + bytes([other]) + data[i + 1:] if 48 <= other <= 57 else data


def bits_low(mask):
    return lambda data: bytes(b & ~mask if 48 <= b <= 57 else b for b in data)


for pair, which, place, mask in ((SAU_MIT, "f", 1, 1), (SAU_MIT, "d", 3, 1), (BARE, "d", 3, 4), (M10_BARE, "d", 1, 2)):
    add(f"one bit flipped in one packet of {which} at capture, digit {place}", pair,
        *[step("band -20", mangle(which, once(lambda data, p=place, m=mask: flip(data, p, m))), delay) for delay in (0.47,)],
        why="a parity bit would have shown it")
    add(f"one bit flipped in one packet of {which} in the dwell, digit {place}", pair,
        step("band -20", mangle(which, once(lambda data, p=place, m=mask: flip(data, p, m))), 0.25))
for pair in (NUM_MIT, SAU_MIT):
    add("bit 2 of the force's tenths flipped in every third packet", pair,
        step("reading 1", mangle("f", lambda s, d, t: [(0, flip(d, 2, 4))] if s.f.packets % 3 == 0 and d in s.f.sent_values else None)),
        quick=pair is SAU_MIT, why="the value kept is the last one, and the band is wider than the fault")
add("bit 0 of the dial's third digit flipped from -20 on", BARE,
    step("near -20", mangle("d", always(lambda data: flip(data, 3, 1)))), cure=unmangle("d"), quick=True)
add("bit 1 of all digits of the dial low", BARE, step("launch", mangle("d", always(bits_low(2)))), cure=unmangle("d"))
add("bit 0 of all digits of the force low after reading 1", SAU_MIT,
    step("reading 1", mangle("f", always(lambda d: d[:1] + bits_low(1)(d[1:])))), cure=unmangle("f"))
add("first digit of the dial lost from -30 on", BARE,
    step("near -30", mangle("d", always(lambda d: d.replace(b"1.", b".").replace(b"0.", b".")))), cure=unmangle("d"))
add("point of the dial lost after reading 2", BARE, step("reading 2", mangle("d", always(lambda d: d.replace(b".", b"")))),
    cure=unmangle("d"))
add("CR lost now and then", LINES, step("reading 1", mangle("d", lambda s, d, t: [(0, d[:-2])] if s.d.packets % 7 == 0 else None)))
add("CR and sign lost: digits of two packets join", BARE,
    step("band -20", mangle("d", once(lambda d: d[:-3])), 0.40),
    step("band -20", mangle("d", once(lambda d: d[-4:])), 0.47), why="the middle of two packets is lost")
add("middle of two packets lost all the time from -20 on", BARE,
    step("near -20", mangle("d", lambda s, d, t: [(0, d[:3])] if s.d.packets % 2 else [(0, d[-3:])])), cure=unmangle("d"), quick=True,
    why="first half of one packet and second half of the next make a number")
add("first digits lost at -30", LINES, step("near -30", mangle("d", always(lambda d: d.replace(b"-1", b"-")))), cure=unmangle("d"))
add("fragments of seven bytes", SAU_MIT, step("reading 2", mangle("f", lambda s, d, t: [(0, d[:3])] if s.f.packets % 3 == 0 else
    [(0, d[3:])] if s.f.packets % 3 == 1 else None)), cure=unmangle("f"))
add("minus lost now and then", BARE, step("reading 1", mangle("d", lambda s, d, t: [(0, d.lstrip(b"-"))] if s.d.packets % 9 == 0 else None)))

# Replies to former requests. ----------------------------------------------------------------------------------------------------


def shifted(which, by):
    """Each request is answered with what was there so many requests ago."""
    def act(s):
        gauge = getattr(s, which)
        queue = []
        def how(data, t):
            if not gauge.sent_values or data != gauge.sent_values[-1]:
                return None
            queue.append(data)
            return [(0.0, queue.pop(0))] if len(queue) > by else []
        gauge.mangle = how
    return act


for by in (1, 20):
    add(f"replies of the dial {by} requests late", M10_MAHR, step("reading 1", shifted("d", by)), cure=unmangle("d"))
add("replies of the dial 15 requests late, slow", SAU_MIT, step("reading 1", shifted("d", 15)), procedure="slow", cure=unmangle("d"))
add("one reply of the force late by 0.35 s on the way", M10_MAHR, step("move -20", lambda s: setattr(s.f, "late_once_s", 0.35), 0.4))
add("one reply of the dial late by 1.4 s on the way", SAU_MIT, step("move -20", lambda s: setattr(s.d, "late_once_s", 1.4), 0.4), quick=True)
add("every reply of the dial late by 0.45 s", M10_MAHR, step("reading 1", lambda s: setattr(s.d, "extra_latency_s", 0.45)))
add("every reply of the dial late by 0.6 s", M10_MAHR, step("reading 1", lambda s: setattr(s.d, "extra_latency_s", 0.6)),
    cure=lambda s: setattr(s.d, "extra_latency_s", 0.0))
add("every packet of the dial twice, the second 0.4 s later", M10_MAHR,
    step("reading 1", mangle("d", lambda s, d, t: [(0, d), (0.4, d)] if b"mm" in d and len(d) > 8 else None)), cure=unmangle("d"))

# Sign. --------------------------------------------------------------------------------------------------------------------------

for pair, quick in ((M10_MAHR, False), (SAU_MIT, True)):
    add("force sign turned after reading 2", pair, step("reading 2", lambda s: setattr(s.f.meter, "sign", -s.f.meter.sign), 0.1),
        cure=lambda s: setattr(s.f.meter, "sign", -s.f.meter.sign))
    add("dial sign turned after reading 2", pair, step("reading 2", lambda s: setattr(s.d.meter, "sign", -s.d.meter.sign), 0.1),
        cure=lambda s: setattr(s.d.meter, "sign", -s.d.meter.sign))
    add("dial sign turned at the preload, before reading 1", pair,
        step("zeroed", lambda s: (setattr(s.d.meter, "sign", -s.d.meter.sign)), 0.02), quick=quick)
add("dial without sign after reading 1", BARE, step("reading 1", d_set(absolute=True)), cure=d_set(absolute=False))
add("dial without sign from the start", BARE, step("launch", d_set(absolute=True)), cure=d_set(absolute=False))
add("force without sign from the start", M10_MAHR, step("launch", f_set(absolute=True)), cure=f_set(absolute=False))
add("push answered the wrong way", M10_MAHR, step("go free", lambda s: None), answers={"sign-check": ["plus"]},
    why="the operator pushes toward minus and says plus: the wrong answer of a person")
add("dial sign turned between cells", M10_MAHR, step("reading 4", lambda s: setattr(s.d.meter, "sign", -1), 0.1), procedure="cells")

# Overload. ----------------------------------------------------------------------------------------------------------------------

for pair, shown_n in ((SAU_MIT, -20.0), (SAU_MIT, -999.99), (NUM_MIT, 20.0)):
    text = f"{abs(shown_n):.2f}"
    add(f"force overload shown as {text}", pair, step("end -20", f_set(held=shown_n)),
        step("end -20", lambda s: s.rig.ramp(s.now(), -45.0, 0.3), 0.02, attack=False), step("reading 3", f_free, 0.05, attack=False),
        cure=f_free, why="beyond the capacity the maker says nothing: a number stands there")
add("dial beyond its range shows zeros", BARE, step("near -20", mangle("d", always(lambda d: b"0.000\r\n"))), cure=unmangle("d"))
add("dial beyond its range shows nines", BARE, step("near -20", mangle("d", always(lambda d: b"-0.999\r\n"))), cure=unmangle("d"))

# Lines of text with numbers. ----------------------------------------------------------------------------------------------------


def chatter(which, text, period=0.3):
    def act(s):
        gauge = getattr(s, which)
        def say():
            if gauge.master is not None:
                gauge.outbox.append((s.now(), text))
                gauge.outbox.sort(key=lambda entry: entry[0])
            s.after(period, say)
        say()
    return act


for pair, which, text in [
    (LINES, "d", b"KEEPALIVE 17\r\n"), (LINES, "d", b"17\r\n"), (LINES, "d", b"# 17\r\n"), (BARE, "d", b"0\r\n"), (BARE, "d", b"12:30:15\r\n"),
    (BARE, "f", b"0\r\n"), (LINES, "f", b"BAT 3.9 V\r\n"), (LINES, "d", b"21.5 C\r\n"), (SAU_MIT, "d", b"911\r"),
    (M10_MAHR, "f", b"V1.00;N;CUR;FLTC8;FLTP1;AOUT00;AOFF0;FULL;MIT;POL;B0\r\n"),
]:
    word = text.decode().strip().split(";")[0]
    add(f"text {word!r} of {which} every 0.3 s", pair, step("zeroed", chatter(which, text), 0.1), cure=None)
add("one bare 0 of the dial at capture", BARE, step("band -20", mangle("d", once(lambda d: b"0.000\r\n")), 0.46))
add("dial repeats a keepalive value while it moves", BARE,
    step("move -20", mangle("d", lambda s, d, t: [(0, s.kept)] if t < s.until else None), 0.05),
    step("move -20", lambda s: (setattr(s, "kept", s.d.sent_values[-1]), setattr(s, "until", s.now() + 2.6)), attack=False))

# Typed by accident. -------------------------------------------------------------------------------------------------------------


def typing(line, period=0.25, seconds=30.0):
    def act(s):
        end = s.now() + seconds
        def again():
            if s.proc.poll() is None and s.now() < end:
                s.type(line)
                s.after(period, again)
        again()
    return act


add("'accept' typed all the time, dial held", M10_MAHR, step("go -10", typing("accept")),
    step("move -10", d_hold, 0.02), step("reading 2", d_free, 0.05, attack=False), quick=True)
add("enter typed all the time", M10_MAHR, step("go 0", typing("")))
add("'take' typed all the time", SAU_MIT, step("go -10", typing("take", 0.2)))
add("'yes' typed all the time", SAU_MIT, step("zeroed", typing("yes", 0.2)))
add("'keep' typed all the time, dial tared", M10_MAHR, step("reading 2", d_key_zero, 0.1), step("reading 2", typing("keep"), 0.2), quick=True)
add("'zero' typed all the time, gauge caught", SAU_MIT, step("go free", lambda s: s.set_goal("caught", -6.0), 0.01), step("go free", typing("zero", 0.3, 8.0), 0.1))
add("'subtract' typed all the time, dial held", M10_MAHR, step("go preload", d_hold, 0.01), step("go preload", typing("subtract", 0.3, 6.0)),
    step("zeroed", d_free, 0.05, attack=False))
add("'flip' typed all the time, dial sign turned", SAU_MIT, step("zeroed", lambda s: setattr(s.d.meter, "sign", 1), 0.02),
    step("zeroed", typing("flip", 0.3, 10.0), 0.1))
add("'r' typed on the way to -30", M10_MAHR, step("move -30", lambda s: s.type("r"), 0.2))
add("'p' typed twice in the dwell, dial tared meanwhile", M10_MAHR, step("band -20", lambda s: s.type("p"), 0.1),
    step("band -20", d_key_zero, 0.5), step("band -20", lambda s: s.type("p"), 1.0))
add("reading taken by key with the dial held", BARE, step("near -20", d_hold), step("near -20", lambda s: s.type(""), 0.1),
    step("near -20", lambda s: s.type("take"), 0.9), step("reading 3", d_free, 0.05, attack=False))

# Interrupted and gone on with. --------------------------------------------------------------------------------------------------

interrupt = lambda s: s.interrupt()
kill = lambda s: s.kill()
nothing = lambda s: None
for how, act, event, delay in (("Ctrl-C", interrupt, "reading 3", 0.2), ("kill -9", kill, "reading 3", 0.02), ("kill -9", kill, "band -20", 0.3),
                               ("kill -9", kill, "move preload", 0.1)):
    where = {"reading 3": "after reading 3", "band -20": "in the dwell at -20", "move preload": "while zeroing"}[event]
    add(f"{how} {where}", M10_MAHR, step(event, act, delay), resumes=[nothing])
for um, quick in ((8.0, False), (60.0, False)):
    add(f"Ctrl-C after reading 3, specimen moved by {um:g} um", M10_MAHR, step("reading 3", interrupt, 0.2), quick=quick,
        resumes=[lambda s, um=um: s.rig.move_stand(s.now(), um)])
for pair, what, change, quick in [
    (M10_MAHR, "force tared under load", f_key_zero, True),
    (SAU_MIT, "force tared under load", f_key_zero, False),
    (M10_MAHR, "dial tared under load", d_key_zero, False),
    (NUM_MIT, "force in lbf", f_set(unit="lbf"), False),
    (SAU_MIT, "force in kgf", f_set(unit="kgf"), False),
    (M10_MAHR, "force in lbf", f_set(unit="lbf"), False),
    (ZTS_SYL, "dial in inch", d_set(unit="in"), False),
    (BARE, "dial in inch", d_set(unit="in"), False),
    (M10_MAHR, "dial sign turned", d_set(sign=-1), False),
    (SAU_MIT, "dial sign turned", d_set(sign=1), True),
    (M10_MAHR, "dial held", d_hold, False),
    (BARE, "another dial, half as sensitive", lambda s: setattr(s.d.meter, "truth", lambda t: s.rig.dial_um(t) / 2), False),
    (BARE, "force in lbf", f_set(unit="lbf"), False),
]:
    cure = {"force in lbf": f_back, "force in kgf": f_back, "dial in inch": d_back, "dial held": d_free}.get(what)
    add(f"kill -9 after reading 3, {what}", pair, step("reading 3", kill, 0.1), resumes=[change], quick=quick, cure=cure)
add("Ctrl-C after reading 3, force tared under load, stiff", M10_MAG, step("reading 3", interrupt, 0.2), resumes=[f_key_zero],
    procedure="stiff", um_per_n=0.3, quick=True, why="the look at the zero moves by less than its limit")
add("Ctrl-C after reading 3, another serial number, said yes", M10_MAHR, step("reading 3", interrupt, 0.2),
    resumes=[lambda s: (setattr(s.d, "serial", "999"), setattr(s.d.meter, "sign", -1))], answers={"other-gauge": ["yes"]},
    why="the other gauge is mounted the other way round")
add("Ctrl-C after reading 3, another serial number, said no", M10_MAHR, step("reading 3", interrupt, 0.2),
    resumes=[lambda s: setattr(s.d, "serial", "999")])
add("Ctrl-C after reading 3, gauges swapped", BARE, step("reading 3", interrupt, 0.2), resumes=[lambda s: s.swap_links()])
add("resumed twice, dial tared the second time", SAU_MIT, step("reading 2", interrupt, 0.2), step("reading 4", kill, 0.1),
    resumes=[nothing, d_key_zero])

# More that are run with --quick: one of each kind. ------------------------------------------------------------------------------

QUICK = (
    "control slow [sauter", "control stiff", "control resume", "control back [sauter", "force unit lbf after reading 2 [zts",
    "dial unit inch after reading 2 [mark10+magnescale]", "force tared and set back", "force tared while zeroing the dial",
    "force tared after reading 2, ended", "dial held 6 N before -20, released after the reading [sauter", "force held at the load, jack goes on",
    "both held at the load", "dial stops at 600 um from the zero", "force stops at 30.2", "dial in steps of 0.05", "last digit of the dial",
    "dial zero leaves 4 um, stiff", "force zero ignored, 0.8 N there", "zero of the dial drifts and comes back",
    "stand of the dial moved by 60 um in the dwell", "gauge not hanging free", "dial lost after reading 2, back in inch [zts",
    "dial lost after reading 2, back in maximum", "dial lost after reading 2, back tared [sauter", "bit 1 of all digits", "one bare 0",
    "dial repeats a keepalive", "kill -9 after reading 3, another dial", "Ctrl-C after reading 3 [", "dial sign turned after reading 2 [mark10",
    "text '0' of d", "force overload shown as 20.00", "dial late by 3 s from the start", "dial cached while it moves",
)
for attack in ALL:
    attack.quick = attack.quick or attack.name.startswith(QUICK)
