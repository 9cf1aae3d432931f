"""Proves the claims of certificates again, in ball arithmetic (Arb, by python-flint).

    pip install python-flint
    python scripts/checks/proof.py proof.json ...

It shares no code and no number with slipmap: it reads a certificate of a point, or of a box of parameters, builds the law from its
definition, and proves what the certificate states, or names the claim that it cannot prove. Statement and lemma:
crates/certify/src/curve/mod.rs, docs/proofs.md. Exit status 0 where every claim of every file is proved.

Notation: u slip speed, V belt speed, v = V - u, C = epsilon c, phi friction in slip over friction at rest, j its drop as slip begins.
Orbits below the belt line: v' = y, y' = -v - (phi'(u) + C) y. A curve (u(s), y(s)) is crossed outwards where
S = u_s (V - u + C y) + y (phi o u)_s - y_s y is positive: no derivative of the law is needed. Over a box of parameters z_i runs from
-1 to 1 along each axis on which it is wide, and S(z) is enclosed by S(0), its slopes at 0 and its second derivatives over the box.
"""

import ast
import json
import math
import re
import sys

from fractions import Fraction

from flint import arb, arb_series, ctx

ctx.prec = 128
# Order of the Taylor form of a cell; halvings and cells of a piece; largest numbers of curves, pieces and control points.
ORDER, HALVINGS, CELLS = 11, 50, 2000
CURVES, PIECES, POINTS, CUTS = 3, 1000, 32, 40

FORMAT = "slipmap proof 3"
STATEMENT = (
    "With x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(|x2 - V|), friction up to 1 at rest, and the "
    "friction law phi of the given name and definition in slip, plus a constant on each of its pieces that makes it "
    "continuous and phi(0+) = 1 - j, j the drop of the law as slip begins: of the points of each part, its domain, "
    "the ranges of the axes, times its range of c, a stick-slip limit cycle exists in a share of at least `present`, "
    "and none in a share of at least `absent`. A range of one value counts as a whole. A proof cuts its domain at a "
    "place of an axis, into a part below and one above, or consists of curves. Damping c and control points (V - x2, "
    "x2') of a curve are those given plus z[i] times those along axis i of the axes on which its domain is wide, "
    "where z[i] runs from -1 to 1; control points then times V over that in the middle. Each curve consists of "
    "Bezier polynomials, run clockwise, which orbits at its damping cross one way: outwards if it returns, inwards "
    "if it is absent or lands. A curve that returns proves that the orbit from the exit point (1 - epsilon c V, V) "
    "with x2' = -j comes back to the belt line (or runs away) at its damping and below; one that is absent, that it "
    "does not come back at its damping and above; one that lands, that it is bounded, and sticks if it comes back, "
    "at its damping and above."
)
KEYS = {"format", "statement", "written_by", "law", "law_definition", "axes", "parts"}

# phi of the laws that a name defines (docs/configuration.md), with their parameters.
BUILT_IN = {
    ("stribeck", ""): ("(1 - alpha)/(1 + eps*gamma*u) + alpha + eps*beta*u^2", "alpha beta gamma"),
    ("exponential", ""): ("mu + (1 - mu)*exp(-u/vs) + eta*u", "mu vs eta"),
    ("exponential", "exponent"): ("mu + (1 - mu)*exp(-(u/vs)^exponent) + eta*u", "mu vs eta exponent"),
    ("lorentzian", ""): ("mu + (1 - mu)/(1 + (u/vs)^2) + eta*u", "mu vs eta"),
    ("coulomb", ""): ("1 - drop + eta*u", "drop eta"),
}


class Refused(Exception):
    """A claim that is not proved."""


class Unknown(Exception):
    """A number that the balls do not decide: a shorter cell may."""


def need(condition, problem):
    if not condition:
        raise Refused(problem)


def number(x):
    """A double, exactly."""
    need(isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x), f"{x!r} is not a finite number")
    return arb(float(x))


# --- formulas ---------------------------------------------------------------------------------------------------------------


