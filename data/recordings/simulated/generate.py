#!/usr/bin/env python3
"""Independent simulator of force/displacement recordings of one part. See README.md.
Dimensionless inside: driver x reaches |x| = 1, base spring has slope 1; scaled to N and mm at the end."""
import argparse, json, os
import numpy as np
from scipy.signal import lfilter

M = 4  # fine steps between two readings


def logu(g, a, b):
    return float(np.exp(g.uniform(np.log(a), np.log(b))))


# ---------------------------------------------------------------- motion
def motion(g, o):
    """Fine path x, run numbers, stride offset. o: needs (time, runs, both, one, unload, minsamp)."""
    runs = g.random() < 0.4 if o.get("runs") is None else o["runs"]
    nr = int(g.integers(3, 7)) if runs else 1
    cyc = int(g.integers(1, 3)) if runs else int(g.integers(o.get("mincyc", 1), 13))
    both = g.random() < 0.5 if o.get("both") is None else o["both"]
    sign = -1.0 if g.random() < 0.2 else 1.0
    shapes = ["ramp", "steps", "sine", "random"]
    shape = g.choice(shapes, p=o.get("p", [0.4, 0.2, 0.2, 0.2]))
    loadonly = bool(runs and o.get("loadonly") and g.random() < 0.25 and shape in ("ramp", "steps"))
    if loadonly:
        cyc = 1
    n = int(logu(g, 100, 2000))
    n = min(2000, max(n, 24 * cyc * nr * (2 if both else 1)))
    rates = g.random() < (0.7 if o.get("time") else 0.25)
    hold = g.random() < (0.5 if o.get("time") else 0.1)
    grow = o.get("grow") and g.random() < 0.7
    per = n / (nr * cyc)
    stephold = int(g.integers(4, 21)) if o.get("time") or g.random() < 0.4 else 1
    parts, rn = [], []
    for r in range(nr):
        pts = [np.zeros(1)]
        for c in range(cyc):
            f = logu(g, 0.4, 2.5) if rates else 1.0
            ncy = max(20, per * f)
            i, tot = r * cyc + c, nr * cyc
            A = 1.0
            if shape == "random":
                A = g.uniform(0.3, 1.0) if i != tot // 2 else 1.0
            if grow:
                A = 0.35 + 0.65 * (i + 1) / tot
            if shape == "sine":
                k = 4 * max(5, int(ncy / 4))
                ph = 2 * np.pi * np.arange(1, k * M + 1) / (k * M)
                pts.append(A * (np.sin(ph) if both else (1 - np.cos(ph)) / 2))
                continue
            B = A * (1.0 if shape != "random" else g.uniform(0.6, 1.0) if g.random() < 0.5 else 1.0)
            turn = [0, A, -B, 0] if both else [0, A, 0]
            if loadonly:
                turn = [0, A]
            dist = sum(abs(np.diff(turn)))
            for a, b in zip(turn[:-1], turn[1:]):
                k = max(6, int(round(ncy * abs(b - a) / dist)))
                if shape == "steps":
                    lev = max(6, k // stephold)
                    for q in range(1, lev + 1):
                        u, v = a + (b - a) * (q - 1) / lev, a + (b - a) * q / lev
                        pts.append(u + (v - u) * np.arange(1, M + 1) / M)
                        if stephold > 1:
                            pts.append(np.full((stephold - 1) * M, v))
                else:
                    pts.append(a + (b - a) * np.arange(1, k * M + 1) / (k * M))
                    if hold:
                        pts.append(np.full(int(ncy * 0.25) * M, b))
        x = np.concatenate(pts)
        x = x[: (len(x) - 1) // M * M + 1]
        # one reading interval between runs, so the clock stays even
        if r:
            x = np.concatenate([np.full(M - 1, x[0]), x])
        parts.append(x)
        rn.append(np.full(len(x), r + 1))
    x, rn = np.concatenate(parts) * sign, np.concatenate(rn)
    x = x / np.abs(x).max()
    off = 0 if g.random() < 0.75 or shape == "steps" else int(g.integers(1, M))
    idx = np.arange(off, len(x), M)
    if not 100 <= len(idx) <= 2000:
        return motion(g, o)
    T = logu(g, 20, 7200)
    return dict(x=x, rn=rn, idx=idx, h=T / len(x), T=T, runs=runs, nr=nr, cyc=cyc, both=both, shape=str(shape),
                loadonly=loadonly, off=off, rates=bool(rates), hold=bool(hold), stephold=stephold)


# ---------------------------------------------------------------- elements
def lag(x, h, tau, z0=0.0):
    a = np.exp(-h / tau)  # input even between fine steps (midpoint)
    u = np.empty_like(x); u[0] = z0 / max(1e-12, 1 - a) if z0 else 0.0
    u[1:] = (x[1:] + x[:-1]) / 2
    z = lfilter([1 - a], [1, -a], np.concatenate([[0.0], u[1:]]))
    return z + z0 * a ** np.arange(len(x))


def fric_d_beside(x, kj, fy, s):
    y = np.empty_like(x); p = x[0]
    for i, d in enumerate(x.tolist()):
        s += kj * (d - p); p = d
        s = fy if s > fy else -fy if s < -fy else s
        y[i] = d + s
    return y


def fric_d_series(x, k2, fy, u):  # K1 = 1
    y = np.empty_like(x)
    for i, d in enumerate(x.tolist()):
        q = (d - u) - k2 * u
        if q > fy: u = (d - fy) / (1 + k2)
        elif q < -fy: u = (d + fy) / (1 + k2)
        y[i] = d - u
    return y


def fric_f_series(x, k2, fy, u):
    y = np.empty_like(x)
    for i, f in enumerate(x.tolist()):
        q = f - k2 * u
        if q > fy: u = (f - fy) / k2
        elif q < -fy: u = (f + fy) / k2
        y[i] = f + u
    return y


def fric_f_beside(x, kj, fy, s):  # K = 1
    y = np.empty_like(x); d = -s; p = x[0]
    for i, f in enumerate(x.tolist()):
        dd = (f - p) / (1 + kj); p = f
        s1 = s + kj * dd
        if s1 > fy: s = fy; d = f - s
        elif s1 < -fy: s = -fy; d = f - s
        else: s = s1; d += dd
        y[i] = d
    return y


# ---------------------------------------------------------------- library equations, for the observer (docs/physics.md)
def turnpath(x, rn):
    p = np.concatenate([[0], np.cumsum(np.abs(np.diff(x)))])
    return p - np.abs(x - x[0])


def obs_static(name, x, P, force_set):
    lo, hi = x.min(), x.max()
    X = x[:, None]
    if name == "joint-backlash":
        return np.sign(X) * (np.abs(X) > P[0]) if force_set else -np.clip(X, -P[0] / 2, P[0] / 2)
    if name == "preloaded-backlash":  # P: edges
        a, b = np.minimum(P[0], P[1]), np.maximum(P[0], P[1])
        s = np.clip(X, a, np.maximum(b, a + 1e-3))
        return s if force_set else -s
    if name == "end-stop":
        v = np.maximum(np.abs(X) - P[0], 0) * np.sign(X)
        return -v if force_set else v
    if name == "joint-separation":
        v = np.maximum(np.abs(X) - P[0], 0) * np.sign(X)
        return v if force_set else -v
    if name == "contact+" or name == "contact-":
        s = 1 if name[-1] == "+" else -1
        if force_set:
            return s * np.maximum(s * X, 0) ** (1 / P[0])
        return s * np.maximum(s * (X - P[1]), 0) ** P[0]


def obs_hist(name, x, t, rn, P, force_set):
    n, k = len(x), len(P[0])
    out = np.empty((n, k))
    if name in ("joint-friction", "load-dependent-friction"):
        r = P[0]; mu = P[1] if name[0] == "l" else 0 * r
        if force_set:
            s0 = P[1] * r if name[0] == "j" else 0 * r
            p = x[0] - s0
            for i in range(n):
                R = r + mu * abs(x[i])
                p = np.minimum(np.maximum(p, x[i] - R), x[i] + R); out[i] = p
        else:
            s = P[1] * r if name[0] == "j" else 0 * r
            s = s + 0 * r
            for i in range(n):
                R = r * (1 + mu * abs(x[i]))
                s = np.minimum(np.maximum(s + (x[i] - x[i - 1] if i else 0), -R), R); out[i] = s
        return out
    if name == "maxwell-slip":
        L = P[0][None, :] * ((np.arange(1, 6) - 0.5) / 5)[:, None]
        s = L * P[1][None, :]
        if force_set:
            p = x[0] - s
            for i in range(n):
                p = np.minimum(np.maximum(p, x[i] - L), x[i] + L); out[i] = p.sum(0)
        else:
            for i in range(n):
                s = np.minimum(np.maximum(s + (x[i] - x[i - 1] if i else 0), -L), L); out[i] = s.sum(0)
        return out
    if name in ("relaxation", "creep"):
        h = t[1] - t[0]
        for j in range(k):
            if name == "relaxation":
                z = lag(x, h, P[0][j])
            else:
                z = sum(lag(x, h, P[0][j] * 10 ** (i / 2)) for i in range(10)) / 2
            out[:, j] = z if force_set else -z
        return out


class Observer:
    """least squares with the true noise: line + a zero for each run + one law, on the noise-free recording"""
    def __init__(s, x, y, t, rn, sd, phi, force_set):
        s.x, s.t, s.rn, s.fs, s.phi, s.sd = x, t, rn, force_set, phi, sd
        B = np.column_stack([x] + [(rn == r).astype(float) for r in np.unique(rn)])
        s.Q, _ = np.linalg.qr(s.w(B)); yw = s.w(y[:, None])
        s.y = (yw - s.Q @ (s.Q.T @ yw))[:, 0]; s.null = float(s.y @ s.y)

    def w(s, G):
        G = G / s.sd[:, None]
        if s.phi:
            H = G.copy(); H[1:] = (G[1:] - s.phi * G[:-1]) / np.sqrt(1 - s.phi ** 2); return H
        return G

    def chi(s, G, signed=True):
        G = s.w(G); G = G - s.Q @ (s.Q.T @ G)
        d = (G * G).sum(0); a = s.y @ G
        ok = d > 1e-9 * len(s.y)
        if signed: ok &= a > 0
        return np.where(ok, s.null - np.where(ok, a * a / np.where(ok, d, 1), 0), s.null)

    def search(s, f, axes, rounds=4):
        """axes: list of (lo, hi, n, log)"""
        ax = [np.geomspace(a, b, n) if l else np.linspace(a, b, n) for a, b, n, l in axes]
        best = s.null
        for _ in range(rounds):
            g = [m.ravel() for m in np.meshgrid(*ax, indexing="ij")]
            c = s.chi(f(g)); j = int(np.argmin(c)); best = min(best, float(c[j]))
            new = []
            for a, (lo, hi, n, l), q in zip(ax, axes, g):
                v = q[j]; i = int(np.argmin(abs(a - v)))
                u, w = a[max(0, i - 1)], a[min(len(a) - 1, i + 1)]
                m = 9 if len(axes) == 1 else 6
                new.append(np.append(np.geomspace(u, w, m), v) if l else np.append(np.linspace(u, w, m), v))
                new[-1].sort()
            ax = new
        return best

    def all(s, times=True):
        x, t, rn, fs, R = s.x, s.t, s.rn, s.fs, {}
        lo, hi = x.min(), x.max(); A = np.abs(x).max(); T = t[-1] - t[0]
        st = lambda nm: (lambda g: obs_static(nm, x, g, fs))
        hi_ = lambda nm: (lambda g: obs_hist(nm, x, t, rn, g, fs))
        R["joint-backlash"] = s.search(st("joint-backlash"), [(0, A * (1 if fs else 2), 60, 0)])
        R["preloaded-backlash"] = s.search(st("preloaded-backlash"), [(lo, hi, 22, 0), (lo, hi, 22, 0)])
        R["end-stop"] = s.search(st("end-stop"), [(0.02, 0.995 * A, 60, 0)])
        R["joint-separation"] = s.search(st("joint-separation"), [(0.02, 0.995 * A, 60, 0)])
        c = s.null
        for q in "+-":
            axes = [(1, 2.2, 8, 0)] + ([] if fs else [(lo, lo + 0.99 * (hi - lo), 20, 0)])
            c = min(c, s.search(st("contact" + q), axes))
        R["contact"] = c
        R["joint-nonlinearity"] = float(s.chi((x * abs(x))[:, None], False)[0])
        G = s.w(np.column_stack([x ** 3, x ** 5])); G = G - s.Q @ (s.Q.T @ G)
        q = np.linalg.lstsq(G, s.y, rcond=None)[0]; R["odd-polynomial"] = float(((s.y - G @ q) ** 2).sum())
        R["joint-friction"] = s.search(hi_("joint-friction"), [(0.003, 0.95 * A, 22, 1), (-1, 1, 7, 0)])
        R["maxwell-slip"] = s.search(hi_("maxwell-slip"), [(0.005, 1.5 * A, 22, 1), (-1, 1, 3, 0)], 3)
        R["load-dependent-friction"] = s.search(hi_("load-dependent-friction"),
                                                [(0.003, 0.95 * A, 14, 1), (0, 0.95 if fs else 10, 8, 0)], 3)
        m = np.maximum(np.maximum.accumulate(abs(x)), 1e-9)
        R["softening"] = float(s.chi(((1 if fs else -1) * x * (1 - abs(x) / m))[:, None])[0])
        p = turnpath(x, rn)
        R["setting-in"] = min(s.search(lambda g: sg * (1 - np.exp(-p[:, None] / g[0])), [(0.25 * A, 16 * A, 30, 1)]) for sg in (1, -1))
        R["thermal-drift"] = float(s.chi(t[:, None], False)[0])
        if times:
            R["relaxation"] = s.search(hi_("relaxation"), [(T / 1000, 3 * T, 24, 1)], 3)
            R["creep"] = s.search(hi_("creep"), [(T / 1000, 3 * T, 14, 1)], 3)
            R["warm-up"] = min(s.search(lambda g: sg * (1 - np.exp(-(t - t[0])[:, None] / g[0])), [(T / 1000, 3 * T, 30, 1)]) for sg in (1, -1))
        if len(np.unique(rn)) > 1:
            c = s.null
            for r in np.unique(rn):
                j = np.flatnonzero(rn == r); c = min(c, float(s.chi(((np.arange(len(x))[:, None] >= j[None, 1:]) & (rn == r)[:, None]).astype(float), False).min()))
            R["slip"] = c
        if fs: R["force-gauge-nonlinearity"] = R["joint-nonlinearity"]
        return R


def exact_names(x, y, rn, fs, kinks, power=1):
    """all laws of the library without memory that are this y exactly (sign of the size counted, plausible ranges not)"""
    B = np.column_stack([x] + [(rn == r).astype(float) for r in np.unique(rn)]); Q, _ = np.linalg.qr(B)
    pr = lambda v: v - Q @ (Q.T @ v)
    z = pr(y); lo, hi = x.min(), x.max(); out = []
    def test(nm, G):
        G = pr(G); d = G @ G
        if d > 1e-12 * len(x):
            a = (G @ z) / d
            if a > 0 and ((z - a * G) ** 2).sum() < 1e-14 * (z @ z) and nm not in out: out.append(nm)
    f = lambda nm, *P: obs_static(nm, x, [np.array([float(p)]) for p in P], fs)[:, 0]
    ed = sorted(set(kinks) | {-k for k in kinks} | {lo, hi})
    for k in kinks:
        k_ = abs(k)
        test("end-stop", f("end-stop", k_)); test("joint-separation", f("joint-separation", k_))
        if not fs: test("joint-backlash", f("joint-backlash", 2 * k_))
        for sg in "+-":
            if fs and k == 0: test("contact", f("contact" + sg, power))
            if not fs and (hi if sg == "+" else -lo) > 1e-6: test("contact", f("contact" + sg, power, k))
    for a in ed:
        for b in ed:
            if b > a + 1e-3: test("preloaded-backlash", f("preloaded-backlash", a, b))
    test("odd-polynomial", x ** 3); test("joint-nonlinearity", x * abs(x)); test("joint-nonlinearity", -x * abs(x))
    return out


# ---------------------------------------------------------------- the kinds
def draw(g, kind, sub, fs):
    """-> motion, answer on the fine path, right, note, physically"""
    o = {2: dict(mincyc=1), 7: dict(time=True), 8: dict(mincyc=3, grow=sub == "softening"), 10: dict(runs=True, loadonly=True)}.get(kind, dict(loadonly=True))
    o = dict(o)
    if kind == 3 and (sub in ("free", "seat", "symmetric")): o["both"] = True
    if kind == 11:
        o = dict(time=True, mincyc=2)
        if sub == "random-stiffness": o = dict(runs=True, loadonly=True)
        if sub == "plastic": o = dict(grow=True, mincyc=3)
        if sub in ("rayleigh", "structural"): o = dict(p=[0.2, 0, 0.3, 0.5], runs=False, mincyc=3)
        if sub == "viscous" or sub == "delay" or sub == "lag": o = dict(time=True, mincyc=2, p=[0.3, 0, 0.4, 0.3])
    if kind == 6 and fs and sub == "p1": o["both"] = True
    m = motion(g, o); x, rn, h, T = m["x"], m["rn"], m["h"], m["T"]
    xs = None; phys = []; lo, hi = x.min(), x.max(); dirn = 1.0 if hi > -lo + 1e-9 or (hi >= -lo - 1e-9 and g.random() < 0.5) else -1.0
    kinks, power = None, 1
    if kind == 1:
        y, right, note = x.copy(), ["nothing-missing"], "linear"
    elif kind == 2:
        u0 = g.uniform(-1, 1)
        if sub == "one":
            k, fy, beside = logu(g, 0.03, 10), logu(g, 0.01, min(0.6, 0.45 * (hi - lo))), g.random() < 0.5
            if beside:
                lead = fy; fy = k * lead / (1 + k if fs else 1)  # lead: the way (load, where that is set) until it slides
                y = (fric_f_beside if fs else fric_d_beside)(x, k, fy, u0 * fy)
            else:
                y = (fric_f_series if fs else fric_d_series)(x, k, fy, u0 * fy / k)
            right, note = ["joint-friction"], f"one slider {'beside' if beside else 'in series with'} the spring, stiffness {k:.3g}, slides at {fy:.3g}, start {u0:.2f} of its limit"
        else:
            c, L = logu(g, 0.03, 3), logu(g, 0.1, 1.2); u0 = u0 if g.random() < 0.5 else 0.0
            y = x.copy()
            for i in range(1, 6):
                l = L * (i - 0.5) / 5
                y += (fric_f_series(x, 1 / c, l, -u0 * l * c) if fs else fric_d_beside(x, c, c * l, u0 * c * l)) / 5 - x / 5
            right, note = ["maxwell-slip"], f"five sliders, limits up to {0.9*L:.3g}, start {u0:.2f} of each limit"
    elif kind == 3:
        if fs and sub in ("free", "seat"):
            p = logu(g, 0.002, 0.15); seat = 0.0 if sub == "free" else g.uniform(0.05, 0.6)
            s0 = g.uniform(-1, 1); y = x.copy(); cur = s0 if sub == "free" else 0.0
            for i, f in enumerate(x.tolist()):
                if abs(f) > seat + 1e-9: cur = 1.0 if f > 0 else -1.0
                elif sub == "seat": cur = 0.0
                y[i] += p * cur
            right, note = ["joint-backlash"], f"play +-{p:.3g}, taken up at load {seat:.3g}, start {s0:.2f}"
        else:
            mid = 0.0 if sub == "symmetric" else g.uniform(lo + 0.1 * (hi - lo), hi - 0.1 * (hi - lo))
            w = logu(g, 0.01, 0.5) * (hi - lo) * 0.6; k = g.uniform(0.2, 1.0) if g.random() < 0.6 else 1.0
            c = k / (1.02 - k) if fs else 0
            gap = np.clip(x - mid, -w / 2, w / 2)
            if fs:  # faces bridged by a weak centring spring: it yields within the play
                y = x + c * gap
            else:
                y = x - k * gap
            y = y - y[0]
            kinks = [q for q in (mid - w / 2, mid + w / 2) if lo < q < hi]
            right, note = None, f"play about {mid:.3g}, width {w:.3g}, stiffness lost in it {k:.3g}"
            phys = ["joint-backlash", "preloaded-backlash"] if mid == 0 else ["preloaded-backlash"]
    elif kind == 4:
        amp = hi if dirn > 0 else -lo
        fr, ks = logu(g, 0.01, 0.3), logu(g, 1, 299)
        two = sub == "two"
        stop = amp * (1 - fr)
        pen = np.maximum(dirn * x - stop, 0) * dirn
        if two: pen = pen + -dirn * np.maximum(-dirn * x - stop, 0)
        y = x - pen * (1 - 1 / (1 + ks)) if fs else x + ks * pen
        kinks = [dirn * stop]; phys = ["end-stop"]
        right, note = None, f"stop {'both sides' if two else 'one side'} in the last {100*fr:.1f} % of the travel, {1+ks:.3g} times as stiff"
    elif kind == 5:
        amp = hi if dirn > 0 else -lo
        q, ratio = amp * g.uniform(0.2, 0.92), g.uniform(0.05, 0.8)
        ov = np.maximum(dirn * x - q, 0) * dirn
        if sub == "two": ov = ov - dirn * np.maximum(-dirn * x - q, 0)
        y = x + ov * (1 / ratio - 1) if fs else x - ov * (1 - ratio)
        kinks = [dirn * q]; phys = ["joint-separation"]
        right, note = None, f"opens at {q:.3g} of the range, {'both faces' if sub=='two' else 'one face'}, then {ratio:.2f} of the stiffness"
    elif kind == 6:
        power = {"p1": 1.0, "p1.5": 1.5, "p2": 2.0}[sub]; amp = hi if dirn > 0 else -lo
        size = logu(g, 0.02, 3)
        if fs:
            on = 0.0; y = x + size * dirn * np.maximum(dirn * x / amp, 0) ** (1 / power)
        else:
            on = g.uniform(0.0, 0.9) * amp if g.random() < 0.8 or lo * hi == 0 else -g.uniform(0, 0.7) * amp
            y = x + size * dirn * (np.maximum(dirn * x - on, 0) / (amp - on)) ** power
        kinks = [dirn * on if on else 0.0]; phys = ["contact"]
        right, note = None, f"contact of power {power}, onset {on:.3g}, size {size:.3g}"
    elif kind == 7:
        t = np.arange(len(x)) * h
        if sub == "relaxation":
            k, tau = logu(g, 0.02, 1.5), T * logu(g, 0.004, 0.5); z = lag(x, h, tau)
            y = x + k * z if fs else x + k * (x - z)
            right, note = ["relaxation"], f"size {k:.3g}, tau {tau/T:.3g} of the recording"
        elif sub == "creep":
            k, tau = logu(g, 0.02, 1), T * logu(g, 0.001, 0.05)
            z = sum(lag(x, h, tau * 10 ** (i / 2)) for i in range(10)) / 2
            y = x + k * z if fs else x * (1 + 2 * k) - k * z
            right, note = ["creep", "relaxation"], f"chain of ten, two a decade, {k:.3g}, first tau {tau/T:.3g} of the recording; relaxation is listed because the brief wants it, only creep is exact"
        elif sub == "warm-up":
            s, tau = logu(g, 0.01, 0.5) * g.choice([-1, 1]), T * logu(g, 0.03, 0.6)
            y = x + s * (1 - np.exp(-t / tau)); right, note = ["warm-up"], f"size {s:.3g}, tau {tau/T:.3g} of the recording"
        else:
            s = logu(g, 0.01, 0.3) * g.choice([-1, 1]); y = x + s * t / T
            right, note = ["thermal-drift"], f"{s:.3g} of the range in the recording"
    elif kind == 8:
        if sub == "softening":
            k = g.uniform(0.03, 0.6); mx = np.maximum(np.maximum.accumulate(abs(x)), 1e-9)
            y = x + (1 if fs else -1) * k * x * (1 - abs(x) / mx); right, note = ["softening"], f"Mullins, {k:.3g}"
        else:
            s, path = logu(g, 0.01, 0.4) * g.choice([-1, 1]), turnpath(x, rn)
            dec = min(16.0, max(0.25, path[-1] * logu(g, 0.05, 0.6)))
            y = x + s * (1 - np.exp(-path / dec)); right, note = ["setting-in"], f"size {s:.3g}, decay {dec:.3g} of path (net way from the start taken off, as the equation says)"
    elif kind == 9:
        c3 = g.uniform(-0.5, 0) if g.random() < 0.5 else logu(g, 0.02, 3)
        if c3 < -0.32: c3 = -0.32
        y = x + c3 * x ** 3; right, note = ["odd-polynomial"], f"cubic {c3:.3g}"
    elif kind == 10:
        r = int(g.integers(1, m["nr"] + 1)); j = np.flatnonzero(rn == r)
        a = j[int(len(j) * g.uniform(0.12, 0.88))]; J = logu(g, 0.005, 0.15) * g.choice([-1, 1])
        y = x.copy(); y[a:j[-1] + 1] += J; right, note = ["slip"], f"jump {J:.3g} in run {r} from {100*(a-j[0])/len(j):.0f} % of it on"
    else:
        right = ["something-unknown"]
        if sub == "lag":
            tau = logu(g, 0.001, 0.02) * T; y = x.copy(); xs = lag(x, h, tau)
            if not fs and g.random() < 0.5: xs = None; y = lag(x, h, tau); what = "force (read)"
            else: what = "set"
            note = f"first-order lag of the {what} channel, {tau/T:.3g} of the recording"
        elif sub == "delay":
            n = max(2, int(len(x) * logu(g, 0.001, 0.01))); y = np.concatenate([np.full(n, x[0]), x[:-n]])
            note = f"dead time of the read channel, {n/len(x):.3g} of the recording"
        elif sub == "viscous":
            b = logu(g, 0.002, 0.1) * T; v = np.gradient(x, h)
            y = x + b / m["cyc"] / 8 * v if not fs else lag(x, h, b / m["cyc"])
            if fs:  # damper beside the spring and a second lag in the gauge: no single time constant
                y = lag(y, h, b / m["cyc"] * 0.6)
            note = "damper force with the speed" if not fs else "two lags in a row (damper beside the spring, then the gauge)"
        elif sub == "plastic":
            fy, a, e = g.uniform(0.1, 0.4), logu(g, 0.02, 0.6), g.uniform(1.6, 2.6)
            mx = np.maximum.accumulate(np.maximum(x * (1 if hi >= -lo else -1), 0)); s = 1 if hi >= -lo else -1
            st = s * a * (np.maximum(mx - fy, 0) / (1 - fy)) ** e
            y = x + st if fs else x - np.minimum(abs(st), 0.6) * s
            note = f"plastic flow beyond {fy:.2f}, set grows with power {e:.2f} of the largest load, {a:.3g} in all"
        elif sub == "norton":
            e = g.choice([3, 5]); a = logu(g, 0.02, 0.5); fl = np.sign(x) * abs(x) ** e
            F = np.cumsum(abs(fl)).max()
            if fs: y = x + a * np.cumsum(fl) / F
            else:
                y = np.empty_like(x); dp = 0.0; kk = 5 * a / F
                for i, d in enumerate(x.tolist()):
                    f = d - dp; dp += kk * np.sign(f) * abs(f) ** e; y[i] = f
            note = f"plastic flow with time, rate goes with force to the power {e}"
        elif sub == "random-stiffness":
            sd = logu(g, 0.01, 0.1); k = 1 + sd * g.standard_normal(m["nr"]); y = x * k[rn - 1]; note = f"stiffness changes from run to run by {100*sd:.1f} %"
        elif sub == "rayleigh":
            pass
        if sub in ("rayleigh", "structural"):
            eta = logu(g, 0.01, 0.1); v = np.diff(x, append=x[-1]); sg = np.sign(v)
            # amplitude and middle of the present half cycle
            tp = [0] + [i for i in range(1, len(x) - 1) if (x[i] - x[i - 1]) * (x[i + 1] - x[i]) < 0] + [len(x) - 1]
            y = x.copy(); e = 1 if sub == "rayleigh" else 0  # rayleigh: loss factor goes with the amplitude
            for a, b in zip(tp[:-1], tp[1:]):
                q = x[a:b + 1]; mid, hw = (q[0] + q[-1]) / 2, abs(q[-1] - q[0]) / 2
                y[a:b] += (-1 if fs else 1) * np.sign(q[-1] - q[0]) * eta * hw ** e * np.sqrt(np.maximum(hw ** 2 - (q[:-1] - mid) ** 2, 0))
            note = f"loop is an ellipse at any rate, loss factor {eta:.3g}" + (" times the amplitude (width goes with its square)" if e else " (structural damping)")
    m["driver"] = x if xs is None else xs
    if right is None:
        right = exact_names(x, y, rn, fs, kinks, power)
    return m, y, right, note, phys


PLAN = [(1, "")] * 15 + [(2, "one")] * 7 + [(2, "five")] * 2 \
    + [(3, "free")] * 1 + [(3, "seat")] * 1 + [(3, "symmetric")] * 3 + [(3, "shifted")] * 4 \
    + [(4, "two")] * 4 + [(4, "one")] * 5 + [(5, "two")] * 4 + [(5, "one")] * 4 \
    + [(6, "p1")] * 2 + [(6, "p1.5")] * 3 + [(6, "p2")] * 3 \
    + [(7, "relaxation")] * 4 + [(7, "creep")] * 3 + [(7, "warm-up")] * 2 + [(7, "drift")] * 2 \
    + [(8, "softening")] * 4 + [(8, "setting-in")] * 4 + [(9, "")] * 6 + [(10, "")] * 6 \
    + [(11, s) for s in ("lag", "delay", "viscous", "plastic", "plastic", "norton", "random-stiffness", "random-stiffness", "rayleigh", "structural", "structural")]
KIND = {1: "nothing", 2: "friction", 3: "backlash", 4: "end-stop", 5: "separation", 6: "contact", 7: "time", 8: "history", 9: "cubic", 10: "slip", 11: "no-law"}


def one(g, kind, sub, fs):
    for attempt in range(400):
        m, yf, right, note, phys = draw(g, kind, sub, fs)
        idx = m["idx"]; x, y, rn = m["driver"][idx], yf[idx], m["rn"][idx]; t = idx * m["h"]
        if not np.all(np.isfinite(y)) or not right: continue
        B = np.column_stack([x] + [(rn == r).astype(float) for r in np.unique(rn)])
        co = np.linalg.lstsq(B, y, rcond=None)[0]; res = y - B @ co
        rms, rng = float(np.sqrt(np.mean(res ** 2))), float(np.ptp(y))
        if kind == 1: sig = logu(g, 5e-4, 5e-3) * rng
        else:
            a, b = max(5e-4 * rng, rms / 30), min(5e-3 * rng, rms / 3)
            if a >= b: continue
            sig = logu(g, a, b)
        # noise: shares of the variance
        dshare = g.uniform(0.05, 0.7 if fs else 0.4) if g.random() < (0.6 if fs else 0.4) else 0.0
        slope = np.abs(np.gradient(y) / np.where(abs(np.gradient(x)) > 1e-9, np.gradient(x), np.inf))
        steep = float(np.percentile(slope, 99)) / abs(co[0]) if abs(co[0]) > 1e-6 else 1.0
        if steep > 1.5: dshare /= steep ** 2
        q = g.random(); step = sig * (g.uniform(0.2, 1) if q < 0.3 else g.uniform(1, 3.2) if q < 0.42 else 0.02)
        phi = float(g.uniform(0.3, 0.9)) if g.random() < 0.2 else 0.0
        sx = np.sqrt(dshare) * sig / max(abs(co[0]), 1e-3)
        sr = np.sqrt(max(0.05 * sig ** 2, sig ** 2 * (1 - dshare) - step ** 2 / 12))
        sdx = np.sqrt(sr ** 2 + step ** 2 / 12 + (sx * np.minimum(slope, 20 * abs(co[0]))) ** 2)
        timecol = not (g.random() < (0.1 if kind == 7 and sub != "drift" else 0.38))
        if kind == 7 and sub != "drift": timecol = True
        ob = Observer(x, y, t, rn, sdx, phi, fs)
        also, chis = [], {}
        if kind != 1:
            chis = ob.all(timecol)
            also = sorted(k for k, v in chis.items() if v < 16 and k not in right)
            if kind == 11 and (also or min(chis.values()) < 0.04 * ob.null) and attempt < 300: continue
        break
    else:
        raise SystemExit(f"no draw for {kind} {sub}")
    n = len(x)
    # readings
    w = g.standard_normal(n)
    if phi: w = lfilter([np.sqrt(1 - phi ** 2)], [1, -phi], np.concatenate([g.standard_normal(60), w]))[60:]
    offs = np.zeros(m["nr"])
    if g.random() < 0.5: offs = g.uniform(-0.03, 0.03, m["nr"]) * rng
    yr = y + sr * w + offs[rn - 1]; xr = x + sx * g.standard_normal(n)
    K, D = logu(g, 0.5, 2e5), logu(g, 0.02, 20)  # N/mm, mm at driver 1
    if fs: fsc, dsc = K * D, D
    else: fsc, dsc = K * D, D
    force, disp = (xr * fsc, yr * dsc) if fs else (yr * fsc, xr * dsc)
    um = D < 0.5; du = 1000.0 if um else 1.0
    sy = step * (dsc * du if fs else fsc)
    xres = 0.05 * sig / max(abs(co[0]), 1e-3) * (fsc if fs else dsc * du)
    disp = disp * du
    def disp_round(v, s):
        return np.round(v / s) * s
    # the display of the read quantity may be coarse, that of the set one is fine
    disp, force = (disp_round(disp, sy), disp_round(force, xres)) if fs else (disp_round(disp, xres), disp_round(force, sy))
    tt = t - t[0] if g.random() < 0.7 else t + g.uniform(0, 50)
    if m['runs'] and kind in (1, 3, 4, 5, 6, 9, 10) and g.random() < 0.3:
        tt = t - np.array([t[rn == r].min() for r in range(1, m['nr'] + 1)])[rn - 1]  # the clock begins again with each run
    cols = [("force_N", force), ("displacement_um" if um else "displacement_mm", disp)]
    if g.random() < 0.5: cols.reverse()
    if timecol: cols.insert(0, ("t_s", tt))
    if m["runs"]: cols.insert(0, ("run", rn))
    fmt = lambda nm, v: f"{int(v)}" if nm == "run" else f"{v:.4f}" if nm == "t_s" else f"{v:.7g}"
    lines = [",".join(c[0] for c in cols)] + [",".join(fmt(nm, v[i]) for nm, v in cols) for i in range(n)]
    tail = f"; {m['shape']}{' loading only' if m['loadonly'] else ''}, {'both signs' if m['both'] else 'one sign'}, {m['nr']} run(s) of {m['cyc']} cycle(s), turns {'between' if m['off'] else 'at'} readings"
    best = sorted(chis.items(), key=lambda kv: kv[1])[:4]
    info = dict(kind=KIND[kind], sub=sub, right=right, response="displacement" if fs else "force", also_right=also, note=note + tail,
                physically=phys or None, time_column=timecol, readings=n,
                truth=dict(noise_share_of_range=sig / rng, effect_over_noise=rms / sig if kind != 1 else 0.0, set_noise_share=dshare, display_over_noise=step / sig, phi=phi,
                           chi2_line=ob.null, chi2_of_right={k: chis[k] for k in right if k in chis}, chi2_best=dict(best)))
    return "\n".join(lines) + "\n", info


def main():
    ap = argparse.ArgumentParser(); ap.add_argument("--seed", type=int, required=True); ap.add_argument("--out", required=True)
    a = ap.parse_args(); os.makedirs(a.out, exist_ok=True)
    g = np.random.default_rng(a.seed); assert len(PLAN) == 100
    by = {}
    jobs = []
    for i in g.permutation(100):
        k, s = PLAN[i]
        if k == 3 and s in ("free", "seat"): fs = True
        elif k == 3: by[3] = by.get(3, int(g.integers(2))) + 1; fs = by[3] % 3 == 0
        else: by[k] = by.get(k, int(g.integers(2))) + 1; fs = by[k] % 2 == 0
        jobs.append((k, s, fs))
    ans = []
    for n, (k, s, fs) in enumerate(jobs, 1):
        txt, info = one(np.random.default_rng([a.seed, n]), k, s, fs)
        f = f"{n:03d}.csv"; open(os.path.join(a.out, f), "w").write(txt); ans.append(dict(file=f, **info))
    json.dump(ans, open(os.path.join(a.out, "answers.json"), "w"), indent=1, default=lambda v: v.item() if hasattr(v, "item") else str(v))


if __name__ == "__main__":
    main()
