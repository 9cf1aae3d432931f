"""The slip flow by Taylor series in MPFR arithmetic: the arithmetic behind reference.py.

Written from the equations alone and sharing nothing with the Rust engines, so that agreement with them is evidence.
Two formulations that share only the parameters:

* `polar_log_radius`: the scalar form dy/dtheta = D sin^2 / (1 + D sin cos), y = ln(r/V), in scaled groups;
* `follow`: the (v, w) flow v' = w, w' = -v + D(u) w in the original parameters, with events by root-finding.

D(u) = eps (-c + gamma (1-alpha)/(1 + eps gamma u)^2 - 2 beta u) is the divergence at slip speed u = |v - V|.

Every solution is expanded to `Accuracy.order` terms by recurrence; the step is the largest at which the last two
terms stay below `Accuracy.tolerance` relative to the state (Jorba and Zou's rule), and never above `Accuracy.cap`.
The local error is of the order of those terms, the arithmetic error far below it; the error of a result is measured
by repeating it at another order, tolerance, precision and step bound.
"""

from dataclasses import dataclass, replace
from operator import mul

import gmpy2
from gmpy2 import mpfr


@dataclass(frozen=True)
class Accuracy:
    """How one run is computed; two runs that differ in all of it check each other."""

    bits: int
    order: int
    tolerance: str
    cap: str

    def enter(self):
        """Makes this the working precision and returns the tolerance and the step bound in it."""
        gmpy2.get_context().precision = self.bits
        return mpfr(self.tolerance), mpfr(self.cap)


FINE = Accuracy(bits=200, order=48, tolerance="1e-46", cap="0.25")
CHECK = Accuracy(bits=152, order=37, tolerance="1e-36", cap="0.19")


@dataclass(frozen=True)
class Point:
    """One point of parameter space. Every number is exactly the f64 that a reader of the tables parses; only `c` may
    be finer, where it is itself computed."""

    epsilon: float
    alpha: float
    beta: float
    gamma: float
    c: float
    belt: float


class Unresolved(Exception):
    """The integration gave no answer; the message says why."""


def product(a, b, n):
    """Coefficient n of the product of two series known up to their coefficients n."""
    return sum(map(mul, a[: n + 1], b[n::-1]))


def step_size(series, order, tolerance, cap):
    """The largest step at which the last two terms of every series stay within tolerance of its state."""
    size = max(abs(s[0]) for s in series)
    h = cap
    for n in (order - 1, order):
        last = max(abs(s[n]) for s in series)
        if last > 0:
            h = min(h, gmpy2.exp(gmpy2.log(tolerance * size / last) / n))
    return h


def evaluate(series, t):
    """Horner's rule."""
    value = series[-1]
    for a in reversed(series[:-1]):
        value = value * t + a
    return value


# --- scalar form ---


def polar_log_radius(point, accuracy):
    """ln(r(2 pi) / V) of the orbit from the exit point, r(0) = V, by the scalar form in the groups A, k, b, C.

    Raises `Unresolved` where the angle stops advancing.
    """
    tolerance, cap = accuracy.enter()
    order = accuracy.order
    eps, belt = mpfr(point.epsilon), mpfr(point.belt)
    rate = eps * mpfr(point.gamma)
    groups = rate * (1 - mpfr(point.alpha)), rate * belt, eps * mpfr(point.beta) * belt, eps * mpfr(point.c)
    turn = 2 * gmpy2.const_pi()
    theta, y = mpfr(0), mpfr(0)
    for _ in range(4000):
        series = polar_series(theta, y, groups, order)
        # The radius, not its logarithm, sets the scale: y starts at 0.
        h = step_size([[mpfr(1)] + series[1:]], order, tolerance, cap)
        if theta + h >= turn:
            return evaluate(series, turn - theta)
        if h < mpfr("1e-12"):
            raise Unresolved("the angle stops advancing")
        y = evaluate(series, h)
        theta += h
    raise Unresolved("the scalar form needs too many steps")