class Direction:
    """The first Taylor coefficients of a series along a direction of parameters."""

    def __init__(self, *terms):
        self.terms = terms
        self.prec = terms[0].prec

    def __getitem__(self, k):
        return self.terms[0][k]

    def lifted(self, other):
        return other.terms if isinstance(other, Direction) else (other, 0, 0)

    def of(self, f, slope, bend):
        """f of it, by the chain rule; `bend` is half the second derivative."""
        _, b, c = self.terms
        return Direction(f, slope * b, slope * c + bend * b * b)

    def __add__(self, other):
        return Direction(*(a + b for a, b in zip(self.terms, self.lifted(other))))

    def __mul__(self, other):
        (a, b, c), (d, e, f) = self.terms, self.lifted(other)
        return Direction(a * d, a * e + b * d, a * f + b * e + c * d)

    def __neg__(self):
        return Direction(*(-a for a in self.terms))

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def inverse(self):
        inverse = 1 / self.terms[0]
        return self.of(inverse, -inverse * inverse, inverse * inverse * inverse)

    def __truediv__(self, other):
        return self * (other.inverse() if isinstance(other, Direction) else 1 / other)

    def __rtruediv__(self, other):
        return self.inverse() * other

    __radd__, __rmul__ = __add__, __mul__

    def exp(self):
        value = self.terms[0].exp()
        return self.of(value, value, value / 2)

    def log(self):
        inverse = 1 / self.terms[0]
        return self.of(self.terms[0].log(), inverse, -inverse * inverse / 2)

    def sqrt(self):
        root = self.terms[0].sqrt()
        return self.of(root, 1 / (2 * root), -1 / (8 * root * root * root))

    def sin(self):
        sin, cos = self.terms[0].sin(), self.terms[0].cos()
        return self.of(sin, cos, -sin / 2)

    def cos(self):
        sin, cos = self.terms[0].sin(), self.terms[0].cos()
        return self.of(cos, -sin, -cos / 2)

    def atan(self):
        x = self.terms[0]
        slope = 1 / (1 + x * x)
        return self.of(x.atan(), slope, -x * slope * slope)

    def derivative(self):
        return Direction(*(a.derivative() for a in self.terms))


def constant(series, value):
    """A number as a series like another one; a pair is a number and its slope along the direction."""
    value, slope = value if isinstance(value, tuple) else (value, 0)
    series_of = lambda x: arb_series([x], series.prec)
    return Direction(series_of(value), series_of(slope), series_of(0)) if isinstance(series, Direction) else series_of(value)


def power(base, exponent):
    """base ** exponent of a series."""
    if exponent.is_integer() and abs(exponent) < 1000:
        n = int(exponent.unique_fmpz())
        result, square = constant(base, 1), base
        for bit in reversed(bin(abs(n))[2:]):
            result, square = (result * square if bit == "1" else result), square * square
        return result if n >= 0 else constant(base, 1) / result
    first = base[0]
    if first > 0:
        return (base.log() * exponent).exp()
    if isinstance(base, Direction):
        raise Unknown
    # Next to rest, where slip speeds are at least 0: the value and the slope, which are finite; nothing is said of more.
    need(exponent >= 1, "a power of the slip speed falls at once as slip begins")
    top = first.upper()
    if not top >= 0:
        raise Unknown
    to = lambda p: arb(0) if top == 0 and p > 0 else arb(1) if p == 0 else (top**p).union(arb(0))
    unknown = arb("nan")
    terms = [to(exponent), exponent * to(exponent - 1) * base[1]] + [unknown] * (base.prec - 2)
    return arb_series(terms[: base.prec], base.prec)


def with_sign(x):
    if x[0] > 0:
        return x
    if x[0] < 0:
        return -x
    raise Unknown


def tanh(x):
    value = lambda x: 1 - 2 / ((2 * x).exp() + 1)
    if not isinstance(x, Direction):
        return value(x)
    t = value(x.terms[0])
    slope = 1 - t * t
    return x.of(t, slope, -t * slope)


def hyperbolic(x, sign):
    return (x.exp() + (-x).exp() * sign) / 2


FUNCTIONS = {
    "exp": lambda x: x.exp(), "ln": lambda x: x.log(), "log": lambda x: x.log(), "sqrt": lambda x: x.sqrt(),
    "sin": lambda x: x.sin(), "cos": lambda x: x.cos(), "tan": lambda x: x.sin() / x.cos(), "atan": lambda x: x.atan(),
    "sinh": lambda x: hyperbolic(x, -1), "cosh": lambda x: hyperbolic(x, 1), "tanh": tanh,
    "asinh": lambda x: (x + (x * x + 1).sqrt()).log(), "log10": lambda x: x.log() / arb(10).log(), "abs": with_sign,
}  # fmt: skip
OPERATORS = {
    ast.Add: lambda a, b: a + b, ast.Sub: lambda a, b: a - b, ast.Mult: lambda a, b: a * b, ast.Div: lambda a, b: a / b,
}  # fmt: skip


