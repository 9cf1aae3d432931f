#!/usr/bin/env python3
"""Proved volumes of the box of configs/validated.toml against processor time: lower bounds of present and absent, an upper one of undecided.

    scripts/study proof_volume > results/validated/volume.csv

Each row is a run of its own, on all cores. `boxes` is the number of boxes tried: that of the key `boxes`, or one less, since
the two halves of a box are tried together.
"""

import csv
import json
import sys
import tempfile
from pathlib import Path

from measure import done

ROOT = Path(__file__).resolve().parents[2]
BOXES = [16, 32, 64, 128, 256]


def main():
    program = Path(sys.argv[1]).resolve()
    names = ["boxes", "processor_seconds", "present", "absent", "undecided_at_most"]
    table = csv.DictWriter(sys.stdout, names, lineterminator="\n")
    table.writeheader()
    with tempfile.TemporaryDirectory() as folder:
        for boxes in BOXES:
            sets = {"validated.boxes": boxes, "validated.proof": f'"{folder}/p.json"', "output.path": f'"{folder}/m.h5"'}
            command = [program, "run", ROOT / "configs/validated.toml", "--json", "--overwrite", "--quiet"]
            command += [part for key, value in sets.items() for part in ("--set", f"{key}={value}")]
            # Processor time of the whole run, independent of other load; its cells take a tenth of a second.
            ran = done(command, messages=None)
            proved = json.loads(ran.said)["proved"]
            known = {name: proved[name] for name in names if name in proved}
            table.writerow({**known, "processor_seconds": round(ran.processor, 2)})
            sys.stdout.flush()


if __name__ == "__main__":
    main()
