"""What answers about real machines cost, beside what was asked for.

    scripts/study machines [--date YYYY-MM-DD] [--extremes NUMBER=1300]

Writes results/machines-DATE.csv: what was measured, its value, the goal, and whether it is met. Processor time, one run each:

* the critical damping of 20,000 columns, V from 0.1 to 1, at a damping above all of them, of friction that falls from 1 to 0.58 within vs, by three laws, and
  the ratio of the slowest to the fastest vs;
* verdict, regime and cycle of 13,640 cells of a formula that falls without end;
* maps of three machines, 100 x 100 of belt speed and normal force, on two threads (wall time);
* the curves of the gallery's configurations and the others that have some;
* random extreme configurations, see scripts/evidence/extremes.py.
"""

import argparse
import datetime
import sys
import tempfile
from pathlib import Path

from measure import done, ended, table

ROOT = Path(__file__).resolve().parents[2]
WIDTHS = [1.0, 0.1, 0.03, 1e-2, 1e-3, 1e-4, 1e-6]
COLUMNS = 20_000
# The law with an exponent is not told below this.
LEAST_STRETCHED = 1e-4

MACHINES = {
    "brake pad": """[friction]
law = "stribeck"
[machine]
mass = 2.0
stiffness = 5.05e5
normal_force = { from = 200.0, to = 3000.0, points = 100 }
static_friction = 0.4
kinetic_friction = 0.25
stribeck_velocity = 0.05
belt_speed = { from = 0.01, to = 0.4, points = 100 }
damping = 50.0
""",
    "drill string": """[friction]
law = "exponential"
[machine]
motion = "rotation"
mass = 471.9698
stiffness = 861.5336
normal_force = { from = 3000.0, to = 12000.0, points = 100 }
static_friction = 0.8
kinetic_friction = 0.5
stribeck_velocity = 1.111111111
belt_speed = { from = 0.5, to = 20.0, points = 100 }
damping = 222.3067
""",
    # A slide on plain bearings; the numbers are of the usual size, and not measured.
    "positioning stage": """[friction]
law = "exponential"
[machine]
mass = 10.0
stiffness = 1e6
normal_force = { from = 50.0, to = 400.0, points = 100 }
static_friction = 0.2
kinetic_friction = 0.12
stribeck_velocity = 1e-3
strengthening = 0.1
belt_speed = { from = 1e-4, to = 0.01, points = 100 }
damping = 60.0
""",
}

FALLING = """[friction]
law = "expression"
phi = "1 - epsilon*a*u + epsilon*b*sin(w*u)"
[grid]
epsilon = 0.1
a = 1.0
b = { from = 0.0, to = 1.0, points = 44 }
w = 3.0
V = { from = 0.2, to = 2.0, points = 10 }
c = { from = 0.0, to = 2.0, points = 31 }
[methods]
run = ["simulation"]
[audit]
cells = 0
"""


def run(program, job, arguments=()):
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "job.toml").write_text(job)
        return done([program, "run", "job.toml", *arguments], folder)


def steep(program):
    formula = 'law = "expression"\nphi = "0.58 + 0.42*exp(-(u/{vs!r})^2)"'
    for name, friction, grid, least in [
        ("exponential", 'law = "exponential"', "mu = 0.58\nvs = {vs!r}\neta = 0.0\n", 0.0),
        ("exponent 2", 'law = "exponential"', "mu = 0.58\nvs = {vs!r}\neta = 0.0\nexponent = 2.0\n", LEAST_STRETCHED),
        ("exponent 2 as a formula", formula, "", 0.0),
    ]:
        found = []
        for vs in (vs for vs in WIDTHS if vs >= least):
            job = (
                f"[friction]\n{friction.format(vs=vs)}\n[grid]\nepsilon = 1.0\n{grid.format(vs=vs)}"
                f"V = {{ from = 0.1, to = 1.0, points = {COLUMNS} }}\nc = 1.95\n"
                '[methods]\nrun = ["simulation"]\n[audit]\ncells = 0\n[output]\npath = "map.h5"\nfields = ["critical_c"]\n'
            )
            ran = run(program, job, ["--quiet", "--threads", "1", "--set", "simulation.tolerance=1e-9"])
            found.append(1e6 * ran.processor / COLUMNS)
            yield f"critical damping, {name}, vs = {vs:g}", found[-1], "microseconds each", 100, "at most"
        yield f"critical damping, {name}: slowest over fastest vs", max(found) / min(found), "", 6, "at most"


def seconds_of(program, name):
    configuration = next(ROOT.glob(f"configs/**/{name}.toml"))
    with tempfile.TemporaryDirectory() as folder:
        command = [program, "run", str(configuration), "--quiet", "--set", f'output.path="{folder}/map.h5"']
        return done(command, ROOT).processor


def measured(program, extremes):
    yield from steep(program)
    job = FALLING + '[output]\npath = "map.h5"\nfields = ["verdict", "regime", "cycle"]\n'
    falling = run(program, job)
    yield "a formula that falls without end, regime and cycle", 44 * 10 * 31 / falling.processor, "cells per second", 10_000, "at least"
    unknown = [line for line in falling.said.splitlines() if line.startswith("regime: not determined")]
    count = float(unknown[0].split(" in ")[1].split(" of ")[0].replace(",", "")) if unknown else 0.0
    yield "the same: cells without a regime", count, "cells", 0, "at most"
    for name, machine in MACHINES.items():
        job = machine + '[output]\npath = "map.h5"\nfields = ["verdict", "critical_damping", "regime"]\n[audit]\ncells = 0\n'
        wall = run(program, job, ["--quiet", "--threads", "2"]).wall
        yield f"{name}, 100 x 100 of belt speed and normal force", wall, "s on two threads", 2, "at most"
    for name in ["quickstart", "brake_pad", "drill_string", "two_coefficients"]:
        yield f"configuration {name} with its curves", seconds_of(program, name), "s", 5, "at most"
    if extremes:
        script = ROOT / "scripts" / "evidence" / "extremes.py"
        said = ended([sys.executable, script, program, str(extremes)]).said
        slowest = max(float(line.split("at most ")[1].split(" s")[0]) for line in said.splitlines() if " at most " in line)
        yield f"slowest command of {extremes:,} extreme configurations", slowest, "s", 10, "at most"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--date", default=datetime.date.today().isoformat())
    parser.add_argument("--extremes", type=int, default=1300)
    args = parser.parse_args()
    add = table(ROOT / "results" / f"machines-{args.date}.csv", ["what", "value", "unit", "goal", "met"])
    for what, value, unit, goal, side in measured(args.program, args.extremes):
        met = value <= goal if side == "at most" else value >= goal
        add([what, f"{value:.3g}", unit, f"{side} {goal:,}", "yes" if met else "no"])


if __name__ == "__main__":
    main()
