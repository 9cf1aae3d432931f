"""Proves the claims of certificates again, in ball arithmetic (Arb, by python-flint).

    pip install python-flint
    python scripts/checks/proof.py point.json ...

It shares no code and no number with slipmap: it reads a certificate of `probe --proof`, builds the law from its definition,
and proves what the certificate states, or names the claim that it cannot prove. Statement and lemma: crates/certify/src/curve/mod.rs,
docs/proofs.md. Exit status 0 where every claim of every file is proved.

Notation: u slip speed, V belt speed, v = V - u, C = epsilon c, phi friction in slip over friction at rest, j its drop as slip begins.
Orbits below the belt line: v' = y, y' = -v - (phi'(u) + C) y. A curve (u(s), y(s)) is crossed outwards where
S = u_s (V - u + C y) + y (phi o u)_s - y_s y is positive: no derivative of the law is needed.
"""

import ast
import json
import math
import re
import sys

from flint import arb, arb_series, ctx

ctx.prec = 128
# Order of the Taylor form of a cell; halvings and cells of a piece; largest numbers of curves, pieces and control points.
ORDER, HALVINGS, CELLS = 11, 50, 2000
CURVES, PIECES, POINTS = 3, 1000, 32

FORMAT = "slipmap proof of a point 2"
STATEMENT = (
    "With x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(|x2 - V|), friction up to 1 at rest, and the friction law phi of "
    "the given name, definition and parameters in slip, plus a constant on each of its pieces that makes it continuous and "
    "phi(0+) = 1 - j, j the drop of the law as slip begins, the orbit that leaves the exit point (1 - epsilon c V, V) with "
    "x2' = -j comes back to the belt line (or runs away) for c < critical_c[0] and does not for c > critical_c[1]; null claims "
    "nothing on its side. Verdict present: a stick-slip limit cycle exists at the given c. Absent: none exists. Undecided: "
    "nothing is claimed of that. Each of the curves consists of Bezier polynomials with control points (V - x2, x2'), run "
    "clockwise, which orbits at epsilon c = viscous cross one way: outwards if it returns, inwards if it is absent or lands. A "
    "curve that returns proves that the orbit comes back or runs away at epsilon c <= viscous; one that is absent, that it does "
    "not come back at epsilon c >= viscous; one that lands, that it is bounded, and sticks if it comes back, at epsilon c >= "
    "viscous."
)
KEYS = {
    "format", "statement", "written_by", "law", "law_definition", "parameters", "epsilon", "V", "c", "critical_c", "verdict",
    "curves",
}  # fmt: skip

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


def constant(series, value):
    return arb_series([value], series.prec)


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


def hyperbolic(x, sign):
    return (x.exp() + (-x).exp() * sign) / 2


