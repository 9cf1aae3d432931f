"""Maps of friction laws with a narrow feature, every cell against its own column.

    scripts/outliers.py [--maps 500] [--program target/debug/slipmap]

Tables with one outlier, and formulas with one narrow dip, bump, step or wave; their axis is the belt speed or the
place of the feature. Each map is computed twice: as users
do, with answers that are interpolated between columns, and with the engine `critical_surface`, which decides
every column by itself. Prints the number of maps and cells that differ, and exits with 1 if any does.
"""

import argparse
import math
import pathlib
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

import h5py

COLUMNS = 64


def mean(phi, speed):
    """The weakening rate averaged over the grazing circle: 2 / (pi V) times the integral of phi cos t."""
    n = 400
    angles = (math.pi * (i + 0.5) / n for i in range(n))
    return 2 / (speed * n) * sum(phi(speed * (1 - math.cos(t))) * math.cos(t) for t in angles)


def table(rng):
    """A smooth law at a few slip speeds, with an outlier between two rows close to it; the place of the outlier."""
    level, scale, at = rng.uniform(0.3, 0.8), rng.uniform(0.2, 1.0), rng.uniform(0.6, 3.0)
    width, height = at * 10 ** rng.uniform(-3, -1), rng.choice([-1, 1]) * 10 ** rng.uniform(-3, -1.3)
    phi = lambda u: level + (1 - level) * math.exp(-u / scale)
    rows = {0.0: 1.0}
    u = 0.0
    while u < 12:
        u += rng.uniform(0.2, 0.6)
        if abs(u - at) > 1.5 * width:
            rows[u] = phi(u)
    rows |= {at - width: phi(at - width), at: phi(at) + height, at + width: phi(at + width)}
    rows = sorted(rows.items())

    def through(u):
        i = max(i for i, row in enumerate(rows[:-1]) if row[0] <= u)
        (a, before), (b, after) = rows[i : i + 2]
        return before + (after - before) * (u - a) / (b - a)

    return rows, through, at


def formula(rng):
    """A smooth law with a feature of a width around a slip speed p."""
    level, scale, at = rng.uniform(0.3, 0.8), rng.uniform(0.2, 1.0), rng.uniform(0.6, 3.0)
    width, height = at * 10 ** rng.uniform(-3, -1), rng.choice([-1, 1]) * 10 ** rng.uniform(-3, -1.3)
    text, shape = rng.choice(
        [
            ("exp(-X^2)", lambda x: math.exp(-min(x * x, 700.0))),
            ("1/(1 + X^2)^2", lambda x: (1 + x * x) ** -2),
            ("tanh(X)", math.tanh),
            ("sin(3*X)*exp(-X^2)", lambda x: math.sin(3 * x) * math.exp(-min(x * x, 700.0))),
        ]
    )
    here, start = (text.replace("X", f"(({u} - p)/{width:.5g})") for u in ("u", "0"))
    text = f"{level:.5g} + {1 - level:.5g}*exp(-u/{scale:.5g}) + {height:.5g}*({here} - {start})"
    smooth = lambda u: level + (1 - level) * math.exp(-u / scale)
    phi = lambda u: smooth(u) + height * (shape((u - at) / width) - shape(-at / width))
    return text, phi, at


def line(from_, to, points=COLUMNS):
    return f"{{ from = {from_!r}, to = {to!r}, points = {points} }}"


def configuration(kind, rng, folder):
    """The configuration of a random map."""
    moves = kind == "formula" and rng.random() < 0.3
    if kind == "table":
        rows, phi, at = table(rng)
        (folder / "law.csv").write_text("".join(f"{u!r},{value!r}\n" for u, value in rows))
        law = 'law = "table"\nfile = "law.csv"'
    else:
        text, phi, at = formula(rng)
        law = f'law = "expression"\nphi = "{text}"'
    # On most maps twice the belt speed passes the feature, on others the belt speed does.
    middle = at * rng.choice([0.5, 0.5, 0.5, 1.0]) * rng.uniform(0.9, 1.1)
    share = rng.uniform(0.05, 0.4)
    ends = [middle * (1 - share), middle * (1 + share)]
    if moves:
        axes = f"p = {line(at * (1 - share), at * (1 + share))}\nV = {middle!r}"
        ends = [middle * 0.999, middle * 1.001]
    else:
        axes = ("" if kind == "table" else f"p = {at!r}\n") + f"V = {line(*ends)}"
    dampings = sorted({max(mean(phi, rng.uniform(*ends)) * rng.uniform(0.97, 1.03), 0.0) for _ in range(2)})
    epsilon = rng.choice([0.3, 1.0])
    # Regimes take a hundred times as long, most of it for columns that have nothing to do with interpolation.
    fields = '["verdict", "regime"]' if rng.random() < 0.03 else '["verdict"]'
    return f"""
[friction]
{law}
[grid]
epsilon = {epsilon}
{axes}
c = {[c / epsilon for c in dampings]}
[methods]
run = ["simulation"]
[audit]
cells = 0
[output]
fields = {fields}
"""


def cells(program, file, engine):
    """The verdicts and regimes of a map, and the number of cells that were interpolated."""
    path = file.with_suffix(f".{engine}.h5")
    options = ["--set", f"simulation.engine={engine}", "--set", f"output.path={path}"]
    run = subprocess.run([program, "run", file, *options], capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"{run.stderr}\n{file.read_text()}")
    with h5py.File(path) as map:
        fields = [name for name in ("verdict_simulation", "regime") if name in map]
        found = {name: map[name][...].ravel().tolist() for name in fields}
        return found, int(map.attrs["cells_by_interpolation"]), int(map.attrs["rhs"])


def compare(program, kind, seed, scratch):
    folder = pathlib.Path(scratch) / f"{kind}{seed}"
    folder.mkdir()
    file = folder / "map.toml"
    file.write_text(configuration(kind, random.Random(f"{kind} {seed}"), folder))
    found, interpolated, work = cells(program, file, "auto")
    wanted, _, own_work = cells(program, file, "critical_surface")
    size = len(wanted["verdict_simulation"])
    wrong = {at for name in wanted for at in range(size) if found[name][at] != wanted[name][at]}
    return {"wrong": len(wrong), "cells": size, "interpolated": interpolated, "work": work, "own": own_work, "seed": seed}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--maps", type=int, default=500)
    parser.add_argument("--program", default=pathlib.Path(__file__).parents[1] / "target/debug/slipmap")
    options = parser.parse_args()
    failed = False
    for kind in ("table", "formula"):
        with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(2) as pool:
            done = list(pool.map(lambda seed: compare(options.program, kind, seed, scratch), range(options.maps)))
        total = {key: sum(one[key] for one in done) for key in done[0]}
        wrong = [one["seed"] for one in done if one["wrong"]]
        print(
            f"{kind}: {len(done)} maps, {total['cells']} cells, {total['interpolated']} interpolated; "
            f"{total['wrong']} cells of {len(wrong)} maps wrong; evaluations of the right-hand side "
            f"{total['work'] / total['own']:.2f} of those without interpolation"
        )
        if wrong:
            print(f"  maps with wrong cells: {wrong[:20]}")
        failed |= bool(wrong)
    sys.exit(failed)


main()