class Formula:
    """phi as text; the names that are neither functions nor constants are parameters, in the order of the text."""

    def __init__(self, text, names=None):
        need(len(text) < 5000 and re.fullmatch(r"[\w\s.+\-*/^(),]*", text) and "**" not in text and "//" not in text, "no formula")
        try:
            self.tree = ast.parse(text.replace("^", "**").strip(), mode="eval").body
        except (SyntaxError, RecursionError, MemoryError) as error:
            raise Refused(f"no formula: {error}") from error
        words = [word for word in re.findall(r"(?<![\w.])[^\W\d]\w*", text)]
        reserved = {"u", "v", "e", "pi", "eps", "epsilon", "max", "sign", *FUNCTIONS}
        self.names = names if names is not None else list(dict.fromkeys(word for word in words if word not in reserved))
        self.corners = []
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "max":
                need(len(node.args) == 2, "max of two")
                unit = self.of_slip(node.args[0])
                node.place = len(self.corners)
                self.corners.append(number(ast.literal_eval(node.args[1])) / unit)

    @staticmethod
    def of_slip(node):
        """The unit of the slip speed in `unit*u`."""
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult) and isinstance(node.left, ast.Constant):
            return number(node.left.value) * Formula.of_slip(node.right)
        need(isinstance(node, ast.Name) and node.id in ("u", "v"), "max is one of the slip speed")
        return arb(1)

    def at(self, node, u, env, above):
        """A series; `above` tells of each max whether the slip speed is the larger one."""
        go = lambda node: self.at(node, u, env, above)
        if isinstance(node, ast.Constant):
            return constant(u, number(node.value))
        if isinstance(node, ast.Name):
            if node.id in ("u", "v"):
                return u
            need(node.id in env, f"the parameter {node.id} has no value")
            return constant(u, env[node.id])
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
            return -go(node.operand) if isinstance(node.op, ast.USub) else go(node.operand)
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", "")
            if name == "max":
                return go(node.args[0 if above[node.place] else 1])
            need(name in FUNCTIONS and len(node.args) == 1 and not node.keywords, f"no function {name}")
            argument = node.args[0]
            if name == "abs" and isinstance(argument, ast.Name) and argument.id in ("u", "v"):
                return u
            return FUNCTIONS[name](go(argument))
        need(isinstance(node, ast.BinOp), "no formula")
        if isinstance(node.op, ast.Pow):
            if isinstance(node.left, ast.Name) and node.left.id == "e":
                return go(node.right).exp()
            base, exponent = go(node.left), go(node.right)
            of = exponent.terms if isinstance(exponent, Direction) else (exponent, arb_series([0], 1), arb_series([0], 1))
            is_constant = all(of[0][k] == 0 for k in range(1, u.prec)) and of[1][0] == 0 and of[2][0] == 0
            return power(base, exponent[0]) if is_constant else (base.log() * exponent).exp()
        need(type(node.op) in OPERATORS, "no formula")
        return OPERATORS[type(node.op)](go(node.left), go(node.right))


def constant_zero(like):
    """The slip speed 0, along a direction if parameters are."""
    zero = arb_series([0], 1)
    return Direction(zero, zero, zero) if isinstance(like, tuple) else zero


# --- laws -------------------------------------------------------------------------------------------------------------------


def parameters_of(name, definition):
    """The names of a law's parameters."""
    definition = definition.removeprefix("small eps\n")
    has_drop = definition.startswith("drop\n") or definition == "drop"
    definition = definition[5:] if has_drop else definition
    if name == "expression":
        names = Formula(definition.partition("\n")[2]).names
    elif name == "table":
        names = []
    else:
        need((name, definition) in BUILT_IN, f"no law {name}")
        names = BUILT_IN[name, definition][1].split()
    return names + ["drop"] * has_drop


