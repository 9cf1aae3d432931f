"""Random friction laws, crowded where kinds meet: every answer of `slipmap probe` against orbits in 80-bit arithmetic.

    scripts/study survey [--laws 3000] [--seed 2026] [--jobs 2] [--out FILE.csv]

Narrow falls with exponents and drops, outliers with a drop, corners on slow belts, tables that end within the orbits, rough tables,
waves, and the named laws. Each law is asked at two dampings, one of them at a place next to a change of behaviour. `survey.c` follows
the orbits; it shares nothing with the program. Counted as wrong are: a change of behaviour (critical damping, grazing, crossing, fold,
Hopf) outside of its bounds; a verdict of the simulation or of a theorem; a regime; a slip cycle that does not close, or is missing; a
landing; a kick; another answer by `--points`. Prints each, writes the counts by kind, and exits with 1 if there are any.
"""

import argparse
import csv
import itertools
import json
import math
import random
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import laws

ROOT = Path(__file__).resolve().parents[2]
THEOREMS = ["instability", "bendixson", "symmetric", "validated"]
ALL_VERDICTS = ["simulation", *THEOREMS]
# Relative distances of what is compared with what is told, beside the stated errors: the rounding of the law's numbers in the program,
# and the tolerance of landings and kicks, which it states as 1e-9 of the orbit.
ROUNDING, TOLERANCE = 4e-15, 2e-8
RADII = 24
# Changes of an orbit in one turn, in belt speeds, that the reference's own rounding hides.
HIDDEN = 1e-13
KINDS = ["narrow", "outlier", "corner", "data end", "rough", "wave", "named"]


@dataclass
class Case:
    kind: str
    options: list
    belt: float
    # The lines that describe the law to survey.c.
    law: list
    rows: list = field(default_factory=list)


def number(rng, low, high):
    return float(f"{rng.uniform(low, high):.5g}")


def logarithmic(rng, low, high):
    return float(f"{math.exp(rng.uniform(math.log(low), math.log(high))):.5g}")


def of_terms(belt, terms):
    return [f"sum {belt!r} {len(terms)}", *(" ".join(map(repr, term)) for term in terms)]


def exponential(rng, belt, mu, width, exponent, drop, eta):
    options = {"mu": mu, "vs": width, "eta": eta, "exponent": exponent, "drop": drop}
    words = [word for name, value in options.items() for word in (f"--{name}", repr(value))]
    terms = [(0, 1 - mu, 0.0, width, exponent), (5, mu, 0.0, 1.0, 0.0), (5, -drop, 0.0, 1.0, 0.0), (5, eta, 0.0, 1.0, 1.0)]
    return ["--law", "exponential", *words], of_terms(belt, terms)


def narrow(rng):
    belt = logarithmic(rng, 0.05, 10)
    width = belt * logarithmic(rng, 1e-5, 0.3)
    exponent = rng.choice([1.0, 2.0, 3.0, 6.0, 10.0, number(rng, 1, 6)])
    mu = number(rng, 0.3, 0.98)
    drop = rng.choice([0.0, number(rng, 0, 0.8 * mu)])
    return Case("narrow", *swap(belt, exponential(rng, belt, mu, width, exponent, drop, rng.choice([0.0, number(rng, 0, 0.05)]))))


def swap(belt, described):
    options, law = described
    return options, belt, law


def named(rng):
    belt = logarithmic(rng, 0.05, 3)
    mu, width, eta = number(rng, 0.3, 0.95), logarithmic(rng, 0.05, 1.5), rng.choice([0.0, number(rng, 0, 0.05)])
    drop = rng.choice([0.0, number(rng, 0, 0.8 * mu)])
    kind = rng.choice(["stribeck", "lorentzian", "coulomb"])
    constant = (5, mu, 0.0, 1.0, 0.0)
    fallen = (5, -drop, 0.0, 1.0, 0.0)
    if kind == "coulomb":
        drop = number(rng, 0.02, 0.9)
        return Case("named", ["--law", kind, "--drop", repr(drop), "--eta", repr(eta)], belt,
                    of_terms(belt, [(5, 1.0, 0.0, 1.0, 0.0), (5, -drop, 0.0, 1.0, 0.0), (5, eta, 0.0, 1.0, 1.0)]))
    if kind == "stribeck":
        options = ["--alpha", repr(mu), "--beta", repr(eta), "--gamma", repr(1 / width)]
        # 1 / (1 / width) is not always width.
        terms = [(6, 1 - mu, 0.0, 1 / (1 / width), 1.0), constant, (5, eta, 0.0, 1.0, 2.0), fallen]
    else:
        options = ["--mu", repr(mu), "--vs", repr(width), "--eta", repr(eta)]
        terms = [(2, 1 - mu, 0.0, width, 1.0), constant, (5, eta, 0.0, 1.0, 1.0), fallen]
    return Case("named", ["--law", kind, *options, "--drop", repr(drop)], belt, of_terms(belt, terms))


