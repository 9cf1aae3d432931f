#!/usr/bin/env python3
"""Reference data for the tests, to 25 significant digits, by arithmetic that shares nothing with the crate.

    python3 scripts/evidence/reference.py             writes tests/data/critical_damping.csv, margins.csv, law_dampings.csv,
                                             drop_dampings.csv and steep_dampings.csv
    python3 scripts/evidence/reference.py --quick     recomputes a random handful of their rows; exit code 1 if one differs
    python3 scripts/evidence/reference.py --theory    measures the orders in eps of the closed-form tests, and looks for
                                             counterexamples to the theory's statements at every row

Needs scripts/requirements.txt. The points come from a fixed seed and the arithmetic is correctly rounded, so the
files are the same on every machine. Every number is computed twice: the critical damping by the scalar form at two
accuracies and, as a third witness, by the (v, w) flow at the root; margins and events by the (v, w) flow at two
accuracies, the margins by the scalar form as well. The largest disagreement goes into the files' headers.
"""

import argparse
import csv
import math
import random
import sys
import time
from dataclasses import replace
from pathlib import Path

import gmpy2
from gmpy2 import mpfr

import laws
import steep
from flow import (
    CHECK,
    FINE,
    Accuracy,
    Point,
    Unresolved,
    critical_damping,
    follow,
    grazing_damping,
    polar_log_radius,
)

DATA = Path(__file__).resolve().parents[2] / "tests" / "data"
SEED = 20260413
LAW_COLUMNS = ["kind", "law", "V", "critical"]
FORMULAS, TABLES = 200, 100
DROP_COLUMNS = ["kind", "law", "static", "V", "critical"]
DROPS = 50, 100, 50
CRITICAL_POINTS, SMALL_CRITICAL_POINTS = 250, 20
# Number of rows of margins.csv from each stratum. Most points of the whole box spiral inward; the other
# strata sample weak damping, belts fast enough for orbits to cross the belt line, and the grazing boundary.
MARGIN_POINTS = {"box": 110, "weak": 120, "fast": 110, "near": 60}
# (power that concentrates beta and c near 0, largest alpha, largest beta, largest c, range of V)
STRATA = {"box": (1, 1, 1, 3, (0.1, 10)), "weak": (3, 1, 1, 3, (0.1, 10)), "fast": (2, 0.3, 0.003, 0.2, (5, 20))}
CRITICAL_COLUMNS = ["epsilon", "alpha", "beta", "gamma", "V", "critical_c"]
NUMBERS = ["margin", "landing_speed", "slip_time", "stick_time", "landing_x1"]
MARGIN_COLUMNS = ["epsilon", "alpha", "beta", "gamma", "c", "V", "margin", "landing_speed", "fate", *NUMBERS[2:]]
# The files have 25 digits; two runs must agree to well below the last of them that a reader may rely on.
REQUIRED = 1e-23
# Enough for signs and for choosing points.
SKETCH = Accuracy(bits=100, order=24, tolerance="1e-20", cap="0.4")


def short(x):
    """Six significant digits, so that the tables stay readable; the f64 nearest to them is the point."""
    return float(f"{x:.6g}")


def digits(x):
    """25 significant digits; empty for no value."""
    return "" if x is None else f"{x:.24e}"


def log_uniform(rng, lo, hi):
    return math.exp(rng.uniform(math.log(lo), math.log(hi)))


def harmonic_balance(p):
    """The energy balance in closed form (theory, "The tests")."""
    gmpy2.get_context().precision = FINE.bits
    eps, gamma, belt = mpfr(p.epsilon), mpfr(p.gamma), mpfr(p.belt)
    k = eps * gamma * belt
    q = gmpy2.sqrt(1 + 2 * k)
    return 2 * gamma * (1 - mpfr(p.alpha)) / (q * (1 + k + q)) - 2 * mpfr(p.beta) * belt


def instability(p):
    """The damping at which the divergence at the equilibrium vanishes."""
    gmpy2.get_context().precision = FINE.bits
    k = mpfr(p.epsilon) * mpfr(p.gamma) * mpfr(p.belt)
    return mpfr(p.gamma) * (1 - mpfr(p.alpha)) / (1 + k) ** 2 - 2 * mpfr(p.beta) * mpfr(p.belt)


def symmetric_absence(p):
    """The damping above which the test `symmetric` excludes a cycle."""
    gmpy2.get_context().precision = FINE.bits
    k = mpfr(p.epsilon) * mpfr(p.gamma) * mpfr(p.belt)
    weakening = mpfr(p.gamma) * (1 - mpfr(p.alpha)) / 2
    return weakening * (1 + 1 / (1 + 2 * k) ** 2) - 2 * mpfr(p.beta) * mpfr(p.belt)


