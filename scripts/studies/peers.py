"""Other integrators on the problem of this project: the grazing margin m/V of many cells, at equal accuracy.

    scripts/study peers [--cells N] [--date YYYY-MM-DD]
    scripts/study peers --cells-from CELLS.csv --out PEERS.csv    # for the chart of slipmap work-precision

With --cells-from, peers answer the cells of `slipmap work-precision` at several tolerances, against its reference, and
the result is for its chart (scripts/study work_precision makes it); the rest of this text is about the table made
without it. Every peer answers the same random cells of the box below; its tolerance is the loosest of a
ladder at which the largest error over its cells is at most `TARGET`, so that times compare at equal accuracy.
Errors are against the (v, w) flow in 100-bit Taylor arithmetic (flow.py), good to 1e-18 here. Times are processor
time of one thread, the least of a few passes; compiling, reading and writing are not counted. Slow peers take fewer
cells: each row says how many. A row is `plausible` if its largest error is at most `TARGET` (for a peer that answers
with verdicts alone: if none is wrong) and no cell went unanswered.
"""

import argparse
import csv
import datetime
import hashlib
import math
import os
import random
import re
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import numpy as np

sys.path.append(str(Path(__file__).parents[1] / "evidence"))
from flow import Accuracy, Point, follow

ROOT = Path(__file__).resolve().parents[2]
TARGET = 1e-9
LADDER = [10.0 ** (-k / 2) for k in range(10, 28)]
CHART = [1e-3, 1e-5, 1e-7, 1e-9, 1e-11, 1e-13]
LAST_ANGLE = 0.01
REFERENCE = Accuracy(bits=100, order=24, tolerance="1e-20", cap="0.4")
BOX = "eps 0.05, alpha [0,1], beta [0,0.5], gamma [0,4], c [0,1], V [0.2,1.5]"
COLUMNS = [
    "peer", "version", "form", "tolerance", "lanes", "cells", "seconds_per_cell", "rhs_per_cell",
    "median_error", "max_error", "wrong_verdicts", "no_answer", "plausible", "near_cells", "near_wrong",
    "near_no_answer", "note",
]  # fmt: skip


# The laws, as numbers of the programs of peers: alpha, eps gamma, eps beta; mu, vs, eta; drop, eta, nothing.
STRIBECK, EXPONENTIAL, COULOMB = range(3)


def draw_cells(count):
    """Cells of the law of the paper; a longer sample begins with the shorter one."""
    rng = random.Random(20260414)
    draw = lambda: [0.05, rng.random(), 0.5 * rng.random(), 4 * rng.random(), rng.random(), 0.2 + 1.3 * rng.random()]
    drawn = np.array([draw() for _ in range(count)])
    return scaled(STRIBECK, dict(zip(("epsilon", "alpha", "beta", "gamma", "c", "V"), drawn.T))), drawn


def scaled(kind, of):
    """Rows of a kind of law, its three numbers, C = eps c and V, from columns by their names."""
    epsilon = of["epsilon"]
    numbers = {
        STRIBECK: lambda: [of["alpha"], epsilon * of["gamma"], epsilon * of["beta"]],
        EXPONENTIAL: lambda: [of["mu"], of["vs"], of["eta"]],
        COULOMB: lambda: [of["drop"], of["eta"], 0 * epsilon],
    }[kind]()
    return np.column_stack([kind + 0 * epsilon, *numbers, epsilon * of["c"], of["V"]])


def read_cells(path):
    """The cells of `slipmap work-precision`, their margins, which of them lie next to the boundary, and the table's
    fingerprint."""
    text = path.read_bytes()
    rows = list(csv.DictReader(text.decode().splitlines()))
    of = {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}
    kind = STRIBECK if "alpha" in of else EXPONENTIAL if "mu" in of else COULOMB
    return scaled(kind, of), of["margin"], of["near"] == 1, hashlib.sha256(text).hexdigest()


def reference_margins(drawn):
    return np.array([float(follow(Point(*map(float, cell)), REFERENCE).margin) for cell in drawn])


def timed(passes, work):
    """The least processor time of some passes, and the last one's result."""
    best = float("inf")
    for _ in range(passes):
        start = time.process_time()
        result = work()
        best = min(best, time.process_time() - start)
    return best, result


def friction(law, numbers, u, exp=np.exp):
    """Friction in slip."""
    a, b, d = numbers
    if law == STRIBECK:
        return (1 - a) / (1 + b * u) + a + d * u * u
    return a + (1 - a) * exp(-u / b) + d * u if law == EXPONENTIAL else 1 - a + b * u