class Law:
    """phi on pieces [from, to] of slip speeds, each a function of a series; the drop j."""

    def __init__(self, name, definition, epsilon, values, middle=None):
        """Values are numbers, or pairs of a number and its slope along a direction of parameters; `middle` is the law in the
        middle of a box."""
        self.middle = middle
        need(isinstance(name, str) and isinstance(definition, str), "no law")
        values, self.zero = list(values), constant_zero(epsilon)
        definition = definition.removeprefix("small eps\n")
        added = arb(0)
        if definition.startswith("drop\n") or definition == "drop":
            need(values, "no drop")
            definition, added = definition[5:], values.pop()
        # Along a direction the drop has a slope.
        self.drop = constant(self.zero, added)
        env = {"eps": epsilon, "pi": number(math.pi), "e": number(math.e)}
        env["epsilon"] = env["eps"]
        if name == "table":
            need(not values and not isinstance(epsilon, tuple), "a table has no parameters, and no boxes")
            self.table(definition)
        elif name == "expression":
            head, _, text = definition.partition("\n")
            self.formula(Formula(text), values, env, head.removesuffix(" above:"), head.endswith(" above:"))
        else:
            need((name, definition) in BUILT_IN, f"no law {name}")
            text, names = BUILT_IN[name, definition]
            self.formula(Formula(text, names.split()), values, env, "1", name == "coulomb")
        need(self.middle or (self.drop[0] >= 0 and self.drop[0] < 1), "the drop is not in [0, 1)")

    def formula(self, formula, values, env, level, may_drop):
        need(len(values) == len(formula.names), "numbers of parameters")
        env = {**env, **dict(zip(formula.names, values))}
        level = number(float(level))
        need(level > 0, "no friction at rest")
        order = sorted(range(len(formula.corners)), key=lambda i: float(formula.corners[i].mid()))
        bounds = [arb(0), *(formula.corners[i] for i in order), arb("inf")]
        need(all(a <= b for a, b in zip(bounds, bounds[1:])) or len(order) < 2, "corners whose order is not known")
        self.pieces = []
        for k, (lo, hi) in enumerate(zip(bounds, bounds[1:])):
            above = [i in order[:k] for i in range(len(order))]
            phi = lambda u, above=above: formula.at(formula.tree, u, env, above) / level
            self.pieces.append((lo, hi, phi))
        self.rest(self.pieces[0][2](self.zero), may_drop)

    def rest(self, begins, may_drop):
        """The drop, from friction as slip begins."""
        self.drops = self.middle.drops if self.middle else may_drop and not abs(begins[0] - 1) < 1e-9
        if self.drops:
            self.drop = self.drop + (1 - begins)
        elif not self.middle:
            need(abs(begins[0] - 1) < 1e-9, "friction in slip does not begin at the friction at rest")

    def table(self, definition):
        """Cubics with the slopes of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984)."""
        # The last line may tell what is known of the file of the data.
        head, *lines = definition.partition("\n{")[0].split("\n")
        level, _, origin = head.partition(" ")
        level, rows = number(float(level)), [[number(float(x)) for x in line.split(",")[:2]] for line in lines]
        need(len(rows) >= 3 and level > 0 and rows[0][0] == 0, "no table")
        u, phi = [row[0] for row in rows], [row[1] / level for row in rows]
        need(all(a < b for a, b in zip(u, u[1:])), "slip speeds do not rise")
        h = [b - a for a, b in zip(u, u[1:])]
        secant = [(b - a) / step for a, b, step in zip(phi, phi[1:], h)]
        same = lambda a, b: (a > 0 and b > 0) or (a < 0 and b < 0)
        level_at = lambda i: rows[i][1] == rows[i + 1][1]  # an exact comparison of the data

        def end(h0, h1, s0, s1):
            slope = ((2 * h0 + h1) * s0 - h0 * s1) / (h0 + h1)
            if not same(slope, s0):
                return arb(0)
            return 3 * s0 if not same(s0, s1) and abs(slope) > 3 * abs(s0) else slope

        slopes = [end(h[0], h[1], secant[0], secant[1])]
        for i in range(1, len(h)):
            before, after = secant[i - 1], secant[i]
            w = 2 * h[i] + h[i - 1], h[i] + 2 * h[i - 1]
            flat = level_at(i - 1) or level_at(i) or not same(before, after)
            slopes.append(arb(0) if flat else (w[0] + w[1]) / (w[0] / before + w[1] / after))
        slopes.append(end(h[-1], h[-2], secant[-1], secant[-2]))
        self.pieces = []
        for i, step in enumerate(h):
            c2 = (3 * secant[i] - 2 * slopes[i] - slopes[i + 1]) / step
            c3 = (slopes[i] + slopes[i + 1] - 2 * secant[i]) / (step * step)
            cubic = lambda x, i=i, c2=c2, c3=c3: phi[i] + (x - u[i]) * (slopes[i] + (x - u[i]) * (c2 + (x - u[i]) * c3))
            self.pieces.append((u[i], u[i + 1], cubic))
        self.rest(constant(self.zero, phi[0]), origin.startswith("above: "))