def polar_series(theta, y0, groups, order):
    """Taylor coefficients of y = ln(r/V) about the angle `theta`."""
    a, k, b, damping = groups
    cos, sin2, cos2 = [gmpy2.cos(theta)], [gmpy2.sin(2 * theta)], [gmpy2.cos(2 * theta)]
    sin = [gmpy2.sin(theta)]
    y, radius, s, p, d = [y0], [gmpy2.exp(y0)], [], [], []
    num, den = [], []
    for n in range(order):
        if n:
            cos.append(-sin[n - 1] / n)
            sin.append(cos[n - 1] / n)
            sin2.append(2 * cos2[n - 1] / n)
            cos2.append(-2 * sin2[n - 1] / n)
            # radius = exp(y):  radius' = y' radius
            radius.append(sum(map(mul, slope[:n], radius[n - 1 :: -1])) / n)
        s.append((1 if n == 0 else 0) - product(radius, cos, n))
        # p = 1 / (1 + k s)
        if n == 0:
            p.append(1 / (1 + k * s[0]))
            slope = []
        else:
            p.append(-k * p[0] * sum(map(mul, s[1 : n + 1], p[n - 1 :: -1])))
        d.append(a * product(p, p, n) - 2 * b * s[n] - (damping if n == 0 else 0))
        # sin^2 = (1 - cos 2 theta)/2, sin cos = sin 2 theta / 2
        num.append((d[n] - product(d, cos2, n)) / 2)
        den.append(product(d, sin2, n) / 2 + (1 if n == 0 else 0))
        if n == 0 and den[0] <= 0:
            raise Unresolved("the angle stops advancing")
        above = num[n] - (sum(map(mul, den[1 : n + 1], slope[n - 1 :: -1])) if n else 0)
        slope.append(above / den[0])
        y.append(slope[n] / (n + 1))
    return y


def critical_damping(point, accuracy, start):
    """The damping c* at which the grazing margin vanishes, by the secant rule from `start`; point.c is ignored.

    The margin is a smooth, strictly decreasing function of c, close to linear over the distance from a good start.
    """
    accuracy.enter()
    c1 = mpfr(start)
    c0 = c1 * (1 - mpfr("1e-4")) - mpfr("1e-8")
    margin = lambda c: polar_log_radius(replace(point, c=c), accuracy)
    y0, y1 = margin(c0), margin(c1)
    # The error of the root is at least that of y over the slope dy/dc, about pi eps.
    enough = mpfr(accuracy.tolerance) * 100 / mpfr(point.epsilon)
    for _ in range(40):
        if y1 == y0:
            return c1
        c0, c1, y0 = c1, c1 - y1 * (c1 - c0) / (y1 - y0), y1
        if abs(c1 - c0) <= enough:
            return c1
        y1 = margin(c1)
    raise Unresolved("the secant rule does not settle")


# --- grazing in the (v, w) flow ---


def first_maximum(point, accuracy):
    """v/V - 1 at the first maximum of v on the orbit from (V, 0), with the lower flow continued above the belt line.

    -1 where the orbit creeps into the equilibrium without a maximum, and at most 0.1 where it runs on beyond the belt
    line, towards the pole of the continued law. Nodes are no exception.
    """
    side = Side(point, 1, accuracy)
    belt = side.belt
    # Half-way to the pole, at v = V (1 + 1/k).
    far = belt + min(belt / 10, 1 / (2 * side.rate))

    def creeps(v, w):
        # Between w = 0 and w = -v with D <= -2 all the way to the equilibrium: the wedge is never left.
        return v * w < 0 and abs(w) < abs(v) and max(side.divergence(v), side.divergence(mpfr(0))) <= -2

    bottom = side.until((mpfr(0), belt, mpfr(0)), lambda v, w: w, creeps)
    if bottom is None or creeps(bottom[1], bottom[2]):
        return mpfr(-1)
    top = side.until(bottom, lambda v, w: max(-w, v - far), creeps)
    return mpfr(-1) if top is None else top[1] / belt - 1


