#!/usr/bin/env python3
"""What the method `validated` leaves undecided: of every shipped configuration of a machine or an article, of a steep brake, and of
random machines.

    scripts/study proof_coverage [--machines NUMBER=300] > results/validated/coverage.csv

Each configuration is a run of its own, with `validated` alone; the random machines, in SI units, one map of one cell each. Processor
time is that of the method, on all cores.
"""

import argparse
import csv
import json
import random
import sys
import tempfile
from pathlib import Path

from measure import done

ROOT = Path(__file__).resolve().parents[2]
CONFIGURATIONS = ["brake_pad", "drill_string", *sorted(f"gallery/{path.stem}" for path in (ROOT / "configs/gallery").glob("*.toml"))]

# The brake of the theory's examples: most of this plane has |D| > 2.
BRAKE = """[friction]
law = "exponential"
[grid]
epsilon = 1.0
mu = 0.6
vs = 0.05
eta = 0.0
V = { from = 0.02, to = 1.0, points = 50 }
c = { from = 0.0, to = 1.0, points = 51 }
"""


def machine(chance):
    """A machine, its numbers spread evenly over orders of magnitude."""
    between = lambda lo, hi: lo * (hi / lo) ** chance.random()
    mass, frequency = between(1e-3, 1e3), between(1.0, 1e3)
    stiffness = mass * (6.283 * frequency) ** 2
    static = between(0.1, 1.0)
    # Static deflection, and the belt speed in units of what it makes of the frequency.
    force = between(1e-3, 0.1) * stiffness * between(1e-3, 0.1) / static
    unit = force * static / (stiffness * mass) ** 0.5
    law = chance.choice(["exponential", "lorentzian", "stribeck"])
    more = "exponent = 2\\n" if law == "exponential" and chance.random() < 0.3 else ""
    return f"""[friction]
law = "{law}"
{more}[machine]
mass = {mass!r}
stiffness = {stiffness!r}
normal_force = {force!r}
static_friction = {static!r}
kinetic_friction = {static * chance.uniform(0.4, 0.95)!r}
stribeck_velocity = {unit * between(0.02, 3.0)!r}
belt_speed = {unit * between(0.03, 3.0)!r}
damping_ratio = {between(1e-3, 0.3)!r}
"""


def undecided(program, path, folder):
    """Cells, how many are undecided, and processor seconds."""
    sets = {"methods.run": '["validated"]', "output.fields": '["verdict"]', "curves.planes": "[]", "audit.cells": 0, "validated.boxes": 0}
    sets["output.path"] = f'"{folder}/map.h5"'
    command = [program, "run", path, "--json", "--overwrite", "--quiet"]
    ran = done(command + [part for key, value in sets.items() for part in ("--set", f"{key}={value}")], messages=None)
    found = json.loads(ran.said)
    method = found["methods"]["validated"] if isinstance(found["methods"], dict) else found["methods"][0]
    return found["cells"], found["cells"] - method["present"] - method["absent"], ran.processor


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--machines", type=int, default=300)
    parser.add_argument("--only", default="")
    arguments = parser.parse_args()
    program = Path(arguments.program).resolve()
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(["configuration", "cells", "undecided", "processor_seconds"])
    chance = random.Random(74)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "job.toml"
        for name in CONFIGURATIONS:
            if arguments.only in name:
                table.writerow([name, *undecided(program, ROOT / f"configs/{name}.toml", folder)])
                sys.stdout.flush()
        place.write_text(BRAKE, encoding="utf-8")
        if arguments.only in "brake":
            table.writerow(["a brake, vs = 0.05, V from 0.02 to 1", *undecided(program, place, folder)])
            sys.stdout.flush()
        total = [0, 0, 0.0]
        for _ in range(arguments.machines):
            place.write_text(machine(chance), encoding="utf-8")
            total = [a + b for a, b in zip(total, undecided(program, place, folder))]
        table.writerow(["random machines", *total])


if __name__ == "__main__":
    main()
