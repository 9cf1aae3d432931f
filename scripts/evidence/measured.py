"""How often true answers lie within the 95 % intervals that are stated for measured friction.

    scripts/study measured [CASES=300] [PAGES=20] [FIRST=0] [WHAT] [OUT.csv]

Synthetic measurements of five laws, as `crates/config/src/measured/coverage.rs` has them, with fixed seeds: the critical dampings of CASES
fits and as many tables, and of fits and curves of as many records over time, and the friction at rest of the records, a second
each; for the first PAGES the critical belt speed and the kick, too, which take several seconds; or only of WHAT: fits, tables,
fits of records, records. At the end by kind of record and of its errors, with the median width of the interval of the critical damping
of records, in units of that of generalised least squares of the true law with the true covariance. OUT.csv has a row for each case: the
distances of the stated answers from the true ones in standard errors, nan where none is stated, and that width.
"""

import os
import re
import subprocess
import sys
from collections import defaultdict
from statistics import median

ANSWERS = ["critical_damping", "critical_belt_speed", "kick", "at_rest"]
LINE = r"([a-z ]+) (\d+): (.*), (\d+) rows, noise ([\d.]+), V/v_s ([\d.]+): (\S+ \S+ \S+ \S+) (\S+)$"


def kinds_of(answer, what):
    """All kinds that a case belongs to."""
    shape = re.match(r"ramps|staircases|sweeps", what)
    if not shape:
        return [answer]
    memory = "errors that remember" if "remembers" in what else "white errors"
    directions = "both directions" if "both" in what else "one direction"
    return [answer, f"{answer}, {shape[0]}, {memory}", f"{answer}, {directions}"]


def told(kind, distances):
    """How many are within, with those withheld, and whether that is 95 % within three binomial errors."""
    known = [distance for distance in distances if distance == distance]
    if not known:
        return f"{kind}: {len(distances)} withheld"
    share = sum(abs(distance) <= 1.96 for distance in known) / len(known)
    off = abs(share - 0.95) > 3 * (0.95 * 0.05 / len(known)) ** 0.5
    words = ", OFF" if off else ""
    return f"{kind}: {100 * share:.1f} % of {len(known)} within, {len(distances) - len(known)} withheld{words}"


given = sys.argv[1:]
cases, pages, first, what, out = given + ["300", "20", "0", "", ""][len(given) :]
command = "cargo test --release --locked -p slipmap-config --lib measured::coverage::coverage -- --ignored --nocapture"
numbers = {"SLIPMAP_CASES": cases, "SLIPMAP_PAGES": pages, "SLIPMAP_FIRST": first, "SLIPMAP_WHAT": what}
ran = subprocess.Popen(command.split(), env={**os.environ, **numbers}, stdout=subprocess.PIPE, text=True)
rows, kinds, widths = [], defaultdict(lambda: defaultdict(list)), defaultdict(list)
for line in ran.stdout:
    print(line, end="")
    case = re.match(LINE, line)
    if not case:
        continue
    distances = ["" if of == "-" else of.lower() for of in case[7].split()]
    rows.append([case[1], int(case[2]), f'"{case[3]}"', *case.groups()[3:6], *distances, case[8].lower()])
    for kind in kinds_of(case[1], case[3]):
        for answer, distance in zip(ANSWERS, distances):
            if distance:
                kinds[answer][kind].append(float(distance))
    if case[8] != "NaN":
        widths[case[1]].append(float(case[8]))
for answer, of_kinds in kinds.items():
    for kind, distances in sorted(of_kinds.items()):
        print(f"{answer} of {told(kind, distances)}")
for kind, of_kind in widths.items():
    print(f"width of the critical damping of {kind}: {median(of_kind):.2f} times that of the true law")
if out:
    with open(out, "w") as file:
        print("answer,case,what,rows,noise,speed", *ANSWERS, "width", sep=",", file=file)
        for row in sorted(rows):
            print(*row, sep=",", file=file)
sys.exit(ran.wait())