FUNCTIONS = {
    "exp": lambda x: x.exp(), "ln": lambda x: x.log(), "log": lambda x: x.log(), "sqrt": lambda x: x.sqrt(),
    "sin": lambda x: x.sin(), "cos": lambda x: x.cos(), "tan": lambda x: x.sin() / x.cos(), "atan": lambda x: x.atan(),
    "sinh": lambda x: hyperbolic(x, -1), "cosh": lambda x: hyperbolic(x, 1), "tanh": lambda x: 1 - 2 / ((2 * x).exp() + 1),
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
            is_constant = all(exponent[k] == 0 for k in range(1, u.prec))
            return power(base, exponent[0]) if is_constant else (base.log() * exponent).exp()
        need(type(node.op) in OPERATORS, "no formula")
        return OPERATORS[type(node.op)](go(node.left), go(node.right))


# --- laws -------------------------------------------------------------------------------------------------------------------


class Law:
    """phi on pieces [from, to] of slip speeds, each a function of a series; the drop j."""

    def __init__(self, certificate):
        name, definition = certificate["law"], certificate["law_definition"]
        need(isinstance(name, str) and isinstance(definition, str), "no law")
        values = [number(x) for x in certificate["parameters"]]
        definition = definition.removeprefix("small eps\n")
        self.drop = arb(0)
        if definition.startswith("drop\n") or definition == "drop":
            need(values, "no drop")
            definition, self.drop = definition[5:], values.pop()
        env = {"eps": number(certificate["epsilon"]), "pi": number(math.pi), "e": number(math.e)}
        env["epsilon"] = env["eps"]
        if name == "table":
            need(not values, "a table has no parameters")
            self.table(definition)
        elif name == "expression":
            head, _, text = definition.partition("\n")
            self.formula(Formula(text), values, env, head.removesuffix(" above:"), head.endswith(" above:"))
        else:
            need((name, definition) in BUILT_IN, f"no law {name}")
            text, names = BUILT_IN[name, definition]
            self.formula(Formula(text, names.split()), values, env, "1", name == "coulomb")
        need(self.drop >= 0 and self.drop < 1, "the drop is not in [0, 1)")

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
        self.rest(self.pieces[0][2](arb_series([0], 1))[0], may_drop)

    def rest(self, begins, may_drop):
        """The drop, from friction as slip begins."""
        if may_drop and not abs(begins - 1) < 1e-9:
            self.drop += 1 - begins
        else:
            need(abs(begins - 1) < 1e-9, "friction in slip does not begin at the friction at rest")

    def table(self, definition):
        """Cubics with the slopes of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984)."""
        head, *lines = definition.split("\n")
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
        self.rest(phi[0], origin.startswith("above: "))


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


class Piece:
    def __init__(self, points, law, belt_speed, viscous, sign):
        self.law, self.belt_speed, self.viscous, self.sign = law, belt_speed, viscous, sign
        self.cells = 0
        speeds = sorted(points[0], key=float)
        self.least, self.most = speeds[0], speeds[-1]
        self.u, self.y = map(coefficients, points)

    def crossing(self, phi, at, order):
        """Taylor series at `at` of S times its sign."""
        x = arb_series([at, 1], order + 2)
        u, y = polynomial(self.u, x), polynomial(self.y, x)
        if u[0].lower() < self.least or u[0].upper() > self.most:
            terms = [u[k] for k in range(order + 2)]
            terms[0] = terms[0].intersection(self.least.union(self.most))
            u = arb_series(terms, order + 2)
        s = u.derivative() * (self.belt_speed - u + self.viscous * y) + y * phi(u).derivative() - y.derivative() * y
        return s * self.sign

    def lowest(self, phi, lo, hi):
        """S times its sign over a cell: the Taylor form, or plain balls where the law has few derivatives."""
        m, r = (lo + hi) / 2, (hi - lo) / 2
        whole = arb(m, r)
        try:
            plain = self.crossing(phi, whole, 0)[0]
            if plain > 0:
                return True
            value = self.crossing(phi, whole, ORDER)[ORDER]
            middle = self.crossing(phi, arb(m), ORDER)
        except (Unknown, ValueError, ZeroDivisionError):
            return False
        for k in reversed(range(ORDER)):
            value = middle[k] + arb(0, r) * value
        return bool(value > 0)

    def is_wrong(self, phi, at):
        try:
            return bool(self.crossing(phi, arb(at), 0)[0] <= 0)
        except (Unknown, ValueError, ZeroDivisionError):
            return False

    def is_crossed(self, lo=0.0, hi=1.0, halvings=HALVINGS):
        """Whether S has its sign on [lo, hi], with each piece of the law that the curve passes there."""
        self.cells += 1
        if self.cells > CELLS:
            return False
        x = arb_series([arb((lo + hi) / 2, (hi - lo) / 2)], 1)
        u = polynomial(self.u, x)[0].intersection(self.least.union(self.most))
        # A piece of the law that the curve touches only, from one side, does not count; ends are compared exactly.
        is_level = self.least == self.most
        passed = [(a, b, phi) for a, b, phi in self.law.pieces if is_level or (a < self.most and b > self.least)]
        met = [phi for a, b, phi in passed if not a > u.upper() and not b < u.lower()]
        if met and all(self.lowest(phi, lo, hi) for phi in met):
            return True
        middle = (lo + hi) / 2
        if halvings == 0 or not met or (len(met) == 1 and self.is_wrong(met[0], middle)):
            return False
        return self.is_crossed(lo, middle, halvings - 1) and self.is_crossed(middle, hi, halvings - 1)


def place(u, y, belt_speed):
    """Left of the equilibrium, below it with u rising, or above it; None proves nothing."""
    if all(x > belt_speed for x in u):
        return "left"
    for name, sign in (("below", -1), ("above", 1)):
        z = [sign * x for x in y]
        is_there = all(x > 0 for x in z[1:-1]) and min(z[0], z[-1]) >= 0 and max(z[0], z[-1]) > 0
        if is_there and (name == "above" or all(a < b for a, b in zip(u, u[1:]))):
            return name
    return None


def prove_curve(curve, law, belt_speed):
    """Proves a curve; returns its kind and damping."""
    need(isinstance(curve, dict) and set(curve) == {"kind", "viscous", "pieces"}, "no curve")
    kind, viscous, V = curve["kind"], number(curve["viscous"]), number(belt_speed)
    need(kind in ("returns", "absent", "lands"), f"no kind {kind!r}")
    need(isinstance(curve["pieces"], list) and 0 < len(curve["pieces"]) <= PIECES, "no pieces")
    known, pieces, places = law.pieces[-1][1], [], []
    for i, points in enumerate(curve["pieces"], 1):
        need(isinstance(points, list) and 2 <= len(points) <= POINTS, f"piece {i} is no polynomial")
        need(all(isinstance(point, list) and len(point) == 2 for point in points), f"piece {i} is no polynomial")
        u, y = ([number(x) for x in column] for column in zip(*points))
        need(all(x >= 0 and x <= known for x in u), f"piece {i} leaves the law")
        if pieces:
            need((u[0], y[0]) == (pieces[-1][0][-1], pieces[-1][1][-1]), f"piece {i} does not begin where the last one ends")
            need(y[0] != 0 or u[0] > V, f"piece {i} begins at y = 0 right of the equilibrium")
        places.append(place(u, y, V))
        need(places[-1], f"piece {i} does not lead once around the equilibrium")
        pieces.append((u, y))
    need(places[0] == "below" and places[-1] == "above", "it does not lead from below to above")
    u0, y0, u1, y1 = pieces[0][0][0], pieces[0][1][0], pieces[-1][0][-1], pieces[-1][1][-1]
    need(u0 == 0 and y0 <= 0, "it does not begin at the belt line")
    if kind == "returns":
        need(-y0 <= law.drop and u1 == 0 and y1 > 0, "its ends prove no return")
    else:
        need(y0 < 0 and -y0 >= law.drop, "it begins inside the exit point")
        if kind == "absent":
            need(u1 > 0 and u1 < V and y1 == 0, "its ends prove no absence")
        else:
            need(u1 == 0 and y1 > 0 and y1 < 2 - law.drop, "its ends prove no landing")
    sign = 1 if kind == "returns" else -1
    for i, points in enumerate(pieces, 1):
        need(Piece(points, law, V, viscous, sign).is_crossed(), f"orbits are not proved to cross piece {i} one way")
    return kind, viscous


# --- certificates -----------------------------------------------------------------------------------------------------------


def prove(certificate):
    """Proves a certificate of a point; returns its verdict."""
    need(isinstance(certificate, dict) and "format" in certificate, "no certificate")
    need(certificate["format"] == FORMAT, f"certificates of the format {certificate['format']!r} are not proved here")
    need(set(certificate) == KEYS, "other keys than the format has")
    need(certificate["statement"] == STATEMENT, "another statement")
    curves, bounds = certificate["curves"], certificate["critical_c"]
    need(isinstance(curves, list) and len(curves) <= CURVES and isinstance(bounds, list) and len(bounds) == 2, "sizes")
    epsilon, belt_speed, c = (number(certificate[key]) for key in ("epsilon", "V", "c"))
    need(epsilon > 0 and belt_speed > 0 and c >= 0, "no point")
    law = Law(certificate)
    proved = {"returns": [], "absent": [], "lands": []}
    for i, curve in enumerate(curves, 1):
        try:
            kind, viscous = prove_curve(curve, law, certificate["V"])
        except Refused as why:
            raise Refused(f"curve {i}: {why}") from why
        proved[kind].append(viscous)
    # Products of two doubles are exact in balls of 128 bits.
    lo, hi = bounds
    need(lo is None or any(number(lo) * epsilon <= viscous for viscous in proved["returns"]), "the lower bound of critical_c")
    need(hi is None or any(number(hi) * epsilon >= viscous for viscous in proved["absent"]), "the upper bound of critical_c")
    here = epsilon * c
    verdict = certificate["verdict"]
    if verdict == "present":
        returns = any(here <= viscous for viscous in proved["returns"])
        need(returns and any(here >= viscous for viscous in proved["lands"]), "the verdict present")
    elif verdict == "absent":
        need(any(here >= viscous for viscous in proved["absent"]), "the verdict absent")
    else:
        need(verdict == "undecided", "no verdict")
    return verdict


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