def weakening(law, numbers, u, exp=np.exp):
    """The fall of friction in slip."""
    a, b, d = numbers
    if law == STRIBECK:
        q = 1 + b * u
        return b * (1 - a) / (q * q) - 2 * d * u
    return (1 - a) / b * exp(-u / b) - d if law == EXPONENTIAL else -b + 0 * u


def start_of(cells):
    """Angle and radius of the exit points, in units of V."""
    drop = np.where(cells[:, 0] == COULOMB, cells[:, 1], 0) / cells[:, 5]
    return np.arctan(drop), np.hypot(drop, 1)


# --- peers: each is a function (cells, tolerance) -> (seconds, margins, rhs per cell or None) ---


class Heyoka:
    """heyoka's batch mode on the scalar form dr/dtheta, from the exit point to the angle 2 pi: no event location needed."""

    name, form, package = "heyoka (batch)", "scalar, Taylor", "heyoka"

    def __init__(self, lanes):
        self.lanes, self.compiled = lanes, {}

    def integrator(self, law, tolerance):
        import heyoka as hy

        if (law, tolerance) not in self.compiled:
            r = hy.make_vars("r")
            sin, cos = hy.sin(hy.time), hy.cos(hy.time)
            d = weakening(law, [hy.par[i] for i in range(3)], hy.par[4] * (1.0 - r * cos), hy.exp) - hy.par[3]
            rhs = d * r * sin * sin / (1.0 + d * sin * cos)
            start, pars = np.ones((1, self.lanes)), np.ones((5, self.lanes))
            self.compiled[law, tolerance] = hy.taylor_adaptive_batch([(r, rhs)], start, pars=pars, tol=tolerance)
        return self.compiled[law, tolerance]

    def __call__(self, cells, tolerance):
        ta, lanes = self.integrator(int(cells[0, 0]), tolerance), self.lanes
        padded = np.pad(cells, ((0, -len(cells) % lanes), (0, 0)), mode="edge")
        angle, radius = start_of(padded)
        margins = np.empty(len(padded))

        def work(end):
            for i in range(0, len(padded), lanes):
                these = slice(i, i + lanes)
                ta.set_time(angle[these])
                ta.state[:] = radius[these]
                ta.pars[:] = padded[these, 1:].T
                ta.propagate_until(end + (angle[these] if end < 1 else 0))
                margins[these] = ta.state[0]

        # A step of length zero costs one expansion and all the calls from Python: an upper bound of the
        # latter.
        self.overhead = timed(3, lambda: work(1e-9))[0] / len(cells)
        seconds, _ = timed(5, lambda: work(2 * np.pi))
        return seconds, margins[: len(cells)] - 1, None


class HeyokaFlow(Heyoka):
    """heyoka's batch mode on the flow in (x1, x2), over the time 2 pi less the angle of the exit point: the right-hand side
    has no sines. The turn ends a little earlier or later, where x2 is largest: the flow is followed for the angle that is left,
    which leaves its square about, and then by two classical Runge-Kutta steps of the scalar form, of all cells at once.
    Their error is a few 1e-14 in all three scenes (3e-8 on the brake if the last angle may be 0.1)."""

    form = "(x1,x2), Taylor, to time 2 pi and the rest of the angle"

    def integrator(self, law, tolerance):
        import heyoka as hy

        if (law, tolerance) not in self.compiled:
            x1, x2 = hy.make_vars("x1", "x2")
            numbers, viscous, belt = [hy.par[i] for i in range(3)], hy.par[3], hy.par[4]
            force = friction(law, numbers, belt - x2, hy.exp)
            flow = [(x1, x2), (x2, force - x1 - viscous * x2)]
            start, pars = np.ones((2, self.lanes)), np.ones((5, self.lanes))
            self.compiled[law, tolerance] = hy.taylor_adaptive_batch(flow, start, pars=pars, tol=tolerance)
        return self.compiled[law, tolerance]

    def __call__(self, cells, tolerance):
        law = int(cells[0, 0])
        ta, lanes = self.integrator(law, tolerance), self.lanes
        padded = np.pad(cells, ((0, -len(cells) % lanes), (0, 0)), mode="edge")
        numbers, viscous, belt = padded[:, 1:4].T, padded[:, 4], padded[:, 5]
        start, turn = np.array([1 - viscous * belt, belt]), 2 * np.pi - start_of(padded)[0]
        ends = np.empty_like(start)

        def follow(states, times):
            for i in range(0, len(padded), lanes):
                these = slice(i, i + lanes)
                ta.set_time(0.0)
                ta.state[:] = states[:, these]
                ta.pars[:] = padded[these, 1:].T
                ta.propagate_until(times[these])
                ends[:, these] = ta.state
            x1, x2 = ends
            w = (friction(law, numbers, belt - x2) - x1 - viscous * x2) / belt
            v = x2 / belt
            return np.hypot(v, w), np.arctan2(-w, v)

        def work(end):
            radius, angle = follow(start, np.minimum(end, turn))
            for _ in range(3):
                if end < 1 or np.abs(angle).max() <= LAST_ANGLE:
                    break
                radius, angle = follow(ends.copy(), -angle)
            return finish_turn(radius, angle, law, padded)

        self.overhead = timed(3, lambda: work(1e-9))[0] / len(cells)
        seconds, radius = timed(5, lambda: work(10.0))
        return seconds, radius[: len(cells)] - 1, None