# --- critical damping ---


def draw_critical(rng):
    return Point(
        epsilon=short(log_uniform(rng, 3e-4, 0.4)),
        alpha=short(rng.uniform(0, 0.95)),
        beta=short(rng.uniform(0, 0.6)),
        gamma=short(rng.uniform(0.2, 5)),
        c=0.0,
        belt=short(rng.uniform(0.1, 2)),
    )


def critical_row(point):
    """c* and the largest relative disagreement of the three ways to it."""
    fine = critical_damping(point, FINE, harmonic_balance(point))
    check = critical_damping(point, CHECK, fine * (1 + mpfr("1e-6")))
    margin = follow(replace(point, c=fine), CHECK).margin
    # dm/dc is -pi eps V to leading order, so m/(pi eps V) is the error of c* by the (v, w) flow.
    by_flow = margin / (gmpy2.const_pi() * mpfr(point.epsilon))
    return fine, float(max(abs(check - fine), abs(by_flow)) / fine)


def critical_table():
    rng = random.Random(SEED)
    rows, worst, tally = [], 0.0, {"c* <= 0": 0, "c* in (0, 0.01]": 0, "small": 0, "small, out of range": 0}
    while len(rows) < CRITICAL_POINTS:
        point = draw_critical(rng)
        if follow(point, SKETCH).fate == "inward":
            tally["c* <= 0"] += 1
            continue
        critical, error = critical_row(point)
        if critical <= 0.01:
            tally["c* in (0, 0.01]"] += 1
            continue
        rows.append((point, critical))
        worst = max(worst, error)
    while tally["small"] < SMALL_CRITICAL_POINTS:
        point = draw_critical(rng)
        # Small roots are rare: choose the strengthening that brings the root near a small target.
        target = log_uniform(rng, 1e-4, 1e-2)
        beta = short(point.beta + (float(harmonic_balance(point)) - target) / (2 * point.belt))
        point = replace(point, beta=beta)
        if not 0 <= beta <= 0.6 or follow(point, SKETCH).fate == "inward":
            tally["small, out of range"] += 1
            continue
        critical, error = critical_row(point)
        if not 1e-4 < critical < 1e-2:
            tally["small, out of range"] += 1
            continue
        tally["small"] += 1
        rows.append((point, critical))
        worst = max(worst, error)
    header = [
        "Critical damping c*: the damping at which the grazing margin of the orbit from the exit point vanishes.",
        f"Made by scripts/evidence/reference.py, seed {SEED}; each parameter is the f64 nearest to its decimals.",
        "Box: epsilon in [3e-4, 0.4] (log), alpha in [0, 0.95], beta in [0, 0.6], gamma in [0.2, 5], V in [0.1, 2].",
        f"{CRITICAL_POINTS} points with c* > 0.01, then {SMALL_CRITICAL_POINTS} with 1e-4 < c* < 0.01 (beta chosen to bring them there).",
        f"Dropped: {tally['c* <= 0']} without c* > 0, {tally['c* in (0, 0.01]']} with c* in (0, 0.01], "
        f"{tally['small, out of range']} candidates for a small c* outside the box or the range.",
        f"Largest relative disagreement of two accuracies and two formulations: {worst:.1e}.",
    ]
    return header, [[*coordinates(p, with_c=False), digits(c)] for p, c in rows], worst


def coordinates(p, with_c=True):
    return [repr(x) for x in (p.epsilon, p.alpha, p.beta, p.gamma, *((p.c,) if with_c else ()), p.belt)]


# --- margins and fates ---


def draw_margin(rng, stratum):
    """A point of the stratum; one in ten takes each of the degenerate limits."""
    power, alpha, beta, c, belt = STRATA[stratum]
    limit = lambda value, *ends: rng.choice(ends) if rng.random() < 0.1 else value
    while True:
        p = Point(
            epsilon=short(log_uniform(rng, 1e-3, 1)),
            alpha=limit(short(rng.uniform(0, alpha)), 0.0, 1.0),
            beta=limit(short(beta * rng.random() ** power), 0.0),
            gamma=limit(short(rng.uniform(0, 10)), 0.0),
            c=limit(short(c * rng.random() ** power), 0.0),
            belt=short(log_uniform(rng, *belt)),
        )
        if p.gamma * (1 - p.alpha) > 0 or p.beta > 0 or p.c > 0:
            return p  # else D = 0: every orbit is closed and the exit orbit grazes exactly


