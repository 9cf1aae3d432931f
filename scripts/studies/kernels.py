"""Time, right-hand sides and arithmetic per answer of each kernel, beside the machine's own limit.

    scripts/study kernels [--date YYYY-MM-DD]
    scripts/study kernels --check    # counts alone: ends with 1 where one is 5 % from the newest table's

Time is processor time of one thread, the least of 15 passes over the same random cells of the box in which speeds are
quoted. Instructions are counted by callgrind as the difference of two runs, of one pass and of two, so that making
cells and tables does not count, and sorted by their mnemonics. Callgrind knows vectors of four numbers (AVX2) and no
wider ones, so that counts are those of any processor of this decade.

The limit: a processor that did nothing but the kernel's vector divisions and square roots takes `division_ns`; one
that did nothing but its vector multiplications, additions and fused multiply-adds takes `arithmetic_ns`, at the rates
that the same thread reaches on independent divisions and fused multiply-adds from registers. The larger of the two is
the limit, and `share_of_limit` what the kernel reaches of it.
"""

import argparse
import csv
import datetime
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# Kernel, cells that are timed, cells that are counted.
KERNELS = [
    ("instability", 1 << 16, 1 << 14), ("symmetric", 1 << 16, 1 << 14),
    ("critical_damping", 1 << 14, 1 << 11), ("direct", 1 << 10, 1 << 8),
]  # fmt: skip
COLUMNS = [
    "kernel", "cells", "ns_per_cell", "rhs_per_cell", "divisions_per_cell", "arithmetic_per_cell",
    "instructions_per_cell", "division_ns", "arithmetic_ns", "share_of_limit",
]  # fmt: skip
OPERATION = re.compile(r"v?(?P<name>div|sqrt|mul|add|sub|fn?m(add|sub)(132|213|231))(?P<kind>[ps])d$")
WIDTHS = {"x": 2, "y": 4, "z": 8}


def bench(path, *arguments):
    done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True, check=True)
    return [float(word) for word in done.stdout.split()]


def disassemble(path):
    """Address -> (divisions, other arithmetic) in numbers, of every instruction of the program."""
    text = subprocess.run(["objdump", "-d", "--no-show-raw-insn", path], capture_output=True, text=True, check=True)
    kinds = {}
    for line in text.stdout.splitlines():
        match = re.match(r"\s*([0-9a-f]+):\s+(\S+)\s*(.*)", line)
        if match:
            operation = OPERATION.match(match[2])
            numbers = 0
            if operation:
                register = re.search(r"%([xyz])mm", match[3])
                numbers = 1 if operation["kind"] == "s" else WIDTHS[register[1]]
            division = bool(operation) and operation["name"] in ("div", "sqrt")
            kinds[int(match[1], 16)] = (numbers * division, numbers * (not division))
    return kinds


def counts(path, kernel, cells, passes):
    """Executions of every instruction of the program, by address as loaded."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind"
        subprocess.run(
            ["valgrind", "-q", "--tool=callgrind", "--dump-instr=yes", "--compress-pos=no", "--compress-strings=no",
             f"--callgrind-out-file={out}", path, "count", kernel, str(cells), str(passes)],
            check=True, stdout=subprocess.DEVNULL,
        )  # fmt: skip
        executed, mine, skip = Counter(), False, False
        for line in out.read_text().splitlines():
            if line.startswith("ob="):
                mine = line.endswith(Path(path).name)
            elif line.startswith("calls="):
                skip = True  # the next line is the inclusive cost of the call
            elif line.startswith("0x"):
                if mine and not skip:
                    address, _, cost = line.split()[:3]
                    executed[int(address, 16)] += int(cost)
                skip = False
        return executed


def per_cell(path, kinds, kernel, cells):
    """Divisions, other arithmetic and instructions per cell."""
    few, many = counts(path, kernel, cells, 1), counts(path, kernel, cells, 2)
    # The load address of the program: the offset that makes every executed address one of the program's
    # instructions.
    lowest = min(many)
    for base in {lowest - address for address in kinds if (lowest - address) % 4096 == 0}:
        if all(address - base in kinds for address in many):
            break
    else:
        sys.exit("the counted addresses are not those of the program")
    totals = [0, 0, 0]
    for address, executions in many.items():
        more = executions - few[address]
        divisions, others = kinds[address - base]
        totals[0] += more * divisions
        totals[1] += more * others
        totals[2] += more
    return [total / cells for total in totals]


def check(path):
    """Compares instructions per cell with the newest stored table."""
    stored = max(ROOT.glob("results/kernels-*.csv"))
    with open(stored, newline="") as file:
        expected = {row["kernel"]: float(row["instructions_per_cell"]) for row in csv.DictReader(file)}
    kinds, changed = disassemble(path), False
    for kernel, _, counted in KERNELS:
        instructions = per_cell(path, kinds, kernel, counted)[2]
        ratio = instructions / expected[kernel]
        changed |= abs(ratio - 1) > 0.05
        print(f"{kernel}: {instructions:.0f} instructions per cell, {ratio:.3f} times those of {stored.name}")
    return 1 if changed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("bench")
    parser.add_argument("--date", default=datetime.date.today().isoformat())
    parser.add_argument("--check", action="store_true", help="compare counts with the newest table, write nothing")
    options = parser.parse_args()
    if options.check:
        sys.exit(check(options.bench))
    kinds = disassemble(options.bench)
    out = ROOT / "results" / f"kernels-{options.date}.csv"
    rows = []
    for kernel, timed, counted in KERNELS:
        division_rate, arithmetic_rate = bench(options.bench, "peaks")
        seconds, rhs = bench(options.bench, "time", kernel, timed)
        divisions, arithmetic, instructions = per_cell(options.bench, kinds, kernel, counted)
        ns = 1e9 * seconds / timed
        division_ns, arithmetic_ns = 1e9 * divisions / division_rate, 1e9 * arithmetic / arithmetic_rate
        limit = max(division_ns, arithmetic_ns)
        rows.append([
            kernel, timed, f"{ns:.1f}", f"{rhs / timed:.1f}", f"{divisions:.1f}", f"{arithmetic:.0f}",
            f"{instructions:.0f}", f"{division_ns:.1f}", f"{arithmetic_ns:.1f}", f"{limit / ns:.2f}",
        ])  # fmt: skip
        print("  ".join(f"{name} {value}" for name, value in zip(COLUMNS, rows[-1])), file=sys.stderr)
    with open(out, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    print(f"peak: {division_rate:.3g} divisions/s, {arithmetic_rate:.3g} fused multiply-adds/s")
    print(f"written: {out.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