def finish_turn(radius, angle, law, cells):
    """r at the angle 0 of orbits that pass (radius, angle), by two steps of the classical Runge-Kutta method."""
    numbers, viscous, belt = cells[:, 1:4].T, cells[:, 4], cells[:, 5]

    def slope(theta, r):
        sin, cos = np.sin(theta), np.cos(theta)
        d = weakening(law, numbers, belt * (1 - r * cos)) - viscous
        return d * r * sin * sin / (1 + d * sin * cos)

    step = -angle / 2
    for _ in range(2):
        k1 = slope(angle, radius)
        k2 = slope(angle + step / 2, radius + step / 2 * k1)
        k3 = slope(angle + step / 2, radius + step / 2 * k2)
        k4 = slope(angle + step, radius + step * k3)
        radius, angle = radius + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4), angle + step
    return radius


def lower_flow(cell):
    """(right-hand side, start, x2') of the lower flow in (x1, x2), analytically continued above the belt line."""
    law, (viscous, belt) = int(cell[0]), map(float, cell[4:])
    numbers = tuple(map(float, cell[1:4]))
    # Far beyond the belt line, where no orbit that counts goes, the exponential function overflows.
    exp = lambda x: math.exp(min(x, 700.0))

    def acceleration(x1, x2):
        return -x1 - viscous * x2 + friction(law, numbers, belt - x2, exp)

    rhs = lambda t, x: (x[1], acceleration(x[0], x[1]))
    return rhs, (1 - viscous * belt, belt), lambda t, x: acceleration(x[0], x[1])


class ScipyMargin:
    """solve_ivp with the event x2' = 0: rising to the minimum of x2, then falling to its maximum (in one go it would
    fire at the start, where x2' vanishes as well)."""

    name, form, package, lanes = "SciPy solve_ivp", "(x1,x2), DOP853 + events", "scipy", 1

    def __call__(self, cells, tolerance):
        from scipy.integrate import solve_ivp

        options = dict(method="DOP853", rtol=max(tolerance, 2.3e-14), atol=tolerance)
        margins, calls = np.full(len(cells), np.nan), [0]

        def extremum(rhs, span, start, event):
            solution = solve_ivp(rhs, span, start, events=event, **options)
            calls[0] += solution.nfev
            return (solution.t_events[0][-1], solution.y_events[0][-1]) if len(solution.t_events[0]) else None

        def work():
            calls[0] = 0
            for i, cell in enumerate(cells):
                rhs, start, turning = lower_flow(cell)
                up, down = (lambda t, x: turning(t, x)), (lambda t, x: turning(t, x))
                up.terminal = down.terminal = True
                up.direction, down.direction = 1, -1
                bottom = extremum(rhs, (0, 20), start, up)
                top = bottom and extremum(rhs, (bottom[0], 40), bottom[1], down)
                if top:
                    margins[i] = top[1][1] / cell[5] - 1

        seconds, _ = timed(2, work)
        return seconds, margins, calls[0] / len(cells)