def draw_near_critical(rng):
    """A point whose damping is within 1e-6 to 1e-1, relative, of the critical one."""
    while True:
        p = replace(draw_critical(rng), beta=short(rng.uniform(0, 0.3)))
        distance = rng.choice((-1, 1)) * 10.0 ** rng.uniform(-6, -1)
        if follow(p, SKETCH).fate != "inward":
            critical = float(critical_damping(p, SKETCH, harmonic_balance(p)))
            if 0.01 < critical < 2.5:
                return replace(p, c=critical * (1 + distance))


def margin_row(point):
    """The orbit's record, and the largest relative disagreement of its ways."""
    fine, check = follow(point, FINE), follow(point, CHECK)
    if fine.fate != check.fate or fine.loops != check.loops:
        raise Unresolved(f"two accuracies tell two fates of {point}: {fine.fate}, {check.fate}")
    worst = 0.0
    for a, b in zip(fine.numbers(), check.numbers()):
        if (a is None) != (b is None):
            raise Unresolved(f"two accuracies disagree on what exists at {point}")
        if a is not None:
            worst = max(worst, float(abs((a - b) / a)))
    if fine.margin is not None:
        polar = gmpy2.expm1(polar_log_radius(point, FINE))
        worst = max(worst, float(abs((polar - fine.margin) / fine.margin)))
    return fine, worst


def margin_table():
    rng = random.Random(SEED + 1)
    points = [draw_margin(rng, stratum) for stratum in STRATA for _ in range(MARGIN_POINTS[stratum])]
    points += [draw_near_critical(rng) for _ in range(MARGIN_POINTS["near"])]
    rows, worst, fates, loops = [], 0.0, {}, 0
    for p in points:
        orbit, error = margin_row(p)
        worst = max(worst, error)
        fates[orbit.fate] = fates.get(orbit.fate, 0) + 1
        loops = max(loops, orbit.loops)
        rows.append([*coordinates(p), *map(digits, orbit.numbers()[:2]), orbit.fate, *map(digits, orbit.numbers()[2:])])
    blank = sum(row[6] == "" for row in rows)
    header = [
        "The orbit from the exit point: scaled grazing margin m/V, speed w = x2' at the first return to the belt line",
        "from below, fate, time of slip from the exit point to the landing, time of stick after it, x1 at landing.",
        "margin is blank where |D| >= 2 somewhere along the first turn of the continued lower flow, or where that flow",
        "is singular; the others are blank where the orbit has no such event.",
        "fate: sticks (0 < w < 2), sticks_from_above (it crosses once and sticks at its return), crosses_forever (it",
        f"does not, nor in {loops} further loops), inward (it never comes back to the belt line).",
        f"Made by scripts/evidence/reference.py, seed {SEED}; each parameter is the f64 nearest to its decimals.",
        f"{MARGIN_POINTS['box']} points of epsilon in [1e-3, 1] (log), alpha in [0, 1], beta in [0, 1], gamma in [0, 10], c in [0, 3],",
        f"V in [0.1, 10] (log); {MARGIN_POINTS['weak']} of the same box with beta and c gathered near 0; {MARGIN_POINTS['fast']} with alpha in [0, 0.3],",
        "beta in [0, 0.003], c in [0, 0.2], V in [5, 20]; in all of these one in ten at each of the limits alpha = 0 or 1,",
        f"beta = 0, gamma = 0, c = 0; {MARGIN_POINTS['near']} of the box of critical_damping.csv with c within 1e-6 to 0.1, relative, of critical.",
        "Fates: " + ", ".join(f"{count} {fate}" for fate, count in sorted(fates.items())) + f"; {blank} blank margins.",
        f"Largest relative disagreement of two accuracies and, for the margins, two formulations: {worst:.1e}.",
    ]
    return header, rows, worst


# --- critical dampings of other laws ---


def law_table(formulas=FORMULAS, tables=TABLES):
    rows, worst = laws.rows(random.Random(SEED + 2), formulas, tables)
    header = [
        "eps c* of random friction laws: formulas in the slip speed u, and tables as slip speed:friction pairs.",
        f"Made by scripts/evidence/reference.py, seed {SEED + 2}; {len(rows)} laws and belt speeds V in [0.1, 3] (log) with eps c* > 0.001",
        "and no node on the way; eps = 1. Each number is the f64 nearest to its decimals.",
        f"Largest relative disagreement of two accuracies: {worst:.1e}.",
    ]
    return header, rows, worst