# --- curves -----------------------------------------------------------------------------------------------------------------


def coefficients(points):
    """Coefficients of powers, from Bezier control points."""
    d = len(points) - 1
    difference = lambda k: sum(((-1) ** (k - i) * math.comb(k, i) * points[i] for i in range(k + 1)), arb(0))
    return [math.comb(d, k) * difference(k) for k in range(d + 1)]


def polynomial(c, x):
    result = arb_series([c[-1]], x.prec)
    for a in reversed(c[:-1]):
        result = a + x * result
    return result


WHOLE, FROM_ZERO = arb(0, 1), arb(0.5, 0.5)


def spread(middle, along):
    """All values of what is linear along the axes."""
    return sum((WHOLE * a for a in along), middle)


class Place:
    """The law where parameters are: in the middle of a box, or all over it, with slopes along some of its axes."""

    def __init__(self, box, is_all=False, along=()):
        self.is_all, self.along, self.belt_speed, self.is_point = is_all, along, box.value(-1), not box.wide
        values = [self.linear(box.value(i), box.slopes(i)) for i in range(len(box.domain))]
        epsilon, *parameters, speed = values
        self.law = Law(box.name, box.definition, epsilon, parameters, box.middle and box.middle.law)
        # V in units of that in the middle.
        is_one = box.domain[-1][0] == box.domain[-1][1]
        self.unit = self.linear(arb(1), []) if is_one else tuple(x / box.value(-1) for x in speed)
        self.epsilon = epsilon

    def linear(self, middle, along):
        """A number that is linear along the axes."""
        if self.is_point:
            return middle
        value = spread(middle, along) if self.is_all else middle
        return value, sum((along[i] for i in self.along if along), arb(0))


class Box:
    """Ranges of epsilon, the law's parameters and V."""

    def __init__(self, name, definition, domain):
        self.name, self.definition, self.domain = name, definition, domain
        self.wide = [i for i, (lo, hi) in enumerate(domain) if lo < hi]
        axes = range(len(self.wide))
        self.middle = None
        self.middle = Place(self)
        self.thin = [Place(self, False, (i,)) for i in axes]
        self.all = [Place(self, True, (i,)) for i in axes]
        self.pairs = [(i, j, Place(self, True, (i, j))) for i in axes for j in range(i)]
        need(bool(self.middle.law.drop[0] >= 0), "the drop is not one")

    def value(self, axis):
        lo, hi = self.domain[axis]
        return (number(lo) + number(hi)) / 2

    def slopes(self, axis):
        lo, hi = self.domain[axis]
        half = (number(hi) - number(lo)) / 2
        return [half if i == axis % len(self.domain) else arb(0) for i in self.wide]


