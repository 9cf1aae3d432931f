"""Random laws with a drop of friction as slip begins: the program's answers against MPFR arithmetic.

    scripts/study drops [--points 10000] [--seed 48] [--jobs 2]

Two coefficients, formulas, tables, and the named laws with the parameters `drop` and `exponent`, at random belt speeds. The
critical damping is computed as in laws.py, which shares nothing with the program, with as many steps as it takes for two
accuracies to agree where the program says otherwise. Each law is asked about at one damping, most of them within 1e-9 to 0.3, relative, of the critical one. Counted as
wrong: a critical damping farther from the reference than the error it states; a verdict of the simulation or of a theorem
that the reference contradicts; a kick, where one turn backward from the belt line decides it, that is off by more than
1e-6. Prints each of these, then the counts, and exits with 1 if there are any.
"""

import argparse
import csv
import math
import random
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path

import gmpy2
from gmpy2 import mpfr

import laws

# Enough for 16 digits of most laws.
QUICK = laws.Effort(bits=90, steps=20, stages=7)
FINEST = 16
# Halvings of the first and the last step under a power that is not whole, which has no series at rest.
HALVINGS = 36
THEOREMS = ["instability", "bendixson", "symmetric"]
KICK = 1e-6
# One in so many laws is asked for its kicks.
KICKED = 4
FUNCTIONS = {name: getattr(gmpy2, name) for name in ["exp", "tanh", "sin", "cos", "cosh", "atan"]}


@dataclass
class Case:
    """A law with a belt speed. `law` is -phi' as a function of mpfr numbers, or a table; a table has no `phi`."""

    kind: str
    options: list
    belt: float
    drop: mpfr
    law: object
    phi: object = None
    is_whole: bool = True
    rows: list = field(default_factory=list)


def number(rng, lo, hi):
    return float(f"{rng.uniform(lo, hi):.5g}")


def logarithmic(rng, lo, hi):
    return float(f"{math.exp(rng.uniform(math.log(lo), math.log(hi))):.5g}")


def named(rng, kind, belt):
    mu, width, eta = number(rng, 0.3, 1), logarithmic(rng, 0.1, 1.5), rng.choice([0.0, number(rng, 0, 0.05)])
    drop = number(rng, 0.02, 0.95) if kind == "coulomb" else number(rng, 0, 0.5)
    M, W, E = mpfr(mu), mpfr(width), mpfr(eta)
    fall = 1 - M
    values = {"mu": mu, "vs": width, "eta": eta}
    if kind == "stribeck":
        values = {"alpha": mu, "beta": eta, "gamma": number(rng, 0.3, 8)}
        G = mpfr(values["gamma"])
        phi = lambda u: fall / (1 + G * u) + M + E * u * u
        rate = lambda u: fall * G / (1 + G * u) ** 2 - 2 * E * u
    elif kind == "coulomb":
        values = {"eta": eta}
        phi, rate = lambda u: 1 + E * u, lambda u: -E
    elif kind == "lorentzian":
        phi = lambda u: M + fall / (1 + (u / W) ** 2) + E * u
        rate = lambda u: 2 * fall * u / W**2 / (1 + (u / W) ** 2) ** 2 - E
    else:
        values["exponent"] = rng.choice([1.0, 2.0, 3.0, number(rng, 2, 5)])
        D = mpfr(values["exponent"])
        # Steps pass rest by rounding alone.
        share = lambda u: max(u, mpfr(0)) / W
        phi = lambda u: M + fall * gmpy2.exp(-(share(u) ** D)) + E * u
        rate = lambda u: fall * D / W * share(u) ** (D - 1) * gmpy2.exp(-(share(u) ** D)) - E
    values["drop"] = drop
    options = [word for name, value in values.items() for word in (f"--{name}", repr(value))]
    is_whole = values.get("exponent", 1.0).is_integer()
    return Case(kind, ["--law", kind, *options], belt, mpfr(drop), rate, phi, is_whole)