def drop_table(counts=DROPS):
    rows, worst = laws.drop_rows(random.Random(SEED + 3), *counts)
    header = [
        "eps c* of random friction laws that drop as slip begins: friction at rest is `static`. Two coefficients as drop and",
        "eta, the slope of friction in slip; formulas in the slip speed u; tables as slip speed:friction pairs.",
        f"Made by scripts/evidence/reference.py, seed {SEED + 3}; {len(rows)} laws and belt speeds V in [0.1, 3] (log) with eps c* > 0.001",
        "and no node on the way; eps = 1. Each number is the f64 nearest to its decimals.",
        f"Largest relative disagreement of two accuracies and, for two coefficients, of the closed form: {worst:.1e}.",
    ]
    return header, rows, worst


# --- files ---


def write(name, columns, table, required=REQUIRED):
    start = time.process_time()
    header, rows, worst = table()
    if not worst < required:
        sys.exit(f"{name}: two computations disagree by {worst:.1e}")
    DATA.mkdir(parents=True, exist_ok=True)
    with open(DATA / name, "w", newline="") as out:
        out.writelines(f"# {line}\n" for line in header)
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
    print("\n".join(header))
    print(f"{name}: {len(rows)} rows in {time.process_time() - start:.0f} s\n")


def read(name):
    with open(DATA / name, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def point_of(row):
    number = lambda key: float(row.get(key, 0))
    return Point(number("epsilon"), number("alpha"), number("beta"), number("gamma"), number("c"), number("V"))


def same(committed, value):
    """Returns whether a committed number equals the recomputed one, to a unit of its last digit."""
    if committed == "" or value is None:
        return committed == "" and value is None
    return bool(abs(mpfr(committed) - value) <= abs(value) * mpfr("1.01e-24"))


def quick(seed, count=2):
    """Recomputes `count` rows of each file at another accuracy; returns the number of rows that differ."""
    rng = random.Random(seed)
    wrong = 0
    for row in rng.sample(read("critical_damping.csv"), count):
        critical = critical_damping(point_of(row), CHECK, harmonic_balance(point_of(row)))
        if not same(row["critical_c"], critical):
            wrong += 1
            print(f"critical_damping.csv {row}: recomputed {digits(critical)}")
    for row in rng.sample(read("margins.csv"), count):
        orbit = follow(point_of(row), CHECK)
        numbers = [same(row[key], value) for key, value in zip(NUMBERS, orbit.numbers())]
        if row["fate"] != orbit.fate or not all(numbers):
            wrong += 1
            print(f"margins.csv {row}: recomputed {orbit}")
    # Rows written by scripts/evidence/columns.c.
    rough, sharp = Accuracy(80, 18, "1e-15", "0.5"), Accuracy(110, 26, "1e-24", "0.4")
    for row in rng.sample(read("columns.csv"), count):
        critical = grazing_damping(point_of(row), rough, sharp)
        if not abs(mpfr(row["critical_c"]) - critical) <= abs(critical) * mpfr("1.01e-17"):
            wrong += 1
            print(f"columns.csv {row}: recomputed {digits(critical)}")
    for row in rng.sample(read("steep_dampings.csv"), count):
        if not steep.same(row):
            wrong += 1
            print(f"steep_dampings.csv {row}: another critical damping is recomputed")
    # The laws come in a sequence from one seed.
    first = [tuple(row.values()) for row in read("law_dampings.csv")][:3]
    if law_table(3, 0)[1] != first:
        wrong += 1
        print("law_dampings.csv: the first rows are not those computed anew")
    if drop_table((3, 0, 0))[1] != [tuple(row.values()) for row in read("drop_dampings.csv")][:3]:
        wrong += 1
        print("drop_dampings.csv: the first rows are not those computed anew")
    print(f"reference rows recomputed with seed {seed}: {4 * count - wrong} agree, {wrong} differ")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="recompute a random handful of the committed rows")
    parser.add_argument("--theory", action="store_true", help="measure the orders in eps, look for counterexamples")
    parser.add_argument("--seed", type=int, help="which handful --quick takes; default: the clock")
    args = parser.parse_args()
    if args.quick:
        sys.exit(1 if quick(time.time_ns() % 1_000_000 if args.seed is None else args.seed) else 0)
    if args.theory:
        import theory_check

        sys.exit(theory_check.main())
    write("critical_damping.csv", CRITICAL_COLUMNS, critical_table)
    write("margins.csv", MARGIN_COLUMNS, margin_table)
    # 18 digits are stored; the tests need 11.
    write("law_dampings.csv", LAW_COLUMNS, law_table, required=1e-15)
    write("drop_dampings.csv", DROP_COLUMNS, drop_table, required=1e-15)
    write("steep_dampings.csv", steep.COLUMNS, steep.table, required=steep.REQUIRED)


if __name__ == "__main__":
    main()