class Piece:
    """A piece of a curve over a box: coefficients of u and y in the middle, and along the axes."""

    def __init__(self, box, points, along, c, sign):
        self.box, self.c, self.sign, self.cells = box, c, sign, 0
        self.u, self.y = ([coefficients(one)] + [coefficients(a) for a in more] for one, more in zip(points, zip(*along) if along else ([], [])))
        speeds = sorted((spread(u, [a[0][k] for a in along]) for k, u in enumerate(points[0])), key=lambda x: float(x.mid()))
        self.least, self.most = min(speeds, key=lambda x: float(x.lower())).lower(), max(speeds, key=lambda x: float(x.upper())).upper()

    def series(self, at, order, coordinate, place):
        x = arb_series([at, 1], order + 2)
        middle, *along = coordinate
        if place.is_point:
            return polynomial(middle, x)
        pairs = [place.linear(m, [a[k] for a in along]) for k, m in enumerate(middle)]
        values, slopes = (polynomial([pair[i] for pair in pairs], x) for i in (0, 1))
        return Direction(values, slopes, arb_series([0], order + 2))

    def about(self, m):
        """The coefficients of u and y about a place: those over a box are narrow there only."""
        shifted = lambda c: (lambda p: [p[k] for k in range(len(c))])(polynomial(c, arb_series([m, 1], len(c))))
        return [[shifted(c) for c in coordinate] for coordinate in (self.u, self.y)]

    def crossing(self, place, phi, about, at, order):
        """Taylor series of S times its sign at `at` from the place about which the coefficients are."""
        u, y = (self.series(at, order, coordinate, place) for coordinate in about)
        if u[0].lower() < self.least or u[0].upper() > self.most:
            values = u.terms[0] if isinstance(u, Direction) else u
            terms = [values[k] for k in range(order + 2)]
            terms[0] = terms[0].intersection(self.least.union(self.most))
            values = arb_series(terms, order + 2)
            u = Direction(values, *u.terms[1:]) if isinstance(u, Direction) else values
        viscous = constant(u, place.epsilon) * constant(u, place.linear(*self.c))
        belt_speed, unit = place.belt_speed, constant(u, place.unit)
        fall = phi(u).derivative() if place.is_point else phi(unit * u).derivative() / unit
        return (u.derivative() * (belt_speed - u + viscous * y) + y * fall - y.derivative() * y) * self.sign

    def taylor(self, place, number, about, r, term):
        """The Taylor form over a cell of a term along a direction."""
        phi = place.law.pieces[number][2]
        of = lambda s: s.terms[term] if isinstance(s, Direction) else s
        middle, whole = (of(self.crossing(place, phi, about, at, ORDER)) for at in (arb(0), arb(0, r)))
        value = whole[ORDER]
        for k in reversed(range(ORDER)):
            value = middle[k] + arb(0, r) * value
        return value

    def is_positive(self, number, lo, hi):
        """S times its sign over a cell and the box: plain balls where the law has few derivatives, or the Taylor form."""
        box, r, about = self.box, (hi - lo) / 2, self.about((lo + hi) / 2)
        try:
            everywhere = box.all[0] if box.wide else box.middle
            if self.crossing(everywhere, everywhere.law.pieces[number][2], about, arb(0, r), 0)[0] > 0:
                return True
            value = self.taylor(box.middle, number, about, r, 0)
            squares = [self.taylor(place, number, about, r, 2) for place in box.all]
            for place, square in zip(box.thin, squares):
                value += WHOLE * self.taylor(place, number, about, r, 1) + FROM_ZERO * square
            for i, j, place in box.pairs:
                value += WHOLE * (self.taylor(place, number, about, r, 2) - squares[i] - squares[j])
        except (Unknown, ValueError, ZeroDivisionError):
            return False
        return bool(value > 0)

    def is_wrong(self, number, at):
        middle = self.box.middle
        try:
            return bool(self.crossing(middle, middle.law.pieces[number][2], self.about(at), arb(0), 0)[0] <= 0)
        except (Unknown, ValueError, ZeroDivisionError):
            return False

    def is_crossed(self, lo=0.0, hi=1.0, halvings=HALVINGS):
        """Whether S has its sign on [lo, hi], with each piece of the law that the curve passes there."""
        self.cells += 1
        if self.cells > CELLS:
            return False
        x = arb_series([arb(0, (hi - lo) / 2)], 1)
        middle, *along = (polynomial(c, x)[0] for c in self.about((lo + hi) / 2)[0])
        u = spread(middle, along).intersection(self.least.union(self.most))
        laws = self.box.middle.law.pieces
        # A piece of the law that the curve touches only, from one side, does not count; ends are compared exactly.
        is_level = self.least == self.most
        passed = [i for i, (a, b, _) in enumerate(laws) if is_level or (a < self.most and b > self.least)]
        # Over a box corners of the law move, and all pieces count.
        met = passed if self.box.wide else [i for i in passed if not laws[i][0] > u.upper() and not laws[i][1] < u.lower()]
        if met and all(self.is_positive(i, lo, hi) for i in met):
            return True
        middle = (lo + hi) / 2
        if halvings == 0 or not met or (len(met) == 1 and self.is_wrong(met[0], middle)):
            return False
        return self.is_crossed(lo, middle, halvings - 1) and self.is_crossed(middle, hi, halvings - 1)


def place(u, y, rises, belt_speed):
    """Left of the equilibrium, below it with u rising, or above it; None proves nothing."""
    if all(x > belt_speed for x in u):
        return "left"
    for name, sign in (("below", -1), ("above", 1)):
        z = [sign * x for x in y]
        ends = [z[0], z[-1]]
        is_there = all(x > 0 for x in z[1:-1]) and all(x >= 0 for x in ends) and any(x > 0 for x in ends)
        if is_there and (name == "above" or rises):
            return name
    return None


def read_pieces(pieces, like=None):
    """Control points as columns of numbers; of slopes as many as of the curve."""
    need(isinstance(pieces, list) and 0 < len(pieces) <= PIECES and len(pieces) == len(like or pieces), "no pieces")
    columns = []
    for i, points in enumerate(pieces, 1):
        need(isinstance(points, list) and 2 <= len(points) <= POINTS, f"piece {i} is no polynomial")
        need(all(isinstance(point, list) and len(point) == 2 for point in points), f"piece {i} is no polynomial")
        need(not like or len(points) == len(like[i - 1][0]), f"piece {i} is no polynomial")
        columns.append(tuple([number(x) for x in column] for column in zip(*points)))
        if i > 1:
            before = columns[-2]
            is_joined = all(columns[-1][k][0] == before[k][-1] for k in (0, 1))
            need(is_joined, f"piece {i} does not begin where the last one ends")
    return columns


