"""Measurements on the theory's statements, in reference arithmetic: `python3 scripts/evidence/reference.py --theory`.

Prints the leading constants in eps of the closed-form tests, and tries every statement that a row of the tables can
contradict. Exit code 1 if one is contradicted.
"""

import random
from dataclasses import replace

import gmpy2
from gmpy2 import mpfr

from flow import CHECK, FINE, Point, Unresolved, critical_damping, follow, polar_log_radius
from reference import (
    SKETCH,
    draw_critical,
    harmonic_balance,
    instability,
    log_uniform,
    point_of,
    read,
    short,
    symmetric_absence,
)

failures = 0


def check(holds, statement, where):
    global failures
    if not holds:
        failures += 1
        print(f"COUNTEREXAMPLE to '{statement}' at {where}")


def constants(alpha, beta, gamma, belt):
    """Ratios of the closed forms' errors to their leading terms, along halvings of eps."""
    print(f"\nalpha {alpha} beta {beta} gamma {gamma} V {belt}; each column tends to 1")
    print("     eps   perturbation  instability  harmonic_balance  wL         slip time")
    for halving in range(6):
        p = Point(0.02 / 2**halving, alpha, beta, gamma, 0.0, belt)
        critical = critical_damping(p, FINE, harmonic_balance(p))
        eps, weak, strong, v = mpfr(p.epsilon), mpfr(gamma) * (1 - mpfr(alpha)), mpfr(beta), mpfr(belt)
        first = weak - 2 * strong * v
        ratios = [
            (critical - first) / (-2 * eps * mpfr(gamma) * weak * v),
            (critical - instability(p)) / (mpfr(3) / 4 * eps**2 * mpfr(gamma) ** 2 * weak * v**2),
            # To third order in the size of D about its odd part d1 x: eps (c* - c_HB) = -(13/576) d1^2 d2,
            # with the Taylor coefficients of D(1 - x) at belt speed, d1 = 2 (A k + b) and d2 = 3 A k^2 for
            # small k.
            (critical - harmonic_balance(p))
            / (-mpfr(13) / 48 * eps**4 * mpfr(gamma) ** 2 * weak * v**4 * (strong + eps * mpfr(gamma) * weak) ** 2),
        ]
        kappa = first / 2
        at_half = follow(replace(p, c=kappa), CHECK)
        growth = gmpy2.sqrt(2 * gmpy2.const_pi() * kappa * eps)
        ratios += [at_half.landing_speed / (v * growth), (2 * gmpy2.const_pi() - at_half.slip_time) / growth]
        print(f"{p.epsilon:8.2e}  " + "  ".join(f"{float(r):11.7f}" for r in ratios))


def orderings(p, critical, where):
    check(instability(p) <= critical, "c_instability <= c*", where)
    check(critical <= harmonic_balance(p), "c* <= c_harmonic_balance", where)
    check(critical <= symmetric_absence(p), "c* <= edge of symmetric", where)


def table_rows():
    for row in read("critical_damping.csv"):
        p = point_of(row)
        gmpy2.get_context().precision = FINE.bits
        orderings(p, mpfr(row["critical_c"]), row)
    fates = {}
    for row in read("margins.csv"):
        p = point_of(row)
        returns = row["fate"] != "inward"
        fates[row["fate"]] = fates.get(row["fate"], 0) + 1
        if row["margin"]:
            check(returns == (float(row["margin"]) > 0), "m >= 0 iff the orbit comes back", row)
        check(not (p.c < instability(p) and not returns), "instability certifies the return", row)
        check(not (p.c > symmetric_absence(p) and returns), "symmetric excludes the return", row)
        check(not (p.c > harmonic_balance(p) and returns), "harmonic_balance excludes the return", row)
        if row["landing_speed"]:
            speed = float(row["landing_speed"])
            check((speed < 2) == (row["fate"] == "sticks"), "sticks iff 0 < w < 2", row)
        check(row["fate"] != "sticks_later", "an orbit that crosses twice never sticks", row)
    print("rows of margins.csv:", fates)


def identities(rng, count=25):
    """The scaling, the scalar form and the monotonicity, at random points."""
    worst, compared = 0.0, 0
    for _ in range(count):
        p = replace(draw_critical(rng), c=short(rng.uniform(0, 2)))
        try:
            y = polar_log_radius(p, CHECK)
            grown = polar_log_radius(replace(p, c=p.c + 0.125), CHECK)
            stiffer = polar_log_radius(replace(p, beta=p.beta + 0.125), CHECK)
            weaker = polar_log_radius(replace(p, alpha=p.alpha / 2), CHECK)
        except Unresolved:
            continue
        # The scaled points are exact only in the working precision, so the (v, w) flow has other inputs.
        three = mpfr(3)
        scaled = Point(three * p.epsilon, p.alpha, p.beta / three, p.gamma / three, p.c / three, p.belt)
        # A third of the belt speed at three times gamma and beta keeps k, b and C; A needs a third of 1 -
        # alpha.
        slower = Point(p.epsilon, 1 - (1 - mpfr(p.alpha)) / 3, p.beta * three, p.gamma * three, p.c, p.belt / three)
        for other in (scaled, slower):
            margin = follow(other, CHECK).margin
            if margin is not None:
                worst = max(worst, float(abs(gmpy2.log1p(margin) - y)))
                compared += 1
        check(grown < y, "m decreases in c", p)
        check(stiffer < y, "m decreases in beta", p)
        check(p.alpha == 0 or weaker > y, "m increases with 1 - alpha", p)
    print(f"scaling: largest change of ln(r/V) {worst:.1e} in {compared} pairs")


def search(rng, count=400):
    """Orderings at random points far beyond the tables' box."""
    tried, closest = 0, (mpfr("inf"), None)
    while tried < count:
        p = Point(
            short(log_uniform(rng, 1e-3, 1)),
            short(rng.random()),
            short(rng.random() ** 2),
            short(log_uniform(rng, 0.1, 30)),
            0.0,
            short(log_uniform(rng, 0.05, 20)),
        )
        if harmonic_balance(p) <= 0:
            continue
        try:
            critical = critical_damping(p, SKETCH, harmonic_balance(p))
        except Unresolved:
            continue
        tried += 1
        gap = harmonic_balance(p) - critical
        # Differences below the estimate's own error are meaningless.
        if abs(gap) > mpfr("1e-16") / mpfr(p.epsilon):
            orderings(p, critical, p)
            closest = min(closest, (gap / harmonic_balance(p), p), key=lambda pair: pair[0])
    print(f"wide search: {tried} points; smallest (c_HB - c*)/c_HB {float(closest[0]):.2e} at {closest[1]}")


def main():
    for place in ((0.2, 0.3, 2.0, 0.7), (0.5, 0.1, 1.0, 1.0), (0.2, 0.0, 2.0, 0.7)):
        constants(*place)
    table_rows()
    identities(random.Random(1))
    search(random.Random(2))
    print(f"{failures} counterexamples")
    return 1 if failures else 0
