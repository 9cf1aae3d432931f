"""The speed of critical dampings from Python and from the engine itself, in one run with alternating passes, and of a law
given as a Python function beside the built-in one.

    scripts/study python_rate OUT.md
"""

import datetime
import math
import os
import statistics
import subprocess
import sys
import time

import numpy as np
import slipmap

PASSES = 7


def engine(program, law, count):
    seconds, _ = subprocess.run(
        [program, law, str(count), "1"], capture_output=True, text=True, check=True
    ).stdout.split()
    return float(seconds)


def python(law, epsilon, V):
    start = time.perf_counter()
    slipmap.critical_c(law, V=V, epsilon=epsilon)
    return time.perf_counter() - start


def machine(pad, count):
    speeds = np.linspace(0.02, 0.4, count)
    start = time.perf_counter()
    pad.critical_damping(belt_speed=speeds)
    return time.perf_counter() - start


def ratios(pairs):
    """Median, least and greatest of the ratios of pairs, first over second."""
    each = [first / second for first, second in pairs]
    return f"{statistics.median(each):.3f} ({min(each):.3f} to {max(each):.3f})"


def main(program, out):
    rows = []
    laws = {
        "stribeck": (slipmap.Law.stribeck(0.4, 0.2, 2.0), 0.1, 1_000_000),
        "exponential": (slipmap.Law.exponential(0.5, 1.0, 0.0), 1.0, 10_000),
    }
    for name, (law, epsilon, count) in laws.items():
        V = np.linspace(0.3, 3.0, count)
        pairs = [(engine(program, name, count), python(law, epsilon, V)) for _ in range(PASSES)]
        best = min(second for _, second in pairs)
        rows.append((f"{name}: one call from Python over the engine itself, rates", count, best, ratios(pairs)))
    pad = slipmap.Machine(mass=2.0, stiffness=5.05e5, damping=20.0, normal_force=1000.0, static_friction=0.4,
                          kinetic_friction=0.25, stribeck_velocity=0.05, belt_speed=0.1)
    count = 1_000_000
    # Each takes minutes.
    pairs = [(engine(program, "pad", count), machine(pad, count)) for _ in range(3)]
    best = min(second for _, second in pairs)
    rows.append(("a brake pad: one call of its machine over the engine itself, rates", count, best, ratios(pairs)))
    built_in, epsilon, count = laws["exponential"]
    V = np.linspace(0.3, 1.9, count)
    own = slipmap.Law.from_function(lambda u: 0.5 + 0.5 * math.exp(-u), fastest=16.0)
    pairs = [(python(own, epsilon, V), python(built_in, epsilon, V)) for _ in range(PASSES)]
    best = min(first for first, _ in pairs)
    rows.append(("exponential as a Python function over the built-in law, times", count, best, ratios(pairs)))
    text = [
        f"# Rates of the Python package, {datetime.date.today()}",
        "",
        f"`scripts/study python_rate`, slipmap {slipmap.__version__}, NumPy {np.__version__}, {os.cpu_count()} cores; "
        f"{PASSES} pairs of passes in turn (3 of the pad), load of the machine {os.getloadavg()[0]:.1f}.",
        "",
        "| what | columns | seconds, best | ratio: median (range) |",
        "| --- | --: | --: | --: |",
        *(f"| {what} | {count:,} | {best:.3f} | {ratio} |" for what, count, best, ratio in rows),
        "",
    ]
    with open(out, "w", encoding="utf-8") as file:
        file.write("\n".join(text))
    print("\n".join(text))


if __name__ == "__main__":
    main(*sys.argv[1:])
