"""Maps of friction laws with a narrow feature, every cell against its own column.

    scripts/study outliers [--maps 500]

Tables with one outlier, and formulas with one narrow dip, bump, step or wave; their axis is the belt speed or the
place of the feature. Each map is computed twice: as users
do, with answers that are interpolated between columns, and every column as a map of its own. Prints the number of maps and cells that differ, and exits with 1 if any does.
"""

import argparse
import itertools
import math
import pathlib
import random
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor

import h5py

COLUMNS = 64


def table(rng):
    """A smooth law at a few slip speeds, with an outlier between two rows close to it; its place and its width."""
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

    return rows, at, width


def formula(rng):
    """A smooth law with a feature around a slip speed p; its place and its width."""
    level, scale, at = rng.uniform(0.3, 0.8), rng.uniform(0.2, 1.0), rng.uniform(0.6, 3.0)
    width, height = at * 10 ** rng.uniform(-3, -1), rng.choice([-1, 1]) * 10 ** rng.uniform(-3, -1.3)
    text = rng.choice(["exp(-X^2)", "1/(1 + X^2)^2", "tanh(X)", "sin(3*X)*exp(-X^2)"])
    here, start = (text.replace("X", f"(({u} - p)/{width:.5g})") for u in ("u", "0"))
    text = f"{level:.5g} + {1 - level:.5g}*exp(-u/{scale:.5g}) + {height:.5g}*({here} - {start})"
    return text, at, width


def line(from_, to, points=COLUMNS):
    return f"{{ from = {from_!r}, to = {to!r}, points = {points} }}"


def configuration(law, axes, dampings, fields):
    return f"""
[friction]
{law}
[grid]
epsilon = 1.0
{axes}
c = {dampings}
[methods]
run = ["simulation"]
[audit]
cells = 0
[output]
fields = {fields}
"""


def random_map(program, kind, rng, folder):
    """The file of a random map. Its dampings are next to the critical one of an orbit that just passes the feature."""
    file = folder / "map.toml"
    if kind == "table":
        rows, at, width = table(rng)
        (folder / "law.csv").write_text("".join(f"{u!r},{value!r}\n" for u, value in rows))
        law, place = 'law = "table"\nfile = "law.csv"', ""
    else:
        text, at, width = formula(rng)
        law, place = f'law = "expression"\nphi = "{text}"', f"p = {at!r}\n"
    belt = 0.5 * (at + rng.uniform(-1, 3) * width)
    file.write_text(configuration(law, f"{place}V = {belt!r}", [0.0], '["verdict", "critical_c"]'))
    critical, *_ = computed(program, file, ["critical_c_simulation"])
    critical = critical["critical_c_simulation"][0]
    if not critical > 0:
        return None
    share, shift = rng.uniform(0.03, 0.3), rng.uniform(-0.5, 0.5)
    ends = lambda middle: line(middle * (1 + share * (shift - 1)), middle * (1 + share * (shift + 1)))
    if kind == "formula" and rng.random() < 0.3:
        axes = f"p = {ends(at)}\nV = {belt!r}"
    else:
        axes = f"{place}V = {ends(belt)}"
    off = 10 ** rng.uniform(-4, -2)
    # Regimes take a hundred times as long, most of it for columns that have nothing to do with interpolation.
    fields = '["verdict", "regime"]' if rng.random() < 0.03 else '["verdict"]'
    file.write_text(configuration(law, axes, [critical * (1 - off), critical * (1 + off)], fields))
    return file


def computed(program, file, variables, *sets):
    """The variables of a map that it has, the number of its interpolated cells, and of evaluations."""
    path = file.with_suffix(".h5")
    options = ["--overwrite", "--quiet", f"--set=output.path={path}", *(f"--set={value}" for value in sets)]
    run = subprocess.run([program, "run", file, *options], capture_output=True, text=True)
    if run.returncode:
        sys.exit(f"{run.stderr}\n{file.read_text()}")
    with h5py.File(path) as map:
        found = {name: map[name][...].ravel().tolist() for name in variables if name in map}
        return found, int(map.attrs["cells_by_interpolation"]), int(map.attrs["rhs"])


def column_by_column(program, file, variables):
    """The same variables of the map whose columns are maps of their own, and the number of evaluations."""
    axis = tomllib.loads(file.read_text())["grid"]
    name, ends = next((name, value) for name, value in axis.items() if isinstance(value, dict))
    all, work = {}, 0
    for number in range(COLUMNS):
        value = ends["from"] + (ends["to"] - ends["from"]) * number / (COLUMNS - 1)
        found, _, own = computed(program, file, variables, f"grid.{name}={value!r}")
        work += own
        for variable, cells in found.items():
            all.setdefault(variable, []).extend(cells)
    return all, work


def compare(program, kind, seed, scratch):
    folder = pathlib.Path(scratch) / f"{kind}{seed}"
    folder.mkdir()
    file = random_map(program, kind, random.Random(f"{kind} {seed}"), folder)
    if file is None:
        return None
    variables = ["verdict_simulation", "regime"]
    found, interpolated, work = computed(program, file, variables)
    wanted, own_work = column_by_column(program, file, variables)
    size = len(wanted["verdict_simulation"])
    wrong = {at for name in wanted for at in range(size) if found[name][at] != wanted[name][at]}
    return {"wrong": len(wrong), "cells": size, "interpolated": interpolated, "work": work, "own": own_work, "seed": seed}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--maps", type=int, default=500)
    options = parser.parse_args()
    failed = False
    for kind in ("table", "formula"):
        with tempfile.TemporaryDirectory() as scratch, ThreadPoolExecutor(2) as pool:
            # Some laws have no critical damping at the belt speed that was drawn.
            maps = pool.map(lambda seed: compare(options.program, kind, seed, scratch), range(2 * options.maps))
            done = list(itertools.islice(filter(None, maps), options.maps))
            pool.shutdown(cancel_futures=True)
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
