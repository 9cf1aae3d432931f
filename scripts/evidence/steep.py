"""Critical dampings of friction that falls within a small slip speed, in MPFR arithmetic: reference.py writes them down.

The law is phi(u) = mu + a exp(-(u/vs)^n) + eta u for u > 0, and 1 at rest; eps = 1. The orbit from the exit point,
(v, v') = (V, -j) with j = 1 - phi(0+), grazes the belt line at the critical damping c: it has its next maximum at
(V, 0). It is followed from both ends to its lowest point by Taylor series in time of the equations of motion,

    v'' = D v' - v,    D = a n u^(n-1)/vs^n exp(-(u/vs)^n) - eta - c,    u = V - v,

and c is where both lowest points are the same.

Next to the grazing end the equation backward in time is stiff, and forgets where it began. It begins at slip speed u1
with v' = 0 and with v'^2 = 2 V u1, between which the orbit lies: it has v' >= 0 there, and v'^2/2 grows with u by at
most V while D >= 0. Solutions at the same slip speed do not cross, so the difference of the two bounds what the late
start costs; it is part of the disagreement that the table's head tells.
"""

import math
import random
import sys

import gmpy2
from gmpy2 import mpfr

from flow import Accuracy, bracketed_root, evaluate, product, step_size

COLUMNS = ["exponent", "mu", "fall", "vs", "eta", "V", "critical"]
SEED = 20261126
WIDTHS = ["1", "0.1", "0.03", "0.01", "0.001", "0.0001", "0.000001"]
ROWS_PER_WIDTH = 24
ROUGH = Accuracy(bits=80, order=18, tolerance="1e-13", cap="0.4")
FINE = Accuracy(bits=150, order=34, tolerance="1e-34", cap="0.25")
CHECK = Accuracy(bits=120, order=26, tolerance="1e-27", cap="0.19")
# Largest product of |D| and a step: Taylor's polynomials of these orders are stable to a third of the order.
STABLE = 6
REQUIRED = 1e-19


class Law:
    """A row's law in the working precision."""

    def __init__(self, exponent, mu, fall, vs, eta, belt):
        self.exponent = exponent
        # Friction at the onset of slip is the f64 sum, as in the program.
        self.drop = 1 - mpfr(mu + fall)
        self.fall, self.vs, self.eta, self.belt = mpfr(fall), mpfr(vs), mpfr(eta), mpfr(belt)

    def weakening(self, u):
        g = (u / self.vs) ** self.exponent
        return self.fall * self.exponent * u ** (self.exponent - 1) / self.vs**self.exponent * gmpy2.exp(-g) - self.eta

    def series(self, v0, w0, c, sign, order):
        """Taylor coefficients in time of v and w = v', and D at the start."""
        v, w, d = [v0], [w0], []
        u = [self.belt - v0]
        # s = u/vs; e = exp(-s^n); exp(-s)' = -s' e; exp(-s^2)' = -(s^2)' e.
        s, g, e = [u[0] / self.vs], [], []
        for n in range(order):
            g.append(s[n] if self.exponent == 1 else product(s, s, n))
            if n == 0:
                e.append(gmpy2.exp(-g[0]))
            else:
                e.append(-sum(k * g[k] * e[n - k] for k in range(1, n + 1)) / n)
            steep = e[n] if self.exponent == 1 else 2 * product(s, e, n)
            d.append(self.fall / self.vs * steep - (self.eta + c if n == 0 else 0))
            w.append(sign * (product(d, w, n) - v[n]) / (n + 1))
            v.append(sign * w[n] / (n + 1))
            s.append(-v[n + 1] / self.vs)
        return v, w, d[0]

    def lowest(self, start, c, sign, accuracy):
        """v at the next lowest point, forward in time (`sign` 1) or backward (-1)."""
        tolerance, cap = accuracy.enter()
        v0, w0 = start
        for _ in range(20000):
            v, w, d = self.series(v0, w0, c, sign, accuracy.order)
            h = step_size([v, w], accuracy.order, tolerance, min(cap, STABLE / abs(d) if d else cap))
            v1, w1 = evaluate(v, h), evaluate(w, h)
            # w has the sign of -sign on the way down.
            if sign * w1 >= 0 and v1 < 0:
                at = bracketed_root(lambda t: sign * evaluate(w, t), mpfr(0), h)
                return evaluate(v, at)
            v0, w0 = v1, w1
        raise ArithmeticError("too many steps")

    def late_start(self, c, forgotten):
        """The largest slip speed from which the orbit backward forgets its start by exp(-forgotten), or 0: the integral of
        D/v' over u, with v' = (V - u)/D where both balance. D >= 0 below it."""
        u, total = self.belt / 2, mpfr(0)
        steepest = self.vs if self.exponent == 2 else 0
        while u > mpfr("1e-3") * self.vs:
            d = self.weakening(u) - c
            below = u * mpfr("0.97")
            # Of exponent 2 D is 0 at u = 0: the orbit is followed from there unless all is forgotten beyond the steepest
            # place; its v' is bounded as D >= -c - eta, which adds less than V itself.
            if d > 0:
                total += d * d / (self.belt - u) * (u - below)
            else:
                total = mpfr(0)
            if total > forgotten and u > steepest / 2:
                return below
            u = below
        return mpfr(0)


