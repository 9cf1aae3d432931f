"""Processor time of the same map for different friction laws.

    scripts/study law_costs [--date YYYY-MM-DD] [--large]

Maps of 512 columns with 20 dampings each, seven methods, the fields `critical_c` and `regime`, one thread, no audit;
with --large also maps of 8,000 columns with 50 dampings (400,000 cells) on two threads. Each is run three times and the
least processor time counts, with the wall time of that run. `ratio` is the processor time over that of `stribeck` of the same size.
Laws that fall steeply: `machines`.
"""

import argparse
import datetime
import math
import tempfile
from pathlib import Path

from measure import done, table

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = ["law", "columns", "cells", "threads", "processor_seconds", "wall_seconds", "ratio"]
RUNS = 3


def axis(lo, hi, points):
    return f"{{ from = {lo}, to = {hi}, points = {points} }}"


def laws(n):
    """Name, lines of [friction], lines of [grid] but for V and c, and belt speeds: n^3 columns each."""
    exponential = f"epsilon = 1.0\nmu = {axis(0.3, 0.8, n)}\nvs = {axis(0.3, 2.0, n)}\neta = 0.02\n"
    formula = 'law = "expression"\nphi = "mu + (1 - mu)*exp(-u/vs) + eta*u"'
    return [
        ("stribeck", 'law = "stribeck"', f"epsilon = 0.5\nalpha = {axis(0.1, 0.8, n)}\nbeta = 0.02\ngamma = {axis(0.5, 3.0, n)}\n", n),
        ("exponential", 'law = "exponential"', exponential, n),
        ("lorentzian", 'law = "lorentzian"', exponential, n),
        ("exponential as expression", formula, exponential, n),
        ("table of 60 rows", 'law = "table"\nfile = "table.csv"', f"epsilon = {axis(0.5, 1.0, n)}\n", n * n),
    ]


def measure(program, folder, threads):
    run = [program, "run", "job.toml", "--overwrite", "--quiet", "--threads", str(threads)]
    return min((done(run, folder) for _ in range(RUNS)), key=lambda it: it.processor)


def friction(path):
    with open(path, "w") as out:
        for i in range(60):
            u = 0.15 * i
            out.write(f"{u:.4g},{0.6 + 0.4 * math.exp(-u) + 0.02 * u:.6g}\n")


def rows(program, n, dampings, threads):
    base = None
    for name, law, grid, belts in laws(n):
        with tempfile.TemporaryDirectory() as folder:
            friction(Path(folder) / "table.csv")
            job = (
                f"[friction]\n{law}\n[grid]\n{grid}V = {axis(0.1, 2.0, belts)}\nc = {axis(0.0, 1.0, dampings)}\n"
                '[audit]\ncells = 0\n[output]\npath = "map.h5"\nfields = ["critical_c", "regime"]\n'
            )
            (Path(folder) / "job.toml").write_text(job)
            least = measure(program, folder, threads)
        spent = least.processor
        base = base or spent
        yield [name, n**3, n**3 * dampings, threads, f"{spent:.3f}", f"{least.wall:.3f}", f"{spent / base:.2f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--date", default=datetime.date.today().isoformat())
    parser.add_argument("--large", action="store_true")
    args = parser.parse_args()
    sizes = [(8, 20, 1)] + ([(20, 50, 2)] if args.large else [])
    add = table(ROOT / "results" / f"law_costs-{args.date}.csv", COLUMNS)
    for size in sizes:
        for row in rows(args.program, *size):
            add(row)


if __name__ == "__main__":
    main()