def formula(kind, belt, static, text, terms):
    """Of a formula; friction at rest is `static`."""
    options = ["--phi", text, *([] if static is None else ["--static", repr(static)])]
    scaled = terms if static is None else [(type, a / static, *rest) for type, a, *rest in terms]
    return Case(kind, options, belt, of_terms(belt, scaled))


def outlier(rng):
    belt = logarithmic(rng, 0.1, 3)
    fall, width = number(rng, 0.05, 0.4), logarithmic(rng, 0.1, 1.5)
    place, thin, height = number(rng, 0.05 * belt, 2.2 * belt), logarithmic(rng, 0.002, 0.1) * belt, number(rng, -0.08, 0.08)
    text = f"1 - {fall}*tanh(u/{width}) + {height}*exp(-((u - {place})/{thin})^2)"
    terms = [(5, 1.0, 0.0, 1.0, 0.0), (1, -fall, 0.0, width, 1.0), (0, height, place, thin, 2.0)]
    at_rest = 1 + height * math.exp(-((place / thin) ** 2))
    static = number(rng, at_rest, 1.6) + 1e-3
    return formula("outlier", belt, max(static, at_rest + 1e-3), text, terms)


def corner(rng):
    # Kinks of formulas are refused up to 2 V; orbits of slow belts, and of those with a drop, slip faster.
    belt = logarithmic(rng, 0.01, 0.3)
    fall, place, rise = number(rng, 0.05, 0.5), number(rng, 2.02 * belt, 6 * belt), number(rng, -0.25, 0.25)
    width = logarithmic(rng, 0.3, 3) * belt
    # The corner changes the slope, not the friction at rest.
    text = f"1 - {fall}*(1 - exp(-u/{width})) + {rise}*(abs(u - {place}) - {place}) + {abs(rise)}*u"
    terms = [(5, 1 - fall, 0.0, 1.0, 0.0), (0, fall, 0.0, width, 1.0), (4, rise, place, 1.0, 1.0), (5, -rise * place, 0.0, 1.0, 0.0),
             (5, abs(rise), 0.0, 1.0, 1.0)]
    return formula("corner", belt, rng.choice([None, number(rng, 1.01, 1.5)]), text, terms)


def wave(rng):
    belt = logarithmic(rng, 0.2, 3)
    fall, width, height, waves = number(rng, 0.05, 0.4), logarithmic(rng, 0.1, 2), number(rng, 0.001, 0.03), logarithmic(rng, 2, 30) / belt
    text = f"1 - {fall}*atan(u/{width}) + {height}*sin({waves}*u)"
    terms = [(5, 1.0, 0.0, 1.0, 0.0), (7, -fall, 0.0, width, 1.0), (3, height, 0.0, waves, 1.0)]
    return formula("wave", belt, rng.choice([None, number(rng, 1.01, 1.3)]), text, terms)


def table(rng, kind):
    belt = logarithmic(rng, 0.1, 2)
    end = belt * (number(rng, 2.02, 2.8) if kind == "data end" else 12)
    scatter = 0.0 if kind == "data end" else logarithmic(rng, 1e-5, 3e-3)
    fall, width, rise = number(rng, 0.05, 0.6), logarithmic(rng, 0.1, 1.5), number(rng, 0, 0.05)
    count = rng.randrange(12, 50)
    speeds = sorted({float(f"{end * (i / count) ** rng.choice([1.0, 1.5]):.4g}") for i in range(1, count + 1)})
    mu = lambda u: 1 - fall * (1 - math.exp(-u / width)) + rise * u + rng.uniform(-1, 1) * scatter
    rows = [(0.0, 1.0), *((u, float(f"{mu(u):.6g}")) for u in speeds)]
    static = rng.choice([1.0, number(rng, 1.005, 1.4)])
    cubics = laws.Cubics(rows, static)
    values = [value / laws.mpfr(static) for value in (laws.mpfr(mu) for _, mu in rows)]
    lines = [f"{u:.25g} {mu:.25g} {slope:.25g}" for u, mu, slope in zip(cubics.u, values, cubics.slope)]
    return Case(kind, ["--static", repr(static)], belt, [f"table {belt!r} {len(rows)}", *lines], rows)


def case(seed):
    rng = random.Random(seed)
    kind = KINDS[seed % len(KINDS)]
    laws.gmpy2.get_context().precision = 100
    made = table(rng, kind) if kind in ("data end", "rough") else globals()[kind](rng)
    return made, rng