class ScipyVerdict:
    """The obvious first script: solve_ivp from the exit point, present if the event x2 = V, rising, fires within
    8 time units. Its `margins` are +1 and -1: only verdicts count."""

    name, form, package, lanes = "SciPy solve_ivp, verdict only", "(x1,x2), DOP853 + event x2 = V", "scipy", 1

    def __call__(self, cells, tolerance):
        from scipy.integrate import solve_ivp

        verdicts, calls = np.full(len(cells), np.nan), [0]

        def work():
            calls[0] = 0
            for i, cell in enumerate(cells):
                rhs, start, _ = lower_flow(cell)
                reach = lambda t, x: x[1] - cell[5]
                reach.terminal, reach.direction = True, 1
                solution = solve_ivp(rhs, (0, 8), start, method="DOP853", rtol=tolerance, atol=tolerance, events=reach)
                calls[0] += solution.nfev
                verdicts[i] = 1 if len(solution.t_events[0]) else -1

        seconds, _ = timed(2, work)
        return seconds, verdicts, calls[0] / len(cells)


class Crate:
    """A Rust crate through scripts/studies/peers-rs."""

    program = None  # of the command line
    lanes = 1

    def __init__(self, package, form, name=None, program_name=None):
        self.package, self.form, self.name, self.program_name = package, form, name or package, program_name or package

    def __call__(self, cells, tolerance):
        path = ROOT / "target/peers-cells.txt"
        path.write_text("".join(" ".join(map(repr, map(float, cell))) + "\n" for cell in cells))
        command = [self.program, self.program_name, repr(tolerance), path, "5"]
        lines = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split("\n")
        answers = np.array([line.split() for line in lines[1:] if line], dtype=float)
        return float(lines[0]), answers[:, 0], answers[:, 1].mean()


def crate_version(package):
    lock = (ROOT / "scripts/studies/peers-rs/Cargo.lock").read_text()
    return re.search(rf'name = "{package}"\nversion = "([^"]+)"', lock).group(1)


# --- measuring ---


def calibrate(peer, cells, exact):
    """The largest tolerance of the ladder at which no error exceeds the target; the smallest if none does."""
    for tolerance in LADDER:
        _, margins, _ = peer(cells, tolerance)
        if np.all(np.abs(margins - exact) <= TARGET):
            return tolerance, ""
    return LADDER[-1], "misses the target at every tolerance"


def measure(peer, cells, exact, tolerance=None, note="", near=None):
    verdict_only = isinstance(peer, ScipyVerdict)
    if tolerance is None:
        tolerance, said = calibrate(peer, cells, exact)
        note = "; ".join(filter(None, (note, said)))
    seconds, margins, rhs = peer(cells, tolerance)
    answered = np.isfinite(margins)
    error = np.abs(margins - exact)[answered]
    worst = error.max() if len(error) else np.inf
    missed = int(np.sum((margins < 0) & (exact > 0)))
    invented = int(np.sum((margins > 0) & (exact < 0)))
    wrong, missing = missed + invented, int(np.sum(~answered))
    if wrong:
        note = "; ".join(filter(None, (note, f"{missed} returns missed, {invented} invented")))
    plausible = not missing and (wrong == 0 if verdict_only else worst <= TARGET)
    if isinstance(peer, Crate):
        package_version = crate_version(peer.package)
    else:
        package_version = version(peer.package)
    near = np.zeros(len(cells), bool) if near is None else near
    return {
        "peer": peer.name,
        "version": package_version,
        "form": peer.form,
        "tolerance": f"{tolerance:.1e}",
        "lanes": peer.lanes,
        "cells": len(cells),
        "seconds_per_cell": f"{seconds / len(cells):.3e}",
        "rhs_per_cell": "" if rhs is None else f"{rhs:.0f}",
        "median_error": "" if verdict_only else f"{np.median(error):.1e}",
        "max_error": "" if verdict_only else f"{worst:.1e}",
        "wrong_verdicts": wrong,
        "no_answer": missing,
        "plausible": "yes" if plausible else "NO",
        "near_cells": int(np.sum(near)),
        "near_wrong": int(np.sum(near & answered & ((margins > 0) != (exact > 0)))),
        "near_no_answer": int(np.sum(near & ~answered)),
        "note": note,
    }


def heyoka_rows(cells, exact):
    """Both forms, at the width that heyoka recommends for this machine and at wider ones: a wider batch does more work
    per call from Python."""
    import heyoka as hy

    native = hy.recommended_simd_size()
    rows = []
    for form in (HeyokaFlow, Heyoka):
        tolerance, said = calibrate(form(native), cells, exact)
        for factor in (1, 4, 16):
            peer = form(native * factor)
            row = measure(peer, cells, exact, tolerance, said)
            width = "width recommended for this machine" if factor == 1 else f"{factor} times that width"
            overhead = f"of it at most {peer.overhead:.1e} s in calls from Python"
            row["note"] = "; ".join(filter(None, (said, width, overhead)))
            rows.append(row)
    return rows


