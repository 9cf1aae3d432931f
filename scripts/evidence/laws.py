"""Critical dampings of random friction laws, formulas and tables, in MPFR arithmetic: reference.py writes them down.

Written from the equations alone and sharing nothing with the crate: the scalar form of the slip flow,

    dy/dtheta = D sin^2 / (1 + D sin cos),   y = ln(r / V),   D = -phi'(V - r cos) - eps c,

from theta = 0, y = 0, is followed through one turn by extrapolation of the midpoint rule (Gragg, Bulirsch and Stoer),
with steps that end where the slip speed meets a corner of a table; eps c is the critical damping where y(2 pi) = 0.
phi' of each formula is written by hand. With a drop j of friction as slip begins the orbit starts at x2' = -j instead:
theta = atan(j / V), y = ln(1 + j^2 / V^2) / 2. A table is the cubic of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984).
"""

import math
from dataclasses import dataclass, replace

import gmpy2
from gmpy2 import mpfr


@dataclass(frozen=True)
class Effort:
    """How one run is computed: bits, steps to a turn, and stages of the extrapolation."""

    bits: int
    steps: int
    stages: int


FINE = Effort(bits=128, steps=40, stages=11)
CHECK = Effort(bits=112, steps=31, stages=10)


def formulas(rng):
    """A random formula as text, and its weakening rate -phi' as a function of mpfr numbers."""
    number = lambda lo, hi: float(f"{rng.uniform(lo, hi):.5g}")
    kind = rng.randrange(8)
    a, b, e = number(0.05, 0.6), number(0.15, 1.5), number(0.001, 0.03)
    A, B, E = mpfr(a), mpfr(b), mpfr(e)
    if kind == 0:
        return f"1 - {a} + {a}*exp(-u/{b})", lambda u: A / B * gmpy2.exp(-u / B)
    if kind == 1:
        return f"1/(1 + {a}*u)", lambda u: A / (1 + A * u) ** 2
    if kind == 2:
        return f"1 - {a} + {a}/(1 + (u/{b})^2)", lambda u: 2 * A * u / B**2 / (1 + (u / B) ** 2) ** 2
    if kind == 3:
        return f"1 - {a}*tanh(u/{b}) + {e}*u", lambda u: A / B / gmpy2.cosh(u / B) ** 2 - E
    if kind == 4:
        return f"1 - {a}*tanh(u/{b}) + {e}*sin(3*u)", lambda u: A / B / gmpy2.cosh(u / B) ** 2 - 3 * E * gmpy2.cos(3 * u)
    if kind == 5:
        weakening = lambda u: A / B * gmpy2.sinh(u / B) / gmpy2.cosh(u / B) ** 2
        return f"1 - {a} + {a}/cosh(u/{b})", weakening
    if kind == 6:
        return f"1 - {a}*atan(u/{b}) + {e}*u^2", lambda u: A / B / (1 + (u / B) ** 2) - 2 * E * u
    return f"1 - {a} + {a}*exp(-(u/{b})^2) + {e}*u", lambda u: 2 * A * u / B**2 * gmpy2.exp(-((u / B) ** 2)) - E


def tables(rng):
    """Random data as text, their weakening rate, and their corners."""
    drop, scale, rise = rng.uniform(0.1, 0.6), rng.uniform(0.2, 1.0), rng.uniform(0, 0.05)
    u, data = 0.0, [(0.0, 1.0)]
    while u < 8:
        u = float(f"{u + rng.uniform(0.03, 0.5) * (0.3 + u):.4g}")
        phi = 1 - drop * (1 - math.exp(-u / scale)) + rise * u + rng.uniform(-1, 1) * 0.003
        data.append((u, float(f"{phi:.4g}")))
    return ";".join(f"{u}:{phi}" for u, phi in data), data


class Cubics:
    """-phi' of a table, and where its slope jumps."""

    def __init__(self, data, static=1):
        self.u, phi = ([mpfr(x) for x in column] for column in zip(*data))
        phi = [value / mpfr(static) for value in phi]
        h = [b - a for a, b in zip(self.u, self.u[1:])]
        secant = [(b - a) / w for a, b, w in zip(phi, phi[1:], h)]
        slope = [self.end(h[0], h[1], secant[0], secant[1])]
        for i in range(1, len(h)):
            if secant[i - 1] * secant[i] <= 0:
                slope.append(mpfr(0))
            else:
                w1, w2 = 2 * h[i] + h[i - 1], h[i] + 2 * h[i - 1]
                slope.append((w1 + w2) / (w1 / secant[i - 1] + w2 / secant[i]))
        slope.append(self.end(h[-1], h[-2], secant[-1], secant[-2]))
        self.h, self.secant, self.slope = h, secant, slope

    @staticmethod
    def end(h0, h1, s0, s1):
        slope = ((2 * h0 + h1) * s0 - h0 * s1) / (h0 + h1)
        if slope * s0 <= 0:
            return mpfr(0)
        return 3 * s0 if s0 * s1 <= 0 and abs(slope) > 3 * abs(s0) else slope

    def piece_of(self, u):
        return max(0, min(sum(knot <= u for knot in self.u) - 1, len(self.h) - 1))

    def weakening(self, piece, u):
        h, x = self.h[piece], (u - self.u[piece]) / self.h[piece]
        s0, s1, secant = self.slope[piece], self.slope[piece + 1], self.secant[piece]
        return -(6 * x * (1 - x) * secant + (1 - x) * (1 - 3 * x) * s0 + x * (3 * x - 2) * s1)