def gap(row, c, accuracy, forgotten):
    """The lowest point of the half from the grazing end minus that of the half from the exit point: positive below the
    critical damping; and what the late start of the former leaves open."""
    accuracy.enter()
    law = Law(*row)
    c = mpfr(c)
    forward = law.lowest((law.belt, -law.drop), c, 1, accuracy)
    u = law.late_start(c, forgotten)
    backward = law.lowest((law.belt - u, mpfr(0)), c, -1, accuracy)
    open_ = mpfr(0)
    if u > 0:
        open_ = abs(law.lowest((law.belt - u, gmpy2.sqrt(2 * law.belt * u)), c, -1, accuracy) - backward)
    return backward - forward, open_


def critical(row):
    """The critical damping and its relative disagreement, or None where it is not between 0.001 and 1.9."""
    rough = lambda c: -gap(row, c, ROUGH, 35)[0]
    try:
        ROUGH.enter()
        lo, hi = mpfr("0.001"), mpfr("1.9") - mpfr(row[4])
        if rough(lo) >= 0 or rough(hi) <= 0:
            return None
        start = bracketed_root(rough, lo, hi, mpfr("1e-12"))
    except ArithmeticError:
        return None
    roots, left = [], mpfr(0)
    for accuracy, forgotten in ((FINE, 85), (CHECK, 70)):
        accuracy.enter()
        b, a = mpfr(start), mpfr(start) * (1 + mpfr("1e-8"))
        fa = gap(row, a, accuracy, forgotten)[0]
        fb, open_ = gap(row, b, accuracy, forgotten)
        for _ in range(8):
            slope = (fb - fa) / (b - a)
            a, fa, b = b, fb, b - fb / slope
            if abs(b - a) < mpfr("1e-16") * b:
                break
            fb, open_ = gap(row, b, accuracy, forgotten)
        else:
            raise ArithmeticError(f"no root found: {row}")
        left = max(left, abs(open_ / slope))
        roots.append(b)
    return roots[0], float((abs(roots[0] - roots[1]) + left) / roots[0])


def draw(rng, width):
    number = lambda lo, hi: float(f"{rng.uniform(lo, hi):.4g}")
    belt = float(f"{math.exp(rng.uniform(math.log(0.1), math.log(3))):.4g}")
    # Decimals that add up to 1 exactly, or to less.
    decimals = lambda lo, hi: round(rng.uniform(lo, hi), 4)
    fall = decimals(0.05, 0.9)
    drop = rng.choice((0.0, decimals(0.0, 0.95 - fall)))
    mu = round(1 - fall - drop, 4)
    eta = rng.choice((0.0, number(0.001, 0.05)))
    return rng.choice((1, 2)), mu, fall, float(width), eta, belt


def table(per_width=ROWS_PER_WIDTH):
    rng = random.Random(SEED)
    rows, worst = [], 0.0
    for width in WIDTHS:
        # The case that showed a missing term of the limit of steep laws.
        fixed = [(1, 0.1, 0.9, 1e-6, 0.0, 0.2)] if width == WIDTHS[-1] else []
        count = 0
        while count < per_width:
            row = fixed.pop() if fixed else draw(rng, width)
            found = critical(row)
            if found is None:
                continue
            value, error = found
            worst = max(worst, error)
            rows.append([row[0], *map(repr, row[1:]), f"{value:.19e}"])
            count += 1
            print(*rows[-1], f"{error:.1e}", file=sys.stderr)
    header = [
        "Critical damping of phi(u) = mu + fall exp(-(u/vs)^exponent) + eta u, friction at rest 1; eps = 1.",
        f"Made by scripts/evidence/reference.py, seed {SEED}; {per_width} rows for each vs with V in [0.1, 3] (log) and a critical damping",
        "between 0.001 and 1.9. Each number is the f64 nearest to its decimals.",
        f"Largest relative disagreement of two accuracies, with what a late start of the stiff half leaves open: {worst:.1e}.",
    ]
    return header, rows, worst


def same(row):
    """Whether the critical damping of a committed row is the recomputed one."""
    *law, committed = row.values()
    value, _ = critical((int(law[0]), *map(float, law[1:])))
    return abs(value - mpfr(committed)) <= REQUIRED * value
