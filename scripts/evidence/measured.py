"""How often true answers lie within the 95 % intervals that are stated for measured friction.

    scripts/study measured [CASES=300] [PAGES=20] [FIRST=0] [WHAT] [OUT.csv]

Synthetic measurements of five laws, as `crates/config/src/measured/coverage.rs` has them, with fixed seeds: the critical dampings of CASES
fits and as many tables, and of fits and curves of as many records over time, a second each, and the critical belt speeds
and kicks of PAGES, which take several seconds each; or only of WHAT: fits, tables, fits of records, records. At the end by kind of
record and of its errors; OUT.csv has a row for each case: the distances of the stated answers from the true ones, in standard errors.
"""

import os
import re
import subprocess
import sys
from collections import defaultdict

given = sys.argv[1:]
cases, pages, first, what, out = given + ["300", "20", "0", "", ""][len(given) :]
command = "cargo test --release --locked -p slipmap-config --lib measured::coverage::coverage -- --ignored --nocapture"
numbers = {"SLIPMAP_CASES": cases, "SLIPMAP_PAGES": pages, "SLIPMAP_FIRST": first, "SLIPMAP_WHAT": what}
ran = subprocess.Popen(command.split(), env={**os.environ, **numbers}, stdout=subprocess.PIPE, text=True)
rows, kinds = ["answer,case,what,rows,noise,speed,distances"], defaultdict(list)
for line in ran.stdout:
    print(line, end="")
    case = re.match(r"([a-z ]+) (\d+): (.*), (\d+) rows, noise ([\d.]+), V/v_s ([\d.]+): \[(.*)\]", line)
    if case:
        distances = case[7].split(", ")
        rows.append(",".join([case[1], case[2], f'"{case[3]}"', case[4], case[5], case[6], " ".join(distances)]))
        kind = re.match(r"ramps|staircases|sweeps", case[3])
        if kind:
            memory = "errors that remember" if "remembers" in case[3] else "white errors"
            kinds[f"{case[1]}, {kind[0]}, {memory}"].append(float(distances[0]))
for kind, distances in sorted(kinds.items()):
    told = [distance for distance in distances if distance == distance]
    within = sum(abs(distance) <= 1.96 for distance in told)
    print(f"{kind}: {100 * within / len(told):.1f} % of {len(told)} within, {len(distances) - len(told)} withheld")
if out:
    with open(out, "w") as file:
        file.write("\n".join([rows[0], *sorted(rows[1:])]) + "\n")
sys.exit(ran.wait())
