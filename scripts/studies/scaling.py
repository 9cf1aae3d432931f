"""Scaling of the cost of a map: n nodes on each of five axes, n^5 cells in n^4 columns.

    scripts/study scaling [n ...]              # 16 24 32 48 64 unless told; a GB of disk for n = 64

n^5 cells at one epsilon, all seven verdicts. Every map is made with one thread and
with two, and every variable of the two files is compared by the fingerprint of its data that the file holds. The work
of `simulation` should grow like the columns, n^4, while there are n^5 cells to fill and to write.

A second table tells the processor time per cell by stage, of each map with one thread, beside what the machine needs to
touch the bytes of a cell: to fill them, to fingerprint them (SHA-256), and to write the finished file to disk.
"""

import csv
import ctypes
import datetime
import hashlib
import json
import os
import shutil
import sys
import tempfile
import time
from pathlib import Path

from measure import FIVE_AXES, done, fingerprints

ROOT = Path(__file__).resolve().parents[2]
COLUMNS = [
    "n", "threads", "cells", "columns", "wall_seconds", "processor_seconds", "peak_MiB", "file_MB",
    "simulation_thread_seconds", "rhs", "audit_contradicted", "variables_equal_to_one_thread",
]  # fmt: skip


def make_map(slipmap, folder, n, threads):
    """A row of the table but its last column, and the fingerprints of the map."""
    path = Path(folder) / "map.h5"
    (Path(folder) / "job.toml").write_text(FIVE_AXES.format(a=n, n=n))
    command = [slipmap, "run", "job.toml", "--json", "--quiet", "--overwrite", "--threads", str(threads)]
    ran = done(command, folder, messages=None)
    summary = json.loads(ran.said)
    row = [
        n, threads, summary["cells"], summary["columns"], f"{ran.wall:.2f}", f"{ran.processor:.2f}",
        f"{ran.memory / (1 << 20):.0f}", f"{path.stat().st_size / 1e6:.2f}",
        f'{summary["methods"]["simulation"]["seconds"]:.3f}', summary["rhs"],
        len(summary["audit"].get("disagreements", [])),
    ]  # fmt: skip
    found = fingerprints(path)
    stages = stages_of(summary, ran.processor)
    stages += [("limit: fill", fill_rate() * VERDICTS), ("limit: SHA-256", hash_rate() * VERDICTS)]
    stages.append(("limit: write and sync", write_rate(path, folder) / summary["cells"]))
    path.unlink()
    return row, found, stages


# Verdicts of a cell, one byte each.
VERDICTS = 7
# Small, because the memory of this program counts in the peak of the programs that it starts.
BLOCK = 1 << 22


def stages_of(summary, processor):
    """Processor seconds per cell of every method and of every other stage, and of all."""
    seconds = [(name, method["seconds"]) for name, method in summary["methods"].items()]
    seconds += summary["stages"].items()
    seconds.append(("start and end of the process", processor - sum(value for _, value in seconds)))
    seconds.append(("all", processor))
    return [(name, value / summary["cells"]) for name, value in seconds]


def least(work, passes=5):
    def once():
        start = time.process_time()
        work()
        return time.process_time() - start

    return min(once() for _ in range(passes))


def fill_rate():
    block = ctypes.create_string_buffer(BLOCK)
    return least(lambda: ctypes.memset(block, 1, BLOCK)) / BLOCK


def hash_rate():
    block = bytes(BLOCK)
    return least(lambda: hashlib.sha256(block).digest()) / BLOCK


def write_rate(path, folder):
    """Wall-clock seconds for a copy of the file, forced to disk."""
    copy = Path(folder) / "copy"
    start = time.monotonic()
    with open(path, "rb") as source, open(copy, "wb") as file:
        shutil.copyfileobj(source, file)
        file.flush()
        os.fsync(file.fileno())
    seconds = time.monotonic() - start
    copy.unlink()
    return seconds


def main():
    slipmap, *sizes = sys.argv[1:]
    slipmap = str(Path(slipmap).resolve())
    sizes = [int(n) for n in sizes] or [16, 24, 32, 48, 64]
    out = ROOT / "results" / f"scaling-{datetime.date.today().isoformat()}.csv"
    rows, table = [], []
    with tempfile.TemporaryDirectory() as folder:
        for n in sizes:
            one, expected, stages = make_map(slipmap, folder, n, 1)
            two, found, _ = make_map(slipmap, folder, n, 2)
            table.append((n, stages))
            equal = sum(found.get(name) == value for name, value in expected.items())
            rows += [one + [""], two + [f"{equal} of {len(expected)}"]]
            for row in rows[-2:]:
                print("  ".join(f"{name} {value}" for name, value in zip(COLUMNS, row)), flush=True)
            if equal != len(expected) or len(found) != len(expected):
                sys.exit(f"n = {n}: the maps of one and of two threads differ")
    with open(out, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    with open(out.with_name(out.name.replace("scaling-", "scaling-stages-")), "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["stage", *(f"nanoseconds_per_cell_n_{n}" for n, _ in table)])
        for stage, *_ in table[-1][1]:
            writer.writerow([stage, *(f"{1e9 * dict(stages)[stage]:.3f}" for _, stages in table)])
    print(f"written: {out.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