def table_rows(cells, exact):
    """Every peer at the largest tolerance that meets the target."""
    few = max(len(cells) // 16, 1)
    rows = heyoka_rows(cells, exact)
    verner = Crate("differential-equations", "(x1,x2), Verner 6(5) + event")
    rows.append(measure(verner, cells, exact))
    scalar = Crate("differential-equations", "scalar, DOP853", program_name="differential-equations-scalar")
    rows.append(measure(scalar, cells, exact))
    rows.append(measure(Crate("diffsol", "(x1,x2), TSIT45 + root"), cells, exact))
    rows.append(measure(Crate("ode_solvers", "scalar, DOPRI5"), cells, exact))
    rows.append(measure(ScipyMargin(), cells[:few], exact[:few]))
    rows.append(measure(ScipyVerdict(), cells[:few], exact[:few], 1e-9, "tolerance fixed"))
    return rows


def chart_rows(cells, exact, near):
    """Every peer over its tolerance. A tolerance at which a peer fails is left out."""
    import heyoka as hy

    few = min(len(cells), 256)
    everyone = [
        (HeyokaFlow(4 * hy.recommended_simd_size()), len(cells)),
        (Crate("differential-equations", "(x1,x2), Verner 6(5) + event"), len(cells)),
        (Crate("differential-equations", "scalar, DOP853", program_name="differential-equations-scalar"), len(cells)),
        (Crate("diffsol", "(x1,x2), TSIT45 + root"), len(cells)),
        (Crate("ode_solvers", "scalar, DOPRI5"), len(cells)),
        (ScipyMargin(), few),
        (ScipyVerdict(), few),
    ]
    for peer, count in everyone:
        for tolerance in CHART:
            try:
                yield measure(peer, cells[:count], exact[:count], tolerance, near=near[:count])
            except (subprocess.CalledProcessError, ValueError) as error:
                print(f"{peer.name} at {tolerance}: {error}", file=sys.stderr)


def show(rows):
    columns = [column for column in COLUMNS if column != "note"]
    widths = [max(len(column), *(len(str(row[column])) for row in rows)) for column in columns]
    for line in [dict(zip(columns, columns)), *rows]:
        print("  ".join(str(line[column]).ljust(width) for column, width in zip(columns, widths)).rstrip())


def machine():
    cpu = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text())
    return f"{cpu.group(1) if cpu else 'unknown processor'}, {os.cpu_count()} logical, load {os.getloadavg()[0]:.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--cells", type=int, default=4096, help="cells for the fast peers; the slow take a fraction")
    parser.add_argument("--date", default=datetime.date.today().isoformat(), help="date in the result's name")
    parser.add_argument("--cells-from", type=Path, metavar="CELLS.csv", help="cells.csv of slipmap work-precision")
    parser.add_argument("--out", type=Path, metavar="PEERS.csv", help="the result of --cells-from")
    args = parser.parse_args()
    if bool(args.cells_from) != bool(args.out):
        parser.error("--cells-from and --out go together")
    Crate.program = args.program
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})  # one core for everything, children included

    if args.cells_from:
        cells, exact, near, fingerprint = read_cells(args.cells_from)
    else:
        cells, drawn = draw_cells(args.cells)
        exact = reference_margins(drawn)
    closest = float(np.min(np.abs(exact)))
    print(f"{len(cells)} cells, {int(np.sum(exact > 0))} with a return; smallest |m/V| {closest:.1e}", file=sys.stderr)
    if args.cells_from:
        rows = list(chart_rows(cells, exact, near))
        said = f"# cells sha256 {fingerprint}\n# {len(cells)} cells of slipmap work-precision; smallest |m/V| {closest:.1e}\n"
        path = args.out
    else:
        rows = table_rows(cells, exact)
        said = f"# {BOX}, {len(cells)} random cells; target error {TARGET}; smallest |m/V| {closest:.1e}\n"
        path = ROOT / f"results/peers-{args.date}.csv"
    path.parent.mkdir(exist_ok=True)
    with open(path, "w", newline="") as out:
        out.write(said)
        out.write(f"# one thread, processor time; {machine()}\n")
        writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    show(rows)


if __name__ == "__main__":
    main()