def grazing_damping(point, rough, fine):
    """c* by the (v, w) flow, for foci and nodes alike: the root of `first_maximum` between the bounds from the even part
    of D (theory, "The tests"), found at `rough` and then at `fine` next to it. point.c is ignored.
    """
    rough.enter()
    eps, belt = mpfr(point.epsilon), mpfr(point.belt)
    k = eps * mpfr(point.gamma) * belt
    weakening, strengthening = mpfr(point.gamma) * (1 - mpfr(point.alpha)), 2 * mpfr(point.beta) * belt
    lo = weakening / (1 + k) ** 2 - strengthening
    hi = weakening * (1 + 1 / (1 + 2 * k) ** 2) / 2 - strengthening
    near = bracketed_root(lambda c: -first_maximum(replace(point, c=c), rough), lo, hi, mpfr("1e-12"))
    fine.enter()
    margin = lambda c: -first_maximum(replace(point, c=c), fine)
    width = weakening * mpfr("1e-11")
    for _ in range(5):
        if margin(near - width) < 0 < margin(near + width):
            return bracketed_root(margin, near - width, near + width, mpfr("1e-11"))
        width *= 100
    raise Unresolved("the finer flow has no root next to the rougher one's")


# --- (v, w) flow ---


class Side:
    """The smooth flow on one side of the belt line: `sign` +1 below it (u = V - v), -1 above it (u = v - V)."""

    def __init__(self, point, sign, accuracy):
        self.tolerance, self.cap = accuracy.enter()
        self.order = accuracy.order
        self.sign = sign
        self.belt = mpfr(point.belt)
        eps = mpfr(point.epsilon)
        self.rate = eps * mpfr(point.gamma)
        self.weakening = self.rate * (1 - mpfr(point.alpha))
        self.strengthening = 2 * eps * mpfr(point.beta)
        self.damping = eps * mpfr(point.c)

    def divergence(self, v):
        """D at velocity v, by the analytic continuation of this side's law where v lies on the other side."""
        u = self.sign * (self.belt - v)
        return self.weakening / (1 + self.rate * u) ** 2 - self.strengthening * u - self.damping

    def series(self, v0, w0):
        """Taylor coefficients in time of v and w."""
        order = self.order
        v, w, d = [v0], [w0], []
        u0 = self.sign * (self.belt - v0)
        p = [1 / (1 + self.rate * u0)]
        minus_rate_p = -self.rate * p[0]
        slip = [u0]
        for n in range(order):
            if n:
                p.append(minus_rate_p * sum(map(mul, slip[1 : n + 1], p[n - 1 :: -1])))
            d.append(self.weakening * product(p, p, n) - self.strengthening * slip[n] - (self.damping if n == 0 else 0))
            w.append((product(d, w, n) - v[n]) / (n + 1))
            v.append(w[n] / (n + 1))
            slip.append(-self.sign * v[n + 1])
        return v, w

    def until(self, start, event, trapped=None):
        """Follows the flow from `start` = (t, v, w) until `event(v, w)` turns positive; returns (t, v, w) there, or None
        as soon as `trapped(v, w)` holds at the end of a step."""
        t, v0, w0 = start
        for _ in range(20000):
            v, w = self.series(v0, w0)
            h = step_size([v, w], self.order, self.tolerance, self.cap)
            if h < mpfr("1e-9"):
                raise Unresolved("step underflow")
            # Between two turning points v is monotone and crosses the belt line at most once, so every event
            # is a single sign change; where the start lies on the event itself (w = 0), w leaves zero within
            # one sample.
            lo = mpfr(0)
            for i in range(1, 9):
                hi = h * i / 8
                if event(evaluate(v, hi), evaluate(w, hi)) > 0:
                    at = bracketed_root(lambda s: event(evaluate(v, s), evaluate(w, s)), lo, hi)
                    return t + at, evaluate(v, at), evaluate(w, at)
                lo = hi
            t, v0, w0 = t + h, evaluate(v, h), evaluate(w, h)
            if trapped is not None and trapped(v0, w0):
                return None
        raise Unresolved("step budget")