def prove_curve(curve, box):
    """Proves a curve over a box; returns its kind and damping, with its slopes."""
    need(isinstance(curve, dict) and set(curve) | {"along"} == {"kind", "c", "pieces", "along"}, "no curve")
    kind, along, V = curve["kind"], curve.get("along", []), box.value(-1)
    need(kind in ("returns", "absent", "lands"), f"no kind {kind!r}")
    need(isinstance(along, list) and len(along) == len(box.wide), "no slopes along the axes")
    need(all(isinstance(one, dict) and set(one) == {"c", "pieces"} for one in along), "no slopes along the axes")
    c = number(curve["c"]), [number(one["c"]) for one in along]
    pieces = read_pieces(curve["pieces"])
    slopes = [read_pieces(one["pieces"], pieces) for one in along]
    known, places, hulls = box.middle.law.pieces[-1][1], [], []
    for i, points in enumerate(pieces):
        more = [one[i] for one in slopes]
        u, y = ([spread(x, [a[k][at] for a in more]) for at, x in enumerate(points[k])] for k in (0, 1))
        rise = lambda column, at: column[at + 1] - column[at]
        rises = all(spread(rise(points[0], at), [rise(a[0], at) for a in more]) > 0 for at in range(len(u) - 1))
        need(all(x >= 0 and x <= known for x in u), f"piece {i + 1} leaves the law")
        need(i == 0 or y[0] > 0 or y[0] < 0 or u[0] > V, f"piece {i + 1} begins at y = 0 right of the equilibrium")
        places.append(place(u, y, rises, V))
        need(places[-1], f"piece {i + 1} does not lead once around the equilibrium")
        hulls.append((u, y))
    need(places[0] == "below" and places[-1] == "above", "it does not lead from below to above")
    # How far the start is below the exit point, and how far the end is below the end of the stick segment.
    drops = [where.law.drop / constant(where.law.zero, where.unit) for where in box.all]
    over = spread(-pieces[0][1][0] - box.middle.law.drop[0], [-s[0][1][0] - d.terms[1][0] for s, d in zip(slopes, drops)])
    room = spread(2 - box.middle.law.drop[0], [d.terms[1][0] for d in drops])
    u0, y0, u1, y1 = hulls[0][0][0], hulls[0][1][0], hulls[-1][0][-1], hulls[-1][1][-1]
    need(u0 == 0 and y0 <= 0, "it does not begin at the belt line")
    if kind == "returns":
        need(over <= 0 and u1 == 0 and y1 > 0, "its ends prove no return")
    else:
        need(y0 < 0 and over >= 0, "it begins inside the exit point")
        if kind == "absent":
            need(u1 > 0 and u1 < V and y1 == 0, "its ends prove no absence")
        else:
            need(u1 == 0 and y1 > 0 and y1 < room, "its ends prove no landing")
    sign = 1 if kind == "returns" else -1
    for i, points in enumerate(pieces):
        one = Piece(box, points, [s[i] for s in slopes], c, sign)
        need(one.is_crossed(), f"orbits are not proved to cross piece {i + 1} one way")
    return kind, Fraction(curve["c"]), sum(abs(Fraction(one["c"])) for one in along)


# --- certificates -----------------------------------------------------------------------------------------------------------


def shares(proved, lo, hi):
    """The shares of a box in which the cycle exists, and does not, by curves at dampings c + sum of z_i slopes."""
    cut = lambda x: min(max(x, Fraction(0)), Fraction(1))
    at = lambda kind: [(c, spread) for which, c, spread in proved if which == kind]
    lands = min((c + spread for c, spread in at("lands")), default=None)
    from_ = None if lands is None else max(lands, lo)
    present = absent = Fraction(0)
    for c, spread in at("returns") if from_ is not None else []:
        if lo == hi:
            present = max(present, Fraction(from_ <= lo <= c - spread))
        else:
            # The mean of the smaller of a linear function and hi is at least its mean less what it exceeds hi by at most.
            top = max(c - max(c + spread - hi, 0), min(c - spread, hi))
            present = max(present, cut((top - from_) / (hi - lo)))
    for c, spread in at("absent"):
        if lo == hi:
            absent = max(absent, Fraction(c + spread <= lo))
        else:
            bottom = min(c + max(lo - c + spread, 0), max(c + spread, lo))
            absent = max(absent, cut((hi - bottom) / (hi - lo)))
    return present, absent