def case(rng):
    belt = logarithmic(rng, 0.1, 3)
    kind = rng.choice(["coulomb", "stribeck", "exponential", "lorentzian", "formula", "table"])
    if kind not in ("formula", "table"):
        return named(rng, kind, belt)
    kinetic = number(rng, 0.2, 0.95)
    static = number(rng, kinetic, 1.2)
    if kind == "formula":
        text, rate = laws.formulas(rng)
        share = mpfr(kinetic) / mpfr(static)
        body = text.replace("^", "**")
        phi = lambda u: share * eval(body, FUNCTIONS | {"u": u})
        options = ["--phi", f"{kinetic}*({text})", "--static", repr(static)]
        return Case(kind, options, belt, 1 - share, lambda u: share * rate(u), phi)
    _, data = laws.tables(rng)
    data = [(u, float(f"{kinetic * phi:.4g}")) for u, phi in data]
    static = max(static, data[0][1])
    cubics = laws.Cubics(data, static)
    return Case(kind, ["--static", repr(static)], belt, 1 - mpfr(data[0][1]) / mpfr(static), cubics, rows=data)


def ask(program, case, damping, folder):
    """The row that the program writes about the law at this damping."""
    points, out, table = folder / "points.csv", folder / "answers.csv", folder / "table.csv"
    points.write_text(f"V,c\n{case.belt!r},{damping!r}\n")
    options = case.options
    if case.rows:
        table.write_text("".join(f"{u!r},{phi!r}\n" for u, phi in case.rows))
        options = [*options, "--table", str(table)]
    command = [program, "probe", *options, "--epsilon", "1", "--points", str(points), "--out", str(out), "--overwrite"]
    told = subprocess.run(command, capture_output=True, text=True)
    if told.returncode:
        raise ArithmeticError(f"{' '.join(command)}: {told.stderr}")
    with open(out, newline="") as file:
        return next(csv.DictReader(file))


def turn(case, damping, effort, drop):
    """ln(r / V) after one turn, as laws.turn; with short steps at both ends where a power is not whole."""
    belt = mpfr(case.belt)
    if case.rows or case.is_whole:
        return laws.turn(case.law, belt, damping, effort, drop)
    start, y = gmpy2.atan2(mpfr(drop), belt), gmpy2.log1p((mpfr(drop) / belt) ** 2) / 2
    width = (2 * gmpy2.const_pi() - start) / effort.steps
    graded = [width / 2] + [width / mpfr(2) ** k for k in range(2, HALVINGS)]
    graded.append(width - sum(graded))
    f = lambda theta, y: laws.slope(case.law, belt, damping, theta, y)
    theta = start
    for h in [*reversed(graded), *[width] * (effort.steps - 2), *graded]:
        theta, y = theta + h, laws.step(f, theta, y, h, effort.stages)
    return y


def root(case, guess, effort, drop, error):
    """eps c*, by secants, to a hundredth of `error`."""
    gmpy2.get_context().precision = effort.bits
    a = mpfr(guess)
    b = a * mpfr("1.0001") + mpfr("1e-7")
    fa, fb = turn(case, a, effort, drop), turn(case, b, effort, drop)
    for _ in range(40):
        if fb == fa:
            return b
        found = b - fb * (b - a) / (fb - fa)
        # Secants gain as many digits as both ends have.
        if abs(found - a) * abs(found - b) <= error * abs(found) / 100:
            return found
        a, fa, b = b, fb, found
        fb = turn(case, b, effort, drop)
    raise ArithmeticError("no root found")


def critical(case, guess, drop, error):
    """eps c*: that of two accuracies that agree to a tenth of `error`, or the first that confirms the guess so well."""
    before = guess
    effort = QUICK
    while effort.steps <= FINEST * QUICK.steps:
        try:
            here = root(case, guess, effort, drop, error)
            if abs(here - before) <= error / 10:
                return here
            before = here
        except ArithmeticError:
            before = mpfr("inf")
        effort = replace(effort, steps=4 * effort.steps)
    raise ArithmeticError("no agreement")