class Engine:
    """survey.c about one law."""

    def __init__(self, program, case):
        self.belt = case.belt
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.process.stdin.write("\n".join(case.law) + "\n")

    def ask(self, *question):
        self.process.stdin.write(" ".join(word if isinstance(word, str) else repr(word) for word in question) + "\n")
        self.process.stdin.flush()
        return self.process.stdout.readline().split()

    def grows(self, viscous, radius):
        """Whether the orbit from a maximum of x2 comes to a larger one; None where that is not known."""
        end = self.ask("turn", viscous, radius)[0]
        if end.isalpha():
            return True if end == "belt" else None
        return float(end) > radius if abs(float(end) - radius) > HIDDEN * self.belt else None

    def end(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def ask(program, this, damping, folder, out=None):
    options = list(this.options)
    if this.rows:
        path = folder / "table.csv"
        path.write_text("".join(f"{u!r},{mu!r}\n" for u, mu in this.rows))
        options += ["--table", str(path)]
    place = ["--epsilon", "1"]
    if out:
        points = folder / "points.csv"
        points.write_text(f"V,c\n{this.belt!r},{damping!r}\n")
        command = [program, "probe", *options, *place, "--points", str(points), "--out", str(out), "--overwrite", "--quiet"]
    else:
        command = [program, "probe", *options, *place, "--V", repr(this.belt), "--c", repr(damping), "--json"]
    told = subprocess.run(command, capture_output=True, text=True)
    if told.returncode:
        raise ValueError(f"{' '.join(command)}: {told.stderr}")
    if not out:
        return json.loads(told.stdout)
    with open(out, newline="") as file:
        return next(csv.DictReader(file))


def judge_changes(engine, told, wrong, counts):
    for change in told["changes"]:
        if change["c"] is None:
            counts[f"{change['kind']} not known"] += 1
            continue
        low, high = change["at_least"], change["at_most"]
        slack = ROUNDING * (1 + abs(high))
        sides = [low - slack, high + slack]
        if sides[0] <= 0 or change["kind"] == "unresolved":
            continue
        counts[change["kind"]] += 1
        if change["kind"] == "return":
            below, above = (engine.ask("fate", c)[0] for c in sides)
            bad = below == "inward" or above in ("sticks", "crosses")
        elif change["kind"] == "grazing":
            below, above = (engine.ask("rest", c)[0] for c in sides)
            bad = below == "turns" or above == "belt"
        elif change["kind"] == "crossing":
            below, above = (engine.ask("fate", c)[0] for c in sides)
            bad = below in ("sticks", "inward") or above in ("crosses", "inward")
        else:
            continue
        if bad:
            wrong.append(f"{change['kind']} in {low!r} to {high!r}: {below} below and {above} above")


def judge_cycles(engine, told, damping, belt, wrong, counts):
    """Slip cycles close where they are told, and none is missing that a scan of the amplitudes shows."""
    cycles = told["cycles"]["slip"]
    if cycles is None:
        counts["slip cycles not known"] += 1
        return
    ends = [0.0]
    for cycle in cycles:
        radius, counts["slip cycles"] = cycle["x2"]["to"], counts["slip cycles"] + 1
        # The slope of the return map magnifies the error of a cycle that repels, and of one that hardly attracts.
        apart = TOLERANCE * radius + 1e-9 * belt * min(1 / max(abs(1 - float(cycle["multiplier"])), 1e-5), 1e5)
        ends += [radius, radius]
        if apart > 0.1 * radius:
            continue
        inner, outer = engine.grows(damping, radius - apart), engine.grows(damping, radius + apart)
        if inner is not None and outer is not None and (inner, outer) != (cycle["stable"], not cycle["stable"]):
            wrong.append(f"slip cycle {radius!r} at c = {damping!r} does not close: grows inside {inner}, outside {outer}")
    ends.append(belt)
    # Between two cycles all orbits grow, or all shrink.
    grid = [belt * (i + 0.5) / RADII for i in range(RADII)] + [belt * 10 ** (-k / 2) for k in range(3, 10)]
    for low, high in zip(ends[::2], ends[1::2]):
        inside = [r for r in grid if low + 1e-6 * belt < r < high - 1e-6 * belt]
        grows = {engine.grows(damping, r) for r in inside} - {None}
        if len(grows) > 1:
            wrong.append(f"a slip cycle between {low!r} and {high!r} is missing at c = {damping!r}")


def judge(engine, this, told, damping, wrong, counts):
    belt = this.belt
    judge_changes(engine, told, wrong, counts)
    fate, *landing = engine.ask("fate", damping)
    sides = {engine.ask("fate", damping * (1 + sign * ROUNDING))[0] for sign in (-1, 1)} | {fate}
    is_clear = len(sides) == 1 and fate in ("sticks", "inward", "crosses")
    counts[f"fate {fate}"] += 1
    for method in ALL_VERDICTS:
        verdict = told["methods"][method]["verdict"]
        counts[f"{method} {verdict}"] += 1
        if is_clear and (verdict, fate == "sticks") in (("present", False), ("absent", True)):
            wrong.append(f"{method} {verdict} at c = {damping!r}: {fate}")
    if is_clear and fate == "sticks" and told["landing"]:
        for name, value in zip(("x1", "slip_time"), map(float, landing)):
            # Next to grazing the landing moves as the root of the distance.
            if abs(told["landing"][name] - value) > TOLERANCE * (1 + abs(value)) and told["flow"]["arcs"]["margin_error"] < 1e-9:
                counts["landings off"] += 1
                near = [engine.ask("fate", damping * (1 + sign * 1e-12)) for sign in (-1, 1)]
                spread = [abs(float(one[1 + (name != "x1")]) - value) for one in near if one[0] == "sticks"]
                if len(spread) == 2 and abs(told["landing"][name] - value) > TOLERANCE + 100 * max(spread):
                    wrong.append(f"{name} {told['landing'][name]!r} at c = {damping!r}, reference {value!r}")
    judge_cycles(engine, told, damping, belt, wrong, counts)
    regime = told["regime"]
    counts["regime known" if regime not in ("failed", "neutral") else f"regime {regime}"] += 1
    if is_clear and regime not in ("failed", "neutral"):
        sticks = "stick_slip" in regime or regime == "bistable"
        if sticks != (fate == "sticks"):
            wrong.append(f"regime {regime} at c = {damping!r}: {fate}")
        small = engine.grows(damping, 1e-4 * min(belt, 1.0))
        if this.kind in ("named", "narrow") and small is not None and small == ("equilibrium" in regime or regime == "bistable"):
            counts["small orbits against the equilibrium"] += 1
        # Loops from beyond the exit point that lead outward tend to a crossing cycle, or grow for ever.
        outward = any(
            end[0] == "crosses" and float(end[1]) > y * (1 + 1e-9)
            for y in (0.0, *(10.0 ** (k / 2) for k in range(-6, 5)))
            for end in [engine.ask("loop", damping, y)]
        )
        if outward and "crossing" not in regime and not this.rows:
            wrong.append(f"regime {regime} at c = {damping!r}: a loop leads outward")


def both(job):
    program, engine_program, seed = job
    this, rng = case(seed)
    wrong, counts = [], Counter(laws=1)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        try:
            first = ask(program, this, number(rng, 0, 0.6), folder)
        except ValueError as refused:
            return this.kind, [], Counter(refused=1, **{str(refused)[-80:]: 0})
        places = [change["c"] for change in first["changes"] if change["c"] and change["c"] > 0]
        damping = number(rng, 0, 1)
        if places:
            near = rng.choice([-1, 1]) * logarithmic(rng, 1e-9, 0.3)
            damping = rng.choice(places) * (1 + (near if rng.random() < 0.7 else rng.uniform(-1, 0.5)))
        second = ask(program, this, damping, folder)
        engine = Engine(engine_program, this)
        judge(engine, this, first, first["point"]["c"], wrong, counts)
        judge(engine, this, second, damping, wrong, counts)
        engine.end()
        if seed % 5 == 0:
            row = ask(program, this, damping, folder, folder / "out.csv")
            counts["by --points"] += 1
            if row["verdict_simulation"] != second["methods"]["simulation"]["verdict"] and second["flow"]["arcs"]["verdict"] == second["flow"]["direct"]["verdict"]:
                wrong.append(f"--points {row['verdict_simulation']} at c = {damping!r}")
    place = f"{' '.join(this.options)} --V {this.belt} seed {seed}"
    return this.kind, [f"{place}: {text}" for text in wrong], counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--laws", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=2026)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    arguments = parser.parse_args()
    engine = ROOT / "target" / "survey"
    subprocess.run(["cc", "-O2", "-o", engine, Path(__file__).with_name("survey.c"), "-lm"], check=True)
    jobs = [(arguments.program, engine, arguments.seed * 10**6 + i) for i in range(arguments.laws)]
    totals, wrong = {}, 0
    with ProcessPoolExecutor(arguments.jobs) as pool:
        for kind, lines, counts in pool.map(both, jobs, chunksize=4):
            totals.setdefault(kind, Counter()).update(counts)
            totals[kind]["wrong"] += len(lines)
            wrong += len(lines)
            for line in lines:
                print(line, flush=True)
    rows = [(kind, name, count) for kind, counts in sorted(totals.items()) for name, count in sorted(counts.items())]
    for kind, name, count in rows:
        print(f"{kind},{name},{count}")
    if arguments.out:
        with arguments.out.open("w", newline="") as file:
            csv.writer(file).writerows([("kind", "what", "count"), *rows])
    print(f"{arguments.laws} laws, {wrong} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