def slope(weakening, belt, viscous, theta, y):
    sin, cos = gmpy2.sin_cos(theta)
    d = weakening(belt * (1 - gmpy2.exp(y) * cos)) - viscous
    turning = 1 + d * sin * cos
    if turning < 0.1:
        raise ArithmeticError("a node, or nearly one")
    return d * sin * sin / turning


def step(f, theta, y, width, stages):
    """y at theta + width."""
    rows = []
    for k in range(1, stages + 1):
        n = 2 * k
        h = width / n
        before, here = y, y + h * f(theta, y)
        for i in range(1, n):
            before, here = here, before + 2 * h * f(theta + i * h, here)
        row = [(before + here + h * f(theta + width, here)) / 2]
        for j in range(1, k):
            ratio = mpfr(k) / (k - j)
            row.append(row[j - 1] + (row[j - 1] - rows[-1][j - 1]) / (ratio * ratio - 1))
        rows.append(row)
    return rows[-1][-1]


def turn(law, belt, viscous, effort, drop=0):
    """y after one turn. `law` is a function or a table."""
    end = 2 * gmpy2.const_pi()
    theta, y = gmpy2.atan2(mpfr(drop), belt), gmpy2.log1p((mpfr(drop) / belt) ** 2) / 2
    if not isinstance(law, Cubics):
        f = lambda theta, y: slope(law, belt, viscous, theta, y)
        start, width = theta, (end - theta) / effort.steps
        for i in range(effort.steps):
            y = step(f, start + width * i, y, width, effort.stages)
        return y
    slip = lambda theta, y: belt * (1 - gmpy2.exp(y) * gmpy2.cos(theta))
    piece = 0
    while theta < end:
        width = min(end / effort.steps, end - theta)
        f = lambda theta, y: slope(lambda u: law.weakening(piece, u), belt, viscous, theta, y)
        after = step(f, theta, y, width, effort.stages)
        u = slip(theta + width, after)
        knots = [k for k in (piece, piece + 1) if 0 < k < len(law.h)]
        crossed = next((k for k in knots if (u > law.u[k]) == (k == piece + 1) and u != law.u[k]), None)
        if crossed is not None:
            # The step that ends at the corner, by secants.
            low, high = (mpfr(0), slip(theta, y) - law.u[crossed]), (width, u - law.u[crossed])
            for _ in range(60):
                at = high[0] - high[1] * (high[0] - low[0]) / (high[1] - low[1])
                at = min(max(at, mpfr(0)), width)
                after = step(f, theta, y, at, effort.stages)
                low, high = high, (at, slip(theta + at, after) - law.u[crossed])
                if abs(high[0] - low[0]) < mpfr("1e-26") or high[1] == 0 or high[1] == low[1]:
                    break
            width = high[0]
            piece = crossed if crossed == piece + 1 else crossed - 1
        theta, y = theta + width, after
        if end - theta < mpfr("1e-25"):
            break
    return y


def critical(make, belt, guess, effort, make_drop=lambda: 0):
    """eps c* of the law that `make` makes in the working precision, by secants; its drop is made there, too."""
    gmpy2.get_context().precision = effort.bits
    law, belt, drop = make(), mpfr(belt), make_drop()
    a = mpfr(guess)
    b = a * mpfr("1.001") + mpfr("1e-6")
    fa, fb = turn(law, belt, a, effort, drop), turn(law, belt, b, effort, drop)
    for _ in range(40):
        a, fa, b = b, fb, b - fb * (b - a) / (fb - fa)
        if abs(b - a) < mpfr("1e-20"):
            return b
        fb = turn(law, belt, b, effort, drop)
    raise ArithmeticError("no root found")


def mean(weakening, belt):
    """The energy balance, from which the search starts."""
    n = 200
    total = 0.0
    for i in range(n):
        t = 2 * math.pi * i / n
        total += float(weakening(mpfr(belt * (1 - math.cos(t))))) * math.sin(t) ** 2
    return 2 * total / n