def prove_node(node, domain, axes, law, damping, cuts=CUTS):
    """Proves a cut or curves; returns the shares of the domain."""
    need(isinstance(node, dict) and set(node) <= {"cut", "curves"} and len(node) <= 1, "no proof of a box")
    if "cut" in node:
        cut = node["cut"]
        need(isinstance(cut, dict) and set(cut) == {"axis", "at", "below", "above"} and cuts > 0, "no cut")
        need(cut["axis"] in axes, "a cut along no axis")
        axis, at = axes.index(cut["axis"]), cut["at"]
        lo, hi = domain[axis]
        need(bool(number(lo) < number(at)) and bool(number(at) < number(hi)), "a cut outside of its box")
        found, width = [Fraction(0)] * 2, Fraction(hi) - Fraction(lo)
        for part, ends in (("below", [lo, at]), ("above", [at, hi])):
            half = [ends if i == axis else range_ for i, range_ in enumerate(domain)]
            share = (Fraction(ends[1]) - Fraction(ends[0])) / width
            one = prove_node(cut[part], half, axes, law, damping, cuts - 1)
            found = [sum_ + share * x for sum_, x in zip(found, one)]
        return found
    curves = node.get("curves", [])
    need(isinstance(curves, list) and len(curves) <= CURVES, "sizes")
    if not curves:
        return Fraction(0), Fraction(0)
    box, proved = Box(*law, domain), []
    for i, curve in enumerate(curves, 1):
        try:
            proved.append(prove_curve(curve, box))
        except Refused as why:
            where = ", ".join(f"{axis} {range_}" for axis, range_ in zip(axes, domain))
            raise Refused(f"curve {i} at {where}: {why}") from why
    return shares(proved, *(Fraction(c) for c in damping))


def prove(certificate):
    """Proves a certificate; returns what is proved, in words."""
    need(isinstance(certificate, dict) and "format" in certificate, "no certificate")
    need(certificate["format"] == FORMAT, f"certificates of the format {certificate['format']!r} are not proved here")
    need(set(certificate) == KEYS, "other keys than the format has")
    need(certificate["statement"] == STATEMENT, "another statement")
    axes, law = certificate["axes"], (certificate["law"], certificate["law_definition"])
    need(all(isinstance(part, str) for part in law), "no law")
    need(isinstance(axes, list) and axes[:1] == ["epsilon"] and axes[-1:] == ["V"], "no axes")
    need(axes[1:-1] == parameters_of(*law), "the axes are not the parameters of the law")
    need(isinstance(certificate["parts"], list), "no parts")
    said = []
    for part in certificate["parts"]:
        need(isinstance(part, dict) and set(part) == {"domain", "c", "present", "absent", "proof"}, "no part")
        domain, damping = part["domain"], part["c"]
        need(isinstance(domain, list) and len(domain) == len(axes), "no domain")
        for range_ in [*domain, damping]:
            need(isinstance(range_, list) and len(range_) == 2 and bool(number(range_[0]) <= number(range_[1])), "no range")
        need(domain[0][0] > 0 and domain[-1][0] > 0 and damping[0] >= 0, "no parameters")
        present, absent = prove_node(part["proof"], domain, axes, law, damping)
        for name, proved in (("present", present), ("absent", absent)):
            need(bool(number(part[name]) <= arb(1)) and Fraction(part[name]) <= proved, f"the share {name}")
        said.append((float(present), float(absent)))
    means = [sum(column) / len(said) for column in zip(*said)] or [0, 0]
    return f"present {means[0]:.4g}, absent {means[1]:.4g}" + (f", of {len(said)} parts on average" if len(said) != 1 else "")


def no_constant(name):
    raise Refused(f"{name} is no number")


def main(paths):
    failed = 0
    for path in paths:
        try:
            with open(path, encoding="utf-8") as file:
                verdict = prove(json.load(file, parse_constant=no_constant))
            print(f"{path}: proved, {verdict}")
        except (Refused, ValueError, KeyError, TypeError, RecursionError, OSError) as why:
            failed += 1
            print(f"{path}: not proved: {why}")
    return 1 if failed or not paths else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
