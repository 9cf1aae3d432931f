"""Speed against accuracy in three scenes, with the integrators of others on the same cells.

    scripts/study work_precision [--seconds S]

The paper's law, the steep friction of a brake, and two coefficients: configs/work-precision*.toml. Of each the cells are
drawn, peers answer them (peers.py), and `slipmap work-precision` measures its own methods and draws all. What is kept:
results/work-precision/SCENE/work-precision.csv and .png. Times are processor time of one thread.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCENES = {"paper": "work-precision", "brake": "work-precision-brake", "coefficients": "work-precision-coefficients"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--seconds", type=float, default=1.0, help="processor time of a method at a setting")
    args = parser.parse_args()
    peers = ROOT / "target/peers-rs/release/peers"
    for scene, configuration in SCENES.items():
        folder = ROOT / "results/work-precision" / scene
        (folder / "peers.csv").unlink(missing_ok=True)
        chart = [args.program, "work-precision", f"configs/{configuration}.toml", "--out", folder, "--overwrite", "--quiet"]
        commands = [
            [*chart, "--set", "work_precision.seconds=1e-6"],
            [sys.executable, Path(__file__).with_name("peers.py"), peers, "--cells-from", folder / "cells.csv"],
            [*chart, "--set", f"work_precision.seconds={args.seconds}"],
        ]
        commands[1] += ["--out", folder / "peers.csv"]
        for command in commands:
            subprocess.run([os.fspath(word) for word in command], cwd=ROOT, check=True)


if __name__ == "__main__":
    main()