def kicks(case, damping):
    """Least velocities below and above 0 at which x1 = phi(V) meets the orbit that grazes the belt line, one turn backward;
    None where there is none before the line."""
    belt, c = mpfr(case.belt), mpfr(damping)
    f = lambda theta, y: laws.slope(case.law, belt, c, theta, y)

    def place(theta, y):
        sin, cos = gmpy2.sin_cos(theta)
        r = belt * gmpy2.exp(y)
        v, w = r * cos, -r * sin
        return v, case.phi(belt - v) - case.phi(belt) - c * v - w

    steps = 6 * QUICK.steps
    width = -2 * gmpy2.const_pi() / steps
    theta, y = 2 * gmpy2.const_pi(), mpfr(0)
    found = {}
    beyond = place(theta, y)[1]
    for i in range(steps):
        after = laws.step(f, theta, y, width, 5)
        ahead, value = place(theta + width, after)
        if (value > 0) != (beyond > 0):
            lo, hi = mpfr(0), width
            for _ in range(40):
                middle = (lo + hi) / 2
                inside = (place(theta + middle, laws.step(f, theta, y, middle, 5))[1] > 0) == (beyond > 0)
                lo, hi = (middle, hi) if inside else (lo, middle)
            v = place(theta + lo, laws.step(f, theta, y, lo, 5))[0]
            if v < belt:
                side = v > 0
                if side not in found or abs(v) < abs(found[side]):
                    found[side] = v
        if i > steps // 2 and ahead >= belt:
            break
        theta, y, beyond = theta + width, after, value
    return [None if side not in found else float(found[side]) for side in (False, True)]


def judge(job):
    """What one law counts for: its kind, what is wrong, and the share of the error it states."""
    program, seed = job
    rng = random.Random(seed)
    gmpy2.get_context().precision = laws.FINE.bits
    this = case(rng)
    kind, wrong, counts = this.kind, [], Counter()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        told = ask(program, this, 0.0, folder)
        if not told["critical_c"]:
            return kind, [], Counter(without=1)
        value, error = float(told["critical_c"]), float(told["critical_c_error"])
        if value <= 0.001:
            return kind, [], Counter(small=1)
        counts["columns"] = 1
        try:
            known = critical(this, value, this.drop, max(error, 1e-14 * value))
        except ArithmeticError:
            return kind, [], counts + Counter(unknown=1)
        if not abs(value - known) <= error + 1e-16:
            wrong.append(f"c* {value!r} +- {error}, reference {float(known)!r}, off by {float(value - known):.2e}")
        counts["far_error"] = int(error > 1e-8 * value)
        distance = rng.choice([-1, 1]) * logarithmic(rng, 1e-9, 0.3)
        damping = value * (1 + (distance if rng.random() < 0.8 else rng.uniform(-1, 1)))
        told = ask(program, this, damping, folder)
        # The relative distance that the reference resolves.
        side = 0 if abs(damping - known) <= 2e-14 * known + error else 1 if damping < known else -1
        for method in ["simulation", *THEOREMS]:
            verdict = told[f"verdict_{method}"]
            counts[f"{method} {verdict}"] += 1
            leaves = told["crossings"] != "0" and method == "simulation"
            if (verdict, side) == ("present", -1) or (verdict, side) == ("absent", 1) and not leaves:
                wrong.append(f"{method} {verdict} at c = {damping!r}, c* = {float(known)!r}")
        if this.phi and rng.randrange(KICKED) == 0 and told["kick_backward"]:
            try:
                bare = root(this, max(0.5 * value, 1e-4), QUICK, 0, 1e-9) if this.drop else known
            except ArithmeticError:
                bare = known
            if bare * (1 + 1e-6) < damping < known:
                gmpy2.get_context().precision = QUICK.bits
                # The orbit may have no turn in polar form.
                try:
                    backward, forward = kicks(this, damping)
                except ArithmeticError:
                    return kind, described(this, seed, wrong), counts + Counter(unknown_kicks=1)
                counts["kicks"] += 1
                forward = this.belt if forward is None else forward
                for name, one in [("kick_backward", backward), ("kick_forward", forward)]:
                    if one is not None and told[name] and not abs(float(told[name]) - abs(one)) <= KICK:
                        wrong.append(f"{name} {told[name]} at c = {damping!r}, reference {one!r}")
    return kind, described(this, seed, wrong), counts


def described(case, seed, wrong):
    return [f"{' '.join(case.options)} V = {case.belt} seed {seed}: {text}" for text in wrong]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--points", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=48)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    jobs = [(arguments.program, arguments.seed * 10**9 + i) for i in range(arguments.points)]
    totals, wrong = {}, 0
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for kind, lines, counts in pool.map(judge, jobs, chunksize=8):
            totals.setdefault(kind, Counter()).update(counts)
            wrong += len(lines)
            for line in lines:
                print(line, flush=True)
    for kind, counts in sorted(totals.items()):
        print(f"{kind}: " + ", ".join(f"{count} {name}" for name, count in sorted(counts.items())))
    print(f"{arguments.points} laws, {wrong} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