def searched(make, belt, start, make_drop=lambda: 0):
    """eps c* and the relative disagreement of two accuracies; None where there is none above 0.001, or a node is met."""
    # Laws that change within a small part of the orbit need more steps.
    for finer in (1, 2, 4, 8):
        try:
            fine, check = (
                critical(make, belt, start, replace(effort, steps=finer * effort.steps), make_drop)
                for effort in (FINE, CHECK)
            )
        except ArithmeticError:
            return None
        if not 0.001 < fine:
            return None
        error = float(abs(fine - check) / fine)
        if error < 1e-16:
            return fine, error
    raise ArithmeticError(f"no agreement at V = {belt}: {error:.1e}")


def rows(rng, formula_count, table_count):
    """(kind, law, V, eps c*) and the largest relative disagreement of two accuracies."""
    found, worst = [], 0.0
    while len(found) < formula_count + table_count:
        gmpy2.get_context().precision = FINE.bits
        belt = float(f"{math.exp(rng.uniform(math.log(0.1), math.log(3))):.5g}")
        if len(found) < formula_count:
            kind, (text, weakening) = "formula", formulas(rng)
            make = lambda: weakening
            start = mean(weakening, belt)
        else:
            kind, (text, data) = "table", tables(rng)
            make = lambda: Cubics(data)
            cubics = make()
            start = mean(lambda u: cubics.weakening(cubics.piece_of(u), u), belt)
        result = None if start < 0.005 else searched(make, belt, start)
        if result:
            worst = max(worst, result[1])
            found.append((kind, text, repr(belt), f"{result[0]:.17e}"))
    return found, worst


def closed_form(ratio, guess):
    """The damping that a drop alone sustains, J = j / V = `ratio`: where v'' + d v' + v = 0 comes back from (1, -J) to 1."""

    def excess(d):
        omega = gmpy2.sqrt(1 - d * d / 4)
        angle = gmpy2.atan((ratio - d / 2) / omega) + gmpy2.atan(d / 2 / omega) - 2 * gmpy2.const_pi()
        return gmpy2.log1p(ratio * (ratio - d)) + d / omega * angle

    a, b = mpfr(guess), mpfr(guess) * mpfr("1.0001")
    for _ in range(40):
        if abs(b - a) < mpfr("1e-25"):
            return b
        fa, fb = excess(a), excess(b)
        a, b = b, b - fb * (b - a) / (fb - fa)
    raise ArithmeticError("no root found")


def drop_rows(rng, coulomb_count, formula_count, table_count):
    """(kind, law, static, V, eps c*) of laws whose friction drops as slip begins, and the largest relative disagreement of
    two accuracies and, for two coefficients, of the closed form."""
    found, worst = [], 0.0
    number = lambda lo, hi: float(f"{rng.uniform(lo, hi):.4g}")
    while len(found) < coulomb_count + formula_count + table_count:
        gmpy2.get_context().precision = FINE.bits
        belt = float(f"{math.exp(rng.uniform(math.log(0.1), math.log(3))):.5g}")
        kinetic = number(0.2, 0.95)
        static = number(kinetic, 1.2)
        make_drop = lambda: 1 - mpfr(kinetic) / mpfr(static)
        if len(found) < coulomb_count:
            static, drop = 1.0, number(0.02, 0.9)
            eta = rng.choice((0.0, number(0.001, 0.05)))
            kind, text, make_drop = "coulomb", f"{drop} {eta}", lambda: mpfr(drop)
            weakening = lambda u: -mpfr(eta)
            make = lambda: weakening
            start = -eta
        elif len(found) < coulomb_count + formula_count:
            kind, (base, rate) = "formula", formulas(rng)
            text = f"{kinetic}*({base})"
            make = lambda: lambda u: mpfr(kinetic) / mpfr(static) * rate(u)
            start = mean(make(), belt)
        else:
            kind, (_, whole) = "table", tables(rng)
            data = [(u, float(f"{kinetic * phi:.4g}")) for u, phi in whole]
            kinetic = data[0][1]
            text = ";".join(f"{u}:{phi}" for u, phi in data)
            make = lambda: Cubics(data, static)
            cubics = make()
            start = mean(lambda u: cubics.weakening(cubics.piece_of(u), u), belt)
        ratio = make_drop() / mpfr(belt)
        start += math.log1p(float(ratio) ** 2) / (2 * math.pi)
        result = None if start < 0.005 else searched(make, belt, start, make_drop)
        if not result:
            continue
        fine, error = result
        if kind == "coulomb":
            gmpy2.get_context().precision = FINE.bits
            known = closed_form(make_drop() / mpfr(belt), start + eta) - mpfr(eta)
            error = max(error, float(abs(fine - known) / known))
        worst = max(worst, error)
        found.append((kind, text, repr(static), repr(belt), f"{fine:.19e}"))
    return found, worst