def bracketed_root(f, lo, hi, relative=None):
    """The root of f in [lo, hi], f(lo) < 0 < f(hi): secant steps kept inside the bracket (the Illinois rule), down to
    the working precision, or to `relative` times the bracket."""
    flo, fhi = f(lo), f(hi)
    if flo >= 0:
        return lo  # the start itself, to rounding: a grazing orbit turns where it reaches the belt line
    limit = (hi - lo) * (mpfr(2) ** (8 - gmpy2.get_context().precision) if relative is None else relative)
    side = 0
    for _ in range(400):
        if hi - lo <= limit:
            break
        at = (lo * fhi - hi * flo) / (fhi - flo)
        fat = f(at)
        if fat == 0:
            return at
        if fat > 0:
            if side == 1:
                flo /= 2
            hi, fhi, side = at, fat, 1
        else:
            if side == -1:
                fhi /= 2
            lo, flo, side = at, fat, -1
        if abs(fat) <= limit * mpfr("1e-3"):
            return at
    return (lo + hi) / 2


@dataclass
class Orbit:
    """What becomes of the orbit from the exit point; None where there is no such quantity."""

    fate: str
    margin: object = None
    landing_speed: object = None
    slip_time: object = None
    stick_time: object = None
    landing_x1: object = None
    loops: int = 0

    def numbers(self):
        """The computed numbers, in the order of the table's columns."""
        return [self.margin, self.landing_speed, self.slip_time, self.stick_time, self.landing_x1]


def follow(point, accuracy, extra_loops=6):
    """Follows the Filippov orbit from the exit point (v, w) = (V, 0).

    It first slips below the belt line. If it comes back with landing speed w it sticks there for 0 < w < 2; for w >= 2
    it goes on above with W = w - 2 and comes back with some W < 0, sticks there for W > -2, and goes on below with
    w = W + 2 otherwise: at most `extra_loops` times more.
    """
    below, above = Side(point, 1, accuracy), Side(point, -1, accuracy)
    belt, zero = below.belt, mpfr(0)
    viscous = below.damping * belt
    turn_up = lambda v, w: w
    turn_down = lambda v, w: -w
    reach = lambda v, w: v - belt

    def trapped(v, w):
        # D <= 0 wherever |v| <= rho < V makes the energy v^2 + w^2 fall for ever, so the orbit cannot reach
        # the belt. Requiring D <= -2 excludes orbits that turn and have a margin; the others tend to a node.
        radius = gmpy2.sqrt(v * v + w * w)
        return radius < belt and below.divergence(radius) <= -2

    orbit = Orbit("inward")
    start = (zero, belt, zero)
    bottom = below.until(start, turn_up, trapped)
    if bottom is None:
        return orbit  # it creeps towards a node: no next maximum, hence no margin
    # Continue to the belt line or to the maximum of v below it, whichever comes first.
    first = below.until(bottom, lambda v, w: max(v - belt, -w), trapped)
    if first is None:
        return orbit
    if abs(first[2]) > abs(first[1] - belt):
        landing = first
        orbit.landing_speed = first[2]
        orbit.fate = "lands"
        try:
            top = below.until(first, turn_down, lambda v, w: below.divergence(v) >= 2 or 1 + below.rate * (belt - v) <= 0)
        except Unresolved:
            top = None
    else:
        top = first
    if top is not None:
        peak = max(belt, top[1])
        if below.divergence(bottom[1]) > -2 and below.divergence(peak) < 2:
            orbit.margin = top[1] / belt - 1
    if orbit.fate == "inward":
        return orbit

    t, speed = landing[0], landing[2]
    for loop in range(extra_loops + 1):
        orbit.loops = loop
        if speed < 2:
            return stuck(orbit, "sticks" if loop == 0 else "sticks_later", t, 1 - viscous - speed, belt, viscous)
        t, v, w = above.until(above.until((t, belt, speed - 2), turn_down), lambda v, w: belt - v)
        if w > -2:
            return stuck(orbit, "sticks_from_above" if loop == 0 else "sticks_later", t, -1 - viscous - w, belt, viscous)
        bottom = below.until((t, belt, w + 2), turn_up)
        t, v, speed = below.until(bottom, reach)
    orbit.fate = "crosses_forever"
    return orbit


def stuck(orbit, fate, t, x1, belt, viscous):
    """Completes the record of an orbit that sticks at x1; it leaves at the exit point 1 - eps c V, moving at V."""
    orbit.fate, orbit.slip_time, orbit.landing_x1 = fate, t, x1
    orbit.stick_time = (1 - viscous - x1) / belt
    return orbit
